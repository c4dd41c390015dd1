"""The drawing frame with its zones, centring and trimming marks (ISO 5457)."""

import string
from collections.abc import Iterator
from itertools import pairwise
from typing import Literal

from drawings.annotations.primitives import TEXT_HEIGHT, FilledPolygon, Primitive, Stroke, Text, rectangle
from drawings.views.view import Box2, Point2

Paper = Literal["A4", "A3", "A2", "A1", "A0"]

PAPERS: dict[Paper, tuple[float, float]] = {
    "A4": (210.0, 297.0),
    "A3": (420.0, 297.0),
    "A2": (594.0, 420.0),
    "A1": (841.0, 594.0),
    "A0": (1189.0, 841.0),
}
"""Trimmed sizes, mm: width, height."""

FILING_MARGIN, MARGIN = 20.0, 10.0
"""Distance of the frame from the trimmed edge: on the left, and elsewhere, mm."""
BORDER = 5.0
"""Width of the border that carries the zones, mm."""
ZONE = 50.0
"""Length of a zone, counted from the centring marks, mm."""
CENTRING = 10.0
"""How far a centring mark reaches into the frame, mm."""

_LETTERS = [letter for letter in string.ascii_uppercase if letter not in "IO"]


def drawing_space(paper: Paper) -> Box2:
    """Inside of the frame, mm."""
    width, height = PAPERS[paper]
    return (FILING_MARGIN, MARGIN, width - MARGIN, height - MARGIN)


def frame(paper: Paper) -> Iterator[Primitive]:
    """Frame, border, zones and marks of a sheet."""
    width, height = PAPERS[paper]
    x0, y0, x1, y1 = drawing_space(paper)
    outer = (x0 - BORDER, y0 - BORDER, x1 + BORDER, y1 + BORDER)
    yield rectangle(drawing_space(paper), "FRAME")
    yield rectangle(outer)
    middle = (width / 2, height / 2)
    for start, end in (
        ((outer[0], middle[1]), (x0 + CENTRING, middle[1])),
        ((outer[2], middle[1]), (x1 - CENTRING, middle[1])),
        ((middle[0], outer[1]), (middle[0], y0 + CENTRING)),
        ((middle[0], outer[3]), (middle[0], y1 - CENTRING)),
    ):
        yield Stroke((start, end), "FRAME")
    yield from _zones(middle[0], x0, x1, [str(i + 1) for i in range(99)], (y0 - BORDER, y1), upright=False)
    yield from _zones(middle[1], y0, y1, _LETTERS, (x0 - BORDER, x1), upright=True)
    yield from _trimming(width, height)


def _zones(
    middle: float, low: float, high: float, names: list[str], borders: tuple[float, float], *, upright: bool
) -> Iterator[Primitive]:
    """Division marks and names along two opposite borders; letters run from the top down."""
    reach = int((high - low) / 2 // ZONE)
    inner = [middle + i * ZONE for i in range(-reach, reach + 1)]
    # A remainder shorter than a third of a zone is part of the last zone.
    marks = [at for at in inner if min(at - low, high - at) > ZONE / 3]
    ends = [low, *marks, high]
    centres = [(a + b) / 2 for a, b in pairwise(ends)]
    if upright:
        centres.reverse()

    def point(along: float, across: float) -> Point2:
        return (across, along) if upright else (along, across)

    for border in borders:
        for at in marks:
            if at != middle:
                yield Stroke((point(at, border), point(at, border + BORDER)))
        for name, at in zip(names, centres):
            x, y = point(at, border + BORDER / 2)
            yield Text(name, (x, y - TEXT_HEIGHT / 2), TEXT_HEIGHT, "middle")


def _trimming(width: float, height: float) -> Iterator[Primitive]:
    long, short = 10.0, 5.0
    for x, toward_x in ((0.0, 1), (width, -1)):
        for y, toward_y in ((0.0, 1), (height, -1)):
            for a, b in ((long, short), (short, long)):
                yield FilledPolygon(
                    ((x, y), (x + toward_x * a, y), (x + toward_x * a, y + toward_y * b), (x, y + toward_y * b))
                )
