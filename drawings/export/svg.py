"""A sheet as SVG: a group for each line weight, a path for each line; of each text its outlines; in millimetres."""

from __future__ import annotations

from functools import cache

import numpy as np

from drawings.annotations.font import glyph
from drawings.export.outline_words import written
from drawings.export.strokes import Shown
from drawings.export.texts import CUBIC, LINE, MOVE, QUADRATIC, Matrix, PaperText, placed_sign
from drawings.sheets.frame import PAPERS, Paper

FINE = 1000.0
"""Steps of a millimetre in which the signs of texts are written."""
_WORDS = {
    (MOVE, 0): "M%.3f %.3f",
    (LINE, 0): "L%.3f %.3f",
    (CUBIC, 0): "C%.3f %.3f",
    (CUBIC, 1): " %.3f %.3f",
    (CUBIC, 2): " %.3f %.3f",
}
_LETTERS = {MOVE: "m", LINE: "l", QUADRATIC: "q", CUBIC: "c"}


def svg(shown: Shown, paper: Paper) -> bytes:
    """The file; the same bytes for the same sheet."""
    width, height = PAPERS[paper]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}" stroke-linecap="round" stroke-linejoin="round">\n'
        '<rect width="100%" height="100%" fill="white"/>\n'
    ]
    for lot in shown.lots:
        flipped = lot.points * (1.0, -1.0) + (0.0, height)
        stroke = f'<g fill="none" stroke="black" stroke-width="{lot.weight or 0.0:g}">\n'
        parts.append("<g>\n" if lot.weight is None else stroke)
        parts.append(written(flipped, lot.codes, _WORDS, lot.begins, '<path d="', '"/>\n'))
        parts.append("</g>\n")
    parts.append("<g>\n")
    parts += (f'<path d="{_path(text, height)}"/>\n' for text in shown.texts)
    parts.append("</g>\n")
    return "".join((*parts, "</svg>\n")).encode("ascii")


def _path(text: PaperText, height: float) -> str:
    """Outlines of a text."""
    matrix = text.matrix
    return "".join(f"M{x:.3f} {height - y:.3f}{_sign(sign, matrix)}" for sign, (x, y) in text.signs())


@cache
def _sign(sign: str, matrix: Matrix) -> str:
    """Outlines of a sign, from where it begins on: each point from the end of the line or curve before."""
    places = np.rint(placed_sign(sign, matrix) * (FINE, -FINE)).astype(np.int64).tolist()
    codes = glyph(sign).codes.tolist()
    found: list[str] = []
    end, before, of_curve = (0, 0), 0, 0
    for (x, y), code in zip(places, codes, strict=True):
        size = {QUADRATIC: 2, CUBIC: 3}.get(code, 1)
        of_curve = of_curve % size + 1 if code == before else 1
        letter = _LETTERS[code] if of_curve == 1 else " "
        found.append(f"{letter}{(x - end[0]) / FINE:g} {(y - end[1]) / FINE:g}")
        if of_curve == size:
            end = (x, y)
        before = code
    return "".join(found)
