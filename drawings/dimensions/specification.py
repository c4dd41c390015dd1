"""Dimension specifications: a declared dimension, datum or tolerance in the plane of a view, with its text.

View coordinates at 1:1, mm. `drawings.placement` finds the position of each on the paper and makes an annotation of it
(`drawings.annotations.annotation`).
"""

from dataclasses import dataclass
from typing import Literal

from drawings.views.view import Point2
from stagecad.parameters.dimension import Characteristic


@dataclass(frozen=True)
class DistanceSpec:
    """A distance between two points, in true length."""

    view: str  # name of the view
    first: Point2
    second: Point2
    angle: float  # direction of measurement, degrees from u
    text: str  # as printed
    measured: float  # value on the solid, mm
    names: tuple[str, ...]  # declarations it shows


@dataclass(frozen=True)
class RoundSpec:
    """A diameter or radius of a circle or an arc."""

    view: str
    kind: Literal["diameter", "radius"]
    centre: Point2
    radius: float
    towards: float  # direction from the centre to the middle of the visible arc, degrees
    spread: float  # angle that the arc covers on either side of it, degrees
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
    """Lines of text on a leader to a feature."""

    view: str
    at: Point2  # middle of the feature
    radius: float  # of the circle on which the leader ends; 0 for a point
    lines: tuple[str, ...]
    names: tuple[str, ...]
    choices: tuple[Point2, ...] = ()  # other points of the feature at which the leader may end
    outward: float | None = None  # direction out of the material at the feature, degrees; None for a hole or an edge


@dataclass(frozen=True)
class FrameSpec:
    """A feature control frame, or a datum letter, on a face that is seen as a line."""

    view: str
    # first, second: ends of that line
    first: Point2
    second: Point2
    outward: float  # direction out of the material, degrees
    names: tuple[str, ...]
    characteristic: Characteristic | None = None  # geometrical characteristic; None for a datum
    tolerance: str = ""
    datums: tuple[str, ...] = ()
    letter: str = ""  # of a datum; empty for a control frame
    # of the round face whose axis is the datum, or distance of the faces whose middle plane it is, mm: its symbol is on
    # that dimension line; else 0
    diameter: float = 0.0
    at: float = 0.5  # part of the line at which its leader is best
    count: int = 1  # of the faces for which a control frame holds together


@dataclass(frozen=True)
class TargetSpec:
    """A datum target point."""

    view: str
    at: Point2  # on the face
    text: str  # its name, `A1`


@dataclass(frozen=True)
class TagSpec:
    """The name of a hole of the hole table."""

    view: str
    at: Point2  # centre of the hole
    radius: float  # of the hole, mm
    text: str  # its name, `A1`


DimensionSpec = DistanceSpec | RoundSpec | AngleSpec | CalloutSpec | FrameSpec | TargetSpec | TagSpec
