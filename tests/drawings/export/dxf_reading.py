"""Contents of a sheet on paper, read from its DXF document alone: texts and lines.

Model space is seen through the viewports of the paper space; a dimension is seen as its block.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ezdxf.document import Drawing

from drawings.annotations.primitives import text_width
from drawings.views.segment_index import Line, arc_points, polyline_lines
from drawings.views.view import Arc, Box2, Point2, bounding_box


@dataclass(frozen=True)
class Viewport:
    """A viewport: paper = centre + (model - view_centre) * scale."""

    scale: float
    centre: Point2
    view_centre: Point2
    box: Box2  # the part of model space that it shows

    def contains(self, points: Sequence[Point2]) -> bool:
        x0, y0, x1, y1 = bounding_box(points)
        return self.box[0] <= x0 and x1 <= self.box[2] and self.box[1] <= y0 and y1 <= self.box[3]

    def to_paper(self, point: Point2) -> Point2:
        x, y = (c + (p - v) * self.scale for c, p, v in zip(self.centre, point, self.view_centre))
        return (x, y)


@dataclass(frozen=True)
class TextBox:
    """A text on the paper."""

    text: str
    middle: Point2  # of the box from the base line to the height of capitals
    half: Point2  # width and height along the text's own directions
    angle: float  # of the base line, radians


class PaperContent:
    """All lines and texts of a sheet in paper coordinates, and what no viewport shows completely."""

    def __init__(self, document: Drawing) -> None:
        self.texts: list[TextBox] = []
        self.lines: list[Line] = []
        self.cut_off: list[str] = []
        viewports = list(_viewports(document))
        for entity in document.paperspace():
            if entity.dxftype() != "VIEWPORT":
                self._add(entity, None)
        for entity in visible_entities(document, document.modelspace()):
            points = entity_points(entity)
            viewport = next((one for one in viewports if one.contains(points)), None)
            if viewport is None:
                self.cut_off.append(f"{entity.dxftype()} on layer {entity.dxf.layer}")
            else:
                self._add(entity, viewport)

    def _add(self, entity: Any, viewport: Viewport | None) -> None:
        if entity.dxftype() == "TEXT":
            self.texts.append(_text_box(entity, viewport))
        else:
            points = entity_points(entity, viewport.scale if viewport else 1.0)
            self.lines += polyline_lines(list(map(viewport.to_paper, points)) if viewport else points)


def _viewports(document: Drawing) -> Iterator[Viewport]:
    for viewport in document.paperspace().query("VIEWPORT"):
        d = viewport.dxf
        if d.id == 1:  # the paper space itself
            continue
        scale = d.height / d.view_height
        u, v = d.view_center_point.x, d.view_center_point.y
        half = (d.width / scale / 2, d.height / scale / 2)
        box = (u - half[0], v - half[1], u + half[0], v + half[1])
        yield Viewport(scale, (d.center.x, d.center.y), (u, v), box)


def visible_entities(document: Any, layout: Iterable[Any]) -> Iterator[Any]:
    """The entities of a layout, those of its block in place of a dimension."""
    for entity in layout:
        if entity.dxftype() == "DIMENSION":
            yield from document.blocks.get(entity.dxf.geometry)
        else:
            yield entity


def _text_box(entity: Any, viewport: Viewport | None) -> TextBox:
    text, height = entity.plain_text(), entity.dxf.height
    width = text_width(text, height)
    scale = viewport.scale if viewport else 1.0
    angle = math.radians(entity.dxf.rotation)
    align, first, second = entity.get_placement()
    at = (second or first) if align.name != "LEFT" else first
    shift = {"LEFT": 0.5, "CENTER": 0.0, "RIGHT": -0.5}[align.name] * width
    c, s = math.cos(angle), math.sin(angle)
    middle = (at.x + shift * c - height / 2 * s, at.y + shift * s + height / 2 * c)
    if viewport:
        middle = viewport.to_paper(middle)
    return TextBox(text, middle, (width * scale / 2, height * scale / 2), angle)


def entity_points(entity: Any, scale: float = 1.0) -> list[Point2]:
    """Points along an entity, in its own space, as dense as its scale on the paper asks for."""
    d = entity.dxf
    match entity.dxftype():
        case "LINE":
            return [(d.start.x, d.start.y), (d.end.x, d.end.y)]
        case "LWPOLYLINE":
            return [(x, y) for x, y, *_ in entity.lwpoints]
        case "CIRCLE":
            return arc_points(Arc((d.center.x, d.center.y), d.radius), scale)
        case "ARC":
            return arc_points(Arc((d.center.x, d.center.y), d.radius, d.start_angle, d.end_angle), scale)
        case "SOLID":
            corners = [(p.x, p.y) for p in (d.vtx0, d.vtx1, d.vtx3, d.vtx2)]
            return [*corners, corners[0]]
        case "HATCH":
            return [(x, y) for path in entity.paths for x, y, *_ in path.vertices]
        case "TEXT":
            return [(d.insert.x, d.insert.y)]
        case kind:
            raise ValueError(f"a sheet has no {kind}")
