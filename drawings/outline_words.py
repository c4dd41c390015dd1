"""Outlines written in the words of a format, all of one lot in one go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np


def written(
    points: np.ndarray,
    codes: np.ndarray,
    words: Mapping[tuple[int, int], str],
    begins: Sequence[int],
    before: str,
    after: str,
) -> str:
    """Outlines as text; where the words ask for whole numbers, points are rounded.

    Args:
        points, codes: as in `drawings.strokes.Outlines`.
        words: how a point is written: by its code, and its place among the points of its curve.
        begins: index of the point with which each outline begins.
        before, after: what stands before and after each outline.
    """
    pattern: list[str] = []
    of_curve = 0
    last = 0
    for code in codes.tolist():
        of_curve = of_curve + 1 if code == last and (code, of_curve + 1) in words else 0
        pattern.append(words[code, of_curve])
        last = code
    for begin in begins:
        pattern[begin] = before + pattern[begin]
    for end in (*begins[1:], len(pattern)):
        pattern[end - 1] += after
    whole = "%d" in next(iter(words.values()))
    values = np.rint(points).astype(np.int64) if whole else points
    return "".join(pattern) % tuple(values.ravel().tolist())
