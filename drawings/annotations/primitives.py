"""Graphical primitives of a sheet in paper coordinates (mm from its lower left corner): lines, arcs, areas, texts.

A sheet is a list of them; DXF, SVG and PDF are written from it (`drawings.export.drawing_model`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from drawings.annotations.font import TEXT_HEIGHT
from drawings.views.view import Arc, Box2, Layer, Point2

SheetLayer = Layer | Literal["DIMENSION", "TEXT", "FRAME", "BORDER"]
"""Layers of views, of annotations, and of the sheet itself: heavy and thin lines of frame and tables."""
LineType = Literal["CONTINUOUS", "DASHED", "CHAIN", "PHANTOM"]
Alignment = Literal["left", "middle", "right"]


class LineStyle(NamedTuple):
    """Weight and type of a line.

    Attributes:
        weight: mm.
        line_type: dashes and gaps (`LINE_TYPES`).
    """

    weight: float
    line_type: LineType = "CONTINUOUS"


LAYERS: dict[SheetLayer, LineStyle] = {
    "VISIBLE": LineStyle(0.5),
    "HIDDEN": LineStyle(0.25, "DASHED"),
    "CENTRE": LineStyle(0.25, "CHAIN"),
    "SECTION": LineStyle(0.25, "CHAIN"),
    "HATCH": LineStyle(0.18),
    "PHANTOM": LineStyle(0.25, "PHANTOM"),
    "THREAD": LineStyle(0.25),
    "DIMENSION": LineStyle(0.25),
    "TEXT": LineStyle(0.25),
    "FRAME": LineStyle(0.7),
    "BORDER": LineStyle(0.25),
}
"""Line weight and line type of each layer (ISO 128-2: wide lines are twice as wide as narrow ones)."""

LINE_TYPES: dict[LineType, tuple[float, ...]] = {
    "CONTINUOUS": (),
    "DASHED": (3.0, 1.0),
    "CHAIN": (6.0, 1.0, 1.0, 1.0),
    "PHANTOM": (6.0, 1.0, 1.0, 1.0, 1.0, 1.0),
}
"""Lengths of dashes and gaps in turn, mm on paper."""

THICK = LineStyle(0.7)
"""Ends of a cutting line (ISO 128-3)."""


@dataclass(frozen=True)
class Stroke:
    """A line through points.

    Args:
        style: that of the layer if None.
    """

    points: tuple[Point2, ...]
    layer: SheetLayer = "BORDER"
    style: LineStyle | None = None


@dataclass(frozen=True)
class ArcStroke:
    """An arc or a circle."""

    arc: Arc
    layer: SheetLayer = "BORDER"
    style: LineStyle | None = None


@dataclass(frozen=True)
class FilledPolygon:
    """A filled polygon: an arrow head, for instance."""

    points: tuple[Point2, ...]
    layer: SheetLayer = "BORDER"


@dataclass(frozen=True)
class Text:
    """A text on one line, in the font and width factor of the sheets.

    Args:
        at: on the base line, at the text's left end, middle or right end.
        height: of capitals, mm.
        angle: of the base line, degrees.
    """

    text: str
    at: Point2
    height: float = TEXT_HEIGHT
    alignment: Alignment = "left"
    angle: float = 0.0


Primitive = Stroke | ArcStroke | FilledPolygon | Text


def rectangle(box: Box2, layer: SheetLayer = "BORDER") -> Stroke:
    """The outline of a box."""
    x0, y0, x1, y1 = box
    return Stroke(((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)), layer)


def turned(primitive: Primitive, about: Point2, angle: float) -> Primitive:
    """A primitive turned about a point, degrees."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))

    def to(point: Point2) -> Point2:
        x, y = point[0] - about[0], point[1] - about[1]
        return (about[0] + x * c - y * s, about[1] + x * s + y * c)

    match primitive:
        case Text():
            return replace(primitive, at=to(primitive.at), angle=primitive.angle + angle)
        case ArcStroke(arc):
            ends = (arc.start_angle + angle, arc.end_angle + angle)
            return replace(primitive, arc=replace(arc, centre=to(arc.centre), start_angle=ends[0], end_angle=ends[1]))
        case _:
            return replace(primitive, points=tuple(map(to, primitive.points)))
