"""How much room views and ink take on the paper."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from drawings.annotations.annotation_ink import text_box
from drawings.annotations.font import LARGE
from drawings.annotations.ink import Circle, Ink, Words
from drawings.views.view import Arc, Box2, Curve, Point2, Segment, View


def label_ink(view: View) -> Iterator[Ink]:
    """The name of a section or detail, below its view."""
    box = view_box(view)
    if view.label and box:
        yield Words(view.label, view.label_at or ((box[0] + box[2]) / 2, box[1] - 3.0 - LARGE), LARGE, "middle")


def view_box(view: View) -> Box2 | None:
    """Room of a view's lines on the paper; none for a view without lines."""
    points = [point for curves in view.curves.values() for curve in curves for point in outermost(curve)]
    if not points:
        return None
    box = box_of(points)
    return (*view.to_paper(box[:2]), *view.to_paper(box[2:]))


def outermost(curve: Curve) -> list[Point2]:
    """Points of a curve that span its box."""
    if isinstance(curve, Segment):
        return [curve.start, curve.end]
    if not isinstance(curve, Arc):
        return list(curve.points)
    (x, y), radius = curve.centre, curve.radius
    quarters = range(math.ceil(curve.start_angle / 90), math.floor(curve.end_angle / 90) + 1)
    angles = [curve.start_angle, curve.end_angle, *(90.0 * quarter for quarter in quarters)]
    return [(x + radius * math.cos(math.radians(a)), y + radius * math.sin(math.radians(a))) for a in angles]


def ink_box(ink: Ink) -> Box2:
    """Room of some ink."""
    if isinstance(ink, Words):
        return text_box(ink)
    return box_of(outermost(ink.arc) if isinstance(ink, Circle) else ink.points)


def box_of(points: Sequence[Point2]) -> Box2:
    """The box that holds some points."""
    xs, ys = zip(*points)
    return (min(xs), min(ys), max(xs), max(ys))


def around(boxes: Sequence[Box2], margin: float) -> Box2:
    """The box that holds some boxes, and a margin, mm."""
    x0, y0, x1, y1 = zip(*boxes)
    return (min(x0) - margin, min(y0) - margin, max(x1) + margin, max(y1) + margin)
