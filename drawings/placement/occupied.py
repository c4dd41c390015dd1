"""What an annotation or a view takes of the paper: boxes of texts, lines, dimension lines, the tip of its arrow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from drawings.annotations.annotation import (
    AngularDimension,
    Annotation,
    Callout,
    DatumSymbol,
    DetailMark,
    FeatureControlFrame,
    LinearDimension,
    RadialDimension,
    SectionMark,
)
from drawings.annotations.annotation_geometry import annotation_primitives, callout_box, text_box
from drawings.annotations.primitives import ArcStroke, FilledPolygon, Primitive, Stroke, Text
from drawings.placement.field import Line, arc_points, around, curve_points, grown, pieces
from drawings.views.view import Box2, Curve, Point2, View


def view_outline(view: View) -> Box2:
    """Box of the part as a view shows it, the view at the origin of the paper; centre lines left out."""
    view = replace(view, place=(0.0, 0.0))
    if view.clip:
        (u, v), radius = view.to_paper(view.clip[0]), view.clip[1] * view.scale
        return (u - radius, v - radius, u + radius, v + radius)
    lines = [
        line
        for layer, curves in view.curves.items()
        if layer in ("VISIBLE", "HIDDEN")
        for curve in curves
        for line in curve_lines(curve, view)
    ]
    x0, y0, x1, y1 = zip(*lines)
    return (min(*x0, *x1), min(*y0, *y1), max(*x0, *x1), max(*y0, *y1))


def curve_lines(curve: Curve, view: View) -> list[Line]:
    """Straight pieces that stand for a curve of a view, paper."""
    return pieces([view.to_paper(point) for point in curve_points(curve, view.scale)])


def keeps_off_itself(annotation: Annotation) -> bool:
    """Whether an annotation's lines cannot touch its own text; the box of a slanting text says nothing about it."""
    slanting = isinstance(annotation, LinearDimension) and annotation.angle not in (0.0, 90.0)
    return slanting or isinstance(annotation, FeatureControlFrame | DatumSymbol | DetailMark | SectionMark)


def occupied(annotation: Annotation, view: View) -> tuple[list[Box2], list[Line], list[Line]]:
    """Boxes of the texts, lines, and dimension lines among the ink of an annotation."""
    ink = list(annotation_primitives(annotation, view))
    boxes = [text_box(item) for item in ink if isinstance(item, Text)]
    lines = [line for item in ink for line in _lines(item)]
    if isinstance(annotation, FeatureControlFrame | DatumSymbol):
        # The whole frame is as good as text.
        cells = [item.points for item in ink if isinstance(item, Stroke) and len(item.points) == 5]
        boxes = [around((*points[0], *points[2]) for points in cells)]
        lines = [line for line in lines if not _within(line, grown(boxes[0], 0.1))]
    if isinstance(annotation, Callout):
        # Symbols within the lines are as good as text; what is left is the leader.
        boxes = [callout_box(annotation, number) for number in range(len(annotation.lines))]
        lines = [line for line in lines if not any(_within(line, grown(box, 0.5)) for box in boxes)]
    lanes: list[Line] = []
    if isinstance(annotation, LinearDimension):
        lanes = [_lane(annotation, lines)]
        if boxes:
            boxes = [around(boxes)]
    if isinstance(annotation, SectionMark):
        # The arrows' stems are taken for dimension lines when they run beside one.
        u, v = annotation.sight
        lanes = [(x, y, x + 9.0 * u, y + 9.0 * v) for x, y in (annotation.start, annotation.end)]
    return boxes, lines, lanes


def _lane(annotation: LinearDimension, lines: Sequence[Line]) -> Line:
    """The dimension line among the lines of a dimension: the longest along it."""
    turn = math.radians(annotation.angle)
    u = (math.cos(turn), math.sin(turn))
    return max(lines, key=lambda line: abs((line[2] - line[0]) * u[0] + (line[3] - line[1]) * u[1]))


def tip_of(annotation: Annotation, view: View) -> Point2 | None:
    """Where an arrow or a datum's triangle must meet a line of the part."""
    match annotation:
        case RadialDimension():
            turn = math.radians(annotation.towards)
            u, v = annotation.centre
            return view.to_paper((u + annotation.radius * math.cos(turn), v + annotation.radius * math.sin(turn)))
        case FeatureControlFrame() | DatumSymbol():
            return view.to_paper(annotation.at)
        case _:
            return None


def about(point: Point2) -> Box2:
    """A small box round a point: what reaches into it is there."""
    return grown((*point, *point), 0.3)


def _within(line: Line, box: Box2) -> bool:
    return all(box[0] <= x <= box[2] and box[1] <= y <= box[3] for x, y in (line[:2], line[2:]))


def _lines(item: Primitive) -> list[Line]:
    match item:
        case Stroke():
            return pieces(item.points)
        case ArcStroke():
            return pieces(arc_points(item.arc))
        case FilledPolygon():
            return pieces((*item.points, item.points[0]))
        case _:
            return []


def moved(annotation: Annotation, by: Point2) -> Annotation:
    """An annotation with all its paper places moved along with its view."""

    def to(point: Point2) -> Point2:
        return (point[0] + by[0], point[1] + by[1])

    match annotation:
        case LinearDimension():
            text_at = to(annotation.text_at) if annotation.text_at else None
            return replace(annotation, line_at=to(annotation.line_at), text_at=text_at)
        case RadialDimension():
            return replace(annotation, text_at=to(annotation.text_at))
        case AngularDimension():
            return replace(annotation, arc_at=to(annotation.arc_at))
        case Callout() | FeatureControlFrame():
            return replace(annotation, elbow=to(annotation.elbow))
        case DatumSymbol():
            return replace(annotation, frame_at=to(annotation.frame_at))
        case SectionMark():
            return replace(annotation, start=to(annotation.start), end=to(annotation.end))
        case DetailMark():
            return replace(annotation, letter_at=to(annotation.letter_at))
        case _:
            return annotation
