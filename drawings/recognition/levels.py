"""Levels of a part that dimensions must give, and rows of equal steps among them."""

from dataclasses import dataclass
from itertools import pairwise

from drawings.recognition.features import NEAR
from stagecad.parameters.dimension import Point

FACE, AXIS, MOUTH = "face", "axis", "mouth"
"""Kinds of level: of a face, of the axis of a round feature, of the mouth of a slanting hole, seen in one view only."""


@dataclass(frozen=True)
class Level:
    """A coordinate that must be given: points of the part at which it can be measured, and equal features there."""

    at: float
    points: tuple[Point, ...]
    view: str = ""
    kind: str = FACE
    of: frozenset[str] = frozenset()


def row_of_equal_steps(rows: list[Level]) -> list[Level]:
    """The longest row of three or more equally spaced levels of equal features."""
    found: list[Level] = []
    for feature in sorted({one for row in rows for one in row.of}):
        equal = [row for row in rows if feature in row.of]
        steps = [b.at - a.at for a, b in pairwise(equal)]
        if len(equal) > max(2, len(found)) and max(steps) - min(steps) < NEAR:
            found = equal
    return found
