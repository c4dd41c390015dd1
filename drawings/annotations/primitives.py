"""Primitives of a sheet: lines, arcs, areas and texts in paper coordinates (mm from the lower left corner).

DXF, SVG and PDF are written from them (`drawings.export.drawing_model`).
"""

import importlib.util
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

from drawings.views.view import Arc, Box2, Layer, Point2

FONT = "DejaVuSans.ttf"
TEXT_STYLE = "LETTERING"
"""Name of the text style in the DXF file."""
WIDTH_FACTOR = 0.8
"""Horizontal scale of the glyphs."""

SMALL_HEIGHT, TEXT_HEIGHT, LARGE_HEIGHT = 2.5, 3.5, 5.0
"""Heights of capitals, mm: captions of the title block; dimensions and notes; titles and view letters."""

LINE_PITCH = 1.5
"""Distance of base lines over the height of capitals."""


def font_path() -> Path:
    """The font's file."""
    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        raise FileNotFoundError("matplotlib, whose package contains the font of the sheets, is not installed")
    return Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / FONT


@cache
def _font() -> Any:
    from fontTools.ttLib import TTFont

    return TTFont(font_path())


@cache
def _glyph_name(character: str) -> str:
    return _font().getBestCmap().get(ord(character), ".notdef")


@cache
def cap_height() -> float:
    """Height of capitals in units of the font."""
    return _font()["glyf"]["A"].yMax


@cache
def em_over_cap_height() -> float:
    """Em size of the font over the height of its capitals."""
    return _font()["head"].unitsPerEm / cap_height()


@cache
def glyph_advance(character: str) -> float:
    """Distance from the origin of a glyph to that of the next one, units of the font."""
    return _font()["hmtx"][_glyph_name(character)][0]


@cache
def glyph_outline(character: str) -> str:
    """Outline of a glyph as an SVG path in units of the font, y upward; empty for a blank."""
    from fontTools.pens.svgPathPen import SVGPathPen

    glyphs = _font().getGlyphSet()
    pen = SVGPathPen(glyphs)
    glyphs[_glyph_name(character)].draw(pen)
    return pen.getCommands()


def printed(text: str) -> str:
    """A text with Ø for the diameter sign, which this font has only at x-height."""
    return text.replace("⌀", "Ø")


@cache
def text_width(text: str, height: float = TEXT_HEIGHT) -> float:
    """Width of a text without symbols, its capitals of a height, on paper, mm."""
    return sum(map(glyph_advance, text)) * WIDTH_FACTOR / cap_height() * height


SheetLayer = Layer | Literal["DIMENSION", "TEXT", "FRAME", "BORDER"]
"""Layers of views, of annotations, and of the sheet itself: heavy and thin lines of frame and tables."""
LineType = Literal["CONTINUOUS", "DASHED", "CHAIN", "PHANTOM"]
Alignment = Literal["left", "middle", "right"]


class LineStyle(NamedTuple):
    """Weight and type of a line."""

    weight: float  # mm
    line_type: LineType = "CONTINUOUS"  # dashes and gaps (`LINE_TYPES`)


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
    """A line through points."""

    points: tuple[Point2, ...]
    layer: SheetLayer = "BORDER"
    style: LineStyle | None = None  # that of the layer if None


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
    """A text on one line, in the font and width factor of the sheets."""

    text: str
    at: Point2  # on the base line, at the text's left end, middle or right end
    height: float = TEXT_HEIGHT  # of capitals, mm
    alignment: Alignment = "left"
    angle: float = 0.0  # of the base line, degrees


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


Symbol = Literal[
    "counterbore",
    "countersink",
    "depth",
    "diameter",
    "surface",
    "flatness",
    "parallelism",
    "perpendicularity",
    "position",
    "cylindricity",
    "straightness",
    "angularity",
    "coaxiality",
    "profile",
]
"""Signs drawn as geometry (`drawings.annotations.symbols`)."""
