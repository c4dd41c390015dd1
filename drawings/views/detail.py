"""Details: the curves of a view clipped to a circle."""

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise

from drawings.views.view import Arc, Curve, Point2, Polyline, Segment


def clipped(curves: Iterable[Curve], centre: Point2, radius: float) -> tuple[Curve, ...]:
    """The parts of curves within a circle."""
    return tuple(piece for curve in curves for piece in _inside(curve, centre, radius))


def _inside(curve: Curve, centre: Point2, radius: float) -> Iterator[Curve]:
    if isinstance(curve, Segment):
        span = _span(curve.start, curve.end, centre, radius)
        if span:
            yield Segment(_between(curve.start, curve.end, span[0]), _between(curve.start, curve.end, span[1]))
    elif isinstance(curve, Arc):
        yield from _arc_inside(curve, centre, radius)
    else:
        yield from _polyline_inside(curve, centre, radius)


def _between(start: Point2, end: Point2, t: float) -> Point2:
    return (start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1]))


def _span(start: Point2, end: Point2, centre: Point2, radius: float) -> tuple[float, float] | None:
    """Ends of the part of a segment within the circle as fractions of its length; None if it is outside."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    fx, fy = start[0] - centre[0], start[1] - centre[1]
    a, b, c = dx * dx + dy * dy, fx * dx + fy * dy, fx * fx + fy * fy - radius * radius
    root = b * b - a * c
    if root <= 0.0 or a == 0.0:
        return None
    low, high = max(0.0, (-b - math.sqrt(root)) / a), min(1.0, (-b + math.sqrt(root)) / a)
    return (low, high) if high - low > 1e-9 else None


def _arc_inside(arc: Arc, centre: Point2, radius: float) -> Iterator[Arc]:
    """The parts of an arc within a circle, between its intersections with it."""
    distance = math.dist(arc.centre, centre)
    angles = [arc.start_angle, arc.end_angle]
    if abs(arc.radius - radius) < distance < arc.radius + radius:
        toward = math.degrees(math.atan2(centre[1] - arc.centre[1], centre[0] - arc.centre[0]))
        cosine = (arc.radius**2 + distance**2 - radius**2) / (2 * arc.radius * distance)
        spread = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
        for crossing in (toward - spread, toward + spread):
            at = crossing + 360.0 * math.ceil((arc.start_angle - crossing) / 360.0)
            if arc.start_angle < at < arc.end_angle:
                angles.append(at)
    angles.sort()
    for start, end in pairwise(angles):
        middle = math.radians((start + end) / 2)
        point = (arc.centre[0] + arc.radius * math.cos(middle), arc.centre[1] + arc.radius * math.sin(middle))
        if end - start > 1e-6 and math.dist(point, centre) < radius:
            yield Arc(arc.centre, arc.radius, start, end)


def _polyline_inside(line: Polyline, centre: Point2, radius: float) -> Iterator[Polyline]:
    run: list[Point2] = []
    for start, end in pairwise(line.points):
        span = _span(start, end, centre, radius)
        if span is None:
            if len(run) > 1:
                yield Polyline(tuple(run))
            run = []
            continue
        if not run or span[0] > 0.0:
            if len(run) > 1:
                yield Polyline(tuple(run))
            run = [_between(start, end, span[0])]
        run.append(_between(start, end, span[1]))
        if span[1] < 1.0:
            yield Polyline(tuple(run))
            run = []
    if len(run) > 1:
        yield Polyline(tuple(run))
