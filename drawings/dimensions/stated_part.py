"""Size and place of each face of a part of which nothing is agreed: each has its own declarations."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from drawings.dimensions.consistency import parallel
from drawings.dimensions.contours import by_model, marks_of
from drawings.dimensions.levels import (
    AXES,
    NEAR,
    SIMPLE,
    SQUARE,
    along_of,
    axes_about,
    corners_of,
    ends_of_cones,
    fillet_at,
    like_edges,
    tangent_rounds,
    touch,
    tube_of,
)
from drawings.dimensions.places import Notes, Part, middle_of_box
from drawings.dimensions.round_sections import sections_of
from drawings.views.view import auxiliary, dot, projection_of
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, mirrored, moved, turned
from stagecad.solids.modelling.verification import DimensionVerifier


class StatedPart(Part):
    """A part of which nothing is agreed: each round face needs its own declaration, each place its dimensions."""

    def __init__(self, verifier: DimensionVerifier, dimensions: Sequence[Dimension], notes: Notes) -> None:
        super().__init__(verifier, dimensions, notes)
        self._sizes: dict[int, str] = {}
        self._rounds = [s for s in verifier.surfaces if s.kind == "CYLINDER"]
        self._cones: list[Dimension] = []
        # The depth in a callout is that of all its holes.
        most = {d.feature: max(o.count for o in dimensions if o.feature == d.feature) for d in dimensions if d.feature}
        deep = (d for d in dimensions if d.kind == "depth")
        self._depths = [replace(d, count=most.get(d.feature, d.count)) for d in deep]
        self._circles = [d for d in dimensions if d.kind == "pitch_circle"]
        self._chamfers = []
        # The ends of slots have the radius of their width, whatever fillets have the same.
        for d in sorted(dimensions, key=lambda d: (d.kind != "linear", d.kind == "chamfer")):
            self._enter(d)

    def _enter(self, d: Dimension) -> None:
        """Enter the round faces whose size a dimension gives."""
        if d.kind in ("diameter", "tap_drill") and d.direction is not None:
            faces = self._verifier.kept(("sized", d), lambda: self._of_diameter(d))
            self._cones += [] if faces else [d]
            for number in faces:
                self._sizes.setdefault(number, d.name)
        elif d.kind in ("radius", "chamfer"):
            edges = self._verifier.kept(("edges", d.kind, d.value), lambda: like_edges(self._verifier, d))
            like = {n: k for n, k in edges.items() if n not in self._sizes and not self._sink(self._surfaces[n])}
            own = [n for n, surface in enumerate(self._surfaces) if surface.holds(d.points[0])]
            keys = {like.get(number, number) for number in own}
            # Where the solid has more than are counted, a note says which are meant, else only the one that is touched.
            every = len({*like.values()}) <= d.count or (d.kind == "chamfer" and d.note != "")
            # Or all that are seen in one view.
            axes = [self._surfaces[n].axis for n in own if d.kind == "radius"]
            beside = {k for n, k in like.items() if any(parallel(self._surfaces[n], axis) for axis in axes)}
            keys |= beside if len(beside) <= d.count else set()
            for number in (*own, *(n for n, key in like.items() if every or key in keys)):
                if d.kind == "radius" or self._surfaces[number].kind in ("PLANE", "CONE"):
                    self._sizes.setdefault(number, d.name)
        elif d.kind == "linear" and d.direction is not None:
            middle = (dot(d.points[0], d.direction) + dot(d.points[1], d.direction)) / 2
            flat = [s for s in self._surfaces if s.kind == "PLANE" and parallel(s, d.direction)]
            between = all(any(s.holds(point) for s in flat) for point in d.points)
            for section in sections_of(s for s in self._surfaces if between and s.is_round(d.value / 2)):
                face = section.face
                across = not section.whole and abs(dot(face.axis, d.direction)) < SQUARE
                equal = d.count > 1 and any(
                    wall.kind == "PLANE" and touch(wall, face) and abs(wall.off_plane(face.origin) - face.radius) < NEAR
                    for wall in self._surfaces
                )
                if across and (equal or abs(dot(face.origin, d.direction) - middle) < NEAR):
                    for face in section.faces:
                        self._sizes.setdefault(self._number(face), f"{d.name} (ends)")

    def _of_diameter(self, d: Dimension) -> list[int]:
        """Numbers of the round faces of which a dimension is the diameter; none for that of a cone."""
        try:
            holes = self._verifier.holes(d)
        except LookupError:
            return []
        round_faces = (s for s in self._surfaces if s.is_round(holes[0].radius) and s.outward == holes[0].outward)
        like, found = [*sections_of(round_faces)], list[int]()
        every = len(holes) < d.count and len(like) <= d.count
        for section in like:
            # Walls of one bore have one diameter; collars of one shaft are counted.
            # Of two that end in one bore from both sides each has its own.
            along = section.along(d.direction or section.axis)
            own = not d.note.startswith("to ") or along.low - NEAR < dot(d.points[0], along.axis) < along.high + NEAR
            bore = own and not section.face.outward and any(map(section.face.is_coaxial, holes))
            if every or bore or (own and any(face is hole for face in section.faces for hole in holes)):
                found += map(self._number, section.faces)
        return found

    def size_of(self, surface: Surface) -> str:
        find = {"TORUS": tube_of, "SPHERE": fillet_at}.get(surface.kind)
        number = self._number((find and find(surface, self._surfaces)) or surface)
        if surface.kind in ("CYLINDER", "SPHERE", "TORUS"):
            return self._sizes.get(number, "") or self._by_note(surface)
        return self._by_note(surface) if surface.kind == "CONE" and not self._joins(surface) else "-"

    def _by_note(self, surface: Surface) -> str:
        """What gives a face without dimensions: the model, or a note."""
        return by_model(surface, self._verifier) * self._notes.model or self._notes.defines(middle_of_box(surface))

    def _number(self, surface: Surface) -> int:
        return next(n for n, other in enumerate(self._surfaces) if other is surface)

    def place_of(self, surface: Surface) -> str:
        if found := self._own_place(surface):
            return found
        for d in (d for d in self._slopes if d.count > 2 and d.direction):
            try:
                rows = self._verifier.features_around(d.points[0], d.points[1], d.direction or d.points[0], d.count)
            except LookupError:
                continue
            row = next((row for row in rows if any(one is surface for one in row)), [])
            slanting = all(s.kind == "PLANE" and not along_of(s.axis) for s in row)
            places = (self._own_place(s) or (slanting and self._by_vertices(s, d)) for s in row)
            if found := next(filter(None, places), ""):
                return f"{d.name}, {found}"
        return self._by_note(surface)

    def _own_place(self, surface: Surface) -> str:
        """What gives the place of a face that is no image of another."""
        bore = self._verifier.kept(("floor", id(surface)), partial(self._bore_of, surface))
        if bore and not self._depth_of(surface, bore):
            return ""
        if (
            found := super().place_of(surface)
            or self._inclined(surface)
            or self._of_prism(surface)
            or self._of_arm(surface)
        ):
            return found
        if surface.kind == "PLANE":
            for d in self._depths:
                across = surface.holds(d.points[1]) or self._is_floor(surface, d)
                if d.direction and parallel(surface, d.direction) and across:
                    return d.name
            return self._by_vertices(surface) or self._by_note(surface)
        if surface.kind == "CYLINDER":
            if slanting := self._slanting(surface) or self._square_to_face(surface):
                return slanting
            for d in self._circles:
                centre, hole = d.points
                if d.direction is None or not parallel(surface, d.direction):
                    continue
                across = [name for name, unit in AXES.items() if abs(dot(unit, d.direction)) < SQUARE]
                known = (self.levels[n].located_by(dot(centre, AXES[n]), 0.0, about=d.direction) for n in across)
                placed = all(known)
                # No angle is needed where the holes are mirror images about an axis of the part.
                u, v = (dot(surface.origin, AXES[name]) - dot(centre, AXES[name]) for name in across[:2])
                step = 180.0 / d.count
                offs = [(math.degrees(math.atan2(v, u)) - axis) % step for axis in (0.0, 90.0)]
                even = min(min(off, step - off) for off in offs) < 1e-3
                around = [b for a, b in (s.points for s in self._slopes if s.count == 1) if math.dist(a, centre) < NEAR]
                at_angle = any(self._on_ring(b, d) if d.count > 1 else surface.off_axis(b) < NEAR for b in around)
                # Other holes on the circle are not among those that it counts.
                turns = (math.tau * n / d.count for n in range(d.count))
                row = (add(centre, turned(subtract(hole, centre), d.direction, turn)) for turn in turns)
                own = d.count == 1 or any(surface.off_axis(at) < NEAR for at in row)
                on = abs(2 * surface.off_axis(centre) - d.value) < NEAR and (even or at_angle)
                if placed and own and on:
                    return f"{d.name}, equally spaced"
        return self._by_note(surface)

    def _bore_of(self, floor: Surface) -> Surface | None:
        """The wall of a blind or stepped hole of which a plane face is the floor."""
        rim = floor.face.outerWire().Edges() if floor.kind == "PLANE" else []
        if len(rim) != 1:
            return None
        middle, on = middle_of_box(floor), rim[0].startPoint().toTuple()
        for s in self._surfaces:
            wall = s.kind == "CYLINDER" and not s.outward and parallel(s, floor.axis)
            # The material is behind the floor, and the bore in front of it.
            ahead = wall and dot(subtract(middle_of_box(s), middle), floor.normal) > 0
            if ahead and s.off_axis(middle) < NEAR and abs(s.off_axis(on) - s.radius) < NEAR:
                return s
        return None

    def _depth_of(self, floor: Surface, bore: Surface) -> bool:
        """Whether a depth or distance ends on the floor of a hole, or of an equal one at its level."""
        for d in (d for d in self._depths if d.direction and parallel(floor, d.direction)):
            if floor.holds(d.points[1]) or self._is_floor(floor, d):
                return True
        equal = self._verifier.kept(("like floors", id(floor)), lambda: self._like_floors(floor, bore))
        return any(s.holds(point) for d in self._distances for point in d.points for s in equal)

    def _like_floors(self, floor: Surface, bore: Surface) -> list[Surface]:
        """The floors of holes of one radius at one level."""
        equal = [floor]
        for s in self._surfaces:
            if s.kind == "PLANE" and abs(dot(subtract(s.origin, floor.origin), floor.axis)) < NEAR:
                like = self._verifier.kept(("floor", id(s)), partial(self._bore_of, s))
                equal += [s] if like and like.is_round(bore.radius) else []
        return equal

    def _on_ring(self, point: Point, d: Dimension) -> bool:
        """Whether a hole of a circle of equal holes is about a point."""
        holes = (s for s in self._surfaces if s.kind == "CYLINDER" and s.off_axis(point) < NEAR)
        return any(abs(2 * s.off_axis(d.points[0]) - d.value) < NEAR for s in holes)

    def _inclined(self, surface: Surface) -> str:
        """A slanting face, by the angle of it or of its mirror image against another face, and a corner."""
        for d in (d for d in self._slopes if d.kind == "angle" and d.direction and surface.kind == "PLANE"):
            for flank in self._verifier.kept(("flanks", d.points, d.direction), partial(self._flanks, d)):
                if mirrored(flank.axis) == mirrored(surface.axis) and not along_of(surface.axis):
                    across = [name for name, unit in AXES.items() if abs(dot(surface.axis, unit)) > SQUARE]
                    for corner in (
                        *corners_of(surface, self._verifier),
                        *([d.points[0]] if surface.is_level(d.points[0]) else ()),
                    ):
                        levels = [self._corner_level(corner, name) for name in across]
                        if all(levels):
                            return "; ".join(dict.fromkeys((d.name, *levels)))
        return ""

    def _flanks(self, d: Dimension) -> list[Surface]:
        """Faces on a leg of an angle, square to the plane of it."""
        vertex, on = d.points
        square = cross(d.direction or vertex, subtract(on, vertex))
        planes = (s for s in self._surfaces if s.kind == "PLANE" and abs(dot(s.axis, square)) < NEAR)
        return [s for s in planes if s.holds(on) and s.is_level(vertex)]

    def _of_prism(self, surface: Surface) -> str:
        """A side of a prism, by the distance of opposite sides of it or of equal ones, the place of its axis, and the
        angle of one that is not square to an axis of the part."""
        own = next((one for one in self._verifier.prisms if any(s is surface for s in one.sides)), None)
        if own is None:
            return ""
        equal = [one for one in self._verifier.prisms if one.is_equal(own)]
        ways = own.widths if own.regular else [(way, value) for way, value in own.widths if own.faces(surface, way)]
        across_it = [d for d in self._distances if any(self._is_in(d, way) for way, _ in ways)]
        sizes = [
            d.name
            for d in across_it
            for one in (equal if len(equal) <= d.count else [own])
            if one.spans(d.points, d.direction or own.axis)
        ]
        turned = [d.name for d in self._slopes for one in equal if one.is_turned_by(d.points)]
        across = [(name, unit) for name, unit in AXES.items() if abs(dot(unit, own.axis)) < SQUARE]
        names = [self.levels[name].located_by(dot(own.centre, unit)) for name, unit in across]
        names += [] if own.square_to_axis else turned or [""]
        return "; ".join(dict.fromkeys((sizes[0], *names))) if sizes and all(names) else ""

    def _of_arm(self, surface: Surface) -> str:
        """A wall, by the width about two axes, its own or that of equal arms, or if it is slanting by the round faces
        that it touches, all of them placed."""
        if surface.kind != "PLANE":
            return ""
        slanting = not along_of(surface.axis)
        met = partial(tangent_rounds, surface, self._surfaces)
        rows = [("tangent", self._verifier.kept(("tangent", id(surface)), met))] if slanting else []
        for d in self._distances:
            own = slanting and self._is_in(d, surface.axis) and any(map(surface.holds, d.points))
            if own or (d.count > 1 and self._arm_walls(d.value) <= 2 * d.count):
                rows.append((d.name, self._about_arm(surface, d.value)))
        for name, rounds in rows:
            own = {s.axis_key: self._level_names(s.origin, s.axis, s) for s in rounds}
            placed = own | {s.axis_key: self._own_place(s) for s in rounds if not self._is_fillet(s)}
            if sum(map(bool, placed.values())) > 1:
                return "; ".join((name, *filter(None, placed.values())))
        return ""

    def _about_arm(self, wall: Surface, width: float) -> list[Surface]:
        """The round faces about the middle of an arm of a width that ends in a wall, and in one on the other side."""
        middle = dot(wall.origin, wall.axis) - 0.5 * width * dot(wall.axis, wall.normal)

        def about() -> list[Surface]:
            ends = (s for s in self._surfaces if s.kind == "PLANE" and dot(s.normal, wall.normal) < SQUARE - 1)
            other = any(abs(dot(subtract(wall.origin, s.origin), wall.normal) - width) < NEAR for s in ends)
            return axes_about(wall, middle, self._surfaces) if other else []

        return self._verifier.kept(("about arm", id(wall), width), about)

    def _arm_walls(self, width: float) -> int:
        """Number of the walls of arms of a width."""

        def count() -> int:
            planes = (s for s in self._surfaces if s.kind == "PLANE")
            return sum(len({one.axis_key for one in self._about_arm(s, width)}) > 1 for s in planes)

        return self._verifier.kept(("walls of arms", width), count)

    def _slanting(self, surface: Surface) -> str:
        """A hole at an angle: by the angle, and the levels of the point where its axis meets the face, or of the middle
        of a ring of holes."""
        for d in self._slopes:
            if d.kind == "angle" and (_is_at(surface, d) or all(surface.off_axis(point) < NEAR for point in d.points)):
                sides = [0.0 if abs(dot(surface.axis, unit)) < SQUARE else None for unit in AXES.values()]
                rows = zip(self.levels.values(), d.points[0], sides, strict=True)
                levels = [row.located_by(level, side) for row, level, side in rows]
                if all(levels):
                    return "; ".join(dict.fromkeys((d.name, *levels)))
        return ""

    def _square_to_face(self, surface: Surface) -> str:
        """A hole square to a slanting face, placed by its corners: by distances from an edge of it, or levels."""
        for face in self._surfaces:
            if face.kind != "PLANE" or along_of(face.axis) or not parallel(face, surface.axis):
                continue
            view, placed = projection_of(auxiliary(face.normal)), self._by_vertices(face)
            names = [placed] if placed else []
            for way in (view.right, view.up) if placed else ():
                name = along_of(way)
                level = dot(surface.origin, AXES[name] if name else way)
                names.append(self.levels[name].located_by(level) if name else self._from_edge(level, way, face, placed))
            if placed and all(names):
                return "; ".join(dict.fromkeys(names))
        return ""

    def _from_edge(self, level: float, way: Point, face: Surface, placed: str) -> str:
        """The last of the distances in a direction that lead from a corner of a slanting face to a level."""
        ends = [(d.name, sorted(dot(p, way) for p in d.points)) for d in self._distances if self._is_in(d, way)]
        known = {dot(corner, way): placed for corner in face.corners}
        for _ in ends:
            for name, (low, high) in ends:
                for here, there in ((low, high), (high, low)):
                    if any(abs(here - one) < NEAR for one in known):
                        known.setdefault(there, name)
        return next((name for one, name in known.items() if abs(one - level) < NEAR), "")

    @staticmethod
    def _is_in(d: Dimension, way: Point) -> bool:
        return d.direction is not None and abs(dot(d.direction, way)) > 1 - SQUARE

    def _is_floor(self, surface: Surface, d: Dimension) -> bool:
        return self._verifier.kept(("is floor", id(surface), d), lambda: self._is_floor_of(surface, d))

    def _is_floor_of(self, surface: Surface, d: Dimension) -> bool:
        """Whether a plane face is the floor of a stepped hole whose depth is declared, or of one of its equals, or an
        area of a mark with this depth."""
        assert d.direction is not None
        rows = (mark.areas for mark in marks_of(self._verifier) if any(s is surface for s in mark.areas))
        if any(s.holds(d.points[1]) for row in rows for s in row):
            return True
        if abs(dot(surface.origin, d.direction) - dot(d.points[1], d.direction)) > NEAR:
            return False
        rims = [[edge.positionAt(part).toTuple() for part in (0.1, 0.4, 0.7)] for edge in surface.face.Edges()]  # pyright: ignore[reportAttributeAccessIssue]
        walls = [s for s in self._surfaces if s.kind == "CYLINDER" and parallel(s, d.direction)]
        own = [s for s in walls if s.off_axis(d.points[1]) < NEAR]
        like = [s for s in walls if any(s.is_round(one.radius) for one in own)] if d.count > 1 else own
        return any(all(map(s.is_at, rim)) for s in like for rim in rims)

    def _by_vertices(self, surface: Surface, around: Dimension | None = None) -> str:
        """A plane, by its level, or at an angle by the located levels of all its corners, or of these turned by the
        angle of equal features around an axis."""
        if name := along_of(surface.axis):
            found = [self.levels[name].located_by(dot(surface.origin, AXES[name]), dot(surface.normal, AXES[name]))]
        else:
            across = [name for name, unit in AXES.items() if abs(dot(surface.axis, unit)) > SQUARE]
            corners = corners_of(surface, self._verifier)
            rows = [[(at, across) for at in dict.fromkeys(pair)] for pair in corners.items()]
            if around and around.direction:
                centre, on = around.points
                normal = cross(around.direction, subtract(on, centre))
                axis, turn = scaled(normal, 1 / math.hypot(*normal)), math.tau / around.count
                for row in rows:
                    out = subtract(row[0][0], centre)
                    row += [(add(centre, turned(out, axis, by)), [*AXES]) for by in (turn, -turn)]
            known = [[[self._corner_level(at, name) for name in names] for at, names in row] for row in rows]
            found = [level for row in known for level in next(filter(all, row), [""])]
        return f"corners: {'; '.join(dict.fromkeys(found))}" if found and all(found) else ""

    def _corner_level(self, corner: Point, name: str) -> str:
        """What gives a corner along an axis: no outline of a round face elsewhere; or the round face on which it is."""
        level = self.levels[name].located_by(dot(corner, AXES[name]), corner=not self.is_at_outline(corner))
        return level or next(filter(None, (self._by_round(corner, name, s) for s in self._rounds)), "")

    def _by_round(self, corner: Point, name: str, surface: Surface) -> str:
        """The diameter of a placed round face on which a corner is that has its other level across the axis."""
        if abs(dot(surface.axis, AXES[name])) > SQUARE or not surface.is_at(corner):
            return ""
        other = next((one for one in AXES if one != name and abs(dot(surface.axis, AXES[one])) < SQUARE), name)
        size = "" if self._is_fillet(surface) else self._sizes.get(self._number(surface), "")
        placed = size and self._level_names(surface.origin, surface.axis, surface) and surface.holds(corner)
        return size if placed and self.levels[other].located_by(dot(corner, AXES[other])) else ""

    def _joins(self, surface: Surface) -> str:
        if surface.kind == "SPHERE" and not fillet_at(surface, self._surfaces):
            names = [self._ball_level(surface, name) for name in AXES]
            return "; ".join(dict.fromkeys(names)) if all(names) else ""
        if surface.kind == "CYLINDER" and not self._is_fillet(surface):
            return ""
        if surface.kind == "TORUS" and tube_of(surface, self._surfaces):
            return ""
        chamfer = self._sizes.get(self._number(surface), "") if surface.kind in ("PLANE", "CONE") else ""
        if chamfer:
            return f"{chamfer}, by the faces it joins"
        return super()._joins(surface) if surface.kind in SIMPLE else self._by_note(surface)

    def _ball_level(self, surface: Surface, name: str) -> str:
        """What gives the middle of a ball along an axis, or its outermost point there."""
        middle = dot(surface.origin, AXES[name])
        tips = (moved(surface.origin, AXES[name], side * surface.radius) for side in (1.0, -1.0))
        levels = [middle, *(dot(tip, AXES[name]) for tip in tips if surface.holds(tip))]
        return next(filter(None, map(self.levels[name].located_by, levels)), "")

    def _sink(self, surface: Surface) -> str:
        """The countersink that a cone is."""
        for d in self._cones if surface.kind == "CONE" else ():
            if d.direction and parallel(surface, d.direction) and "countersink" in d.name:
                low, high = surface.extent(d.direction)
                own = surface.off_axis(d.points[0]) < NEAR or d.count > 1
                wide = max(map(surface.off_axis, surface.vertices), default=0.0)
                level = low - NEAR <= dot(d.points[0], d.direction) <= high + NEAR
                if own and level and abs(2 * wide - d.value) < NEAR:
                    return d.name
        return ""

    def _cone(self, surface: Surface) -> str:
        """A drill point below a depth, a countersink, or a cone between diameters at located levels."""
        along = next((name for name in AXES if parallel(surface, AXES[name])), None)
        if along is None:
            return ""
        if name := self._sink(surface):
            return name
        rims = {round(dot(v, AXES[along]), 4): surface.off_axis(v) for v in surface.vertices}
        # Slits may end between its ends.
        ends = {level: radius for level, radius in rims.items() if radius > NEAR and level in (min(rims), max(rims))}
        for level, radius in ends.items():
            known = any(
                number in self._sizes and abs(other.radius - radius) < NEAR and other.is_coaxial(surface)
                for number, other in enumerate(self._surfaces)
                if other.kind == "CYLINDER"
            )
            own = [d for d in self._cones if abs(d.value - 2 * radius) < NEAR and surface.off_axis(d.points[0]) < NEAR]
            equal = len(ends_of_cones(self._surfaces, radius))
            stated = any(d.count == equal or abs(dot(d.points[0], AXES[along]) - level) < NEAR for d in own)
            if not (known or stated) or not self.levels[along].locates_end(level):
                return ""
        return "cone between diameters, or drill point below a depth" if ends else ""


def _is_at(surface: Surface, d: Dimension) -> bool:
    """Whether an axis is one of several at equal angles about a vertex."""
    if d.count == 1 or d.direction is None or surface.off_axis(d.points[0]) > NEAR:
        return False
    normal = cross(d.direction, subtract(d.points[1], d.points[0]))
    angle = math.degrees(math.acos(max(-1.0, min(1.0, dot(surface.axis, d.direction)))))
    steps = [one / d.value for one in (angle, 180.0 - angle)]
    return any(abs(one - round(one)) < NEAR for one in steps) and abs(dot(surface.axis, normal)) < NEAR * math.hypot(
        *normal
    )
