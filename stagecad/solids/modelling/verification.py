"""Verification of dimensions: measures each declared dimension on the solid; a drawing cannot differ from the part.

The declaration gives the points; the value comes from the surfaces of the solid: the plane of a face, the axis and
radius of a cylinder, the end of a bore. A declaration without a feature at its points is an error.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any, NamedTuple

from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.frame import add, cross, dot, scaled, subtract
from stagecad.solids.modelling.kernel import cq, occ
from stagecad.solids.modelling.surface import (
    NEAR,
    UNITS,
    Prism,
    Surface,
    features_of_faces,
    is_beside,
    meeting,
    mirrored,
    moved,
    prisms_of,
    rejection,
    surface_of,
    turned,
)

BEYOND = 0.02
"""Distance from a point of the surface at which a ray begins, mm."""
TOUCH = 1e-6
"""Distance below which a point is on a face, mm."""
SLANTING = (0.4178, 0.5391, 0.7313)
"""Direction that no edge of a usual part has."""


class Crossing(NamedTuple):
    """Where a ray meets a face."""

    distance: float  # from the start of the ray, mm
    leaves: bool  # whether the ray leaves the material there
    is_clear: bool  # whether it passes through the face, beside its edges and not at the start


class DimensionVerifier:
    """Measures dimensions on the `surfaces` of one solid, one per face, in the solid's order."""

    def __init__(self, solid: cq.Shape) -> None:
        self.solid = solid
        self.surfaces = [surface_of(face) for face in solid.Faces()]
        self._kept: dict[Hashable, Any] = {}

    def kept(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """What follows from the solid and a key, made once."""
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    @cached_property
    def box(self) -> tuple[Point, Point]:
        """Lower and upper corner of the bounding box."""
        (x, y, z), (u, v, w) = zip(*(s.low for s in self.surfaces)), zip(*(s.high for s in self.surfaces))
        return (min(x), min(y), min(z)), (max(u), max(v), max(w))

    @property
    def size(self) -> float:
        """Largest side of the bounding box, mm."""
        return max(high - low for low, high in zip(*self.box))

    def is_inside(self, point: Point) -> bool:
        """Whether a point is in the material."""
        low, high = self.box
        if not all(a <= p <= b for a, p, b in zip(low, point, high)):
            return False
        crossings = self._crossings(point, SLANTING)
        if all(one.is_clear for one in crossings):
            return bool(crossings) and crossings[0].leaves
        for classifier in self._classifiers:
            classifier.Perform(occ.gp_Pnt(*point), 1e-6)
            if classifier.State() == occ.TopAbs_IN:
                return True
        return False

    def is_covered(self, point: Point, way: Point) -> bool:
        """Whether there is material in a direction from a point of the surface."""
        start = moved(point, way, BEYOND)
        crossings = self._crossings(start, way)
        if all(one.is_clear for one in crossings):
            return bool(crossings)
        # The ray runs along a face or through an edge: between the places at which it meets faces.
        levels = sorted({0.0, *(one.distance for one in crossings)})
        return any(self.is_inside(moved(start, way, (a + b) / 2)) for a, b in pairwise(levels))

    def _crossings(self, point: Point, way: Point) -> list[Crossing]:
        """Where a ray meets the faces, the nearest first."""
        rays = self._rays
        rays.Perform(occ.gp_Lin(occ.gp_Pnt(*point), occ.gp_Dir(*way)), -TOUCH, math.inf)
        found = []
        for number in range(1, rays.NbPnt() + 1):
            distance, transition = rays.WParameter(number), rays.Transition(number)
            is_clear = distance > TOUCH and rays.State(number) == occ.TopAbs_IN
            is_clear &= transition in (occ.IntCurveSurface_In, occ.IntCurveSurface_Out)
            found.append(Crossing(distance, transition == occ.IntCurveSurface_Out, is_clear))
        return sorted(found)

    @cached_property
    def _rays(self) -> Any:
        """The kernel's intersections of lines with the faces."""
        rays = occ.IntCurvesFace_ShapeIntersector()
        rays.Load(self.solid.wrapped, TOUCH)
        return rays

    @cached_property
    def _classifiers(self) -> list[Any]:
        """The kernel's classifiers of points, up to a hundred times slower where bores cross."""
        return [occ.BRepClass3d_SolidClassifier(solid.wrapped) for solid in self.solid.Solids()]

    def open_ends(self, surface: Surface, along: Point) -> tuple[bool, ...]:
        """For the lower and the upper end of a bore along a direction, True where it is open; only those that are."""
        return self.kept(("open ends", id(surface), along), lambda: self._ends_that_are_open(surface, along))

    def _ends_that_are_open(self, surface: Surface, along: Point) -> tuple[bool, ...]:
        found: list[bool] = []
        across = cross(along, (0.36, 0.48, 0.8))
        size, side_way = math.hypot(*across), cross(along, across)
        # A crossing hole may divide the wall.
        low, high = surface.extent(along)
        walls = (s for s in self._of("CYLINDER", along) if s.is_coaxial(surface) and s.is_round(surface.radius))
        for start, end in sorted(s.extent(along) for s in walls if s.outward == surface.outward):
            low, high = (min(low, start), max(high, end)) if start < high + NEAR and end > low - NEAR else (low, high)
        for end, side in zip((low, high), (-1.0, 1.0), strict=True):
            # Beyond the cone of a drill, off the axis: a smaller hole may go on from the floor.
            beyond = end + side * (0.02 + 0.5 * surface.radius) - dot(surface.origin, along)
            foot = moved(surface.origin, along, beyond)
            reach = 0.8 * surface.radius / size
            around = [moved(foot, way, sign * reach) for way in (across, side_way) for sign in (-1.0, 1.0)]
            # A rib may cover a part of it.
            found.append(not all(map(self.is_inside, around)) and not self.has_floor(surface, along, end))
        return tuple(one for one in found if one)

    def has_floor(self, wall: Surface, along: Point, level: float) -> bool:
        """Whether a bore ends at a level in a floor of its own, of which another hole may have removed a part; what is
        left of it beside a face that the hole breaks through is none."""
        ends = (s for s in self._of("PLANE", along) if abs(dot(s.origin, along) - level) < NEAR and s.vertices)
        reach = [[wall.off_axis(vertex) for vertex in s.vertices] for s in ends]
        within = [max(row) < wall.radius + NEAR for row in reach if min(row) < wall.radius + NEAR]
        return bool(within) and all(within)

    @cached_property
    def prisms(self) -> tuple[Prism, ...]:
        """Slots, rectangular openings and regular prisms."""
        return tuple(prisms_of(self.surfaces))

    @cached_property
    def vertices(self) -> tuple[Point, ...]:
        """All vertices of the solid."""
        return tuple(vertex.toTuple() for vertex in self.solid.Vertices())

    @cached_property
    def _straight_edges(self) -> list[tuple[Point, ...]]:
        """Ends of the straight edges of the solid."""
        straight = (edge for edge in self.solid.Edges() if edge.geomType() == "LINE")
        return [tuple(vertex.toTuple() for vertex in edge.Vertices()) for edge in straight]

    def measure(self, dimension: Dimension) -> float | None:
        """Value of a dimension on the solid, mm (degrees; a number for slope and count).

        None for dimensions without geometry in the solid: threads, and callouts of text.
        """
        points, along = dimension.points, dimension.direction
        if along is None or not points:
            raise LookupError(f"dimension '{dimension.name}' needs points and a direction for its verification")
        match dimension.kind:
            case "linear":
                return abs(self._place(points[1], along) - self._place(points[0], along))
            case "depth":
                return abs(self._level(points[1], along) - self._level(points[0], along))
            case "pitch":
                whole = self._place(points[1], along) - self._place(points[0], along)
                between = [moved(points[0], along, n * whole / dimension.count) for n in range(1, dimension.count)]
                # Each feature of the row is at its place, holes as holes.
                holes = self._axis_place(points[0], along) is not None
                for point in between:
                    if (self._axis_place(point, along) if holes else self._place(point, along)) is None:
                        raise LookupError(f"no hole of the row at {point}")
                return abs(whole) / dimension.count
            case "sag":
                half, radius = math.dist(points[0], points[1]) / 2, self.face_on(points[0], "SPHERE").radius
                return radius - math.sqrt(radius**2 - half**2)
            case "diameter" | "tap_drill":
                return 2 * self.round_about(points, along)[1]
            case "radius":
                return self.face_on(points[0], "CYLINDER", "SPHERE", "TORUS").radius
            case "chamfer":
                low, high = self.face_on(points[0], "PLANE", "CONE").extent(along)
                return high - low
            case "slope":
                sine = abs(dot(self.face_on(points[0], "PLANE").axis, along))
                return sine / math.sqrt(1 - sine**2)
            case "angle":
                return self._angle(points[0], points[1], along, dimension.count)
            case "pitch_circle":
                return self._pitch_circle(dimension)
            case "count":
                return self._count(points[0], along) / dimension.count
            case _:
                return None

    def holes(self, dimension: Dimension) -> list[Surface]:
        """The round faces of all equal holes that a diameter or tap drill applies to, one per hole.

        Where the solid has not as many parallel ones as the dimension counts (holes on a circle, radial), only the
        declared one. LookupError for a cone.
        """
        axis = dimension.direction
        if axis is None:
            raise LookupError(f"dimension '{dimension.name}' has no axis")
        (_, radius), point = self.round_about(dimension.points, axis), dimension.points[0]
        like = [s for s in self._of("CYLINDER", axis) if abs(s.radius - radius) < NEAR]
        at = dot(point, axis)
        here = [
            s for s in like if s.off_axis(point) < NEAR and s.extent(axis)[0] - NEAR <= at <= s.extent(axis)[1] + NEAR
        ]
        if not here:
            raise LookupError(f"'{dimension.name}' is the diameter of a cone")
        first = here[0]
        same_ends = [s for s in like if math.dist(s.extent(axis), first.extent(axis)) < NEAR]
        same_mouth = [s for s in like if min(abs(a - b) for a, b in zip(s.extent(axis), first.extent(axis))) < NEAR]
        spans = {s.axis_key: sum(other.span for other in like if other.is_coaxial(s)) for s in like}
        # Beside notches of the radius at a rim.
        same_span = [s for s in like if abs(spans[s.axis_key] - spans[first.axis_key]) < NEAR]
        for group in (like, same_mouth, same_ends, same_span, None):
            # Of some that end in another hole, and some that do not.
            group = group or [s for s in same_ends if self.open_ends(s, axis) == self.open_ends(first, axis)]
            found: list[Surface] = []
            for surface in group:
                if not any(surface.off_axis(other.origin) < NEAR for other in found):
                    found.append(surface)
            if len(found) == dimension.count:
                return found
        return [first]

    def face_on(self, point: Point, *kinds: str) -> Surface:
        """The face at a point, of one of the kinds."""
        for surface in self.surfaces:
            if surface.kind in kinds and surface.holds(point):
                return surface
        raise LookupError(f"no {' or '.join(kinds).lower()} face at {point}")

    def round_about(self, points: tuple[Point, ...], axis: Point) -> tuple[Surface, float]:
        """Round face about `axis` at the first point, on the axis, and its radius there; a second point, on the face,
        selects one of several."""
        point, touch = points[0], points[1] if len(points) > 1 else None
        at, found = dot(point, axis), set[str]()
        for surface in (s for kind in ("CYLINDER", "CONE") for s in self._of(kind, axis) if s.off_axis(point) < NEAR):
            radius = surface.radius + surface.taper * dot(subtract(point, surface.origin), surface.axis)
            low, high = surface.extent(axis) if surface.kind == "CYLINDER" else (at, at)
            away = surface.off_axis(touch) - radius if touch else 0.0
            held = not touch or (surface.holds(touch) if surface.kind == "CYLINDER" else abs(away) < NEAR)
            if low - NEAR <= at <= high + NEAR:
                if held:
                    return surface, radius
                found.add(f"{2 * radius:.6g}")
        size = f" of diameter {2 * math.dist(touch, point):.6g}" if touch else ""
        there = f"; the solid has {', '.join(sorted(found))} there" if found else ""
        raise LookupError(f"no round face{size} about {axis} through {point}{there}")

    def _pitch_circle(self, dimension: Dimension) -> float:
        """Diameter of a circle of equally spaced holes, mm."""
        (centre, hole), axis = dimension.points, dimension.direction or (0.0, 0.0, 1.0)
        radius = self.round_about((hole,), axis)[1]
        like = [s for s in self._of("CYLINDER", axis) if abs(s.radius - radius) < NEAR]
        first = next(surface for surface in like if surface.off_axis(hole) < NEAR)
        out = rejection(subtract(first.origin, centre), axis)
        side = cross(axis, out)
        for number in range(dimension.count):
            turn = 2 * math.pi * number / dimension.count
            c, s = math.cos(turn), math.sin(turn)
            x, y, z = (p + c * o + s * q for p, o, q in zip(centre, out, side, strict=True))
            if not any(surface.off_axis((x, y, z)) < NEAR for surface in like):
                raise LookupError(
                    f"hole {number + 1} of {dimension.count} on the circle is not at ({x:g}, {y:g}, {z:g})"
                )
        return 2 * math.hypot(*out)

    def _place(self, point: Point, along: Point) -> float:
        """Coordinate along `along` of the face at the point, or of the axis of the round feature there."""
        for surface in self.surfaces:
            place = surface.place(point, along)
            if place is not None and surface.holds(point):
                return place
        axis = self._axis_place(point, along)
        return self._level(point, along) if axis is None else axis

    def _of(self, kind: str, axis: Point | None = None) -> Iterator[Surface]:
        """The surfaces of a kind; with `axis`, those whose axis, or normal, runs along it."""
        for surface in self.surfaces:
            if surface.kind == kind and (axis is None or abs(abs(dot(surface.axis, axis)) - 1) < 1e-9):
                yield surface

    def slanting_mouth(self, surface: Surface, point: Point) -> Point | None:
        """Where the axis of a slanting hole through a point meets the plane face there, or the round one about an axis
        that it meets; None for any other."""
        if surface.kind != "CYLINDER" or max(map(abs, surface.axis)) > 1 - 1e-9 or surface.off_axis(point) > NEAR:
            return None
        for plane in self._of("PLANE"):
            across = dot(surface.axis, plane.axis)
            if abs(dot(subtract(point, plane.origin), plane.axis)) < NEAR and abs(across) > 0.1:
                reach = dot(subtract(plane.origin, surface.origin), plane.axis) / across
                return moved(surface.origin, surface.axis, reach)
        for shaft in (s for s in self._of("CYLINDER") if s.outward and s.is_at(point) and surface.meets(s)):
            level = dot(subtract(point, shaft.origin), shaft.axis)
            return moved(moved(shaft.origin, shaft.axis, level), shaft.radial(point), shaft.radius)
        return None

    def _axis_place(self, point: Point, along: Point) -> float | None:
        """Coordinate along `along` of a round feature's or prism's axis that passes the point, of the middle of equal
        holes around it, or of a crown's middle."""
        for surface in self._of("CYLINDER"):
            if abs(dot(surface.axis, along)) > 1e-9 and (mouth := self.slanting_mouth(surface, point)):
                return dot(mouth, along)
        for surface in (*self._of("CYLINDER"), *self._of("CONE"), *self._of("TORUS")):
            if abs(dot(surface.axis, along)) < 1e-9 and surface.off_axis(point) < NEAR:
                return dot(surface.origin, along)
        for prism in self.prisms:
            if prism.is_axis(point, along):
                return dot(prism.centre, along)
        rings: dict[tuple[float, ...], dict[tuple[float, ...], float]] = defaultdict(dict)
        for surface in self._of("CYLINDER"):
            if abs(dot(surface.axis, along)) < 1e-9:
                ring = (round(surface.radius, 3), round(surface.off_axis(point), 3), *surface.axis_key[3:])
                rings[ring][surface.axis_key] = dot(surface.origin, along)
        for ring in (ring for ring in rings.values() if len(ring) > 2):
            if abs(sum(ring.values()) / len(ring) - dot(point, along)) < NEAR:
                return sum(ring.values()) / len(ring)
        for surface in self._of("SPHERE"):
            if abs(dot(subtract(surface.origin, point), along)) < NEAR and surface.holds(point):
                return dot(surface.origin, along)
        return None

    def _level(self, point: Point, along: Point) -> float:
        """Coordinate of the end of a bore about the point, or of a plane normal to `along` at the point. Otherwise of
        the middle between the outermost such planes, if the point lies there."""
        at = dot(point, along)
        mouths = (self.slanting_mouth(surface, point) for surface in self._of("CYLINDER", along))
        levels = [dot(mouth, along) for mouth in mouths if mouth] + [
            end
            for surface in self._of("CYLINDER", along)
            if surface.off_axis(point) < NEAR
            for end in surface.extent(along)
        ]
        planes = [dot(surface.origin, along) for surface in self._of("PLANE", along)]
        if planes:
            planes.append((min(planes) + max(planes)) / 2)
        for level in levels + planes:
            if abs(level - at) < NEAR:
                return level
        for vertex in self.vertices:
            if math.dist(vertex, point) < NEAR:
                return dot(vertex, along)
        for start, end in self._straight_edges:
            # Any point of an edge that is square to the direction.
            square = abs(dot(subtract(end, start), along)) < NEAR
            if square and abs(math.dist(start, point) + math.dist(point, end) - math.dist(start, end)) < NEAR:
                return dot(start, along)
        # The line in which the flanks of a groove, or a flank and a wall beside a fillet, would meet.
        flat = [s for s in self._of("PLANE") if s.is_level(point) and abs(dot(s.axis, along)) < 1 - NEAR]
        # Or the point of a wall beside the axis of the round face in which it ends.
        for wall in (s for s in self._of("PLANE") if s.is_level(point)):
            unit = max(UNITS, key=lambda one: abs(dot(wall.axis, one)))
            for s in (s for s in self._of("CYLINDER") if any(map(s.is_at, wall.vertices))):
                if math.hypot(*rejection(rejection(subtract(point, s.origin), s.axis), unit)) < NEAR:
                    apart = dot(subtract(wall.origin, point), wall.axis) / dot(wall.axis, unit)
                    return at + apart if abs(dot(along, unit)) > 1 - 1e-9 else dot(s.origin, along)
        for one, other in (pair for pair in combinations(flat, 2) if any(abs(dot(s.axis, along)) > NEAR for s in pair)):
            if (apex := meeting(one, other, point)) and abs(dot(cross(one.axis, other.axis), along)) < 1e-9:
                return dot(apex, along)
        raise LookupError(f"nothing of the solid ends at {point} along {along}")

    def _angle(self, vertex: Point, point: Point, along: Point, count: int) -> float:
        """Angle between `along` and a slanting axis, or a plane face, through both points; of equal holes or features
        around an axis through `vertex`, that of the next of `count`; between parallel axes through both points, about
        the first; degrees."""
        step = subtract(point, vertex)
        sides = (side for prism in self.prisms for side in prism.sides)
        if count == 1 and any(side.holds(vertex) and side.holds(point) for side in sides):
            return math.degrees(math.acos(dot(step, along) / math.hypot(*step)))
        for surface in self._of("CYLINDER"):
            if max(map(abs, surface.axis)) < 1 - 1e-9 and max(map(surface.off_axis, (vertex, point))) < NEAR:
                sign = math.copysign(1.0, dot(step, surface.axis))
                angle = math.acos(sign * dot(surface.axis, along))
                normal = scaled(cross(along, scaled(surface.axis, sign)), 1 / math.sin(angle))
                if count > 1 and abs(count * angle - math.tau) > 1e-6:
                    raise LookupError(f"{count} times {math.degrees(angle):.6g} degrees do not go around")
                for number in range(2, count):
                    way = turned(along, normal, number * angle)
                    like = (one for one in self._of("CYLINDER", way) if abs(one.radius - surface.radius) < NEAR)
                    ends = (one.extent(way)[1] - dot(vertex, way) for one in like if one.off_axis(vertex) < NEAR)
                    if max(ends, default=0.0) < surface.radius:
                        raise LookupError(f"no hole at {number} times {math.degrees(angle):.6g} degrees from {along}")
                return math.degrees(angle)
        for flank in (one for one in self._of("PLANE") if one.holds(point) and one.is_level(vertex)):
            trace = cross(flank.axis, cross(along, step))
            flat = (s for s in self._of("PLANE") if mirrored(s.axis) == mirrored(flank.axis))
            like = {(s.normal, round(dot(s.origin, s.normal), 2)) for s in flat}
            beside = (s for s in self._of("PLANE") if abs(dot(s.axis, along)) < 1e-6 and s.is_level(vertex))
            # Between the two flanks of a groove, or to a face beside each flank.
            flanks = count if max(map(abs, along)) > 1 - 1e-9 else 2 * count
            if math.hypot(*trace) > NEAR and len(like) == flanks and any(s is not flank for s in beside):
                cosine = dot(trace, along) / math.hypot(*trace)
                return math.degrees(math.acos(math.copysign(1.0, dot(trace, step)) * cosine))
        axes = [self._middle(at) for at in (vertex, point)]
        if axes[0] and axes[1] and abs(dot(axes[0][1], along)) < 1e-6:
            step = rejection(subtract(axes[1][0], axes[0][0]), axes[0][1])
        elif count > 1:
            self.features_around(vertex, point, along, count)
        else:
            raise LookupError(f"no axes at {vertex} and {point}, and no face from one to the other")
        return math.degrees(math.acos(dot(step, along) / math.hypot(*step)))

    def _middle(self, point: Point) -> tuple[Point, Point] | None:
        """A point and the direction of the axis of a round face or prism through a point."""
        found = [(s.origin, s.axis) for s in self._of("CYLINDER") if s.off_axis(point) < NEAR]
        prisms = ((one.centre, one.axis) for one in self.prisms)
        found += [(at, axis) for at, axis in prisms if math.hypot(*rejection(subtract(point, at), axis)) < NEAR]
        return next(iter(found), None)

    def features_around(self, vertex: Point, point: Point, along: Point, count: int) -> list[list[Surface]]:
        """The faces of equal features around an axis through `vertex`, the images of each in one row: of the feature
        with a face at the point, at equal angles from `along`. LookupError where a face has no image."""
        rows = self.kept(("around", vertex, point, along, count), lambda: self._around(vertex, point, along, count))
        if not rows or not all(map(all, rows)):
            raise LookupError(f"no {count} equal features around {vertex}, one of them at {point}")
        return rows

    def _around(self, vertex: Point, point: Point, along: Point, count: int) -> list[list[Surface | None]]:
        normal = cross(along, subtract(point, vertex))
        axis = scaled(normal, 1 / math.hypot(*normal))
        faces = [s for s in self.surfaces if is_beside(s, vertex, axis)]
        own = next((group for group in features_of_faces(faces) if any(s.holds(point) for s in group)), [])
        return [[self._image(s, faces, vertex, axis, n * math.tau / count) for n in range(count)] for s in own]

    @staticmethod
    def _image(own: Surface, faces: list[Surface], vertex: Point, axis: Point, angle: float) -> Surface | None:
        """The face that is the image of another by a turn."""
        normal, centre = turned(own.axis, axis, angle), add(vertex, turned(subtract(own.centre, vertex), axis, angle))
        like = (s for s in faces if s.kind == own.kind and abs(dot(s.axis, normal)) > 1 - 1e-6)
        alike = (s for s in like if math.dist(s.centre, centre) < 1e-3 and math.isclose(s.area, own.area, rel_tol=1e-3))
        return next((s for s in alike if s.kind == "PLANE" or abs(s.radius - own.radius) < NEAR), None)

    def _count(self, point: Point, along: Point) -> int:
        """Number of holes in the row of the one at the point along `along`; or of all crowns, or crests."""
        for surface in self._of("CYLINDER"):
            if abs(dot(surface.axis, along)) < 1e-9 and surface.off_axis(point) < NEAR:
                return len({round(place, 3) for place in self._row(surface, along)})
        for here in self.surfaces:
            if here.kind in ("SPHERE", "PLANE") and here.holds(point):
                return sum(_alike(here, other) for other in self.surfaces)
        raise LookupError(f"nothing to count at {point}")

    def _row(self, first: Surface, along: Point) -> list[float]:
        """Coordinates along `along` of the cylinders of the same radius with axes in one row with the first."""
        places = []
        for other in self._of("CYLINDER", first.axis):
            across = subtract(other.origin, first.origin)
            step, depth = dot(across, along), dot(across, first.axis)
            in_row = add(scaled(along, step), scaled(first.axis, depth))
            if math.dist(across, in_row) < NEAR and abs(other.radius - first.radius) < NEAR:
                places.append(step)
        return places


def _alike(one: Surface, other: Surface) -> bool:
    """Spheres of one radius; faces in one plane."""
    if one.kind != other.kind:
        return False
    if one.kind == "SPHERE":
        return abs(one.radius - other.radius) < NEAR
    level = abs(dot(subtract(other.origin, one.origin), one.axis))
    return level < NEAR and abs(dot(one.axis, other.axis)) > 1 - 1e-9
