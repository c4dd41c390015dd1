"""Geometry of the faces of a solid: what its planes and round faces are, and the prisms that planes form."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import add, cross, dot, scaled, subtract
from stagecad.solids.modelling.kernel import cq, occ

NEAR = 1e-4
"""Largest distance of a declared point from its surface, mm; the accuracy of the value does not depend on it."""
UNITS: tuple[Point, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Surface:
    """Geometry of a face: plane, cylinder, cone, sphere or torus, with its bounding box."""

    face: cq.Face
    kind: str
    origin: Point
    axis: Point
    radius: float  # radius of a cylinder, sphere, or the tube of a torus; of a cone at its origin
    taper: float  # tangent of a cone's half angle
    low: Point
    high: Point

    @cached_property
    def vertices(self) -> tuple[Point, ...]:
        """Vertices of the face; computed on demand, since they are needed for few faces."""
        return tuple(vertex.toTuple() for vertex in self.face.Vertices())

    @cached_property
    def corners(self) -> list[Point]:
        """Corners of the outline of a plane face, without those of holes in it, and those in which a curve goes on."""
        wire = self.face.outerWire()
        ends = [
            (edge.geomType(), edge.positionAt(part).toTuple(), edge.tangentAt(part).toTuple())
            for edge in wire.Edges()
            for part in (0.0, 1.0)
        ]
        found: list[Point] = []
        for point in (vertex.toTuple() for vertex in wire.Vertices()):
            kinds = [(kind, way) for kind, end, way in ends if math.dist(end, point) < NEAR]
            same = len(kinds) == 2 and kinds[0][0] == kinds[1][0] and abs(dot(kinds[0][1], kinds[1][1])) > 1 - 1e-6
            found += [] if same else [point]
        return found or [vertex.toTuple() for vertex in wire.Vertices()]

    @cached_property
    def centre(self) -> Point:
        """Centre of the area of the face."""
        return self.face.Center().toTuple()

    @cached_property
    def area(self) -> float:
        """Area of the face, mm2."""
        return self.face.Area()

    @cached_property
    def outward(self) -> bool:
        """Whether the material of a round face is on the side of its axis, as of a shaft."""
        normal, point = self.middle
        return dot(self.radial(point), normal) > 0.0

    @cached_property
    def middle(self) -> tuple[Point, Point]:
        """Normal and point of the face in the middle of its parameters."""
        u0, u1, v0, v1 = self.face._uvBounds()
        normal, point = self.face.normalAt((u0 + u1) / 2, (v0 + v1) / 2)
        return normal.toTuple(), point.toTuple()

    @cached_property
    def normal(self) -> Point:
        """Normal of a plane face out of the material."""
        sign = math.copysign(1.0, dot(self.face.normalAt(self.face.Center()).toTuple(), self.axis))
        x, y, z = (round(sign * a, 15) + 0.0 for a in self.axis)
        return (x, y, z)

    @cached_property
    def span(self) -> float:
        """Angle of a round face about its axis, radians; of a spline surface, which has other parameters, on the mean
        of its length."""
        if self.kind == "CYLINDER" and self.face.geomType() != "CYLINDER":
            low, high = self.extent(self.axis)
            return self.area / (self.radius * (high - low))
        u0, u1, _, _ = self.face._uvBounds()  # pyright: ignore[reportPrivateUsage]
        return u1 - u0

    def radial(self, point: Point) -> Point:
        """Unit vector from the axis to a point."""
        out = rejection(subtract(point, self.origin), self.axis)
        size = max(math.hypot(*out), 1e-12)
        return (out[0] / size, out[1] / size, out[2] / size)

    @property
    def axis_key(self) -> tuple[float, ...]:
        """Numbers that are equal for coaxial faces."""
        sign = 1.0 if self.axis > (0.0, 0.0, 0.0) else -1.0
        unit = tuple(sign * a for a in self.axis)
        foot = rejection(self.origin, self.axis)
        return tuple(round(value, 3) + 0.0 for value in (*foot, *unit))

    def is_round(self, radius: float) -> bool:
        """Whether the face is a cylinder of a radius."""
        return self.kind == "CYLINDER" and abs(self.radius - radius) < NEAR

    def is_coaxial(self, other: Surface) -> bool:
        """Whether two round faces have one axis."""
        return self.off_axis(other.origin) < NEAR and abs(abs(dot(self.axis, other.axis)) - 1) < 1e-9

    def meets(self, other: Surface) -> bool:
        """Whether the axes of two round faces meet at right angles."""
        apart = dot(subtract(other.origin, self.origin), cross(self.axis, other.axis))
        return abs(dot(self.axis, other.axis)) < 1e-9 and abs(apart) < NEAR

    def off_axis(self, point: Point) -> float:
        """Distance of a point from the axis, mm."""
        to = subtract(point, self.origin)
        along = dot(to, self.axis)
        return math.dist(to, (along * self.axis[0], along * self.axis[1], along * self.axis[2]))

    def is_level(self, point: Point) -> bool:
        """Whether a point is in the plane of a face."""
        return self.off_plane(point) < NEAR

    def off_plane(self, point: Point) -> float:
        """Distance of a point from the plane of a face, mm."""
        return abs(dot(subtract(point, self.origin), self.axis))

    def is_at(self, point: Point) -> bool:
        """Whether a point is at the radius of a cylinder."""
        return abs(self.off_axis(point) - self.radius) < NEAR

    def holds(self, point: Point) -> bool:
        """Whether the point is on the face."""
        if not all(a - NEAR <= p <= b + NEAR for a, p, b in zip(self.low, point, self.high, strict=True)):
            return False
        if point not in self._held:
            if self._within is None:
                self._held[point] = self.face.distance(cq.Vertex.makeVertex(*point)) < NEAR
            else:
                self._held[point] = self.off_plane(point) < NEAR and self._within(point)
        return self._held[point]

    @cached_property
    def _held(self) -> dict[Point, bool]:
        """Points that were asked for: the kernel's answer is slow, and dimensions share points."""
        return {}

    @cached_property
    def _within(self) -> Callable[[Point], bool] | None:
        """Whether the outline of a plane face holds a point of its plane, ten times as fast as the kernel's distance;
        None for a face of another surface."""
        if self.face.geomType() != "PLANE":
            return None
        frame = occ.BRepAdaptor_Surface(self.face.wrapped).Plane().Position()
        (x, y), at = ((d.X(), d.Y(), d.Z()) for d in (frame.XDirection(), frame.YDirection())), frame.Location()
        origin, outline = (at.X(), at.Y(), at.Z()), occ.BRepTopAdaptor_FClass2d(self.face.wrapped, NEAR)

        def within(point: Point) -> bool:
            off = subtract(point, origin)
            return outline.Perform(occ.gp_Pnt2d(dot(off, x), dot(off, y))) != occ.TopAbs_OUT

        return within

    def extent(self, along: Point) -> tuple[float, float]:
        """Least and largest coordinate of the face's vertices in a direction, mm; along an axis of the part of the face
        itself, as the edges of crossing bores go beyond their vertices."""
        at = [dot(v, along) for v in self.vertices]
        ends = sorted((dot(self.low, along), dot(self.high, along)))
        if max(map(abs, along)) < 1 - 1e-9:
            return min(at), max(at)
        low, high = min(at, default=ends[0]), max(at, default=ends[1])
        return ends[0] if ends[0] < low - NEAR else low, ends[1] if ends[1] > high + NEAR else high

    def place(self, point: Point, along: Point) -> float | None:
        """Coordinate along `along` of the intersection with the line through the point, if nearly normal; else None."""
        centre = dot(self.origin, along)
        side = math.copysign(1.0, dot(point, along) - centre)
        if self.kind == "PLANE":
            slant = dot(self.axis, along)
            return (
                dot(point, along) + dot(subtract(self.origin, point), self.axis) / slant if abs(slant) > 0.9 else None
            )
        if self.kind == "SPHERE" or (self.kind == "CYLINDER" and abs(dot(self.axis, along)) < 1e-9):
            place = centre + side * self.radius
            return place if abs(place - dot(point, along)) < NEAR else None
        return None


@dataclass(frozen=True)
class Prism:
    """Sides of a prism along an axis of the part that half a turn brings onto each other: a slot, rectangle or polygon.

    `pairs`: opposite plane sides; `ends`: half cylinders of a slot; `sides`: all but fillets; `centre`: a point of its
    axis.
    """

    pairs: tuple[tuple[Surface, Surface], ...]
    ends: tuple[Surface, ...]
    sides: tuple[Surface, ...]
    centre: Point
    axis: Point

    @cached_property
    def widths(self) -> tuple[tuple[Point, float], ...]:
        """Direction and distance of opposite sides."""
        rows = [(one.normal, abs(dot(subtract(one.origin, other.origin), one.normal))) for one, other in self.pairs]
        if self.ends:
            run, radius = cross(self.axis, rows[0][0]), self.ends[0].radius
            rows.append((run, 2 * radius + abs(dot(subtract(self.ends[0].origin, self.ends[-1].origin), run))))
        return tuple(rows)

    @property
    def regular(self) -> bool:
        """Whether the sides are those of a regular polygon."""
        angles = sorted(math.acos(max(-1.0, min(1.0, dot(way, self.widths[0][0])))) for way, _ in self.widths)
        steps = [abs(angle / math.pi * len(angles) - round(angle / math.pi * len(angles))) for angle in angles]
        even = max(steps) < 1e-5 and max(value for _, value in self.widths) - min(v for _, v in self.widths) < NEAR
        return even and len(angles) > 1 and not self.ends

    @property
    def closed(self) -> bool:
        """Whether the sides end at the corners, and do not go on beyond them as those of arms or crossing slots."""
        for number, (one, _) in enumerate(self.pairs):
            way, size = self.widths[number - 1]
            half = 0.5 * size / math.hypot(*cross(one.normal, way))
            if len(self.pairs) > 2:
                half = 0.5 * size * math.tan(0.5 * math.pi / len(self.pairs))
            run, beside = cross(self.axis, one.normal), [s for s in self.sides if abs(dot(s.axis, one.axis)) > 1 - 1e-6]
            if any(abs(dot(subtract(v, self.centre), run)) > half + 1e-3 for s in beside for v in s.vertices):
                return False
        return True

    @property
    def square_to_axis(self) -> bool:
        """Whether two sides are square to an axis of the part."""
        return any(max(map(abs, one.axis)) > 1 - 1e-9 for one, _ in self.pairs)

    def is_axis(self, point: Point, along: Point) -> bool:
        """Whether a point is on the axis, and this square to a direction."""
        off = math.hypot(*rejection(subtract(point, self.centre), self.axis))
        return abs(dot(self.axis, along)) < 1e-9 and off < NEAR

    def is_equal(self, other: Prism) -> bool:
        """Whether another one differs by its place only."""
        return len(self.widths) == len(other.widths) and all(
            abs(dot(one, two)) > 1 - 1e-6 and abs(size - value) < 2e-3
            for (one, size), (two, value) in zip(self.widths, other.widths)
        )

    def faces(self, surface: Surface, way: Point) -> bool:
        """Whether a side is at the end of the prism in a direction."""
        return abs(dot(surface.axis, way)) > 1 - 1e-6 or (surface in self.ends and way == self.widths[-1][0])

    def is_turned_by(self, points: tuple[Point, ...]) -> bool:
        """Whether a line through two points is along a side, or along one through the middle."""
        step, off = subtract(points[-1], points[0]), subtract(points[0], self.centre)
        sides = [(way, value / 2) for way, value in self.widths if abs(dot(way, step)) < 1e-9 * math.hypot(*step)]
        return any(min(abs(dot(off, way)), abs(abs(dot(off, way)) - half)) < NEAR for way, half in sides)

    def spans(self, points: tuple[Point, ...], along: Point) -> bool:
        """Whether a distance in a direction, beside the sides, is that of two opposite ones, or of the axes of the
        ends."""
        at = sorted(dot(subtract(point, self.centre), along) for point in points)
        ends = [(min(s.low[n] for s in self.sides) - NEAR, max(s.high[n] for s in self.sides) + NEAR) for n in range(3)]
        if not all(low <= a <= high for point in points for a, (low, high) in zip(point, ends)):
            return False
        sizes = [value for way, value in self.widths if abs(dot(way, along)) > 1 - 1e-6]
        sizes += [value - 2 * self.ends[0].radius for value in sizes if self.ends]
        return any(abs(at[1] - size / 2) < 2e-3 and abs(at[0] + size / 2) < 2e-3 for size in sizes)


def prisms_of(surfaces: Iterable[Surface]) -> Iterator[Prism]:
    """Slots, and rectangular and regular openings along an axis of the part; of outer prisms those of six sides and
    more, with two of them square to another axis."""
    faces = [s for s in surfaces if s.kind in ("PLANE", "CYLINDER")]
    for number, axis in enumerate(UNITS):
        beside = [s for s in faces if abs(abs(s.axis[number]) - (s.kind == "CYLINDER")) < 1e-9]
        for group in connected(beside):
            if found := _prism(group, axis):
                one = found.pairs[0][0]
                inner = dot(subtract(one.origin, found.centre), one.normal) <= 0
                if inner or (len(found.pairs) > 2 and found.square_to_axis):
                    yield found


def _prism(group: list[Surface], axis: Point) -> Prism | None:
    """The prism of connected faces along an axis, if they form one; a hole may cross its sides."""
    walls: dict[Point, list[Surface]] = {}
    for s in (s for s in group if s.kind == "PLANE"):
        walls.setdefault(rounded(s.normal), []).append(s)
    rounds: dict[tuple[float, ...], list[Surface]] = {}
    for s in (s for s in group if s.kind == "CYLINDER"):
        rounds.setdefault(s.axis_key, []).append(s)
    opposite = [(row, walls.get(rounded(scaled(n, -1.0)), [])) for n, row in walls.items() if n < (0.0, 0.0, 0.0)]
    pairs = tuple((row[0], other[0]) for row, other in opposite if other)
    one_plane = (abs(dot(subtract(s.origin, row[0].origin), n)) < NEAR for n, row in walls.items() for s in row)
    if not pairs or 2 * len(pairs) != len(walls) or not all(one_plane):
        return None
    halves = [row for row in rounds.values() if abs(sum(s.span for s in row) - math.pi) < 0.02 and not row[0].outward]
    ends = tuple(s for row in halves for s in row) if len(pairs) == 1 else ()
    sides = (*(s for row in walls.values() for s in row), *ends)
    x, y, z = ((min(s.low[n] for s in sides) + max(s.high[n] for s in sides)) / 2 for n in range(3))
    prism = Prism(pairs, ends, sides, (x, y, z), axis)
    off = [(dot(subtract(s.origin, prism.centre), s.normal) for s in pair) for pair in pairs]
    ways = {math.copysign(1.0, one) for one, other in off if abs(one - other) < NEAR}
    (_, width), *others = prism.widths
    slot = len(halves) == 2 and all(abs(2 * end.radius - width) < NEAR for end in ends) and others[0][1] - width > NEAR
    found = slot if len(pairs) == 1 else (len(pairs) == 2 or prism.regular) and prism.closed
    return prism if len(ways) == 1 and found else None


def rounded(vector: Point) -> Point:
    x, y, z = (round(value, 6) + 0.0 for value in vector)
    return (x, y, z)


def moved(point: Point, direction: Point, by: float) -> Point:
    """The point moved along a direction, mm."""
    return add(point, scaled(direction, by))


def turned(vector: Point, axis: Point, angle: float) -> Point:
    """A vector turned about a unit vector, radians."""
    along = scaled(axis, dot(axis, vector))
    across = subtract(vector, along)
    return add(along, add(scaled(across, math.cos(angle)), scaled(cross(axis, across), math.sin(angle))))


def mirrored(normal: Point) -> tuple[float, ...]:
    """Numbers that are equal for the normals of faces that are mirror images about planes of the part."""
    return tuple(round(abs(a), 6) for a in normal)


def meeting(one: Surface, other: Surface, point: Point) -> Point | None:
    """The point of the line in which the planes of two faces meet that is nearest to a point; None of parallel ones."""
    edge = cross(one.axis, other.axis)
    size = dot(edge, edge)
    if size < 1e-9:
        return None
    ways = ((one, cross(other.axis, edge)), (other, cross(edge, one.axis)))
    steps = [scaled(way, dot(subtract(s.origin, point), s.axis) / size) for s, way in ways]
    return add(point, add(*steps))


def is_beside(surface: Surface, point: Point, axis: Point) -> bool:
    """Whether a turn about an axis moves a face: not an end face, nor a round face about the axis."""
    square = abs(dot(surface.axis, axis)) > 1 - 1e-6
    return (surface.kind == "PLANE" and not square) or (
        surface.kind == "CYLINDER" and not (square and surface.off_axis(point) < NEAR)
    )


def connected(surfaces: list[Surface]) -> list[list[Surface]]:
    """Faces in groups that share corners."""
    groups: list[tuple[set[tuple[float, ...]], list[Surface]]] = []
    for surface in surfaces:
        corners = {tuple(round(a, 3) + 0.0 for a in corner) for corner in surface.vertices}
        own = [group for group in groups if group[0] & corners]
        groups = [group for group in groups if group not in own]
        groups.append((corners.union(*(group[0] for group in own)), [s for group in own for s in group[1]] + [surface]))
    return [group for _, group in groups]


def features_of_faces(surfaces: list[Surface]) -> list[list[Surface]]:
    """Faces in groups that share corners; single walls that are opposite each other across air, as of a slit, too."""
    found: list[list[Surface]] = []
    for group in connected(surfaces):
        mate = next((one for one in found if len(one) == len(group) == 1 and _are_opposite(one[0], group[0])), None)
        if mate:
            mate += group
        else:
            found.append(group)
    return found


def _are_opposite(one: Surface, other: Surface) -> bool:
    if not one.kind == other.kind == "PLANE" or dot(one.normal, other.normal) > 1e-9 - 1:
        return False
    step = scaled(subtract(add(other.low, other.high), add(one.low, one.high)), 0.5)
    across = dot(step, one.normal)
    return across > NEAR and math.dist(step, scaled(one.normal, across)) < NEAR


def rejection(vector: Point, axis: Point) -> Point:
    """The component of a vector at right angles to an axis."""
    return subtract(vector, scaled(axis, dot(vector, axis)))


def surface_of(face: cq.Face) -> Surface:
    """The geometry of a face of a solid."""
    kind, shape = face.geomType(), None
    if kind in ("BSPLINE", "BEZIER", "EXTRUSION", "REVOLUTION"):
        # A face of a loft or sweep may be plane or round, and other programs export all faces so.
        found = occ.ShapeAnalysis_CanonicalRecognition(face.wrapped)
        shapes = (occ.gp_Pln(), occ.gp_Cylinder(), occ.gp_Cone(), occ.gp_Sphere())
        simple: dict[str, Any] = dict(zip(("Plane", "Cylinder", "Cone", "Sphere"), shapes, strict=True))
        if name := next((name for name, one in simple.items() if getattr(found, f"Is{name}")(NEAR, one)), None):
            kind, shape = name.upper(), simple[name]
    elif kind in ("PLANE", "CYLINDER", "CONE", "SPHERE", "TORUS"):
        shape = getattr(occ.BRepAdaptor_Surface(face.wrapped), kind.title())()
    frame = shape.Position() if shape else None
    size = {"CYLINDER": "Radius", "CONE": "RefRadius", "SPHERE": "Radius", "TORUS": "MinorRadius"}.get(kind)
    radius = getattr(shape, size)() if size else 0.0
    taper = math.tan(shape.SemiAngle()) if shape and kind == "CONE" else 0.0
    box = occ.Bnd_Box()
    occ.BRepBndLib.AddOptimal_s(face.wrapped, box)
    x0, y0, z0, x1, y1, z1 = box.Get()
    at, axis = (frame.Location(), frame.Direction()) if frame else (None, None)
    return Surface(
        face,
        kind,
        (at.X(), at.Y(), at.Z()) if at else (0.0, 0.0, 0.0),
        (axis.X(), axis.Y(), axis.Z()) if axis else (0.0, 0.0, 0.0),
        radius,
        taper,
        (x0, y0, z0),
        (x1, y1, z1),
    )
