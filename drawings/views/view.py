"""Views: curves in the plane of projection at 1:1, and their place on the paper.

Coordinate systems, in mm. Part: (x, y, z) of the solid. View: (u, v) in the plane of projection, u to the right, v up,
at 1:1, with the projection of the part's origin as origin. Paper: (x, y) from the lower left corner of the sheet.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import Literal

from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import add, scaled, subtract
from stagecad.solids.modelling.frame import dot as dot

Point2 = tuple[float, float]
Box2 = tuple[float, float, float, float]
"""Lower left and upper right corner: u0, v0, u1, v1."""

Layer = Literal["VISIBLE", "HIDDEN", "CENTRE", "SECTION", "HATCH", "PHANTOM", "THREAD"]
"""Kinds of line of a view, by the names of their layers in the DXF file (ISO 128-2).

`SECTION` is the cutting line of a section in another view; the outline of the section is `VISIBLE`. `PHANTOM` is the
range of a moving part, `THREAD` the major diameter of a tapped hole.
"""


def degrees_of(vector: Point2) -> float:
    """Direction of a vector in the plane, degrees from u."""
    return math.degrees(math.atan2(vector[1], vector[0]))


def direction(angle: float) -> Point2:
    """Unit vector at an angle, degrees."""
    return (math.cos(math.radians(angle)), math.sin(math.radians(angle)))


def offset(point: Point2, u: Point2, along: float, across: float = 0.0) -> Point2:
    """A point moved along a unit vector and across it, to its left."""
    return (point[0] + u[0] * along - u[1] * across, point[1] + u[1] * along + u[0] * across)


def distance_along(point: Point2, start: Point2, u: Point2) -> float:
    """Distance of a point from a start along a unit vector."""
    return (point[0] - start[0]) * u[0] + (point[1] - start[1]) * u[1]


@dataclass(frozen=True)
class Segment:
    """A straight line."""

    start: Point2
    end: Point2


@dataclass(frozen=True)
class Arc:
    """A circular arc, counter-clockwise between two angles in degrees; a circle from 0 to 360."""

    centre: Point2
    radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0


@dataclass(frozen=True)
class Polyline:
    """Any other curve as points along it."""

    points: tuple[Point2, ...]


Curve = Segment | Arc | Polyline


@dataclass(frozen=True)
class Projection:
    """A direction of view, by the directions to the right and up on the paper; the line of sight is -(right x up)."""

    name: str  # `top`, `front`, ..., as in `stagecad.parameters.dimension.View`
    # right, up: orthogonal unit vectors, part coordinates
    right: Point
    up: Point

    @property
    def towards_eye(self) -> Point:
        """Unit vector from the part to the eye."""
        (a, b, c), (u, v, w) = self.right, self.up
        return (b * w - c * v, c * u - a * w, a * v - b * u)

    def to_view(self, point: Point) -> Point2:
        """View coordinates of a point of the part, mm at 1:1."""
        return (sum(a * b for a, b in zip(self.right, point)), sum(a * b for a, b in zip(self.up, point)))


_S2, _S3, _S6 = math.sqrt(2), math.sqrt(3), math.sqrt(6)

PROJECTIONS = {
    projection.name: projection
    for projection in (
        Projection("front", (1, 0, 0), (0, 0, 1)),
        Projection("back", (-1, 0, 0), (0, 0, 1)),
        Projection("right", (0, 1, 0), (0, 0, 1)),
        Projection("left", (0, -1, 0), (0, 0, 1)),
        Projection("top", (1, 0, 0), (0, 1, 0)),
        Projection("bottom", (1, 0, 0), (0, -1, 0)),
        Projection("iso", (1 / _S2, 1 / _S2, 0), (-1 / _S6, 1 / _S6, 2 / _S6)),
    )
}
"""Third angle: the top view is above the front view, the right view to its right, the bottom view below it."""


@cache
def projection_of(name: str) -> Projection:
    """The projection of a name: one of `PROJECTIONS`, or `auxiliary X Y Z`, against a slanting face of this normal."""
    if name in PROJECTIONS:
        return PROJECTIONS[name]
    x, y, z = (float(word) for word in name.split()[1:])
    size = math.hypot(x, y)
    return Projection("auxiliary", (-y / size, x / size, 0.0), (-x * z / size, -y * z / size, size))


def auxiliary(normal: Point) -> str:
    """Name of the projection against a slanting face."""
    return f"auxiliary {' '.join(map(repr, normal))}"


@dataclass(frozen=True)
class Cut:
    """The cutting plane of a section, or its planes; the material on the side of the eye is removed.

    `offset`: parallel planes through the points, one after the other along `way`, which change half-way between them.
    `half`: only beyond the point. `aligned`: beyond the point the plane through the second one, turned into the first.
    """

    point: Point  # of the plane, part coordinates
    normal: Point  # unit vector towards the eye
    letter: str  # of the name of the section, `A-A`
    more: tuple[Point, ...] = ()  # points of the other planes
    kind: Literal["offset", "half", "aligned"] = "offset"
    way: Point = (0.0, 0.0, 0.0)  # unit vector in the plane, across which it changes

    def holds(self, point: Point, near: float = 1e-6) -> bool:
        """Whether a point is where a plane that is parallel to the paper cuts."""
        along, plane = dot(point, self.way), self.point
        if self.kind == "half" and along < self.changes[0] - near:
            return False
        if self.kind == "aligned" and along > self.changes[0] + near:
            return False
        if self.kind == "offset" and self.more:
            plane = (plane, *self.more)[sum(along > change for change in self.changes)]
        return abs(dot(subtract(point, plane), self.normal)) < near

    @property
    def words(self) -> str:
        """Its kind and the coordinates of its points, as after the name of a view of a part."""
        if self.kind == "offset" and not self.more and self.point == (0.0, 0.0, 0.0):
            return "section"
        points = (self.point, *(self.more if self.kind != "half" else (add(self.point, self.way),)))
        return " ".join((self.kind, *(f"{a:.9g}" for point in points for a in point)))

    @property
    def changes(self) -> tuple[float, ...]:
        """Coordinates along `way` at which the plane changes."""
        at = [dot(point, self.way) for point in (self.point, *self.more)]
        return tuple((one + other) / 2 for one, other in pairwise(at)) if self.kind == "offset" else (at[0],)

    @property
    def path(self) -> tuple[Point, ...]:
        """Corners of the cutting line, from a point of its first to one of its last leg."""
        points = (self.point, *self.more)
        if self.kind == "half":
            return (add(self.point, self.normal), self.point, add(self.point, self.way))
        if self.kind == "aligned":
            return (subtract(self.point, self.way), *points)
        steps = [
            add(point, scaled(self.way, change - dot(point, self.way)))
            for change, pair in zip(self.changes, pairwise(points), strict=True)
            for point in pair
        ]
        return (points[0], *steps, points[-1])


def section_cut(view: str, points: Sequence[Point], letter: str, kind: str = "offset") -> Cut:
    """The planes of a section that is seen as a view from outside: `offset`, through one or more points; `half`, beyond
    the first point, to the right or towards a second one; `aligned`, through an axis and towards a second point.

    Raises:
        ValueError: another kind, or number of points.
    """
    counts = {"offset": range(1, 9), "half": (1, 2), "aligned": (2,)}
    if len(points) not in counts.get(kind, ()):
        raise ValueError(f"{kind} is a kind of section through points: offset, half (one), aligned (two)")
    projection, (first, *more) = PROJECTIONS[view], points
    # The plane changes along the direction of the paper in which its points are further apart.
    last = more[-1] if more else add(first, projection.right)
    apart = [dot(subtract(last, first), way) for way in (projection.right, projection.up)]
    number = 0 if abs(apart[0]) >= abs(apart[1]) else 1
    way = scaled((projection.right, projection.up)[number], math.copysign(1.0, apart[number]))
    others = () if kind == "half" else tuple(more)
    return Cut(first, projection.towards_eye, letter, others, kind, way)  # type: ignore[arg-type]


@dataclass(frozen=True)
class View:
    """One view: curves by layer, and its place on the paper."""

    name: str  # unique on the sheet; annotations refer to it: `top`, `front`, `section A-A`, `detail X`
    projection: Projection  # direction of view
    curves: dict[Layer, tuple[Curve, ...]] = field(default_factory=dict)  # by layer, view coordinates at 1:1
    scale: float = 1.0  # paper over part, 0.5 for 1:2
    place: Point2 = (0.0, 0.0)  # paper coordinates of the view's origin
    label: str = ""  # text below the view (`A-A`, `X (1:2)`); empty for none
    label_at: Point2 | None = None  # middle of the base line of the label, paper; default just below the view
    clip: tuple[Point2, float] | None = None  # centre and radius of the circle of a detail, view coordinates
    cut: Cut | None = None  # plane of a section; None for a view from outside
    face: Cut | None = None  # plane of the slanting face that an auxiliary view shows
    aligned_with: str = ""  # name of the view with which it is aligned; empty for none

    def on(self, *layers: Layer) -> list[Curve]:
        """Curves on some layers."""
        return [curve for layer in layers for curve in self.curves.get(layer, ())]

    def to_paper(self, point: Point2) -> Point2:
        """Paper coordinates of a point of the view."""
        return (self.place[0] + self.scale * point[0], self.place[1] + self.scale * point[1])


def view_box(view: View) -> Box2 | None:
    """Bounding box of a view's curves on the paper, mm; None for a view without curves."""
    points = [point for curves in view.curves.values() for curve in curves for point in extreme_points(curve)]
    if not points:
        return None
    box = bounding_box(points)
    return (*view.to_paper(box[:2]), *view.to_paper(box[2:]))


def extreme_points(curve: Curve) -> list[Point2]:
    """Points whose bounding box is that of the curve; of an arc, its ends and its points at multiples of 90 degrees."""
    if isinstance(curve, Segment):
        return [curve.start, curve.end]
    if not isinstance(curve, Arc):
        return list(curve.points)
    (x, y), radius = curve.centre, curve.radius
    quarters = range(math.ceil(curve.start_angle / 90), math.floor(curve.end_angle / 90) + 1)
    angles = [curve.start_angle, curve.end_angle, *(90.0 * quarter for quarter in quarters)]
    return [(x + radius * math.cos(math.radians(a)), y + radius * math.sin(math.radians(a))) for a in angles]


def bounding_box(points: Sequence[Point2]) -> Box2:
    """Bounding box of points."""
    xs, ys = zip(*points)
    return (min(xs), min(ys), max(xs), max(ys))


def enclosing_box(boxes: Sequence[Box2], margin: float = 0.0) -> Box2:
    """Bounding box of boxes, enlarged by a margin on each side."""
    x0, y0, x1, y1 = zip(*boxes)
    return (min(x0) - margin, min(y0) - margin, max(x1) + margin, max(y1) + margin)
