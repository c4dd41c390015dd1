"""Thin lines of threads in tapped holes (ISO 6410-1): three quarters of a circle from the end, lines in a section."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from drawings.views.view import Arc, Curve, Cut, Layer, Point2, Projection, Segment, dot
from stagecad.parameters.dimension import Point

NEAR = 1e-3
"""Greatest difference of a drawn circle from the drill's, mm."""
SQUARE = 1e-6
LEAST = 0.7
"""Least distance between the lines of crest and root, mm on the paper (ISO 6410-1)."""
OPEN = (100.0, 350.0)
"""Ends of the circle of a thread, degrees."""


@dataclass(frozen=True)
class ThreadedHole:
    """A tapped hole."""

    mouth: Point  # start of the thread on the axis, part coordinates, mm
    into: Point  # unit vector along the axis into the material
    length: float  # of the full thread, mm
    # drill, major: diameters, mm
    drill: float
    major: float
    blind: bool  # whether the thread ends before the hole does
    rim: float = 0.0  # radius of the chamfer at the mouth, mm; 0 without one


def thread_lines(
    curves: Mapping[Layer, Iterable[Curve]],
    holes: Iterable[ThreadedHole],
    projection: Projection,
    cut: Cut | None,
    scale: float,
) -> dict[Layer, tuple[Curve, ...]]:
    """Lines of the threads that a view shows, by layer; a thread is seen where the circle of its drill is drawn."""
    holes = [replace(hole, major=max(hole.major, hole.drill + 2 * LEAST / scale)) for hole in holes]
    circles = [curve for curve in curves.get("VISIBLE", ()) if isinstance(curve, Arc)]
    thin: list[Curve] = []
    wide: list[Curve] = []
    for hole in holes:
        along = dot(hole.into, projection.towards_eye)
        if abs(abs(along) - 1.0) < SQUARE:
            if _is_drawn(projection.to_view(hole.mouth), hole.drill / 2, circles):
                thin.append(Arc(projection.to_view(hole.mouth), hole.major / 2, *OPEN))
        elif cut and abs(along) < SQUARE and cut.holds(hole.mouth):
            thin += _sides(hole, projection)
            wide += [_end(hole, projection)] if hole.blind else []
    return {"THREAD": tuple(thin), "VISIBLE": tuple(wide)}


def without_mouths(curves: Iterable[Curve], holes: Iterable[ThreadedHole], projection: Projection) -> tuple[Curve, ...]:
    """Visible curves of a view without the circles of the chamfers of tapped holes, which are omitted (ISO 6410-1)."""
    rims = [
        (projection.to_view(hole.mouth), hole.rim)
        for hole in holes
        if hole.rim and abs(abs(dot(hole.into, projection.towards_eye)) - 1.0) < SQUARE
    ]
    return tuple(
        curve
        for curve in curves
        if not isinstance(curve, Arc)
        or not any(abs(curve.radius - rim) < NEAR and math.dist(curve.centre, at) < NEAR for at, rim in rims)
    )


def _is_drawn(centre: Point2, radius: float, circles: Iterable[Arc]) -> bool:
    return any(
        abs(circle.radius - radius) < NEAR
        and abs(circle.centre[0] - centre[0]) < NEAR
        and abs(circle.centre[1] - centre[1]) < NEAR
        for circle in circles
    )


def _points(hole: ThreadedHole, projection: Projection, along: float) -> tuple[Point2, Point2]:
    """Both ends of the major diameter at a distance from the mouth."""
    x, y, z = (m + along * d for m, d in zip(hole.mouth, hole.into, strict=True))
    u, v = projection.to_view((x, y, z))
    du, dv = projection.to_view(hole.into)
    half = hole.major / 2
    return (u - half * dv, v + half * du), (u + half * dv, v - half * du)


def _sides(hole: ThreadedHole, projection: Projection) -> Iterator[Segment]:
    starts, ends = _points(hole, projection, 0.0), _points(hole, projection, hole.length)
    for start, end in zip(starts, ends, strict=True):
        yield Segment(start, end)


def _end(hole: ThreadedHole, projection: Projection) -> Segment:
    return Segment(*_points(hole, projection, hole.length))
