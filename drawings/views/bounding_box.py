"""Bounding boxes of curves, views and point sets."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drawings.views.view import Arc, Box2, Curve, Point2, Segment, View


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
