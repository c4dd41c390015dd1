"""Texts as they stand on the paper, and their outlines sign by sign: each sign's are worked out once a size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from drawings.annotations.font import glyph
from drawings.views.view import Point2

MOVE, LINE, QUADRATIC, CUBIC = 1, 2, 3, 4
"""Codes of an outline's points, as in matplotlib: a curve's control points have the code of its end."""

Matrix = tuple[float, float, float, float]
"""What a point (x, y) of a sign is turned and scaled by: (a x + b y, c x + d y)."""


@dataclass(frozen=True)
class PaperText:
    """One line of text.

    Attributes:
        words: plain text.
        start: where its base line begins, mm on paper.
        height: of capitals, mm.
        turn: of its base line, degrees.
        narrowed: width factor.
    """

    words: str
    start: Point2
    height: float
    turn: float
    narrowed: float

    @property
    def matrix(self) -> Matrix:
        """From signs of height 1 to the paper."""
        turn = math.radians(self.turn)
        c, s = self.height * math.cos(turn), self.height * math.sin(turn)
        return (c * self.narrowed, -s, s * self.narrowed, c)

    def moved_back(self, share: float) -> PaperText:
        """The text moved back along its base line by a share of its length."""
        a, _, c, _ = self.matrix
        back = share * sum(glyph(sign).advance for sign in self.words)
        return replace(self, start=(self.start[0] - a * back, self.start[1] - c * back))

    def signs(self) -> Iterator[tuple[str, Point2]]:
        """Each sign and where it begins on the base line; blanks left out."""
        a, _, c, _ = self.matrix
        x, y = self.start
        along = 0.0
        for sign in self.words:
            own = glyph(sign)
            if len(own.points):
                yield sign, (x + a * along, y + c * along)
            along += own.advance


def text_outlines(texts: Sequence[PaperText]) -> tuple[np.ndarray, np.ndarray]:
    """Points on paper, and their codes, of all signs of some texts."""
    points, codes = [np.empty((0, 2))], [np.empty(0, dtype=np.int64)]
    places: list[Point2] = []
    for text in texts:
        matrix = text.matrix
        for sign, place in text.signs():
            points.append(placed_sign(sign, matrix))
            codes.append(glyph(sign).codes)
            places.append(place)
    begins = np.repeat(np.array(places).reshape(-1, 2), [len(part) for part in points[1:]], axis=0)
    return np.concatenate(points) + begins, np.concatenate(codes)


@cache
def placed_sign(sign: str, matrix: Matrix) -> np.ndarray:
    """Points of a sign, from where it begins, turned and scaled."""
    return glyph(sign).points @ np.array(matrix).reshape(2, 2).T


def with_cubics(points: np.ndarray, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outlines with each quadratic curve as a cubic one, which is all that some formats have."""
    first = np.flatnonzero(codes == QUADRATIC)[::2]
    start, control, end = (points[first + k] for k in (-1, 0, 1))
    repeats = np.ones(len(codes), dtype=np.int64)
    repeats[first] = 2
    found, kinds = np.repeat(points, repeats, axis=0), np.repeat(codes, repeats)
    places = first + np.arange(len(first))
    found[places] = start + 2.0 / 3.0 * (control - start)
    found[places + 1] = end + 2.0 / 3.0 * (control - end)
    kinds[kinds == QUADRATIC] = CUBIC
    return found, kinds
