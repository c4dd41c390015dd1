"""The font of the sheets: its file, heights of lettering (ISO 3098-1), widths of texts, outlines of glyphs.

The font is DejaVu Sans, narrowed to the proportions of ISO 3098. Its file comes with matplotlib, so that outlines and
widths are the same on every machine. It lacks the symbols for depth and counterbore; these and the symbols of
tolerances are drawn as geometry (`drawings.annotations.symbols`).
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

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
    """Width of a text without symbols on paper, mm.

    Args:
        height: of capitals, mm.
    """
    return sum(map(glyph_advance, text)) * WIDTH_FACTOR / cap_height() * height
