"""What the frame, the title block, tables and symbols are made of: strokes, filled areas and texts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drawings.annotations.font import TEXT_HEIGHT
from drawings.views.view import Arc, Box2, Point2

SheetLayer = Literal["FRAME", "BORDER", "TEXT"]
"""Layers of the sheet itself: the frame's heavy line, thin lines of borders and tables, lettering."""

Alignment = Literal["left", "middle", "right"]


@dataclass(frozen=True)
class Stroke:
    """A line through points, mm."""

    points: tuple[Point2, ...]
    layer: SheetLayer = "BORDER"


@dataclass(frozen=True)
class ArcStroke:
    """An arc or a circle."""

    arc: Arc
    layer: SheetLayer = "BORDER"


@dataclass(frozen=True)
class FilledPolygon:
    """A filled polygon."""

    points: tuple[Point2, ...]
    layer: SheetLayer = "BORDER"


@dataclass(frozen=True)
class Text:
    """A text on one line.

    Args:
        at: on the base line, at the text's left end, middle or right end.
        height: of capitals, mm.
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
