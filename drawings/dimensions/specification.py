"""What a view is asked to show: a declaration turned to the view's plane, with its text, but without a place yet.

View coordinates at 1:1, mm; `drawings.placement.views` finds the places on the paper and makes
`drawings.annotations.annotation` of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drawings.annotations.annotation import Symbol
from drawings.views.view import Point2


@dataclass(frozen=True)
class DistanceSpec:
    """A length between two points, seen true."""

    view: str
    first: Point2
    second: Point2
    angle: float
    text: str
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class RoundSpec:
    """A diameter or radius of what is seen as a circle or an arc.

    Args:
        towards: direction from the centre to the middle of what is seen of the arc, degrees.
        spread: how far to either side of it the arc reaches, degrees.
    """

    view: str
    kind: Literal["diameter", "radius"]
    centre: Point2
    radius: float
    towards: float
    spread: float
    text: str
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class AngleSpec:
    """An angle between the directions from a vertex to two points."""

    view: str
    vertex: Point2
    first: Point2
    second: Point2
    text: str
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class CalloutSpec:
    """Lines of text on a leader to a feature.

    Args:
        at: middle of the feature.
        radius: of the circle the leader ends on; 0 for a point.
        choices: other places on the feature where the leader may end.
    """

    view: str
    at: Point2
    radius: float
    lines: tuple[str, ...]
    names: tuple[str, ...]
    choices: tuple[Point2, ...] = ()


@dataclass(frozen=True)
class FrameSpec:
    """A feature control frame, or a datum letter, on a face seen as a line.

    Args:
        first, second: ends of that line.
        outward: direction out of the material, degrees.
        letter: of a datum; a characteristic is none then.
        diameter: of the round face whose axis the datum is, mm: its mark goes on that dimension line; else 0.
    """

    view: str
    first: Point2
    second: Point2
    outward: float
    names: tuple[str, ...]
    characteristic: Symbol | None = None
    tolerance: str = ""
    datums: tuple[str, ...] = ()
    letter: str = ""
    diameter: float = 0.0


DimensionSpec = DistanceSpec | RoundSpec | AngleSpec | CalloutSpec | FrameSpec
