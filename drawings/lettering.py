"""The lettering of the sheets: one font for all formats, its heights, and how wide a text is.

The font is DejaVu Sans, narrowed to the proportions of ISO 3098, from matplotlib's package: the same file, and so the
same outlines and widths, on every machine, whatever fonts that has. It lacks the signs for depth and counterbore;
those, and the other symbols, are drawn (`drawings.symbols`).
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

FONT = "DejaVuSans.ttf"
STYLE = "LETTERING"
NARROWED = 0.8
"""Width factor of the text style."""

SMALL, TEXT, LARGE = 2.5, 3.5, 5.0
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
    return fonts.make_font(FONT, 1.0, NARROWED)


def prepare() -> None:
    """Make the font known to ezdxf; before any text is measured or drawn."""
    _font()


def text_width(text: str, height: float = TEXT) -> float:
    """Width of a plain text on paper, mm."""
    return _width(text) * height if text else 0.0


@cache
def _width(text: str) -> float:
    """Of a text one millimetre high: while places are sought the same few texts are measured again and again."""
    return _font().text_width(text)


@cache
def outline(text: str, narrowed: float = NARROWED) -> tuple[np.ndarray, list[int], float]:
    """Points and codes of a text's outlines (`drawings.strokes`), and its width, all at a height of capitals of 1.

    Args:
        narrowed: width factor.
    """
    path = _font().text_path_ex(text, 1.0, narrowed)
    if not len(path):
        return np.empty((0, 2)), [], 0.0
    codes = [_MOVE, *(code for command in path.command_codes() for code in _CODES[int(command)])]
    return path.np_vertices(), codes, _font().text_width_ex(text, 1.0, narrowed)


_MOVE = 1
_CODES = {1: (2,), 2: (3, 3), 3: (4, 4, 4), 4: (1,)}
"""Codes of the points that come with each of ezdxf's commands."""
