"""The lettering of the sheets: one font for all formats, its heights, and how wide a text is.

The font is DejaVu Sans, narrowed to the proportions of ISO 3098, from matplotlib's package: the same file, and so the
same outlines and widths, on every machine, whatever fonts that has. It lacks the signs for depth and counterbore;
those, and the other symbols, are drawn (`drawings.annotations.symbols`).
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

FONT = "DejaVuSans.ttf"
TEXT_STYLE = "LETTERING"
WIDTH_FACTOR = 0.8
"""Width factor of the text style."""

SMALL_HEIGHT, TEXT_HEIGHT, LARGE_HEIGHT = 2.5, 3.5, 5.0
"""Heights of capitals, mm (ISO 3098-1): captions of the title block; dimensions and notes; titles and view letters."""

LINE_PITCH = 1.5
"""Distance of base lines over the height of capitals."""


@cache
def _font() -> Any:
    """The font, for measuring; makes it known to ezdxf in place of whatever the system has under that name."""
    from ezdxf.fonts import fonts
    from ezdxf.fonts.font_manager import get_ttf_font_face

    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        raise FileNotFoundError("matplotlib, which brings the lettering font, is not installed")
    path = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / FONT
    # There is no public way to name a single file; ezdxf is pinned.
    fonts.font_manager.clear()
    fonts.font_manager._font_cache.add_entry(path, get_ttf_font_face(path))
    return fonts.make_font(FONT, 1.0, WIDTH_FACTOR)


def prepare() -> None:
    """Make the font known to ezdxf; before any text is measured or drawn."""
    _font()


def text_width(text: str, height: float = TEXT_HEIGHT) -> float:
    """Width of a plain text on paper, mm."""
    return _width(text) * height if text else 0.0


@cache
def _width(text: str) -> float:
    """Of a text one millimetre high: while places are sought the same few texts are measured again and again."""
    return _font().text_width(text)


@dataclass(frozen=True)
class Glyph:
    """A sign of the font, at a height of capitals of 1 and at its own width.

    Attributes:
        points: (n, 2) of its outlines, from the place where it begins on the base line; none for a blank.
        codes: (n,) what each point is for (`drawings.export.strokes`).
        advance: how far on the next sign begins.
    """

    points: np.ndarray
    codes: np.ndarray
    advance: float


@cache
def glyph(sign: str) -> Glyph:
    """A sign's outlines; a box where the font lacks it."""
    path = _font().text_path_ex(sign, 1.0, 1.0)
    # The font gives blanks alone no width.
    advance = _font().text_width_ex(f"{sign}|", 1.0, 1.0) - _font().text_width_ex("|", 1.0, 1.0)
    if not len(path):
        return Glyph(np.empty((0, 2)), np.empty(0, dtype=np.int64), advance)
    codes = [_MOVE, *(code for command in path.command_codes() for code in _CODES[int(command)])]
    return Glyph(path.np_vertices(), np.array(codes), advance)


_MOVE = 1
_CODES = {1: (2,), 2: (3, 3), 3: (4, 4, 4), 4: (1,)}
"""Codes of the points that come with each of ezdxf's commands."""
