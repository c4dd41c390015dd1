"""Centre lines and centre marks of what is round, where a view shows it (ISO 128-2, line type 04.1).

Seen along its axis, a round feature is a circle, or most of one, and gets a cross. Seen from the side it is a pair of
lines, mirror images of each other about the axis, and gets a line between them.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drawings.views.line_cleaning import cleaned, joined
from drawings.views.view import Arc, Box2, Curve, Layer, Point2, Polyline, Projection, Segment
from stagecad.parameters.dimension import Point

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

BEYOND = 3.0
"""How far a centre line passes the outline, mm on paper."""
NEAR = 0.02
"""How well two lines must mirror each other, mm."""
MOST = 180.0
"""Arcs of one circle that together cover more than this are marked like a circle, degrees."""


@dataclass(frozen=True)
class Axis:
    """What is round about one axis: its place, its greatest radius, and how far it reaches along the axis, mm."""

    origin: Point
    direction: Point
    radius: float
    low: float
    high: float


def axes_of(shape: TopoDS_Shape) -> tuple[Axis, ...]:
    """Axes of the cylinders and cones of a shape that go round by half a turn or more."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    found: dict[tuple[float, ...], list[Axis]] = {}
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        surface = BRepAdaptor_Surface(TopoDS.Face_s(explorer.Current()))
        explorer.Next()
        if surface.GetType() not in (GeomAbs_Cylinder, GeomAbs_Cone):
            continue
        if surface.LastUParameter() - surface.FirstUParameter() < math.pi - 1e-6:
            continue
        if surface.GetType() == GeomAbs_Cylinder:
            axis = surface.Cylinder().Axis()
            radius = surface.Cylinder().Radius()
            low, high = surface.FirstVParameter(), surface.LastVParameter()
        else:
            cone = surface.Cone()
            axis = cone.Axis()
            ends = (surface.FirstVParameter(), surface.LastVParameter())
            radius = max(abs(cone.RefRadius() + v * math.sin(cone.SemiAngle())) for v in ends)
            low, high = (v * math.cos(cone.SemiAngle()) for v in ends)
        place, direction = axis.Location(), axis.Direction()
        d = (direction.X(), direction.Y(), direction.Z())
        p = (place.X(), place.Y(), place.Z())
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
) -> tuple[Curve, ...]:
    """Centre lines of a view.

    Args:
        curves: of the view, by layer.
        axes: of the part (`axes_of`), before any cut.
        projection, scale: of the view.
        symmetry: `u` for a line of symmetry along u through the view's origin, `v` along v.
    """
    shown = [curve for layer in ("VISIBLE", "HIDDEN") for curve in curves.get(layer, ())]
    beyond = BEYOND / scale
    lines = [*_crosses(shown, beyond), *_sides(shown, axes, projection, beyond), *_symmetry(shown, symmetry, beyond)]
    return cleaned(lines)[0]


def _crosses(shown: list[Curve], beyond: float) -> Iterator[Segment]:
    turns: dict[tuple[float, float, float], float] = {}
    for curve in shown:
        if isinstance(curve, Arc):
            key = (round(curve.centre[0], 3) + 0.0, round(curve.centre[1], 3) + 0.0, round(curve.radius, 3))
            turns[key] = turns.get(key, 0.0) + curve.end_angle - curve.start_angle
    reach: dict[Point2, float] = {}
    for (x, y, radius), covered in turns.items():
        if covered > MOST:
            reach[x, y] = max(reach.get((x, y), 0.0), radius)
    for (x, y), radius in sorted(reach.items()):
        r = radius + beyond
        yield Segment((x - r, y), (x + r, y))
        yield Segment((x, y - r), (x, y + r))


def _sides(shown: list[Curve], axes: Iterable[Axis], projection: Projection, beyond: float) -> Iterator[Segment]:
    eye = projection.towards_eye
    ends = [end for curve in shown for end in _ends(curve)]
    rows: dict[tuple[float, ...], list[tuple[float, float]]] = {}
    for axis in axes:
        if abs(sum(a * b for a, b in zip(axis.direction, eye, strict=True))) > 1e-6:
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
    """Whether lines end on both sides of the axis at its radius, as the outlines of what is round do."""
    low, high = axis.low - NEAR, axis.high + NEAR
    sides: list[list[float]] = [[], []]
    for x, y in ends:
        dx, dy = x - at[0], y - at[1]
        across = dy * along[0] - dx * along[1]
        if abs(abs(across) - axis.radius) < NEAR and low <= dx * along[0] + dy * along[1] <= high:
            sides[across > 0].append(dx * along[0] + dy * along[1])
    return any(abs(a - b) < NEAR for a in sides[0] for b in sides[1])


def _symmetry(shown: list[Curve], symmetry: Iterable[str], beyond: float) -> Iterator[Segment]:
    box = bounds(shown)
    for direction in symmetry:
        if direction == "u":
            yield Segment((box[0] - beyond, 0.0), (box[2] + beyond, 0.0))
        else:
            yield Segment((0.0, box[1] - beyond), (0.0, box[3] + beyond))


def bounds(curves: Iterable[Curve]) -> Box2:
    """Box of some curves' ends and circles, view coordinates."""
    points: list[Point2] = []
    for curve in curves:
        if isinstance(curve, Arc) and curve.end_angle - curve.start_angle > 359.0:
            (x, y), r = curve.centre, curve.radius
            points += [(x - r, y - r), (x + r, y + r)]
        elif isinstance(curve, Segment):
            points += [curve.start, curve.end]
        elif isinstance(curve, Polyline):
            points += curve.points
    xs, ys = zip(*points)
    return (min(xs), min(ys), max(xs), max(ys))
