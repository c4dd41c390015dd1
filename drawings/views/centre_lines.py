"""Centre lines and centre marks of round features, and lines of symmetry (ISO 128-2, line type 04.1).

A circle, or half of one, gets a centre mark. A feature seen from the side, whose outlines are mirror images
about its axis, gets a centre line.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from drawings.views.line_cleaning import cleaned, joined
from drawings.views.view import (
    Arc,
    Curve,
    Layer,
    Point2,
    Polyline,
    Projection,
    Segment,
    bounding_box,
    dot,
    extreme_points,
)
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.kernel import KernelShape, cq, occ, parts_of
from stagecad.solids.modelling.surface import surface_of

BEYOND = 3.0
"""Length of a centre line beyond the outline, mm on the paper."""
NEAR = 0.02
"""Greatest deviation of two outlines from mirror symmetry, mm."""
LEAST = 179.5
"""Sum of the angles of the arcs of a circle from which on it gets a centre mark, as the end of a slot does, degrees."""


@dataclass(frozen=True)
class Axis:
    """Axis of a round feature: a point and the direction, its greatest radius, and its ends along the axis, mm."""

    origin: Point
    direction: Point
    radius: float
    low: float
    high: float


@dataclass(frozen=True)
class Mark:
    """A centre mark where no circle has one: its point, the normal of the plane in which it is, the halves of its lines
    or a radius of lines along the view, and the centres of arcs that have no marks."""

    at: Point
    normal: Point
    radius: float = 0.0
    halves: tuple[Point, ...] = ()
    ends: tuple[Point, ...] = ()
    layer: Layer = "CENTRE"  # or `THREAD`, for a flank up to the line in which it would meet another one

    def is_in(self, projection: Projection) -> bool:
        return abs(dot(self.normal, projection.towards_eye)) > 0.999

    def thin(self, projection: Projection) -> Iterator[Segment]:
        """Its lines in a view, if they are no centre lines."""
        if self.layer != "CENTRE" and self.is_in(projection):
            yield from _mark(self, projection, 0.0)


def axes_of(shape: KernelShape) -> tuple[Axis, ...]:
    """Axes of the cylinders and cones of a shape that cover half a turn or more."""
    found: dict[tuple[float, ...], list[Axis]] = {}
    for face in parts_of(shape, "Face"):
        surface = occ.BRepAdaptor_Surface(face)
        if surface.GetType() in (occ.GeomAbs_Plane, occ.GeomAbs_Sphere, occ.GeomAbs_Torus):
            continue
        # A face of a sweep or of splines may be round.
        own = surface_of(cq.Face(face))
        if own.kind not in ("CYLINDER", "CONE") or own.span < math.pi - 1e-6:
            continue
        p, d, radius, angle = own.origin, own.axis, own.radius, math.atan(own.taper)
        if surface.GetType() in (occ.GeomAbs_Cylinder, occ.GeomAbs_Cone):
            ends = (surface.FirstVParameter(), surface.LastVParameter())
            radius = max(abs(radius + v * math.sin(angle)) for v in ends)
            low, high = (v * math.cos(angle) for v in ends)
        else:
            low, high = (end - dot(p, d) for end in own.extent(d))
        if d < (0.0, 0.0, 0.0):
            d, low, high = (-d[0], -d[1], -d[2]), -high, -low
        along = sum(a * b for a, b in zip(p, d, strict=True))
        foot = (p[0] - along * d[0], p[1] - along * d[1], p[2] - along * d[2])
        key = tuple(round(value, 3) + 0.0 for value in (*foot, *d))
        found.setdefault(key, []).append(Axis(foot, d, radius, low + along, high + along))
    return tuple(item for key in sorted(found) for item in found[key])


def centre_lines(
    curves: Mapping[Layer, Iterable[Curve]],
    axes: Iterable[Axis],
    projection: Projection,
    scale: float,
    symmetry: Iterable[str] = (),
    marks: Iterable[Mark] = (),
) -> tuple[Curve, ...]:
    """Centre lines of a view; marks instead of those at the ends of slots."""
    shown = [curve for layer in ("VISIBLE", "HIDDEN") for curve in curves.get(layer, ())]
    beyond = BEYOND / scale
    axes, marks = list(axes), [mark for mark in marks if mark.layer == "CENTRE" and mark.is_in(projection)]
    lines = [
        *_crosses(shown, axes, projection, beyond, [projection.to_view(end) for mark in marks for end in mark.ends]),
        *(line for mark in marks for line in _mark(mark, projection, beyond)),
        *_sides(shown, axes, projection, beyond),
        *_symmetry(shown, symmetry, beyond),
    ]
    return cleaned(lines)[0]


def _crosses(
    shown: list[Curve], axes: Iterable[Axis], projection: Projection, beyond: float, without: Sequence[Point2]
) -> Iterator[Segment]:
    turns: dict[tuple[float, float, float], float] = {}
    for curve in shown:
        if isinstance(curve, Arc):
            key = (round(curve.centre[0], 3) + 0.0, round(curve.centre[1], 3) + 0.0, round(curve.radius, 3))
            turns[key] = turns.get(key, 0.0) + curve.end_angle - curve.start_angle
    reach: dict[Point2, float] = {}
    for (x, y, radius), covered in turns.items():
        if covered > LEAST:
            reach[x, y] = max(reach.get((x, y), 0.0), radius)
    # The mouth of a hole in a round face is no arc, though it is seen as one.
    bent = [curve.points for curve in shown if isinstance(curve, Polyline)]
    for axis in axes:
        (x, y), radius = projection.to_view(axis.origin), axis.radius
        if abs(dot(axis.direction, projection.towards_eye)) > 1 - 1e-6 and any(
            all(abs(math.dist(point, (x, y)) - radius) < NEAR for point in points) for points in bent
        ):
            key = (round(x, 3) + 0.0, round(y, 3) + 0.0)
            reach[key] = max(reach.get(key, 0.0), radius)
    for at, radius in sorted((at, r) for at, r in reach.items() if all(math.dist(at, end) > NEAR for end in without)):
        yield from _cross(at, radius + beyond)


def _mark(mark: Mark, projection: Projection, beyond: float) -> Iterator[Segment]:
    at, halves = projection.to_view(mark.at), [projection.to_view(half) for half in mark.halves]
    for u, v in halves or ((mark.radius, 0.0), (0.0, mark.radius)):
        more = 1 + beyond / math.hypot(u, v)
        yield Segment((at[0] - more * u, at[1] - more * v), (at[0] + more * u, at[1] + more * v))


def _cross(at: Point2, arm: float) -> Iterator[Segment]:
    x, y = at
    yield Segment((x - arm, y), (x + arm, y))
    yield Segment((x, y - arm), (x, y + arm))


def _sides(shown: list[Curve], axes: Iterable[Axis], projection: Projection, beyond: float) -> Iterator[Segment]:
    eye = projection.towards_eye
    ends = [end for curve in shown for end in _ends(curve)]
    rows: dict[tuple[float, ...], list[tuple[float, float]]] = {}
    for axis in axes:
        if abs(dot(axis.direction, eye)) > 1e-6:
            continue
        at, along = projection.to_view(axis.origin), projection.to_view(axis.direction)
        if _mirrored(ends, at, along, axis):
            shift = at[0] * along[0] + at[1] * along[1]
            key = tuple(round(value, 3) + 0.0 for value in (at[0] - shift * along[0], at[1] - shift * along[1], *along))
            rows.setdefault(key, []).append((axis.low + shift, axis.high + shift))
    for (x, y, u, v), spans in sorted(rows.items()):
        for low, high in joined(spans, 2 * beyond):
            low, high = low - beyond, high + beyond
            yield Segment((x + low * u, y + low * v), (x + high * u, y + high * v))


def _ends(curve: Curve) -> tuple[Point2, ...]:
    if isinstance(curve, Segment):
        return (curve.start, curve.end)
    if isinstance(curve, Polyline):
        return (curve.points[0], curve.points[-1])
    return ()


def _mirrored(ends: list[Point2], at: Point2, along: Point2, axis: Axis) -> bool:
    """Whether lines end at the radius on both sides of the axis, as the outlines of a round feature do."""
    low, high = axis.low - NEAR, axis.high + NEAR
    sides: list[list[float]] = [[], []]
    for x, y in ends:
        dx, dy = x - at[0], y - at[1]
        across = dy * along[0] - dx * along[1]
        if abs(abs(across) - axis.radius) < NEAR and low <= dx * along[0] + dy * along[1] <= high:
            sides[across > 0].append(dx * along[0] + dy * along[1])
    return any(abs(a - b) < NEAR for a in sides[0] for b in sides[1])


def _symmetry(shown: list[Curve], symmetry: Iterable[str], beyond: float) -> Iterator[Segment]:
    u0, v0, u1, v1 = bounding_box([point for curve in shown for point in extreme_points(curve)])
    for direction in symmetry:
        if direction == "u":
            yield Segment((u0 - beyond, 0.0), (u1 + beyond, 0.0))
        else:
            yield Segment((0.0, v0 - beyond), (0.0, v1 + beyond))
