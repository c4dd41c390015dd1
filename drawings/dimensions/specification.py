"""Dimension specifications: a declared dimension, datum or tolerance in the plane of a view, with its text.

View coordinates at 1:1, mm. `drawings.placement` finds the position of each on the paper and makes an annotation of it
(`drawings.annotations.annotation`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drawings.views.view import Point2
from stagecad.parameters.dimension import Characteristic


@dataclass(frozen=True)
class DistanceSpec:
    """A distance between two points, in true length.

    Args:
        view: name of the view.
        angle: direction of measurement, degrees from u.
        text: as printed.
        measured: value on the solid, mm.
        names: declarations it shows.
    """

    view: str
    first: Point2
    second: Point2
    angle: float
    text: str
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class RoundSpec:
    """A diameter or radius of a circle or an arc.

    Args:
        towards: direction from the centre to the middle of the visible arc, degrees.
        spread: angle that the arc covers on either side of it, degrees.
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
        radius: of the circle on which the leader ends; 0 for a point.
        choices: other points of the feature at which the leader may end.
        outward: direction out of the material at the feature, degrees; None for a hole or an edge.
    """

    view: str
    at: Point2
    radius: float
    lines: tuple[str, ...]
    names: tuple[str, ...]
    choices: tuple[Point2, ...] = ()
    outward: float | None = None


@dataclass(frozen=True)
class FrameSpec:
    """A feature control frame, or a datum letter, on a face that is seen as a line.

    Args:
        first, second: ends of that line.
        outward: direction out of the material, degrees.
        characteristic: geometrical characteristic; None for a datum.
        letter: of a datum; empty for a control frame.
        diameter: of the round face whose axis is the datum, or distance of the faces whose middle plane it is, mm: its
            symbol is on that dimension line; else 0.
        at: part of the line at which its leader is best.
    """

    view: str
    first: Point2
    second: Point2
    outward: float
    names: tuple[str, ...]
    characteristic: Characteristic | None = None
    tolerance: str = ""
    datums: tuple[str, ...] = ()
    letter: str = ""
    diameter: float = 0.0
    at: float = 0.5


@dataclass(frozen=True)
class TargetSpec:
    """A datum target point.

    Args:
        at: on the face.
        text: its name, `A1`.
    """

    view: str
    at: Point2
    text: str


@dataclass(frozen=True)
class TagSpec:
    """The name of a hole of the hole table.

    Args:
        at: centre of the hole.
        radius: of the hole, mm.
        text: its name, `A1`.
    """

    view: str
    at: Point2
    radius: float
    text: str


DimensionSpec = DistanceSpec | RoundSpec | AngleSpec | CalloutSpec | FrameSpec | TargetSpec | TagSpec
