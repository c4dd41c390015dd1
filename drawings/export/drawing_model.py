"""A sheet as graphical primitives in paper coordinates: the one model from which DXF, SVG and PDF are written."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from drawings.annotations.annotation import MeasuredDimension, label_primitives
from drawings.annotations.primitives import (
    LAYERS,
    ArcStroke,
    FilledPolygon,
    LineStyle,
    Primitive,
    Stroke,
    Text,
    printed,
    text_width,
)
from drawings.sheets.frame import PAPERS, Paper, frame, title_primitives
from drawings.sheets.sheet import Sheet
from drawings.views.view import Arc, Curve, Layer, Point2, Polyline, Segment, View, direction, offset

SHORT_CHAIN = 12.0
"""Centre lines shorter than this on paper are drawn without a break, mm: two dashes would not be read as a chain."""

_EIGHTH = math.pi / 4


@dataclass(frozen=True)
class PrimitiveGroup:
    """Primitives that belong together: the frame, a view, an annotation."""

    primitives: tuple[Primitive, ...]  # in paper coordinates
    view: View | None = None  # to which they belong; None for what belongs to the sheet itself
    dimension: MeasuredDimension | None = None  # which they show; None where they show no dimension


@dataclass(frozen=True)
class DrawingModel:
    """Everything that is drawn on a sheet."""

    name: str  # of the sheet
    paper: Paper
    scale: float  # of its main views, paper over part
    groups: tuple[PrimitiveGroup, ...]  # in the order in which they are drawn

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the paper, mm."""
        return PAPERS[self.paper]

    def strokes(self) -> dict[LineStyle, list[Stroke | ArcStroke]]:
        """All lines and arcs by their line style, thin lines first."""
        found: dict[LineStyle, list[Stroke | ArcStroke]] = {}
        for primitive in self._primitives():
            if isinstance(primitive, Stroke | ArcStroke):
                found.setdefault(primitive.style or LAYERS[primitive.layer], []).append(primitive)
        return dict(sorted(found.items()))

    def polygons(self) -> list[FilledPolygon]:
        """All filled areas."""
        return [primitive for primitive in self._primitives() if isinstance(primitive, FilledPolygon)]

    def texts(self) -> list[Text]:
        """All texts as they are printed."""
        texts = (primitive for primitive in self._primitives() if isinstance(primitive, Text))
        return [replace(text, text=printed(text.text)) for text in texts]

    def _primitives(self) -> Iterator[Primitive]:
        return (primitive for group in self.groups for primitive in group.primitives)


def drawing_model(sheet: Sheet) -> DrawingModel:
    """The primitives of a sheet."""
    groups = [PrimitiveGroup((*frame(sheet.paper), *title_primitives(sheet.title, sheet.paper), *sheet.tables))]
    groups += (PrimitiveGroup(tuple(note.primitives())) for note in sheet.notes)
    for view in sheet.views:
        lines = [_curve_primitive(one, layer, view) for layer, curves in view.curves.items() for one in curves]
        groups.append(PrimitiveGroup((*lines, *label_primitives(view)), view))
    for annotation in sheet.annotations:
        view = sheet.view(annotation.view)
        primitives = tuple(map(_on_dimension_layer, annotation.primitives(view)))
        measured = isinstance(annotation, MeasuredDimension)
        groups.append(PrimitiveGroup(primitives, view, annotation if measured else None))
    return DrawingModel(sheet.name, sheet.paper, sheet.scale, tuple(groups))


def _on_dimension_layer(primitive: Primitive) -> Primitive:
    """A primitive of an annotation, with the layer of annotations in place of that of the sheet's thin lines."""
    if isinstance(primitive, Text) or primitive.layer != "BORDER":
        return primitive
    return replace(primitive, layer="DIMENSION")


def _curve_primitive(curve: Curve, layer: Layer, view: View) -> Primitive:
    match curve:
        case Segment(start, end):
            short = layer == "CENTRE" and math.dist(start, end) * view.scale < SHORT_CHAIN
            style = LineStyle(LAYERS[layer].weight) if short else None
            return Stroke((view.to_paper(start), view.to_paper(end)), layer, style)
        case Arc(centre, radius):
            return ArcStroke(replace(curve, centre=view.to_paper(centre), radius=radius * view.scale), layer)
        case Polyline(points):
            return Stroke(tuple(map(view.to_paper, points)), layer)


def bezier_curves(arc: Arc) -> tuple[Point2, list[tuple[Point2, Point2, Point2]]]:
    """An arc as cubic Bezier curves of an eighth of a circle at most, 4.1e-6 of the radius off.

    Unlike arcs by centre and radius they stay exact in programs that calculate with single precision, however far the
    centre is.
    """
    sweep = math.radians((arc.end_angle - arc.start_angle) % 360.0 or 360.0)
    count = max(1, math.ceil(sweep / _EIGHTH - 1e-9))
    step = sweep / count
    # The control points lie on the tangents at both ends, at this distance over the radius.
    tangent = 4 / 3 * math.tan(step / 4)
    share, turn = math.hypot(1.0, tangent), math.atan(tangent)

    def at(angle: float, over_radius: float = 1.0) -> Point2:
        radius = arc.radius * over_radius
        return (arc.centre[0] + radius * math.cos(angle), arc.centre[1] + radius * math.sin(angle))

    ends = [math.radians(arc.start_angle) + step * number for number in range(count + 1)]
    curves = [(at(begin + turn, share), at(end - turn, share), at(end)) for begin, end in pairwise(ends)]
    return at(ends[0]), curves


def text_origin(text: Text) -> Point2:
    """Left end of a text's base line."""
    back = {"left": 0.0, "middle": 0.5, "right": 1.0}[text.alignment] * text_width(text.text, text.height)
    return offset(text.at, direction(text.angle), -back)


def text_matrix(text: Text, width: float, height: float) -> tuple[float, float, float, float]:
    """Matrix (a, b, c, d) that turns a text along its base line and scales it: x' = a x + c y, y' = b x + d y."""
    c, s = direction(text.angle)
    return (c * width, s * width, -s * height, c * height)
