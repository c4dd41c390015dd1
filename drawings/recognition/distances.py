"""Distances between the levels of a solid: of faces, axes and corners along each axis of the part.

Walls that face each other across air have the width between them; of a width about an axis both places follow. Levels
of equal faces at equal steps have a pitch. Others are tied to a datum face, or in pairs to the middle.
"""

import math
import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any

from drawings.dimensions.definition import centred_axes
from drawings.dimensions.levels import AXES, NEAR, WHOLE, along_of, axis_kind, corners_of, is_usual_size, touch
from drawings.recognition.features import (
    AXIS,
    FACE,
    MOUTH,
    Features,
    Level,
    decimals,
    features_of,
    middle_of_face,
    rows_of_equal_faces,
    rows_of_equal_steps,
)
from drawings.recognition.part_file import Proposed, as_dimension
from drawings.recognition.sections import Inside, sections
from drawings.recognition.visible import (
    PASSING,
    PREFERRED,
    VIEW_OF,
    VisibleLines,
    at_level,
    extremes,
    negative,
    positive,
    tidy,
    views_along,
)
from drawings.views.view import PROJECTIONS, Cut, dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, moved
from stagecad.solids.modelling.verification import DimensionVerifier

ANOTHER_VIEW = 25.0
"""Cost of each less usual view, mm."""
CORNER, CONCAVE = "corner", "concave"
"""Kind of a level of corners of a flank that has an angle, and the name of those at an inner edge of it."""
FOLLOWS = 3
"""Order of a distance that follows from a width."""


class Distances:
    """Collects proposals, and questions of threads."""

    def __init__(self, verifier: DimensionVerifier) -> None:
        self.verifier = verifier
        self.features: Features = features_of(verifier)
        self.centred = centred_axes(verifier)
        self.proposed: list[Proposed] = []
        self.questions: list[str] = []
        self.levels_of: dict[str, list[Level]] = defaultdict(list)
        self._spans: dict[str, tuple[str, Level, Level]] = {}
        self.lines = VisibleLines(verifier)
        self._low, self._high = verifier.box
        self.images: set[int] = set()  # identities of faces that are placed as images of others
        self.walls: set[int] = set()  # identities of faces that face another one of the part
        # levels of sections by the axis across them
        self._planes = {name: {0.0} if name in self.centred else set[float]() for name in AXES}
        self._facing: dict[str, list[tuple[Surface, Surface]]] = {}  # walls with air between them, by the axis across
        self.around_view = ""
        self._rays: set[tuple[float, ...]] = set()  # axes that are placed by a distance and an angle
        self.at_angle: set[int] = set()  # identities of slanting faces that have an angle
        self.images_of: dict[Point, Point] = {}  # corners of a feature that are images of others of it
        self.around: dict[int, int] = {}  # by the identity of a face: number of equal features around an axis

    def add(self, method: str, name: str, value: float, *arguments: Any, order: int = 0, **fields: Any) -> None:
        """Add a proposal under a name and key of its own."""
        used = {one.name for one in self.proposed}
        number = 2
        unique = name
        while unique in used:
            unique, number = f"{name} {number}", number + 1
        key = re.sub(r"[ .-]", "_", unique)
        one = Proposed(method, unique, key, round(value, 9), arguments, fields, order)
        try:
            # Points of faces that should be one differ by the accuracy of the file.
            measured = self.verifier.measure(as_dimension(one))
        except LookupError:
            return
        if measured is not None and abs(measured - value) > NEAR:
            return
        self.proposed.append(one if measured is None else replace(one, value=round(measured, 9)))

    def _of(self, surface: Surface) -> frozenset[str]:
        """Name of the features around an axis to which a face belongs."""
        return frozenset({f"{self.around[id(surface)]} around"} if id(surface) in self.around else ())

    def _is_concave(self, flank: Surface, corner: Point) -> bool:
        """Whether there is more material than air around an edge of a flank: the face beside it is in front of it."""
        edge = next(unit for unit in AXES.values() if abs(dot(unit, flank.axis)) < 1e-6)
        planes = (s for s in self.verifier.surfaces if s.kind == "PLANE" and s is not flank and s.holds(corner))
        beside = (subtract(s.centre, corner) for s in planes if abs(dot(s.axis, edge)) < 1e-6)
        return any(dot(step, flank.normal) > NEAR for step in beside)

    def levels(self) -> None:
        """Distances that give the levels of planes, axes and corners along each axis of the part."""
        equal = rows_of_equal_faces(self.verifier.surfaces)
        for surface in self.verifier.surfaces:
            name = along_of(surface.axis) if surface.kind == "PLANE" else None
            if name is not None and id(surface) not in self.images:
                at = dot(surface.origin, AXES[name])
                points = (*surface.vertices, *extremes(surface)) or (tidy(middle_of_face(surface)),)
                of, side = equal[name, id(surface)] | self._of(surface), dot(surface.normal, AXES[name])
                self.levels_of[name].append(Level(at, points, of=of, side=side))
        for surface in self.features.spheres:
            for name, unit in AXES.items():
                out = next(axis for axis in AXES.values() if axis != unit)
                point = tidy(moved(surface.origin, out, surface.radius))
                self.levels_of[name].append(Level(dot(surface.origin, unit), (point,)))
        for surface in (s for s in self.features.slanted if id(s) not in self.images):
            for name, unit in AXES.items():
                if abs(dot(surface.axis, unit)) > 1e-6:
                    for vertex in (self.images_of.get(corner, corner) for corner in corners_of(surface, self.verifier)):
                        at = dot(vertex, unit)
                        ends = f"{at - surface.low[list(AXES).index(name)]:.2f}"
                        equal_corners = frozenset(f"{row} {ends}" for row in equal[name, id(surface)])
                        of = equal_corners | self._of(surface)
                        at_angle = id(surface) in self.at_angle
                        of |= {CONCAVE} if at_angle and self._is_concave(surface, vertex) else set()
                        kind = CORNER if at_angle else FACE
                        self.levels_of[name].append(
                            Level(at, (vertex,), self.around_view if id(surface) in self.around else "", kind, of)
                        )
        self._cone_ends()
        self._facing = {name: [*self._facing_walls(name)] for name in AXES}
        for number, name in enumerate(AXES):
            self._axis_levels(name, self._low[number], self._high[number])

    def _cone_ends(self) -> None:
        """Levels of the ends of cones, and their diameters where no cylinder has them."""
        known = [s for s in self.verifier.surfaces if s.kind == "CYLINDER"]
        done: set[tuple[float, ...]] = set()
        equal: dict[tuple[float, ...], list[tuple[float, Surface, Point, Point]]] = defaultdict(list)
        for cone in self.features.cones:
            name = along_of(cone.axis)
            if name is None:
                continue
            for vertex in cone.vertices:
                radius, at = cone.off_axis(vertex), dot(vertex, AXES[name])
                key = (*cone.axis_key, round(at, 2), round(radius, 2))
                between = min(abs(at - end) for end in cone.extent(AXES[name])) > NEAR
                if radius < NEAR or key in done or between:
                    continue
                done.add(key)
                self.levels_of[name].append(Level(at, (vertex,)))
                if not any(abs(one.radius - radius) < NEAR and one.is_coaxial(cone) for one in known):
                    foot = tidy(moved(cone.origin, AXES[name], at - dot(cone.origin, AXES[name])))
                    out = scaled(subtract(vertex, foot), 1 / radius)
                    equal[*cone.axis_key, cone.outward, round(radius, 3)].append((radius, cone, foot, out))
        for number, group in enumerate(equal.values(), start=1):
            radius, cone, foot, out = group[0]
            view = self._side_view(cone.axis, radius, foot) if cone.outward else "section"
            count = {"count": len(group)} if group[1:] else {}
            self.add("diameter", f"cone {number}", 2 * radius, foot, positive(cone.axis), out, view=view, **count)

    def _side_view(self, axis: Point, radius: float, at: Point, way: Point | None = None) -> str:
        """View that shows both outlines of a round feature from the side, else the one along its axis."""
        for view in ("front", "right", "top", "back", "left", "bottom"):
            eye = PROJECTIONS[view].towards_eye
            if abs(dot(eye, axis)) < 1e-6:
                across = cross(eye, axis)
                if all(self.lines.seen(moved(at, across, side * radius), view) is not None for side in (-1.0, 1.0)):
                    return view
        # In a groove of an end face it is seen from the side of the groove.
        across = way or next(unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6)
        beside = moved(at, across, radius + 2e-3)
        view = self.lines.open_view(axis, beside, "section")
        return view if view in VIEW_OF.values() and self.lines.seen(beside, view) is not None else "section"

    def add_levels(self, axis: Point, point: Point, view: str, kind: str = AXIS, *equal: str) -> None:
        """Levels of a point along the axes of the part that are square to its own axis; or its distance on a ray."""
        if kind == AXIS and self._on_ray(axis, point, view):
            return
        for name, unit in AXES.items():
            if abs(dot(unit, axis)) < 1e-6:
                about = axis_kind(self.verifier, unit, at := dot(point, unit), along_of(axis) or "")
                self.levels_of[name].append(Level(at, (point,), view, kind, frozenset(equal), about=about))

    def rounds(self, axis: Point) -> list[Surface]:
        """Round faces of holes and shafts along an axis, whole ones before others, large ones first."""
        faces = (s for one in (*self.features.holes, *self.features.shafts) for s in one.faces if s.kind == "CYLINDER")
        return sorted(
            (s for s in faces if abs(dot(s.axis, axis)) > 1 - 1e-6), key=lambda s: (s.span <= WHOLE, -s.radius)
        )

    def _on_ray(self, axis: Point, point: Point, view: str) -> bool:
        """Whether an axis is on a ray from the axis of the largest round feature, at a distance or angle of a usual
        value and fewer decimals than its coordinates have; they are then given."""
        rounds, prisms = self.rounds(axis), (one.centre for one in self.verifier.prisms)
        parallel = (s for s in self.verifier.surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, axis)) > 1 - 1e-6)
        on = any(s.off_axis(point) < NEAR for s in parallel) or any(math.dist(at, point) < NEAR for at in prisms)
        if not rounds or along_of(axis) is None or not on:
            return False
        centre = tidy(moved(rounds[0].origin, axis, dot(subtract(point, rounds[0].origin), axis)))
        if math.dist(point, centre) < NEAR or all(map(is_usual_size, subtract(point, centre))):
            return False
        units = [way for unit in AXES.values() if abs(dot(unit, axis)) < NEAR for way in (unit, negative(unit))]
        apart = [s.radial(centre) for s in rounds if s.off_axis(centre) > NEAR]
        arms = [unit for unit in units if any(math.dist(way, negative(unit)) < NEAR for way in apart)]
        start = min(units, key=lambda unit: (unit not in arms, -dot(unit, towards(centre, point))))
        distance, angle = math.dist(centre, point), math.degrees(math.acos(dot(start, towards(centre, point))))
        usual = is_usual_size(distance) or abs(2 * angle - round(2 * angle)) < 1e-4
        if not usual or decimals(distance) > max(map(decimals, subtract(point, centre))):
            return False
        key = tidy(subtract(point, scaled(axis, dot(point, axis))))
        if key not in self._rays:
            self._rays.add(key)
            self.add("linear", "ray", distance, centre, tidy(point), towards(centre, point), view=view)
            self.add("angle", "ray angle", angle, centre, tidy(point), start, view=view)
        return True

    def _axis_levels(self, name: str, low: float, high: float) -> None:
        rows: list[Level] = []
        for level in sorted(self.levels_of[name], key=lambda one: (one.kind in (AXIS, MOUTH), one.at)):
            # Faces with opposite normals are walls of different features.
            last = next((row for row in rows[-3:] if _is_one(row, level)), None)
            if last:
                kind = last.kind if last.kind == level.kind else FACE if FACE in (last.kind, level.kind) else AXIS
                points, equal = (*last.points, *level.points), last.of | level.of
                seen = last.seen | {(one.view, point) for one in (last, level) for point in one.points if not one.seen}
                view, side = last.view or level.view, last.side or level.side
                joined = replace(last, points=points, view=view, kind=kind, of=equal, seen=seen, side=side)
                rows[rows.index(last)] = joined
            else:
                rows.append(level)
        rows.sort(key=lambda row: row.at)
        ends = [row for row in (_row_at(rows, low, -1.0), _row_at(rows, high, 1.0)) if row is not None]
        # A feature around an axis that alone ends there is dimensioned from the axis.
        ends = ends if len(ends) == 2 or not any(_is_around(end) for end in ends) else []
        size = {"x": "length", "y": "width", "z": "height"}[name]
        if len(ends) == 2 and ends[0] is not ends[1]:
            self._between(size, name, *ends, order=0)
        rows, every = self._rows(name, rows, ends), rows
        follows = self._widths(name, rows, every)
        if name in self.centred:
            self._pairs(name, rows, ends, follows)
        else:
            self._from_datum(name, rows, ends, follows)

    def _rows(self, name: str, rows: list[Level], ends: list[Level]) -> list[Level]:
        """The pitch of equal features in a row, and of equal faces also the distances within one of them; all levels
        but those that need a place."""
        spaced = rows_of_equal_steps([row for row in rows if row not in ends])
        while spaced:
            lead, *others = spaced
            step = lead[1].at - lead[0].at
            alike = [row for row in others if row[0].kind != AXIS and len(row) == len(lead)]
            alike = [row for row in alike if abs(row[1].at - row[0].at - step) < NEAR and row[0].at < lead[1].at]
            (one, other), view = self._points(name, lead[0], lead[-1])
            steps = len(lead) - 1
            before = len(self.proposed)
            self.add("pitch", f"{name} pitch", (lead[-1].at - lead[0].at) / steps, one, other, steps, view=view)
            if len(self.proposed) == before:
                # The features are not in one line.
                spaced = others
                continue
            for row in alike:
                self._between(f"{name} width", name, lead[0], row[0], 1, len(lead))
            levels = [level for row in (lead, *alike) for level in row]
            symmetric = name in self.centred and all(
                any(abs(level.at + other.at) < NEAR for other in levels) for level in levels
            )
            gone = {id(level) for level in levels[0 if symmetric else 1 :]}
            rows = [row for row in rows if id(row) not in gone]
            spaced = [row for row in others if not any(id(level) in gone for level in row) and row not in alike]
        return rows

    def _widths(self, name: str, rows: list[Level], every: list[Level]) -> set[int]:
        """Widths between walls that face each other, off the middle of a symmetric part; levels that follow from them:
        of the further wall that needs a place, or of both where an axis between them is in the middle."""
        flat = [row for row in every if row.kind not in (AXIS, MOUTH)]
        follows: set[int] = set()
        equal: dict[tuple[float, ...], list[tuple[Level, Level]]] = defaultdict(list)
        number = list(AXES).index(name)
        for walls in sorted(self._facing[name], key=lambda walls: abs(sum(dot(w.origin, AXES[name]) for w in walls))):
            low, high = (round(dot(wall.origin, AXES[name]), 3) for wall in walls)
            one, other = _row_at(flat, low, 1.0), _row_at(flat, high, -1.0)
            placed = [level for level in (one, other) if level and not any(level is row for row in rows)]
            if not one or not other or placed[1:] or (name in self.centred and abs(low + high) < NEAR):
                continue
            sizes = (wall.high[n] - wall.low[n] for wall in walls for n in range(3) if n != number)
            row = equal[tuple(round(size, 2) for size in (high - low, *sorted(sizes)))]
            row += [] if (one, other) in row else [(one, other)]
            about = any(
                s.kind == "CYLINDER" and abs(dot(s.origin, AXES[name]) - (low + high) / 2) < NEAR
                for wall in walls
                for s in self.verifier.surfaces
                if abs(dot(s.axis, AXES[name])) < NEAR and touch(s, wall)
            )
            further = [one, other] if about else [max((one, other), key=lambda level: abs(level.at))]
            further = [one if level is other else other for level in placed] or further
            follows |= {id(row) for level in further for row in (level, _row_at(flat, -level.at, -level.side) or level)}
        for row in equal.values():
            self._between(f"{name} width", name, *row[0], 1, len(row))
        return follows

    def _facing_walls(self, name: str) -> Iterator[tuple[Surface, Surface]]:
        """Walls of grooves and slots: congruent faces, or faces beside one floor, with air between them."""
        number, planes = list(AXES).index(name), [s for s in self.verifier.surfaces if s.kind == "PLANE"]
        square = [(s.normal[number], s) for s in planes if along_of(s.axis) == name]
        for wall in (s for normal, s in square if normal > 0):
            at = wall.high[number]
            beyond = [s for normal, s in square if normal < 0 and s.low[number] > at + NEAR and touch(s, wall, number)]
            for other in sorted(beyond, key=lambda s: s.low[number]):
                gap = (at, other.low[number])
                ends = zip((*wall.low, *wall.high), (*other.low, *other.high), strict=True)
                like = all(abs(a - b) < 0.02 for n, (a, b) in enumerate(ends) if n % 3 != number)
                floors = (s for s in self.verifier.surfaces if touch(s, wall) and touch(s, other))
                if like or any(math.dist((s.low[number], s.high[number]), gap) < 0.02 for s in floors):
                    points = (
                        moved(p, AXES[name], (gap[1] - gap[0]) / 2) for p in (middle_of_face(wall), *wall.vertices)
                    )
                    if not all(map(self.verifier.is_inside, points)):
                        self.walls |= {id(wall), id(other)}
                        yield wall, other
                    break

    def _pairs(self, name: str, rows: list[Level], ends: list[Level], follows: Collection[int]) -> None:
        """Distances of levels at both sides of the middle; a level at one side only is given from an end."""
        for row in rows:
            middle = abs(row.at) < NEAR
            order = FOLLOWS if id(row) in follows else None
            if row in ends or (middle and row.kind != FACE):
                continue
            mirror = (
                None if middle else next((o for o in rows if _is_one(replace(o, at=-o.at, side=-o.side), row)), None)
            )
            if mirror is None:
                start = next((end for end in ends if end.at * row.at > 0), ends[0] if ends else None)
                axis = next((one for one in rows if abs(one.at) < NEAR), None)
                before = len(self.proposed)
                if start is None and row.kind != AXIS and not _is_around(row):
                    self._from_outline(name, row)
                start = start or axis
                if start and len(self.proposed) == before:
                    self._between(f"{name} place", name, start, row, order)
            elif row.at < 0:
                what = "spacing" if row.kind == AXIS else "distance"
                self._between(f"{name} {what}", name, row, mirror, order)

    def _from_outline(self, name: str, row: Level) -> None:
        """Distance of a flat or key seat from the opposite outline of a round part."""
        shaft = max(self.features.shafts, key=lambda shaft: shaft.radius, default=None)
        inner = self._cut_through(name, row, row)
        if shaft is None or inner is None:
            return
        (_, on), _ = inner
        number = list(AXES).index(name)
        own = [s for s in self.features.shafts if s.low - NEAR <= dot(on, s.axis) <= s.high + NEAR]
        radius, view = max((s.radius for s in own), default=shaft.radius), "section"
        across = [s.radius for hole in self.features.holes for s in hole.faces if s.axis_key == shaft.face.axis_key]
        seat = [r for r in across if r < abs(row.at)]
        if seat and any(on[number] * s.normal[number] < 0 for s in self.verifier.surfaces if s.holds(on)):
            # The floor of a key seat in a bore, from the opposite wall of the bore.
            radius, view = max(seat), VIEW_OF.get(positive(shaft.face.axis), "section")
        opposite = at_level(on, name, -math.copysign(radius, row.at))
        self.add("linear", f"{name} place", abs(row.at) + radius, opposite, on, AXES[name], view=view, order=1)

    def _from_datum(self, name: str, rows: list[Level], ends: list[Level], follows: Collection[int]) -> None:
        """Distances from a datum: the lower end, or the upper one where the lower is an edge, else the axis of the
        largest round face, of a shaft before a bore."""
        rounds = (s for s in self.verifier.surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, AXES[name])) < NEAR)
        largest = max(rounds, key=lambda s: (s.span > WHOLE, s.outward, s.radius), default=None)
        main = dot(largest.origin, AXES[name]) if largest else 0.0
        axes = (row for row in rows if abs(row.at) < NEAR or row.kind == AXIS)
        datum = next((end for end in ends if end.side), min(axes, key=lambda row: abs(row.at - main), default=None))
        given = [end for end in ends if end is not datum][-1:] if len(ends) == 2 else []  # by the size
        for row in rows:
            pair = [one for one in rows if one.kind == row.kind == AXIS and one.of & row.of]
            pair = pair if len(pair) == 2 and _in_line(name, *pair) else []
            if pair and row is pair[1]:
                self._between(f"{name} spacing", name, pair[0], row)
                continue
            # A pattern about the axis of another feature begins there.
            middle = sum(one.at for one in pair) / 2
            about = [one for one in rows if pair and one.kind == AXIS and abs(one.at - middle) < NEAR]
            about = [one for one in about if self._radius_about(one) > self._radius_about(row)]
            start = next((end for end in ends if self._is_mouth(name, end, row)), next(iter(about), datum))
            if datum and start and row is not datum and row not in given:
                self._between(f"{name} place", name, start, row, FOLLOWS if id(row) in follows else None)

    def _radius_about(self, level: Level) -> float:
        """Radius of the largest round face about a point of a level."""
        rounds = (s for s in self.verifier.surfaces if s.kind == "CYLINDER")
        return max((s.radius for s in rounds if any(s.off_axis(at) < NEAR for at in level.points)), default=0.0)

    def _is_mouth(self, name: str, end: Level, row: Level) -> bool:
        """Whether a level is the floor of slots or pockets, between walls from it to an end of the part."""
        number, span = list(AXES).index(name), sorted((end.at, row.at))
        level = [s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(s.low[number] - row.at) < NEAR]
        floors = [s for s in level if along_of(s.axis) == name]

        def is_wall(wall: Surface, floor: Surface) -> bool:
            return touch(floor, wall) and math.dist((wall.low[number], wall.high[number]), span) < NEAR

        pairs = [pair for axis, pairs in self._facing.items() if axis != name for pair in pairs]
        inner = [s for s in floors if any(all(is_wall(wall, s) for wall in pair) for pair in pairs)]
        return bool(floors) and len(inner) == len(floors)

    def _between(
        self, what: str, name: str, first: Level, second: Level, order: int | None = None, count: int = 1
    ) -> None:
        if abs(second.at - first.at) < NEAR:
            return
        (one, other), view = self._points(name, first, second)
        around = [int(tag.partition(" ")[0]) for tag in first.of & second.of if tag.endswith(" around")]
        count = max(count, *around, 1)
        ends = (first, second)
        if any(level.kind == CORNER for level in ends):
            # An angle gives one of the corners of a flank: the outer one, or that of a usual value, is the better one.
            odd = not is_usual_size(second.at - first.at)
            order = FOLLOWS + any(CONCAVE in level.of for level in ends) + odd
        rank = order if order is not None else 1 if second.view else 2
        fields: dict[str, Any] = {"view": view, **({"count": count} if count > 1 else {})}
        self.add("linear", what, abs(second.at - first.at), one, other, AXES[name], order=rank, **fields)
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

    def _in_views(self, one: Proposed, views: Collection[str]) -> Proposed | None:
        """A distance in that of some views that shows it best; None for others, or if no view shows it."""
        name, first, second = self._spans.get(one.name, ("x", Level(0.0, ()), Level(0.0, ())))
        shown, points, view = self._best(name, first, second, views_along(name, views))
        fields = {**one.fields, "view": view}
        return replace(one, arguments=(*points, *one.arguments[2:]), fields=fields) if shown else None

    def with_inside(self, views: tuple[str, ...], proposed: list[Proposed]) -> tuple[tuple[str, ...], list[Proposed]]:
        """The views and proposals, the front view as a section where one shows what is inside and the distances of the
        view, else with hidden lines where there are blind or stepped holes."""
        marked = [one.arguments[:2] for one in proposed if one.fields.get("view") == "section"]
        marked = [points for points in marked if abs(points[0][1]) + abs(points[1][1]) < NEAR]
        others = tuple(view for view in views if view != "front")
        inside = Inside(self.verifier, self.features, bool(marked))
        for cut in sections(inside):
            self.lines.cut_front(cut)
            found = [self._in_section(cut, one) if one.fields.get("view") == "front" else one for one in proposed]
            straight = cut.kind == "offset" and not cut.more
            if straight or (all(found) and all(cut.holds(point) for points in marked for point in points)):
                more = [view for view in VIEW_OF.values() if view != "front"]
                pairs = zip(found, proposed, strict=True)
                known = [one or self._in_views(own, others) or self._in_views(own, more) or own for one, own in pairs]
                used = (one.fields.get("view", "front") for one in known)
                return tuple(dict.fromkeys((f"front {cut.words}", *others, *(v for v in used if v != "front")))), known
        self.lines.cut_front(None)
        return (("front hidden", *others) if inside.deep else views), proposed

    def without_hidden(self, views: Sequence[str], proposed: list[Proposed]) -> tuple[tuple[str, ...], list[Proposed]]:
        """The views and proposals without those whose ends or arcs no view shows."""
        shown = [one for one in proposed if self._is_shown(one)]
        used = {one.fields.get("view", "front") for one in shown} | {"front"}
        return tuple(view for view in views if view.partition(" ")[0] in used), shown

    def _is_shown(self, one: Proposed) -> bool:
        """Whether the view of a distance or radius shows it; True in a section or an auxiliary view."""
        if (view := one.fields.get("view", "front")) not in VIEW_OF.values():
            return True
        if one.name in self._spans:
            _, *levels = self._spans[one.name]
            ends = zip(levels, one.arguments, strict=False)
            return all(self._shown(level, view) or self.lines.has_centre_line(at, view) for level, at in ends)
        if one.method == "linear":
            *ends, way = one.arguments[:3]
            walls = [s for s in self.verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, way)) > 0.5]
            ends = [point for point in ends if any(s.holds(point) for s in walls)]
        else:
            ends = one.arguments[: one.method == "radius" and one.fields.get("note") != "spherical"]
        return all(self.lines.seen(point, view) is not None for point in ends)

    def _in_section(self, cut: Cut, one: Proposed) -> Proposed | None:
        """A dimension of the front view as a section shows it; None where it does not."""
        if one.name in self._spans:
            return self._in_views(one, {"front"})
        points: list[Point] = [point for point in one.arguments[:2] if one.method == "linear"]
        if one.method == "diameter" and abs(dot(one.arguments[1], cut.normal)) < NEAR:
            across = scaled(cross(cut.normal, one.arguments[1]), one.value / 2)
            points = [add(one.arguments[0], across), subtract(one.arguments[0], across)]
        return one if all(self.lines.seen(point, "front") is not None for point in points) else None

    def _points(self, name: str, first: Level, second: Level) -> tuple[tuple[Point, Point], str]:
        """Points of two levels in the view that shows both best, else in a section through the middle of a face."""
        wanted = [view for view in (second.view, first.view) if view in views_along(name)]
        shown, points, view = self._best(name, first, second, [*wanted, *PREFERRED[name], *views_along(name)])
        if second.kind == AXIS and second.view == "section":
            return (at_level(second.points[0], name, first.at), second.points[0]), "section"
        inner = None if shown or second.kind == AXIS else self._cut_through(name, first, second)
        return inner or (points, view)

    def _best(
        self, name: str, first: Level, second: Level, views: Sequence[str]
    ) -> tuple[bool, tuple[Point, Point], str]:
        """Whether one of some views shows two levels, and the points and the view that show them best."""
        found: list[tuple[bool, float, Point, Point, str]] = []
        for rank, view in enumerate(dict.fromkeys(views)):
            if found and min(found)[:2] < (False, ANOTHER_VIEW * rank):
                break
            for cost, one in self._shown(first, view):
                for more, other in self._shown(second, view):
                    passing = max(cost * (first.kind != AXIS), more * (second.kind != AXIS)) >= PASSING
                    away = self._offset(one, other, view, name)
                    found.append((passing, cost + more + away + ANOTHER_VIEW * rank, one, other, view))
        if not found:
            one, other = ((*level.points, (0.0, 0.0, 0.0))[0] for level in (first, second))
            return False, (tidy(one), tidy(other)), PREFERRED[name][0]
        passing, _, one, other, view = min(found)
        return not passing, (tidy(one), tidy(other)), view

    def _cut_through(self, name: str, first: Level, second: Level) -> tuple[tuple[Point, Point], str] | None:
        """Ends of a distance to a face within the part, in a section through the middle of this face."""
        planes = (s for s in self.verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) == name)
        face = next((s for s in planes if abs(dot(s.origin, AXES[name]) - second.at) < NEAR), None)
        if face is None:
            return None
        eye = PROJECTIONS[first.view].towards_eye if first.kind == AXIS and first.view in PROJECTIONS else None
        across = next((axis for axis in "yxz" if eye and abs(dot(eye, AXES[axis])) > 0.5), "x" if name == "y" else "y")
        inside = tidy(middle_of_face(face))
        if not face.holds(inside):
            # On a ledge around a pocket.
            edges = [edge for edge in face.face.Edges() if edge.geomType() == "LINE"]
            edges = [edge for edge in edges if abs(dot(edge.tangentAt(0).toTuple(), AXES[across])) > 0.9]
            inside = next((tidy(edge.positionAt(0.5).toTuple()) for edge in edges), inside)
        rim = extremes(face) if len(face.face.outerWire().Edges()) == 1 else []
        if rim:
            # The floor of a hole in the plane of its axis.
            middle = dot(scaled(add(face.low, face.high), 0.5), AXES[across])
            inside = min(rim, key=lambda point: round(abs(dot(point, AXES[across]) - middle), 3))
        planes = self._planes[across]
        inside = next((at for at in (at_level(inside, across, plane) for plane in planes) if face.holds(at)), inside)
        planes.add(dot(inside, AXES[across]))
        start, plane = at_level(inside, name, first.at), dot(inside, AXES[across])
        # On the face at the other end, and not in the air beside it.
        faces = [s for s in self.verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) == name]
        ends = (at_level(point, across, plane) for point in (start, *first.points[:8]))
        start = next((end for end in ends if any(s.holds(end) for s in faces)), start)
        if eye:
            start = tidy(moved(first.points[0], eye, dot(subtract(inside, first.points[0]), eye)))
        return (start, inside), "section"

    def _shown(self, level: Level, view: str) -> list[tuple[float, Point]]:
        """Points of a level in a view with their costs; the axes of holes in the view along them."""
        own = sorted(point for other, point in level.seen if other == view)
        if level.kind != FACE and (view == level.view or own):
            return [(0.0, point) for point in (own or level.points)[:8]]
        costs = [(self.lines.seen(point, view), point) for point in dict.fromkeys(level.points[:60])]
        return sorted((cost, point) for cost, point in costs if cost is not None)[:8]

    def _offset(self, one: Point, other: Point, view: str, name: str) -> float:
        step = [b - a for a, b in zip(PROJECTIONS[view].to_view(one), PROJECTIONS[view].to_view(other), strict=True)]
        u, v = PROJECTIONS[view].to_view(AXES[name])
        return round(abs(step[0] * v - step[1] * u), 3)


def _is_one(row: Level, level: Level) -> bool:
    """Whether levels of faces, or of axes, are one; of faces with opposite normals they are two."""
    alike = (level.kind in (AXIS, MOUTH)) == (row.kind in (AXIS, MOUTH))
    return alike and level.about == row.about and abs(level.at - row.at) < NEAR and level.side * row.side >= 0.0


def _is_around(row: Level) -> bool:
    """Whether a level is that of equal features around an axis."""
    return any(tag.endswith(" around") for tag in row.of)


def _row_at(rows: Sequence[Level], at: float, side: float) -> Level | None:
    """The level of faces with a normal, else of others; None for none."""
    near = [row for row in rows if abs(row.at - at) < NEAR and row.side * side >= 0.0]
    return min(near, key=lambda row: (row.kind in (AXIS, MOUTH), row.side == 0.0), default=None)


def _in_line(name: str, one: Level, other: Level) -> bool:
    """Whether two features at different levels along an axis are beside each other."""
    return not {at_level(point, name, 0.0) for point in one.points}.isdisjoint(
        at_level(point, name, 0.0) for point in other.points
    )
