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
        points, codes: as in `drawings.export.strokes.Outlines`.
        words: how a point is written: by its code, and its place among the points of its curve.
        begins: index of the point with which each outline begins.
        before, after: what stands before and after each outline.
    """
    # Of a curve's points the first comes after one of another code, or after a whole curve.
    sizes = np.bincount([code for code, _ in words])
    numbers = np.arange(len(codes))
    changed = np.diff(codes, prepend=0) != 0
    of_curve = (numbers - np.maximum.accumulate(np.where(changed, numbers, 0))) % sizes[codes]
    table = np.empty((len(sizes), sizes.max()), dtype=object)
    for place, word in words.items():
        table[place] = word
    pattern: list[str] = table[codes, of_curve].tolist()
    for begin in begins:
        pattern[begin] = before + pattern[begin]
    for end in (*begins[1:], len(pattern)):
        pattern[end - 1] += after
    whole = "%d" in next(iter(words.values()))
    values = np.rint(points).astype(np.int64) if whole else points
    return "".join(pattern) % tuple(values.ravel().tolist())
