"""Dimensions proposed for a solid without declarations, until the check of definition is satisfied and none is spare.

Each feature gives its size (`drawings.recognition.features`); the levels of faces and axes along each axis of the part
are tied to a datum face, or in pairs to the middle where the part reaches equally far to both sides. Each dimension is
in a view in which lines of the part are drawn at its points. A dimension without which the check is still satisfied is
left out. The result is data: it is written as Python (`drawings.recognition.part_file`).
"""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

from drawings.dimensions.contours import FREE, by_model, marks_of
from drawings.dimensions.definition import Definition, Notes, centred_axes, definition
from drawings.dimensions.levels import AXES, NEAR, SQUARE, along_of, is_fillet, is_usual_size, key_of_chamfer, tube_of
from drawings.recognition.features import AXIS, MOUTH, Hole, Level, centre_of_circle, middle_of_face, tap_drill_of
from drawings.recognition.part_file import Proposal, Proposed, as_dimension
from drawings.recognition.rings import Ring, features_around, rings_around
from drawings.recognition.visible import (
    VIEW_OF,
    at_level,
    extremes,
    negative,
    on_outline,
    positive,
    proposed_datums,
    tidy,
    usual_eye,
)
from drawings.recognition.walls import Walls
from drawings.views.view import PROJECTIONS, Cut, auxiliary, dot, projection_of
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Prism, Surface, connected, moved, turned
from stagecad.solids.modelling.verification import DimensionVerifier

FLATS = {2: "SQ", 3: "HEX AF", 4: "OCT AF"}
"""Words beside the width across the flats of a regular prism, by the number of its pairs of sides."""
ANGLE_STEP = 15
"""Step of the directions in which the outline of a ball is looked for, degrees."""


def propose(verifier: DimensionVerifier, without: Collection[str] = ()) -> Proposal:
    """Dimensions of a solid, without some, which no view of its sheet shows."""
    builder = _Builder(verifier)
    builder.marks()
    builder.equal_features()
    builder.prisms()
    builder.webs()
    builder.holes()
    builder.round_features()
    builder.arms()
    builder.chamfers()
    builder.angles()
    builder.levels()
    found = builder.proposed
    symmetric = centred_axes(verifier)

    made: dict[str, tuple[Proposed, Dimension]] = {}

    def defined(proposed: Sequence[Proposed]) -> Definition:
        for one in proposed:
            if one.name not in made or made[one.name][0] is not one:
                made[one.name] = (one, as_dimension(one))
        dimensions = [made[one.name][1] for one in proposed]
        return definition(verifier, dimensions, (), Notes(symmetric, packaged=False, model=True))

    def problems(proposed: Sequence[Proposed]) -> tuple[str, ...]:
        return defined(proposed).problems

    found = builder.in_fewer_views(_without_superfluous(found, problems))
    model = dict(builder.of_model())
    questions = (*builder.questions, *model.values())
    views = tuple(dict.fromkeys(one.fields["view"] for one in found if "view" in one.fields))
    views, found = builder.with_inside(views, found)
    views, shown = builder.without_hidden(views, [one for one in found if one.name not in without])
    # A distance may need one that was left out to give a face.
    found = _without_superfluous(shown, problems) if len(shown) < len(found) else shown
    undefined = tuple(face.words for face in defined(found).faces if any(face.problems))
    if undefined:
        questions = (*questions, f"no dimension gives these faces, but the model: {'; '.join(undefined)}")
    diameters = {one.value: one.fields["view"] for one in found if one.name.startswith("diameter")}
    seen = [view.partition(" ")[0] for view in views]
    datums = tuple(proposed_datums(verifier, builder.features, seen, diameters, builder.lines, builder.walls))
    return Proposal(tuple(found), questions, problems(found), views, datums, tuple(model), undefined)


def _without_superfluous(
    proposed: list[Proposed], problems: Callable[[Sequence[Proposed]], tuple[str, ...]]
) -> list[Proposed]:
    """The proposals without those that the definition does not need, the last ones first; a hole keeps its depths, and
    beside them its diameters."""
    left = {line for line in problems(proposed) if "follows from" not in line}
    for one in sorted(proposed, key=lambda one: (one.order, proposed.index(one)), reverse=True):
        rest = [other for other in proposed if other is not one]
        has_depth = one.method == "depth" or any(other.name == f"{one.name} depth" for other in rest)
        if not has_depth and all(line in left for line in problems(rest) if "follows from" not in line):
            proposed = rest
    return proposed


class _Builder(Walls):
    """Collects proposals, and questions of threads."""

    # What the model gives

    def marks(self) -> None:
        """Depths of engraved marks, whose outlines the model gives."""
        for mark in marks_of(self.verifier):
            self.images |= {id(s) for s in mark.walls}
            if mark.is_recess:
                self.images |= {id(s) for s in mark.areas}
                area = max(mark.areas, key=lambda s: s.face.Area())
                end = tidy(middle_of_face(area))
                if not area.holds(end):
                    end = area.vertices[0]
                mouth, out = at_level(end, mark.axis, mark.mouth), tidy(area.normal)
                fields: dict[str, Any] = {"view": VIEW_OF[out], "feature": "mark", "note": "outline by the model"}
                self.add("depth", "mark", abs(mark.mouth - mark.level), mouth, end, negative(out), **fields)

    def of_model(self) -> Iterator[tuple[str, str]]:
        """What is left to the model, and the question to the designer about it, each kind once."""
        marks = marks_of(self.verifier)
        if marks:
            places = ", ".join(f"({', '.join(f'{a:.0f}' for a in middle_of_face(mark.areas[0]))})" for mark in marks)
            yield "outlines of marks", f"marks at {places}: are they text? Then state text, font and height"
        if free := sum(by_model(s, self.verifier) == FREE for s in self.verifier.surfaces):
            yield "free-form faces", f"the model gives {free} free-form faces: with which tolerance of profile?"

    def equal_features(self) -> None:
        """Angles of equal features around the axis of the part, of which one is dimensioned."""
        surfaces, shafts = self.verifier.surfaces, self.features.shafts
        shaft = max(shafts, key=lambda one: one.radius, default=None)
        known = (*(s for hole in self.features.holes for s in hole.faces), *self.features.chamfers)
        taken = {id(s) for s in known} | {id(s) for s in self.features.fillets if is_fillet(s, surfaces)}
        if shaft is None or along_of(shaft.axis) is None:
            return
        taken |= {id(s) for one in self.verifier.prisms if shaft.face.off_axis(one.centre) < NEAR for s in one.sides}
        for ring in features_around(surfaces, shaft, taken):
            count, points = len(ring.features), (ring.centre, ring.neighbour, ring.start)
            fields: dict[str, Any] = {"view": self.lines.open_view(shaft.axis, ring.neighbour), "count": count}
            before = len(self.proposed)
            self.add("angle", "angle around", 360.0 / count, *points, **fields)
            if len(self.proposed) > before:
                self.images |= {id(s) for feature in ring.features[1:] for s in feature}
                self.around.update({id(s): count for s in ring.features[0]})
                vertices = [v for s in ring.features[0] for v in s.vertices]
                steps = ((v, turned(subtract(v, ring.centre), shaft.axis, math.tau / count)) for v in vertices)
                images = [(v, add(ring.centre, step)) for v, step in steps]
                self.images_of |= {at: v for v, image in images for at in vertices if math.dist(at, image) < NEAR}
                self.around_view = fields["view"]

    # Holes

    def holes(self) -> None:
        """Callouts of equal holes, circles on which they are, and the levels of their axes."""
        groups: dict[object, list[Hole]] = defaultdict(list)
        shafts, all_holes = self.features.shafts, self.features.holes
        rings = {id(hole): ring for ring in rings_around(all_holes, shafts) for hole in ring.features}
        for hole in all_holes:
            group = groups[rings.get(id(hole), hole.kind)]
            # One through several walls is one hole.
            again = id(hole) not in rings and any(hole.faces[0].is_coaxial(other.faces[0]) for other in group)
            group += [] if again else [hole]
        for number, (kind, group) in enumerate(groups.items(), start=1):
            ring = kind if isinstance(kind, Ring) else None
            head = max(group, key=lambda hole: (round(hole.mouth[1], 6), round(hole.mouth[0], 6)))
            head, level = ring.features[0] if ring else head, dot(head.mouth, head.into)
            if not ring:
                ends = (moved(hole.mouth, hole.into, level - dot(hole.mouth, hole.into)) for hole in group)
                group = [replace(hole, mouth=tidy(end)) for hole, end in zip(group, ends, strict=True)]
            self._callout(f"hole {number}", head, len(group))
            if ring:
                angle, points = 360.0 / len(group), (ring.centre, ring.neighbour, ring.start)
                self.add("angle", f"angle {number}", angle, *points, view="section", count=len(group))
            even = None if ring else centre_of_circle(group, shafts)
            circle = even or (None if ring else self._common_circle(group))
            if circle:
                centre = tidy(circle)
                self._pitch_circle(f"pitch circle {number}", centre, group, len(group) if even else 1)
                self.add_levels(head.into, centre, self._view_of(head))
            elif self._view_of(head) == "auxiliary":
                self._on_face(f"place {number}", group)
            elif along_of(head.into) is None:
                for count, hole in enumerate(group, start=1):
                    self._slanting(f"angle {number}" if count == 1 else f"angle {number}.{count}", hole)
            else:
                for hole in [head] if ring else group:
                    self.add_levels(hole.into, hole.mouth, self._view_of(hole), AXIS, f"hole {number}")

    def _view_of(self, hole: Hole) -> str:
        """View from the side of the mouth of a hole; for a slanting one that against its face; else the section."""
        if along_of(hole.into) is None:
            return "auxiliary" if self._face_of(hole) else "section"
        view = VIEW_OF[tidy(negative(hole.into))]
        # One in an inner wall is covered.
        return view if hole.through or not self.lines.is_covered(negative(hole.into), hole.mouth) else "section"

    def _face_of(self, hole: Hole) -> Surface | None:
        """The slanting face to which a hole is square."""
        faces = (s for s in self.features.slanted if Cut(s.origin, s.normal, "").holds(hole.mouth, NEAR))
        return next((face for face in faces if abs(dot(face.axis, hole.into)) > 1 - 1e-6), None)

    def _on_face(self, name: str, group: Sequence[Hole]) -> None:
        """Distances of holes in a slanting face from its lowest corner, or of pairs about a middle plane."""
        face = self._face_of(group[0])
        assert face is not None
        view = projection_of(auxiliary(face.normal))
        for way in (view.right, view.up):
            corner = min(face.corners, key=lambda one: dot(one, way))
            levels = {round(dot(hole.mouth, way), 3): hole.mouth for hole in group}
            for level, mouth in sorted(levels.items()):
                mirror = levels.get(-level) if (along_of(way) or " ") in self.centred else None
                start = mirror if mirror and level > 0 else corner
                if mirror is None or level > 0:
                    value = dot(mouth, way) - dot(start, way)
                    self.add("linear", name, value, tidy(start), tidy(mouth), tidy(way), view="auxiliary")

    def _slanting(self, name: str, hole: Hole) -> None:
        """Angle of a hole against the face that it begins in, and the levels of the point where its axis meets it; of
        one towards the axis of a round face against an axis of the part."""
        mouth, into = tidy(hole.mouth), hole.into
        rounds = (s for s in self.verifier.surfaces if s.kind == "CYLINDER" and s.outward and s.is_at(mouth))
        if shaft := next(filter(hole.faces[0].meets, rounds), None):
            centre = tidy(moved(shaft.origin, shaft.axis, dot(subtract(mouth, shaft.origin), shaft.axis)))
            inner, out = tidy(moved(mouth, into, 0.5 * hole.steps[-1][1])), negative(into)
            start = max(
                (way for unit in AXES.values() for way in (unit, negative(unit))), key=lambda way: dot(way, out)
            )
            self.add("angle", name, math.degrees(math.acos(dot(start, out))), centre, inner, start, view="section")
            self.add_levels(start, mouth, "section", MOUTH)
            return
        planes = [s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, into)) > 0.1]
        begins = [s for s in planes if abs(dot(s.origin, s.axis) - dot(mouth, s.axis)) < NEAR and along_of(s.axis)]
        if sum(abs(a) < 1e-6 for a in into) != 1 or not begins:
            return
        normal = AXES[along_of(begins[0].axis) or "z"]
        start = next(unit for unit in AXES.values() if unit != normal and abs(dot(unit, into)) > 1e-6)
        beside = next(unit for unit in AXES.values() if abs(dot(unit, into)) < 1e-6)
        met = None if is_usual_size(dot(mouth, start)) else self._crossing(hole, beside)
        start = start if dot(start, into) > 0 else negative(start)
        view, inner = self.lines.open_view(normal, mouth), tidy(moved(mouth, into, 0.5 * hole.steps[-1][1]))
        vertex, end, start = (met, mouth, negative(start)) if met else (mouth, inner, start)
        angle = math.degrees(math.acos(dot(start, towards(vertex, end))))
        self.add("angle", name, angle, vertex, end, start, view="section")
        if met:
            self.levels_of[along_of(beside) or "x"].append(Level(dot(mouth, beside), (mouth,), view, MOUTH))
        else:
            self.add_levels(normal, mouth, view, MOUTH)

    def _crossing(self, hole: Hole, beside: Point) -> Point | None:
        """Where the axis of a slanting hole meets that of a bore across it."""
        bores = (o.faces[0] for o in self.features.holes if abs(dot(o.faces[0].axis, beside)) > 1 - 1e-6)
        at = ((s, moved(hole.mouth, hole.into, dot(subtract(s.origin, hole.mouth), hole.into))) for s in bores)
        return next((tidy(point) for s, point in at if s.off_axis(point) < NEAR), None)

    def _callout(self, name: str, hole: Hole, count: int) -> None:
        common: dict[str, Any] = {"view": self._view_of(hole), "count": count, "feature": name}
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
            end_point, into = moved(hole.mouth, hole.into, end), tidy(hole.into)
            # Of one in a round face a floor at a usual distance from the axis of this has that.
            planes = (s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, into)) > 0.1)
            flat = any(s.is_level(hole.mouth) for s in planes)
            usual = flat or is_usual_size(end) or not is_usual_size(dot(end_point, into))
            if (number < last or not hole.through) and self._is_outside(hole.mouth) and usual:
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
            # Slits may be there.
            between = [scaled(add(one, other), 0.5**0.5) for one, other in combinations(usual, 2)]
            for unit in (*across, *usual, *map(negative, usual), *between, *map(negative, between)):
                if abs(dot(unit, into)) < 1e-6:
                    point = moved(at, unit, radius)
                    if any(s.is_round(radius) and s.holds(point) for s in self.verifier.surfaces):
                        return at, unit
        # Equal notches around it may be in all of these directions.
        faces = (s for s in self.verifier.surfaces if s.is_round(radius) and s.off_axis(mouth) < NEAR)
        at = moved(mouth, into, sum(span) / 2)
        ways = (tidy(s.radial(s.middle[1])) for s in faces)
        return next(
            ((at, way) for way in ways if any(s.holds(moved(at, way, radius)) for s in self.verifier.surfaces)), None
        )

    def _common_circle(self, group: Sequence[Hole]) -> Point | None:
        """Centre of a circle about the largest round face on which equal holes are at angles of a usual value."""
        into, rounds = group[0].into, self.rounds(group[0].into)
        if len(group) < 3 or not rounds or along_of(into) is None:
            return None
        centre = moved(rounds[0].origin, into, dot(subtract(group[0].mouth, rounds[0].origin), into))
        radii = [math.dist(hole.mouth, centre) for hole in group]
        if max(radii) - min(radii) > NEAR or min(radii) < NEAR or not is_usual_size(radii[0]):
            return None
        start = next(unit for unit in AXES.values() if abs(dot(unit, into)) < NEAR)
        halves = [2 * math.degrees(math.acos(dot(start, towards(centre, hole.mouth)))) for hole in group]
        return centre if all(abs(half - round(half)) < 1e-4 for half in halves) else None

    def _pitch_circle(self, name: str, centre: Point, group: Sequence[Hole], count: int) -> None:
        """The circle of holes, and the least angle of one from an axis of the part where they are not mirror images
        about it; of each that is not on an axis where `count` is 1, for holes that are not equally spaced."""
        hole = group[0]
        radius, middle = math.dist(hole.mouth, centre), moved(centre, hole.into, hole.steps[-1][1] * 0.5)
        along = tidy(tuple(abs(a) for a in hole.into))  # type: ignore[arg-type]
        view, across = self._view_of(hole), [unit for unit in AXES.values() if abs(dot(unit, along)) < 1e-6]
        ends = [moved(one.mouth, hole.into, hole.steps[-1][1] * 0.5) for one in group]
        self.add("pitch_circle", name, 2 * radius, tidy(middle), tidy(ends[0]), count, along, view=view)
        found: list[tuple[float, Point, Point]] = []
        for end in ends:
            units = [way for unit in across for way in (unit, negative(unit))] if count == 1 else across
            near = max(units, key=lambda unit: round(dot(unit, subtract(end, middle)), 6))
            found.append((math.degrees(math.acos(min(1.0, dot(subtract(end, middle), near) / radius))), end, near))
        step = 180.0 / count
        found.sort(key=lambda one: round(one[0], 6))
        for angle, end, start in found if count == 1 else found[:1]:
            if min(min(off % step, step - off % step) for off in (angle, 90.0 - angle)) > 1e-3:
                self.add("angle", f"{name} angle", angle, tidy(middle), tidy(end), start, view=view)

    # Prisms, shafts, fillets, chamfers

    def prisms(self) -> None:
        """Sizes of slots, rectangular openings and regular prisms, equal ones together, their middles and angles."""
        groups: dict[tuple[object, ...], list[Prism]] = defaultdict(list)
        for one in (one for one in self.verifier.prisms if not any(id(side) in self.images for side in one.sides)):
            view = self.lines.open_view(one.axis, middle_of_face(one.pairs[0][0]))
            sizes = (round(a, 3) + 0.0 for way, value in one.widths for a in (*positive(way), value))
            groups[view, one.axis, round(dot(one.centre, one.axis), 3), *sizes].append(one)
            self.images |= {id(side) for side in one.sides}
        for number, (key, group) in enumerate(groups.items(), start=1):
            view, one, count = str(key[0]), group[0], len(group)
            count = max(count, *(self.around.get(id(side), 1) for side in one.sides))
            fields: dict[str, Any] = {"view": view, **({"count": count} if count > 1 else {})}
            if one.regular:
                fields["note"] = FLATS.get(len(one.pairs), f"{2 * len(one.pairs)} FLATS")
            name = f"{'slot' if one.ends else 'polygon' if one.regular else 'opening'} {number}"
            rows = one.widths if one.ends else sorted(one.widths, key=lambda row: row[1])
            for (way, value), size in zip(one.widths[:1] if one.regular else rows, ("width", "length")):
                along, ends = positive(way), self._across(one, positive(way), value, view)
                inner = value - 2 * one.ends[0].radius if one.ends and size == "length" else value
                if is_usual_size(inner) and not is_usual_size(value):
                    value, ends = inner, [tidy(moved(one.centre, along, side * inner / 2)) for side in (-1.0, 1.0)]
                self.add("linear", f"{name} {size}", value, *ends, along, **fields)
            if not one.square_to_axis and not any(id(side) in self.around for side in one.sides):
                self._turned(f"{name} angle", one, view)
            for prism in group:
                if not self._seat(f"{name} place", prism, view):
                    self.add_levels(prism.axis, tidy(prism.centre), view, AXIS, name)

    def _across(self, prism: Prism, along: Point, value: float, view: str) -> list[Point]:
        """Ends of the distance of opposite sides, in the middle, or where a hole has removed them, beside it."""
        run = cross(prism.axis, along)
        reach = max((size for way, size in prism.widths if abs(dot(way, run)) > 0.5), default=0.0)
        places = (moved(prism.centre, run, part * reach) for part in (0.0, 0.25, -0.25, 0.4, -0.4))
        rows = [[tidy(moved(at, along, side * value / 2)) for side in (-1.0, 1.0)] for at in places]

        def is_drawn(end: Point) -> bool:
            return self.lines.seen(end, view) is not None and any(side.holds(end) for side in prism.sides)

        return next((row for row in rows if all(map(is_drawn, row))), rows[0])

    def _turned(self, name: str, prism: Prism, view: str) -> None:
        """Angle of a slot, or of the side of a polygon that is nearest to it, against the horizontal of a view."""
        right, eye, middle = PROJECTIONS[view].right, PROJECTIONS[view].towards_eye, prism.centre
        rows = [[moved(end.origin, end.axis, dot(subtract(middle, end.origin), end.axis)) for end in prism.ends]]
        if not prism.ends:
            rows = [sorted(side.corners, key=lambda one: -round(dot(one, eye), 3))[:2] for side in prism.sides]
        rows = [sorted(row, key=lambda one: dot(one, right)) for row in rows]
        vertex, *_, point = min(rows, key=lambda row: -round(dot(towards(row[0], row[-1]), right), 6))
        angle = math.degrees(math.acos(dot(towards(vertex, point), right)))
        self.add("angle", name, angle, tidy(vertex), tidy(point), right, view=view)

    def _seat(self, name: str, prism: Prism, view: str) -> bool:
        """Whether a slot is a key seat along a shaft: its nearer end is placed from the end or shoulder beside it."""
        run, half = (prism.widths[-1][0], prism.widths[-1][1] / 2) if prism.ends else (prism.axis, 0.0)
        for shaft in (s for s in self.features.shafts if abs(dot(s.axis, run)) > 1 - 1e-6):
            about = abs(dot(subtract(prism.centre, shaft.face.origin), cross(prism.axis, run))) < NEAR
            middle = dot(prism.centre, shaft.axis)
            if not about or not shaft.low < middle - half < middle + half < shaft.high:
                continue
            low = middle - shaft.low < shaft.high - middle
            level, side = (shaft.low, -1.0) if low else (shaft.high, 1.0)
            ends = (s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, run)) > 1 - 1e-6)
            rims = [at for s in ends if abs(dot(s.origin, shaft.axis) - level) < NEAR for at in extremes(s)]
            start = max(rims, key=lambda at: dot(at, PROJECTIONS[view].towards_eye), default=None)
            if start is None:
                return False
            end = tidy(moved(prism.centre, shaft.axis, side * half))
            self.add("linear", name, abs(dot(end, shaft.axis) - level), tidy(start), end, positive(run), view=view)
            return True
        return False

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
            count = {"count": len(group)} if len(group) > 1 else {}
            direction = on[1] if on else None
            view = "section" if shaft in grooves else self._side_view(axis, shaft.radius, at, direction)
            name, along = f"diameter {number}", positive(axis)
            self.add("diameter", name, 2 * shaft.radius, tidy(at), along, direction, view=view, **count)
            for one in group:
                foot = moved(one.face.origin, axis, (one.low + one.high) / 2 - dot(one.face.origin, axis))
                self.add_levels(axis, tidy(foot), VIEW_OF.get(tidy(positive(axis)), "top"))
        rounds: dict[tuple[object, ...], list[Surface]] = defaultdict(list)
        equal: dict[tuple[object, ...], list[Surface]] = defaultdict(list)
        for face in (*self.features.fillets, *self.features.spheres):
            equal[face.kind == "SPHERE", round(face.radius, 4)].append(face)
        for key, faces in equal.items():
            slanting = any(face.kind == "CYLINDER" and along_of(face.axis) is None for face in faces)
            for joined in connected(faces):
                # One leader for those that are seen in one view, or go around a floor; or for all, where no view shows
                # some of them.
                ways = frozenset(face.axis_key[3:] for face in joined if face.kind == "CYLINDER" and not slanting)
                rounds[*key, ways].extend(joined)
        for face in self.features.fillets:
            tube = face.kind == "TORUS" and tube_of(face, self.verifier.surfaces)
            nose = face.kind == "CYLINDER" and not is_fillet(face, self.verifier.surfaces)
            if (nose or tube) and id(face) not in self.images:
                by = 0.0 if tube else dot(subtract(middle_of_face(face), face.origin), face.axis)
                at = tidy(moved(face.origin, face.axis, by))
                self.add_levels(face.axis, at, self.lines.open_view(face.axis, middle_of_face(face)))
        for number, faces in enumerate(rounds.values(), start=1):
            shown = [face for face in faces if along_of(face.axis)] or faces
            circular = [face for face in shown if face.kind == "CYLINDER"] or shown
            face = min(circular, key=lambda one: self.lines.is_covered(usual_eye(one.axis), middle_of_face(one)))
            at, axis = middle_of_face(face), face.axis
            view = self.lines.open_view(axis, at, "section") if face.kind == "CYLINDER" else "front"
            outlines = ((one, *end) for one in faces for end in self._outlines(one))
            if face.kind == "SPHERE":
                _, _, view = next((one for one in outlines if face.outward), (face, at, view))
            elif view == "section" or self.lines.seen(tidy(at), view) is None:
                face, at, view = next(outlines, (face, at, view))
            kinds = len({s.axis_key if s.kind == "CYLINDER" else (id(s),) for s in faces})
            note: dict[str, Any] = {"note": "spherical"} if face.kind == "SPHERE" else {}
            count = {"count": kinds} if kinds > 1 else {}
            along = (0.0, 0.0, 1.0) if face.kind == "SPHERE" else positive(face.axis)
            self.add("radius", f"radius {number}", face.radius, tidy(at), along, view=view, **count, **note)

    def _outlines(self, face: Surface) -> Iterator[tuple[Point, str]]:
        """Points of a round face where a view shows its arc, with the view."""
        middle = middle_of_face(face)
        for view in ("front", "right", "top", "back", "left", "bottom"):
            eye = PROJECTIONS[view].towards_eye
            along = abs(dot(eye, face.axis))
            ends = [middle] if along > 1 - SQUARE else []
            if face.kind == "TORUS" and along < SQUARE:
                foot = moved(face.origin, face.axis, dot(subtract(middle, face.origin), face.axis))
                across = cross(eye, face.axis)
                ends = [moved(foot, across, side * math.dist(foot, middle)) for side in (1.0, -1.0)]
            elif face.kind == "SPHERE":
                up = scaled(PROJECTIONS[view].up, face.radius)
                ends = [add(face.origin, turned(up, eye, math.radians(turn))) for turn in range(0, 360, ANGLE_STEP)]
            for end in map(tidy, ends):
                if face.holds(end) and self.lines.seen(end, view) is not None:
                    yield end, view

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
            number_of = len({key_of_chamfer(one) for one, _ in faces})
            count = {"count": number_of} if number_of > 1 else {}
            self.add("chamfer", f"chamfer {number}", leg, tidy(point), along, view=view, **count)

    def _chamfer_view(self, face: Surface, along: Point) -> str:
        if face.kind == "CONE" and not face.outward:
            return self.lines.open_view(along, middle_of_face(face))
        if face.kind == "PLANE":
            free = next(u for u in AXES.values() if abs(dot(face.axis, u)) < 0.1)
            return self.lines.open_view(free, middle_of_face(face))
        return next(v for v in ("front", "right", "top") if abs(dot(PROJECTIONS[v].towards_eye, along)) < 1e-6)
