"""Dimensions proposed for a solid without declarations, until the check of definition is satisfied and none is spare.

Each feature gives its size (`drawings.recognition.features`); the levels of faces and axes along each axis of the part
are tied to a datum face, or in pairs to the middle where the part reaches equally far to both sides. Each dimension is
in a view in which lines of the part are drawn at its points. A dimension without which the check is still satisfied is
left out. The result is data: it is written as Python (`drawings.recognition.part_file`).
"""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any

from drawings.dimensions.definition import Notes, centred_axes, definition
from drawings.dimensions.levels import AXES, NEAR, along_of, corners, is_fillet, is_mirrored, outward_normal
from drawings.recognition.features import (
    AXIS,
    FACE,
    MOUTH,
    Features,
    Hole,
    Level,
    centre_of_circle,
    features_of,
    middle_of_face,
    row_of_equal_steps,
    tap_drill_of,
)
from drawings.recognition.part_file import Proposal, Proposed, as_dimension
from drawings.recognition.rings import Ring, rings_around
from drawings.recognition.visible import (
    PREFERRED,
    VIEW_OF,
    VisibleLines,
    at_level,
    extremes,
    negative,
    on_outline,
    positive,
    proposed_datums,
    tidy,
    views_along,
)
from drawings.views.view import PROJECTIONS, Cut, auxiliary, dot, projection_of
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import cross
from stagecad.solids.modelling.verification import DimensionVerifier, Surface, moved

ANOTHER_VIEW = 25.0
"""Cost of each less usual view, mm."""


def propose(verifier: DimensionVerifier) -> Proposal:
    """Dimensions of a solid."""
    builder = _Builder(verifier)
    builder.holes()
    builder.slots()
    builder.round_features()
    builder.chamfers()
    builder.levels()
    found = builder.proposed
    symmetric = centred_axes(verifier)

    def problems(proposed: Sequence[Proposed]) -> tuple[str, ...]:
        dimensions = [as_dimension(one) for one in proposed]
        notes = Notes(symmetric, packaged=False)
        return definition(verifier, dimensions, (), notes).problems

    found = builder.in_fewer_views(_without_superfluous(found, problems))
    questions = tuple(builder.questions)
    views = tuple(dict.fromkeys(one.fields["view"] for one in found if "view" in one.fields))
    diameters = {one.value: one.fields["view"] for one in found if one.name.startswith("diameter")}
    datums = tuple(proposed_datums(verifier, builder.features, views, diameters, builder.lines))
    views = builder.with_inside(views, found)
    found = builder.in_section(found) if "front section" in views else found
    return Proposal(tuple(found), questions, problems(found), views, datums)


def _without_superfluous(
    proposed: list[Proposed], problems: Callable[[Sequence[Proposed]], tuple[str, ...]]
) -> list[Proposed]:
    """The proposals without those that the definition does not need, the last ones first."""
    left = {line for line in problems(proposed) if "follows from" not in line}
    for one in sorted(proposed, key=lambda one: (one.order, proposed.index(one)), reverse=True):
        rest = [other for other in proposed if other is not one]
        if all(line in left for line in problems(rest) if "follows from" not in line):
            proposed = rest
    return proposed


class _Builder:
    """Collects proposals, and questions of threads."""

    def __init__(self, verifier: DimensionVerifier) -> None:
        self.verifier = verifier
        self.features: Features = features_of(verifier)
        self.centred = centred_axes(verifier)
        self.proposed: list[Proposed] = []
        self.questions: list[str] = []
        self._levels: dict[str, list[Level]] = defaultdict(list)
        self._spans: dict[str, tuple[str, Level, Level]] = {}
        self.lines = VisibleLines(verifier)
        self._low, self._high = verifier.box

    def add(self, method: str, name: str, value: float, *arguments: Any, order: int = 0, **fields: Any) -> None:
        """Add a proposal under a name and key of its own."""
        used = {one.name for one in self.proposed}
        number = 2
        unique = name
        while unique in used:
            unique, number = f"{name} {number}", number + 1
        key = unique.replace(" ", "_").replace("-", "_")
        one = Proposed(method, unique, key, round(value, 9), arguments, fields, order)
        try:
            # Points of faces that should be one differ by the accuracy of the file.
            measured = self.verifier.measure(as_dimension(one))
        except LookupError:
            return
        if measured is not None and abs(measured - value) > NEAR:
            return
        self.proposed.append(one if measured is None else replace(one, value=round(measured, 9)))

    # Holes

    def holes(self) -> None:
        """Callouts of equal holes, circles on which they are, and the levels of their axes."""
        groups: dict[object, list[Hole]] = defaultdict(list)
        shafts, all_holes = self.features.shafts, self.features.holes
        rings = {id(hole): ring for ring in rings_around(all_holes, shafts) for hole in ring.holes}
        for hole in all_holes:
            groups[rings.get(id(hole), hole.kind)].append(hole)
        for number, (kind, group) in enumerate(groups.items(), start=1):
            ring = kind if isinstance(kind, Ring) else None
            head = max(group, key=lambda hole: (round(hole.mouth[1], 6), round(hole.mouth[0], 6)))
            head = ring.holes[0] if ring else head
            self._callout(f"hole {number}", head, len(group))
            if ring:
                angle, points = 360.0 / len(group), (ring.centre, ring.neighbour, ring.start)
                self.add("angle", f"angle {number}", angle, *points, view="section", count=len(group))
            circle = None if ring else centre_of_circle(group, shafts)
            if circle:
                centre = tidy(circle)
                self._pitch_circle(f"pitch circle {number}", centre, group)
                self._add_levels(head.into, centre, self._view_of(head))
            elif self._view_of(head) == "auxiliary":
                self._on_face(f"place {number}", group)
            elif along_of(head.into) is None:
                for count, hole in enumerate(group, start=1):
                    self._slanting(f"angle {number}" if count == 1 else f"angle {number}.{count}", hole)
            else:
                for hole in [head] if ring else group:
                    self._add_levels(hole.into, hole.mouth, self._view_of(hole), AXIS, f"hole {number}")

    def _view_of(self, hole: Hole) -> str:
        """View from the side of the mouth of a hole; for a slanting one that against its face; else the section."""
        if along_of(hole.into) is None:
            return "auxiliary" if self._face_of(hole) else "section"
        view = VIEW_OF[tidy(negative(hole.into))]
        # One in an inner wall is covered.
        return view if hole.through or not self.lines.is_covered(negative(hole.into), hole.mouth) else "section"

    def _face_of(self, hole: Hole) -> Surface | None:
        """The slanting face to which a hole is square."""
        faces = (s for s in self.features.slanted if Cut(s.origin, outward_normal(s), "").holds(hole.mouth, NEAR))
        return next((face for face in faces if abs(dot(face.axis, hole.into)) > 1 - 1e-6), None)

    def _on_face(self, name: str, group: Sequence[Hole]) -> None:
        """Distances of holes in a slanting face from its lowest corner, or of pairs about a middle plane."""
        face = self._face_of(group[0])
        assert face is not None
        view = projection_of(auxiliary(outward_normal(face)))
        for way in (view.right, view.up):
            corner = min(corners(face), key=lambda one: dot(one, way))
            levels = {round(dot(hole.mouth, way), 3): hole.mouth for hole in group}
            for level, mouth in sorted(levels.items()):
                mirror = levels.get(-level) if (along_of(way) or " ") in self.centred else None
                start = mirror if mirror and level > 0 else corner
                if mirror is None or level > 0:
                    value = dot(mouth, way) - dot(start, way)
                    self.add("linear", name, value, tidy(start), tidy(mouth), tidy(way), view="auxiliary")

    def _slanting(self, name: str, hole: Hole) -> None:
        """Angle of a hole against the face that it begins in, and the levels of the point where its axis meets it."""
        mouth, into = tidy(hole.mouth), hole.into
        planes = [s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, into)) > 0.1]
        begins = [s for s in planes if abs(dot(s.origin, s.axis) - dot(mouth, s.axis)) < NEAR and along_of(s.axis)]
        if sum(abs(a) < 1e-6 for a in into) != 1 or not begins:
            return
        normal = AXES[along_of(begins[0].axis) or "z"]
        start = next(unit for unit in AXES.values() if unit != normal and abs(dot(unit, into)) > 1e-6)
        start = start if dot(start, into) > 0 else negative(start)
        end = tidy(moved(mouth, into, 0.5 * hole.steps[-1][1]))
        angle = math.degrees(math.acos(dot(start, into)))
        self.add("angle", name, angle, mouth, end, start, view="section")
        self._add_levels(normal, mouth, self.lines.open_view(normal, mouth), MOUTH)

    def _add_levels(self, axis: Point, point: Point, view: str, kind: str = AXIS, *equal: str) -> None:
        """Levels of a point along the axes of the part that are square to its own axis."""
        for name, unit in AXES.items():
            if abs(dot(unit, axis)) < 1e-6:
                self._levels[name].append(Level(dot(point, unit), (point,), view, kind, frozenset(equal)))

    def _callout(self, name: str, hole: Hole, count: int) -> None:
        view = self._view_of(hole)
        common: dict[str, Any] = {"view": view, "count": count, "feature": name}
        along = positive(hole.into)
        last = len(hole.steps) - 1
        start = 0.0
        for number, (radius, end) in reversed(list(enumerate(hole.steps))):
            start = hole.steps[number - 1][1] if number else 0.0
            at = moved(hole.mouth, hole.into, (start + end) / 2)
            on = self._touch(hole.mouth, hole.into, radius, (start, end))
            step = name if number == last else f"{name} counterbore" + (f" {number + 1}" if number else "")
            note: dict[str, Any] = {"note": hole.way_out} if number == last and hole.through else {}
            at, direction = (on[0], on[1]) if on else (at, None)
            self.add("diameter", step, 2 * radius, tidy(at), along, direction, **common, **note)
            if (number < last or not hole.through) and self._is_outside(hole.mouth):
                end_point, into = moved(hole.mouth, hole.into, end), tidy(hole.into)
                self.add("depth", f"{step} depth", end, tidy(hole.mouth), tidy(end_point), into, **common)
        if hole.sink[0]:
            text: dict[str, Any] = {"note": f"x {hole.sink[1]:.0f}°"}
            out = next(unit for unit in AXES.values() if abs(dot(unit, along)) < 0.9)
            self.add("diameter", f"{name} countersink", hole.sink[0], tidy(hole.mouth), along, out, **common, **text)
        thread = tap_drill_of(2 * hole.steps[-1][0]) if len(hole.steps) == 1 and not hole.sink[0] else ""
        if thread:
            self.questions.append(
                f"{name}: is {2 * hole.steps[-1][0]:g} mm the tap drill of {thread}? Then declare it with d.tapped(...)"
            )

    def _is_outside(self, mouth: Point) -> bool:
        """Whether an axis meets a face of the part at a point, from which a depth is measured there."""
        planes = (dot(s.axis, mouth) - dot(s.axis, s.origin) for s in self.verifier.surfaces if s.kind == "PLANE")
        rounds = (s.off_axis(mouth) - s.radius for s in self.verifier.surfaces if s.kind == "CYLINDER")
        return any(abs(off) < NEAR for off in (*planes, *rounds))

    def _touch(self, mouth: Point, into: Point, radius: float, span: tuple[float, float]) -> tuple[Point, Point] | None:
        """A point of the axis, and a direction from it to a point that is on the face of a step."""
        for part in (0.5, 0.2, 0.8, 0.05, 0.95):
            at = moved(mouth, into, span[0] + part * (span[1] - span[0]))
            # Of a slanting hole the wall is touched in the plane of its section.
            across = [
                cross(into, unit) for unit in AXES.values() if abs(dot(unit, into)) < 1e-6 and along_of(into) is None
            ]
            # In the plane of a section through the middle first.
            usual = [AXES[name] for name in "zxy"]
            for unit in (*across, *usual, *map(negative, usual)):
                if abs(dot(unit, into)) < 1e-6:
                    point = moved(at, unit, radius)
                    if any(s.is_round(radius) and s.holds(point) for s in self.verifier.surfaces):
                        return at, unit
        return None

    def _pitch_circle(self, name: str, centre: Point, group: Sequence[Hole]) -> None:
        hole = group[0]
        radius = math.dist(hole.mouth, centre)
        at = moved(hole.mouth, hole.into, hole.steps[-1][1] * 0.5)
        middle = moved(centre, hole.into, hole.steps[-1][1] * 0.5)
        along = tidy(tuple(abs(a) for a in hole.into))  # type: ignore[arg-type]
        view = self._view_of(hole)
        self.add("pitch_circle", name, 2 * radius, tidy(middle), tidy(at), len(group), along, view=view)

    # Slots, shafts, fillets, chamfers

    def slots(self) -> None:
        """Widths of slots, and the levels of the axes of their ends."""
        groups: dict[tuple[object, ...], list[tuple[Point, Point, str]]] = defaultdict(list)
        for slot in self.features.slots:
            (first, second), axis = slot.centres, slot.axis
            run = tuple(b - a for a, b in zip(first, second, strict=True))
            size = math.hypot(*run)
            across = positive(cross(axis, tuple(r / size for r in run)))  # type: ignore[arg-type]
            middle: Point = tuple((a + b) / 2 for a, b in zip(first, second, strict=True))  # type: ignore[assignment]
            view = self.lines.open_view(axis, middle)
            groups[(round(slot.radius, 4), across, view, round(dot(middle, tidy(axis)), 3))].append(
                (middle, across, view)
            )
            for centre in slot.centres:
                self._add_levels(axis, tidy(centre), view)
        for number, (key, group) in enumerate(groups.items(), start=1):
            (middle, across, view), radius = group[-1], float(key[0])  # type: ignore[arg-type]
            ends = [tidy(moved(middle, across, side * radius)) for side in (-1.0, 1.0)]
            count = {"count": len(group)} if len(group) > 1 else {}
            self.add("linear", f"slot {number} width", 2 * radius, *ends, across, view=view, **count)

    def round_features(self) -> None:
        """Diameters of shafts and bosses, radii of fillets and balls."""
        shafts: dict[tuple[object, ...], list[Any]] = defaultdict(list)
        grooves = self.features.grooves
        for shaft in (*self.features.shafts, *grooves):
            key = (round(shaft.radius, 3), shaft in grooves, round(abs(dot(shaft.face.axis, (1, 2, 4))), 3))
            shafts[key].append(shaft)
        for number, group in enumerate(shafts.values(), start=1):
            shaft = group[0]
            axis = shaft.axis
            at = moved(shaft.face.origin, axis, (shaft.low + shaft.high) / 2 - dot(shaft.face.origin, axis))
            on = self._touch(moved(at, axis, -1e-3), axis, shaft.radius, (0.0, 2e-3))
            view = "section" if shaft in grooves else self._side_view(axis, shaft.radius, at)
            count = {"count": len(group)} if len(group) > 1 else {}
            direction = on[1] if on else None
            self.add(
                "diameter",
                f"diameter {number}",
                2 * shaft.radius,
                tidy(at),
                positive(axis),
                direction,
                view=view,
                **count,
            )
            for one in group:
                foot = moved(one.face.origin, axis, (one.low + one.high) / 2 - dot(one.face.origin, axis))
                self._add_levels(axis, tidy(foot), VIEW_OF.get(tidy(positive(axis)), "top"))
        rounds: dict[tuple[object, ...], list[Surface]] = defaultdict(list)
        for face in (*self.features.fillets, *self.features.spheres):
            key = (face.kind == "SPHERE", round(face.radius, 4))
            rounds[key].append(face)
        for face in self.features.fillets:
            if face.kind == "CYLINDER" and not is_fillet(face, self.verifier.surfaces):
                foot = moved(face.origin, face.axis, dot(middle_of_face(face), face.axis) - dot(face.origin, face.axis))
                self._add_levels(face.axis, tidy(foot), self.lines.open_view(face.axis, middle_of_face(face)))
        for number, faces in enumerate(rounds.values(), start=1):
            circular = [face for face in faces if face.kind == "CYLINDER"] or faces
            face = circular[0]
            axis = face.axis
            kinds = len({s.axis_key if s.kind == "CYLINDER" else (id(s),) for s in faces})
            view = self.lines.open_view(axis, middle_of_face(face), "section") if face.kind == "CYLINDER" else "front"
            note: dict[str, Any] = {"note": "spherical"} if face.kind == "SPHERE" else {}
            count = {"count": kinds} if kinds > 1 else {}
            self.add(
                "radius",
                f"radius {number}",
                face.radius,
                tidy(middle_of_face(face)),
                positive(axis) if face.kind != "SPHERE" else (0.0, 0.0, 1.0),
                view=view,
                **count,
                **note,
            )

    def _side_view(self, axis: Point, radius: float, at: Point) -> str:
        """View that shows both outlines of a round feature from the side, else the one along its axis."""
        for view in ("front", "right", "top", "back", "left", "bottom"):
            eye = PROJECTIONS[view].towards_eye
            if abs(dot(eye, axis)) < 1e-6:
                across = cross(eye, axis)
                if all(self.lines.seen(moved(at, across, side * radius), view) is not None for side in (-1.0, 1.0)):
                    return view
        # In a groove of an end face it is seen from the side of the groove.
        beside = next((moved(at, unit, radius + 2e-3) for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6), at)
        return self.lines.open_view(axis, beside, VIEW_OF.get(tidy(positive(axis)), "top"))

    def chamfers(self) -> None:
        """Legs of chamfers, equal ones together."""
        groups: dict[float, list[tuple[Surface, Point]]] = defaultdict(list)
        for face in self.features.chamfers:
            along = face.axis if face.kind == "CONE" else next(u for u in AXES.values() if abs(dot(face.axis, u)) > 0.1)
            number = list(AXES).index(along_of(along) or "x")
            groups[round(face.high[number] - face.low[number], 3)].append((face, positive(along)))
        for number, (leg, faces) in enumerate(groups.items(), start=1):
            # A chamfer of a hole is not seen from the side.
            face, along = max(faces, key=lambda one: one[0].kind == "PLANE" or one[0].outward)
            view = self._chamfer_view(face, along)
            point = on_outline(face, view) if face.kind == "CONE" else middle_of_face(face)
            count = {"count": len(faces)} if len(faces) > 1 else {}
            self.add("chamfer", f"chamfer {number}", leg, tidy(point), along, view=view, **count)

    def _chamfer_view(self, face: Surface, along: Point) -> str:
        if face.kind == "CONE" and not face.outward:
            return self.lines.open_view(along, middle_of_face(face))
        if face.kind == "PLANE":
            free = next(u for u in AXES.values() if abs(dot(face.axis, u)) < 0.1)
            return self.lines.open_view(free, middle_of_face(face))
        return next(v for v in ("front", "right", "top") if abs(dot(PROJECTIONS[v].towards_eye, along)) < 1e-6)

    # Levels

    def levels(self) -> None:
        """Distances that give the levels of planes, axes and corners along each axis of the part."""
        for surface in self.verifier.surfaces:
            name = along_of(surface.axis) if surface.kind == "PLANE" else None
            if name is not None:
                at = dot(surface.origin, AXES[name])
                points = (*surface.vertices, *extremes(surface))
                self._levels[name].append(Level(at, points or (tidy(middle_of_face(surface)),)))
        for surface in self.features.spheres:
            for name, unit in AXES.items():
                out = next(axis for axis in AXES.values() if axis != unit)
                point = tidy(moved(surface.origin, out, surface.radius))
                self._levels[name].append(Level(dot(surface.origin, unit), (point,)))
        for surface in self.features.slanted:
            for name, unit in AXES.items():
                if abs(dot(surface.axis, unit)) > 1e-6:
                    for vertex in corners(surface):
                        self._levels[name].append(Level(dot(vertex, unit), (vertex,)))
        self._cone_ends()
        for number, name in enumerate(AXES):
            self._axis_levels(name, self._low[number], self._high[number])

    def _cone_ends(self) -> None:
        """Levels of the ends of cones, and their diameters where no cylinder has them."""
        known = [s for s in self.verifier.surfaces if s.kind == "CYLINDER"]
        done: set[tuple[float, ...]] = set()
        for cone in self.features.cones:
            name = along_of(cone.axis)
            if name is None:
                continue
            for vertex in cone.vertices:
                radius, at = cone.off_axis(vertex), dot(vertex, AXES[name])
                key = (*cone.axis_key, round(at, 2), round(radius, 2))
                if radius < NEAR or key in done:
                    continue
                done.add(key)
                self._levels[name].append(Level(at, (vertex,)))
                if not any(abs(one.radius - radius) < NEAR and one.is_coaxial(cone) for one in known):
                    foot = tidy(moved(cone.origin, AXES[name], at - dot(cone.origin, AXES[name])))
                    out = tuple((v - f) / radius for v, f in zip(vertex, foot, strict=True))
                    view = self._side_view(cone.axis, radius, foot) if cone.outward else "section"
                    number = 1 + sum(one.name.startswith("cone") for one in self.proposed)
                    self.add("diameter", f"cone {number}", 2 * radius, foot, AXES[name], out, view=view)

    def _axis_levels(self, name: str, low: float, high: float) -> None:
        rows: list[Level] = []
        for level in sorted(self._levels[name], key=lambda one: one.at):
            if rows and abs(level.at - rows[-1].at) < NEAR:
                last = rows[-1]
                view = last.view or level.view
                kind = last.kind if last.kind == level.kind else FACE if FACE in (last.kind, level.kind) else AXIS
                points, equal = (*last.points, *level.points), last.of | level.of
                rows[-1] = replace(last, points=points, view=view, kind=kind, of=equal)
            else:
                rows.append(level)
        by_level = {round(row.at, 3): row for row in rows}
        ends = [row for row in (by_level.get(round(low, 3)), by_level.get(round(high, 3))) if row is not None]
        size = {"x": "length", "y": "width", "z": "height"}[name]
        if len(ends) == 2 and ends[0] is not ends[1]:
            self._between(size, name, *ends, order=0)
        if name in self.centred:
            self._pairs(name, rows, ends)
        else:
            self._from_datum(name, rows, ends)

    def _pairs(self, name: str, rows: list[Level], ends: list[Level]) -> None:
        """Distances of levels at both sides of the middle; a level at one side only is given from an end."""
        spaced = [row for row in row_of_equal_steps(rows) if abs(row.at) > NEAR]
        spaced = spaced if spaced and abs(spaced[0].at + spaced[-1].at) < NEAR else []
        self._pitch(name, row_of_equal_steps(rows) if spaced else [])
        for row in rows:
            middle = abs(row.at) < NEAR
            if row in ends or row in spaced or (middle and row.kind != FACE):
                continue
            mirror = None if middle else next((other for other in rows if abs(other.at + row.at) < NEAR), None)
            if mirror is None:
                start = next((end for end in ends if end.at * row.at > 0), ends[0] if ends else None)
                start = start or next((one for one in rows if abs(one.at) < NEAR and row.kind == AXIS), None)
                if start is None:
                    self._from_outline(name, row)
                    continue
                self._between(f"{name} place", name, start, row)
            elif row.at < 0:
                what = "spacing" if row.kind == AXIS else "distance"
                self._between(f"{name} {what}", name, row, mirror)

    def _from_outline(self, name: str, row: Level) -> None:
        """Distance of a flat or key seat from the opposite outline of a round part."""
        shaft = max(self.features.shafts, key=lambda shaft: shaft.radius, default=None)
        inner = self._in_section(name, row, row)
        if shaft is None or inner is None:
            return
        (_, on), _ = inner
        number = list(AXES).index(name)
        own = [s for s in self.features.shafts if s.low - NEAR <= dot(on, s.axis) <= s.high + NEAR]
        radius, view = max((s.radius for s in own), default=shaft.radius), "section"
        across = [s.radius for hole in self.features.holes for s in hole.faces if s.axis_key == shaft.face.axis_key]
        seat = [r for r in across if r < abs(row.at)]
        if seat and any(on[number] * outward_normal(s)[number] < 0 for s in self.verifier.surfaces if s.holds(on)):
            # The floor of a key seat in a bore, from the opposite wall of the bore.
            radius, view = max(seat), VIEW_OF.get(positive(shaft.face.axis), "section")
        opposite = at_level(on, name, -math.copysign(radius, row.at))
        self.add("linear", f"{name} place", abs(row.at) + radius, opposite, on, AXES[name], view=view, order=1)

    def _from_datum(self, name: str, rows: list[Level], ends: list[Level]) -> None:
        """Distances from a datum: the lower end, else the middle axis of the part."""
        axis = next((row for row in rows if abs(row.at) < NEAR or row.kind == AXIS), None)
        datum = ends[0] if ends else axis
        if datum is None:
            return
        spaced = row_of_equal_steps(rows)
        self._pitch(name, spaced)
        for row in rows:
            if row is not datum and row not in ends[1:] and row not in spaced[1:]:
                self._between(f"{name} place", name, datum, row)

    def _pitch(self, name: str, spaced: list[Level]) -> None:
        """The distance of neighbours in a row of equal features."""
        if spaced:
            (one, other), view = self._points(name, spaced[0], spaced[-1])
            steps = len(spaced) - 1
            self.add("pitch", f"{name} pitch", (spaced[-1].at - spaced[0].at) / steps, one, other, steps, view=view)

    def _between(self, what: str, name: str, first: Level, second: Level, order: int | None = None) -> None:
        (one, other), view = self._points(name, first, second)
        rank = order if order is not None else 1 if second.view else 2
        self.add("linear", what, abs(second.at - first.at), one, other, AXES[name], view=view, order=rank)
        if self.proposed:
            self._spans.setdefault(self.proposed[-1].name, (name, first, second))

    def in_fewer_views(self, proposed: list[Proposed]) -> list[Proposed]:
        """The proposals without views of which other views show all distances."""
        for view in ("right", "left", "back", "bottom", "top"):
            used: set[str] = {one.fields.get("view", "front") for one in proposed} | {"front"}
            moved_to: dict[str, Proposed] = {}
            inside = [one for one in proposed if one.fields.get("view") == view]
            for one in inside:
                if found := self._in_views(one, used - {view}):
                    moved_to[one.name] = found
            if len(moved_to) == len(inside):
                proposed = [moved_to.get(one.name, one) for one in proposed]
        return proposed

    def in_section(self, proposed: list[Proposed]) -> list[Proposed]:
        """The proposals with the ends of those in the front view on lines that it has as a section."""
        self.lines.cut_front()
        inside = [one if one.fields.get("view") == "front" else None for one in proposed]
        return [(one and self._in_views(one, {"front"})) or own for one, own in zip(inside, proposed, strict=True)]

    def _in_views(self, one: Proposed, views: Collection[str]) -> Proposed | None:
        """A distance in that of some views that shows it best; None for others, or if no view shows it."""
        name, first, second = self._spans.get(one.name, ("x", Level(0.0, ()), Level(0.0, ())))
        shown, points, view = self._best(name, first, second, views_along(name, views))
        fields = {**one.fields, "view": view}
        return replace(one, arguments=(*points, *one.arguments[2:]), fields=fields) if shown else None

    def with_inside(self, views: tuple[str, ...], proposed: Sequence[Proposed]) -> tuple[str, ...]:
        """The views, the front view as a section through the middle where this shows the holes, else with hidden lines
        where there are blind or stepped ones."""
        sections = [one for one in proposed if one.fields.get("view") == "section"]
        middle = any(abs(one.arguments[0][1]) + abs(one.arguments[1][1]) < NEAR for one in sections)
        turned = {shaft.face.axis_key for shaft in self.features.shafts}
        deep = [h for h in self.features.holes if not h.through or len(h.steps) > 1 or h.faces[0].axis_key in turned]
        middle |= any(abs(hole.mouth[1]) < NEAR and abs(hole.into[1]) < NEAR for hole in deep)
        facing = any(abs(hole.into[1]) > NEAR for hole in self.features.holes)
        long = any(abs(shaft.face.axis[0]) > 0.5 and not deep for shaft in self.features.shafts)
        front = ""
        if middle and not facing and not long and "y" in self.centred and is_mirrored(self.verifier.surfaces, 1, 0.0):
            front = "front section"
        elif deep:
            front = "front hidden"
        return (front, *(view for view in views if view != "front")) if front else views

    def _points(self, name: str, first: Level, second: Level) -> tuple[tuple[Point, Point], str]:
        """Points of two levels in the view that shows both best, else in a section through the middle of a face."""
        wanted = [view for view in (second.view, first.view) if view in views_along(name)]
        shown, points, view = self._best(name, first, second, [*wanted, *PREFERRED[name], *views_along(name)])
        if second.kind == AXIS and second.view == "section":
            return (at_level(second.points[0], name, first.at), second.points[0]), "section"
        inner = None if shown or second.kind == AXIS else self._in_section(name, first, second)
        return inner or (points, view)

    def _best(
        self, name: str, first: Level, second: Level, views: Sequence[str]
    ) -> tuple[bool, tuple[Point, Point], str]:
        """Whether one of some views shows two levels, and the points and the view that show them best."""
        found: list[tuple[float, Point, Point, str]] = []
        for rank, view in enumerate(dict.fromkeys(views)):
            if found and min(found)[0] < ANOTHER_VIEW * rank:
                break
            for cost, one in self._shown(first, view):
                for more, other in self._shown(second, view):
                    away = self._offset(one, other, view, name)
                    found.append((cost + more + away + ANOTHER_VIEW * rank, one, other, view))
        if not found:
            one, other = ((*level.points, (0.0, 0.0, 0.0))[0] for level in (first, second))
            return False, (tidy(one), tidy(other)), PREFERRED[name][0]
        _, one, other, view = min(found)
        ends = ((one, first), (other, second))
        shown = all(self.lines.seen(point, view) == 0.0 or level.kind == AXIS for point, level in ends)
        return shown, (tidy(one), tidy(other)), view

    def _in_section(self, name: str, first: Level, second: Level) -> tuple[tuple[Point, Point], str] | None:
        """Ends of a distance to a face within the part, in a section through the middle of this face."""
        planes = (s for s in self.verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) == name)
        face = next((s for s in planes if abs(dot(s.origin, AXES[name]) - second.at) < NEAR), None)
        inside = middle_of_face(face) if face else None
        return ((at_level(inside, name, first.at), tidy(inside)), "section") if inside else None

    def _shown(self, level: Level, view: str) -> list[tuple[float, Point]]:
        """Points of a level in a view with their costs; the axes of holes in the view along them."""
        if level.kind != FACE and level.view == view:
            return [(0.0, point) for point in level.points[:8]]
        costs = [(self.lines.seen(point, view), point) for point in dict.fromkeys(level.points[:60])]
        return sorted((cost, point) for cost, point in costs if cost is not None)[:8]

    def _offset(self, one: Point, other: Point, view: str, name: str) -> float:
        step = [b - a for a, b in zip(PROJECTIONS[view].to_view(one), PROJECTIONS[view].to_view(other), strict=True)]
        u, v = PROJECTIONS[view].to_view(AXES[name])
        return round(abs(step[0] * v - step[1] * u), 3)
