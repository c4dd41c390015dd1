"""Symbols drawn as geometry, since no font has them all: of holes, of geometrical tolerances, of surface texture.

Each is given for a height of capitals of 1 with its lower left corner at the origin; proportions after ISO 7083 (form
and position), ISO 129-1 (depth, counterbore) and ISO 21920-1 (surface).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import get_args

from drawings.annotations.annotation import Symbol
from drawings.annotations.font import TEXT_HEIGHT, text_width
from drawings.annotations.primitives import ArcStroke, FilledPolygon, Primitive, Stroke, Text
from drawings.views.view import Arc, Point2

_SPACE = 0.35
"""Space on both sides of a symbol within a text, over its height."""

_WIDTHS: dict[Symbol, float] = {
    "counterbore": 1.3,
    "countersink": 1.3,
    "depth": 0.9,
    "diameter": 1.0,
    "surface": 1.2,
    "flatness": 1.5,
    "parallelism": 1.2,
    "perpendicularity": 1.3,
    "position": 1.4,
    "cylindricity": 1.5,
}

_NAMED = re.compile(r"\{(" + "|".join(get_args(Symbol)) + r")\}")


def symbol_width(symbol: Symbol, height: float = TEXT_HEIGHT) -> float:
    """Width of a symbol at a height of capitals, mm."""
    return _WIDTHS[symbol] * height


def symbol_primitives(symbol: Symbol, at: Point2, height: float = TEXT_HEIGHT) -> Iterator[Primitive]:
    """A symbol with its lower left corner at a point of the paper."""

    def place(x: float, y: float) -> Point2:
        return (at[0] + x * height, at[1] + y * height)

    def line(*points: Point2) -> Stroke:
        return Stroke(tuple(place(*point) for point in points))

    def ring(x: float, y: float, radius: float) -> ArcStroke:
        return ArcStroke(Arc(place(x, y), radius * height))

    if symbol == "counterbore":
        yield line((0, 0.75), (0, 0.05), (1.3, 0.05), (1.3, 0.75))
    elif symbol == "countersink":
        yield line((0, 0.8), (0.65, 0.05), (1.3, 0.8))
    elif symbol == "depth":
        yield line((0, 1), (0.9, 1))
        yield line((0.45, 1), (0.45, 0.3))
        yield FilledPolygon((place(0.45, 0), place(0.2, 0.5), place(0.7, 0.5)))
    elif symbol == "diameter":
        yield ring(0.5, 0.5, 0.36)
        yield line((0.15, 0), (0.85, 1))
    elif symbol == "surface":
        yield line((0, 0.5), (0.3, 0), (0.9, 1.0))
        yield line((0, 0.5), (0.6, 0.5))
    elif symbol == "flatness":
        yield line((0, 0.1), (1.1, 0.1), (1.5, 0.9), (0.4, 0.9), (0, 0.1))
    elif symbol == "parallelism":
        yield line((0, 0), (0.6, 1))
        yield line((0.6, 0), (1.2, 1))
    elif symbol == "perpendicularity":
        yield line((0, 0.05), (1.3, 0.05))
        yield line((0.65, 0.05), (0.65, 1))
    elif symbol == "position":
        yield ring(0.7, 0.5, 0.45)
        yield line((0, 0.5), (1.4, 0.5))
        yield line((0.7, -0.2), (0.7, 1.2))
    else:
        yield ring(0.75, 0.5, 0.36)
        yield line((0.0, 0), (0.6, 1))
        yield line((0.9, 0), (1.5, 1))


def _pieces(text: str) -> Iterator[tuple[str, bool]]:
    """The plain stretches and the symbols of a text, and whether each is a symbol."""
    for number, piece in enumerate(_NAMED.split(text)):
        if piece:
            yield piece, bool(number % 2)


@cache
def symbol_text_width(text: str, height: float = TEXT_HEIGHT) -> float:
    """Width of a text in which `{depth}` and the like stand for symbols, mm."""
    return sum(
        (_WIDTHS[piece] + 2 * _SPACE) * height if is_symbol else text_width(piece, height)  # type: ignore[index]
        for piece, is_symbol in _pieces(text)
    )


def symbol_text_primitives(text: str, at: Point2, height: float = TEXT_HEIGHT) -> Iterator[Primitive]:
    """A text with symbols in it, from its left end on the base line."""
    x, y = at
    for piece, is_symbol in _pieces(text):
        if is_symbol:
            yield from symbol_primitives(piece, (x + _SPACE * height, y), height)  # type: ignore[arg-type]
            x += (_WIDTHS[piece] + 2 * _SPACE) * height  # type: ignore[index]
        else:
            yield Text(piece, (x, y), height)
            x += text_width(piece, height)
