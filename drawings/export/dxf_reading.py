"""Contents of a sheet on paper, read from its DXF document alone: texts, lines, symbols, dimensions.

Model space is seen through the viewports of the paper space; a dimension is seen as its block.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ezdxf.document import Drawing

from drawings.annotations.font import text_width
from drawings.views.bounding_box import bounding_box
from drawings.views.segment_index import Line, arc_points, polyline_lines
from drawings.views.view import Arc, Box2, Point2

PART = ("VISIBLE", "HIDDEN", "CENTRE", "HATCH", "PHANTOM", "THREAD")
"""Layers of the part's own lines."""
EDGES = ("VISIBLE", "HIDDEN")
"""Layers of its edges."""
LONGEST_ARROW = 3.3
"""Longest arrow head of a leader, mm on paper; those of cutting lines are longer."""
SYMBOL = 6.0
"""Closed or bent lines outside the views that are smaller than this are symbols, mm on paper."""


@dataclass(frozen=True)
class Viewport:
    """A viewport: paper = centre + (model - view_centre) * scale.

    Attributes:
        box: the part of model space that it shows.
    """

    scale: float
    centre: Point2
    view_centre: Point2
    box: Box2

    def contains(self, points: Sequence[Point2]) -> bool:
        """Whether all points, in model space, are shown."""
        x0, y0, x1, y1 = bounding_box(points)
        return self.box[0] <= x0 and x1 <= self.box[2] and self.box[1] <= y0 and y1 <= self.box[3]

    def to_paper(self, point: Point2) -> Point2:
        return (
            self.centre[0] + (point[0] - self.view_centre[0]) * self.scale,
            self.centre[1] + (point[1] - self.view_centre[1]) * self.scale,
        )


@dataclass(frozen=True)
class TextBox:
    """A text on the paper.

    Attributes:
        middle: of the box from the base line to the height of capitals.
        half: half width and half height along the text's own directions.
        angle: of the base line, radians.
    """

    text: str
    middle: Point2
    half: Point2
    angle: float

    def corners(self) -> list[Point2]:
        c, s = math.cos(self.angle), math.sin(self.angle)
        u, v = self.half
        return [
            (self.middle[0] + a * c - b * s, self.middle[1] + a * s + b * c)
            for a, b in ((-u, -v), (u, -v), (u, v), (-u, v))
        ]

    def local(self, point: Point2) -> Point2:
        """A point in the text's own coordinates, the origin at its middle."""
        x, y = point[0] - self.middle[0], point[1] - self.middle[1]
        c, s = math.cos(self.angle), math.sin(self.angle)
        return (x * c + y * s, -x * s + y * c)


class PaperContent:
    """All texts and lines of a sheet in paper coordinates.

    Attributes:
        texts: all of them; `view_texts` those in viewports.
        sheet_lines: of the frame, the title block and tables; `view_lines` those in viewports.
        part_lines: those of `view_lines` that are lines of the part; `edges` those of its edges;
            `part_boxes` boxes of the curves.
        symbols: boxes of symbols, and of the frames of tolerances and datum letters.
        dimensions: the DIMENSION entities.
        leaders: tips of the arrows that belong to no dimension; `triangles` corners of datum triangles;
            `sight_arrows` tips of the larger arrows in the direction of sight of a section or view.
        cut_off: descriptions of entities that no viewport shows completely.
    """

    def __init__(self, document: Drawing) -> None:
        self.texts: list[TextBox] = []
        self.sheet_lines: list[Line] = []
        self.view_lines: list[Line] = []
        self.view_texts: list[TextBox] = []
        self.part_lines: list[Line] = []
        self.edges: list[Line] = []
        self.part_boxes: list[Box2] = []
        self.symbols: list[Box2] = []
        self.cut_off: list[str] = []
        self.leaders: list[Point2] = []
        self.triangles: list[tuple[Point2, ...]] = []
        self.sight_arrows: list[Point2] = []
        self.viewports = list(_viewports(document))
        for entity in document.paperspace():
            if entity.dxftype() == "TEXT":
                self.texts.append(_text_box(entity, None))
            elif entity.dxftype() != "VIEWPORT":
                self.sheet_lines += polyline_lines(entity_points(entity))
        self.dimensions: list[Any] = list(document.modelspace().query("DIMENSION"))
        for entity in visible_entities(document, document.modelspace()):
            self._add_from_model_space(entity)
        for entity in document.modelspace().query("SOLID"):
            self._add_arrow(entity_points(entity))

    def viewport_of(self, points: Sequence[Point2]) -> Viewport | None:
        """The first viewport that shows all points of model space."""
        return next((viewport for viewport in self.viewports if points and viewport.contains(points)), None)

    def _add_arrow(self, points: Sequence[Point2]) -> None:
        """Enter a filled triangle of an annotation: the arrow of a leader, or the triangle of a datum."""
        viewport = self.viewport_of(points)
        if viewport is None:
            return
        corners = list(dict.fromkeys(map(viewport.to_paper, points)))
        if len(corners) != 3:
            return
        tip = max(corners, key=lambda corner: sum(math.dist(corner, other) for other in corners))
        one, other = (corner for corner in corners if corner != tip)
        wide, long = math.dist(one, other), math.dist(tip, ((one[0] + other[0]) / 2, (one[1] + other[1]) / 2))
        if wide > 0.8 * long:
            self.triangles.append(tuple(corners))
        else:
            (self.leaders if long < LONGEST_ARROW else self.sight_arrows).append(tip)

    def _add_from_model_space(self, entity: Any) -> None:
        points = entity_points(entity)
        viewport = self.viewport_of(points)
        if viewport is None:
            self.cut_off.append(f"{entity.dxftype()} on layer {entity.dxf.layer}")
        elif entity.dxftype() == "TEXT":
            text = _text_box(entity, viewport)
            self.texts.append(text)
            self.view_texts.append(text)
        else:
            points = list(map(viewport.to_paper, points))
            lines = polyline_lines(points)
            self.view_lines += lines
            if entity.dxf.layer in PART:
                self.part_lines += lines
                self.edges += lines if entity.dxf.layer in EDGES else []
                self.part_boxes.append(bounding_box(points))
            elif entity.dxftype() in ("LWPOLYLINE", "CIRCLE"):
                box = bounding_box(points)
                framed = len(points) == 5 and math.dist(points[0], points[4]) < 1e-9
                if framed or max(box[2] - box[0], box[3] - box[1]) < SYMBOL:
                    self.symbols.append(box)


def joined_boxes(boxes: Sequence[Box2], near: float) -> list[Box2]:
    """Boxes around all boxes that overlap, or that are nearer to each other than `near` along both axes."""
    found: list[Box2] = []
    left = np.array(boxes, dtype=float).reshape(-1, 4)
    while len(left):
        (x0, y0, x1, y1), left = left[0], left[1:]
        while True:
            touched = (left[:, 0] < x1 + near) & (left[:, 2] > x0 - near)
            touched &= (left[:, 1] < y1 + near) & (left[:, 3] > y0 - near)
            if not touched.any():
                break
            x0, y0 = np.minimum(left[touched, :2].min(axis=0), (x0, y0))
            x1, y1 = np.maximum(left[touched, 2:].max(axis=0), (x1, y1))
            left = left[~touched]
        found.append((float(x0), float(y0), float(x1), float(y1)))
    # A box that has grown may reach one that was complete before.
    return found if len(found) == len(boxes) else joined_boxes(found, near)


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


def entity_points(entity: Any) -> list[Point2]:
    """Points along an entity, in its own space."""
    d = entity.dxf
    match entity.dxftype():
        case "LINE":
            return [(d.start.x, d.start.y), (d.end.x, d.end.y)]
        case "LWPOLYLINE":
            return [(x, y) for x, y, *_ in entity.lwpoints]
        case "CIRCLE":
            return arc_points(Arc((d.center.x, d.center.y), d.radius))
        case "ARC":
            return arc_points(Arc((d.center.x, d.center.y), d.radius, d.start_angle, d.end_angle))
        case "SOLID":
            corners = [(p.x, p.y) for p in (d.vtx0, d.vtx1, d.vtx3, d.vtx2)]
            return [*corners, corners[0]]
        case "HATCH":
            return [(x, y) for path in entity.paths for x, y, *_ in path.vertices]
        case "TEXT":
            return [(d.insert.x, d.insert.y)]
        case kind:
            raise ValueError(f"a sheet has no {kind}")
