"""Symbols drawn as geometry, since no font has them all: of holes, of geometrical tolerances, of surface texture.

Proportions according to ISO 7083 (form and position), ISO 129-1 (depth, counterbore) and ISO 21920-1 (surface texture).
"""

import math
import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple, get_args

from drawings.annotations.primitives import (
    TEXT_HEIGHT,
    ArcStroke,
    FilledPolygon,
    Primitive,
    Stroke,
    Symbol,
    Text,
    rectangle,
    text_width,
)
from drawings.views.view import Arc, Point2

_SPACE = 0.35
"""Space on both sides of a symbol within a text, over its height."""


class _Shape(NamedTuple):
    """A symbol at a height of capitals of 1, its lower left corner at the origin: polylines, circles, polygons."""

    width: float
    lines: tuple[tuple[Point2, ...], ...]
    circles: tuple[tuple[Point2, float], ...] = ()
    polygons: tuple[tuple[Point2, ...], ...] = ()


_SHAPES: dict[Symbol, _Shape] = {
    "counterbore": _Shape(1.3, (((0, 0.75), (0, 0.05), (1.3, 0.05), (1.3, 0.75)),)),
    "countersink": _Shape(1.3, (((0, 0.8), (0.65, 0.05), (1.3, 0.8)),)),
    "depth": _Shape(
        0.9, (((0, 1), (0.9, 1)), ((0.45, 1), (0.45, 0.3))), polygons=(((0.45, 0), (0.2, 0.5), (0.7, 0.5)),)
    ),
    "diameter": _Shape(1.0, (((0.15, 0), (0.85, 1)),), (((0.5, 0.5), 0.36),)),
    "surface": _Shape(1.2, (((0, 0.5), (0.3, 0), (0.9, 1.0)), ((0, 0.5), (0.6, 0.5)))),
    "flatness": _Shape(1.5, (((0, 0.1), (1.1, 0.1), (1.5, 0.9), (0.4, 0.9), (0, 0.1)),)),
    "parallelism": _Shape(1.2, (((0, 0), (0.6, 1)), ((0.6, 0), (1.2, 1)))),
    "perpendicularity": _Shape(1.3, (((0, 0.05), (1.3, 0.05)), ((0.65, 0.05), (0.65, 1)))),
    "position": _Shape(1.4, (((0, 0.5), (1.4, 0.5)), ((0.7, -0.2), (0.7, 1.2))), (((0.7, 0.5), 0.45),)),
    "cylindricity": _Shape(1.5, (((0.0, 0), (0.6, 1)), ((0.9, 0), (1.5, 1))), (((0.75, 0.5), 0.36),)),
    "straightness": _Shape(1.4, (((0, 0.5), (1.4, 0.5)),)),
    "angularity": _Shape(1.4, (((1.4, 0.05), (0, 0.05), (1.2, 0.95)),)),
    "coaxiality": _Shape(1.0, (), (((0.5, 0.5), 0.5), ((0.5, 0.5), 0.25))),
    "profile": _Shape(
        1.4,
        (
            (
                (0.0, 0.15),
                *((0.7 - 0.7 * math.cos(k * math.pi / 16), 0.15 + 0.7 * math.sin(k * math.pi / 16)) for k in range(17)),
                (0.0, 0.15),
            ),
        ),
    ),
}
_NAMED = re.compile(r"\{(" + "|".join(get_args(Symbol)) + r"|frame:[^}]*|box:[^}]*)\}")
"""A symbol, a control frame `{frame:position|⌀0.2|A|B}` (characteristic, tolerance, datum letters), or a theoretically
exact value in its frame, `{box:1:20}`."""
FRAME_HEIGHT = 1.5
"""Height of a control frame within a text, over the height of capitals."""
_BOX_MARGIN, BOX_RISE = 0.6, 0.17
"""Width of the frame of a value beyond its text, and its distance above and below it, over the height of capitals."""


def symbol_width(symbol: Symbol, height: float = TEXT_HEIGHT) -> float:
    """Width of a symbol at a height of capitals, mm."""
    return _SHAPES[symbol].width * height


def symbol_primitives(symbol: Symbol, at: Point2, height: float = TEXT_HEIGHT) -> Iterator[Primitive]:
    """A symbol with its lower left corner at a point of the paper."""

    def place(point: Point2) -> Point2:
        return (at[0] + point[0] * height, at[1] + point[1] * height)

    shape = _SHAPES[symbol]
    for points in shape.lines:
        yield Stroke(tuple(map(place, points)))
    for centre, radius in shape.circles:
        yield ArcStroke(Arc(place(centre), radius * height))
    for points in shape.polygons:
        yield FilledPolygon(tuple(map(place, points)))


def _pieces(text: str) -> Iterator[tuple[str, str | None]]:
    """The parts of a text: plain text, or a symbol or control frame."""
    for number, piece in enumerate(_NAMED.split(text)):
        if piece:
            yield (piece, None) if number % 2 == 0 else ("", piece)


def _cells(frame: str, height: float) -> list[tuple[str, float]]:
    """Content and width of the compartments of a control frame; the first is the name of a symbol."""
    first, *others = frame.removeprefix("frame:").split("|")
    return [
        (first, symbol_width(first, height) + 0.8 * height),  # type: ignore[arg-type]
        *((text, max(text_width(text, height) + 0.8 * height, FRAME_HEIGHT * height)) for text in others),
    ]


def _piece_width(text: str, symbol: str | None, height: float) -> float:
    if symbol is None:
        return text_width(text, height)
    if symbol.startswith("frame:"):
        return sum(width for _, width in _cells(symbol, height))
    if symbol.startswith("box:"):
        return text_width(symbol.removeprefix("box:"), height) + _BOX_MARGIN * height
    return symbol_width(symbol, height) + 2 * _SPACE * height  # type: ignore[arg-type]


def _frame_primitives(frame: str, at: Point2, height: float) -> Iterator[Primitive]:
    x, low = at[0], at[1] - (FRAME_HEIGHT - 1) / 2 * height
    for number, (content, width) in enumerate(_cells(frame, height)):
        yield rectangle((x, low, x + width, low + FRAME_HEIGHT * height))
        if number:
            yield Text(content, (x + width / 2, at[1]), height, "middle")
        else:
            yield from symbol_primitives(content, (x + 0.4 * height, at[1]), height)  # type: ignore[arg-type]
        x += width


def _boxed(text: str, at: Point2, height: float) -> Iterator[Primitive]:
    """A text in a frame, from its left end on the base line."""
    (x, y), rise = at, BOX_RISE * height
    width = text_width(text, height) + _BOX_MARGIN * height
    yield rectangle((x, y - rise, x + width, y + height + rise))
    yield Text(text, (x + width / 2, y), height, "middle")


@cache
def symbol_text_width(text: str, height: float = TEXT_HEIGHT) -> float:
    """Width of a text with symbols written as `{depth}` and the like, mm."""
    return sum(_piece_width(*piece, height) for piece in _pieces(text))


def symbol_text_primitives(text: str, at: Point2, height: float = TEXT_HEIGHT) -> Iterator[Primitive]:
    """A text with symbols written as `{depth}` and the like, from its left end on the base line."""
    x, y = at
    for piece, symbol in _pieces(text):
        if symbol and symbol.startswith("frame:"):
            yield from _frame_primitives(symbol, (x, y), height)
        elif symbol and symbol.startswith("box:"):
            yield from _boxed(symbol.removeprefix("box:"), (x, y), height)
        elif symbol:
            yield from symbol_primitives(symbol, (x + _SPACE * height, y), height)  # type: ignore[arg-type]
        else:
            yield Text(piece, (x, y), height)
        x += _piece_width(piece, symbol, height)


def unframed(text: str) -> str:
    """A text with theoretically exact values without their frames."""
    return re.sub(r"\{box:([^}]*)\}", r"\1", text)
