"""Annotations of a sheet with their places: dimensions, callouts, tolerances, datums, marks, notes.

Coordinates are either view coordinates (mm at 1:1, so that a DIMENSION entity measures the part's true size) or paper
coordinates (mm). `names` are the declarations that an annotation shows; each is on a sheet once.
"""

from dataclasses import dataclass
from typing import Literal

from drawings.annotations.primitives import TEXT_HEIGHT
from drawings.views.view import Point2

Symbol = Literal[
    "counterbore",
    "countersink",
    "depth",
    "diameter",
    "surface",
    "flatness",
    "parallelism",
    "perpendicularity",
    "position",
    "cylindricity",
    "straightness",
    "angularity",
    "coaxiality",
    "profile",
]
"""Signs drawn as geometry (`drawings.annotations.symbols`)."""


@dataclass(frozen=True)
class LinearDimension:
    """A distance along a direction: two extension lines, the dimension line between them, the text on it."""

    view: str  # name of the view it belongs to
    # first, second: measured points, view coordinates
    first: Point2
    second: Point2
    angle: float  # direction of measurement, degrees from u
    line_at: Point2  # a point on the dimension line, paper
    text: str  # as printed, with its decimals, count and tolerance (`2x 40.00`)
    measured: float  # value on the solid, mm
    names: tuple[str, ...]
    text_at: Point2 | None = None  # centre of the text, paper; None for the middle of the dimension line


@dataclass(frozen=True)
class RadialDimension:
    """A diameter or radius on a leader to a circle in true shape."""

    view: str
    kind: Literal["diameter", "radius"]
    # centre, radius: view coordinates
    centre: Point2
    radius: float
    towards: float  # direction of the leader from the centre, degrees
    text: str
    text_at: Point2  # centre of the text, paper
    measured: float  # value on the solid, mm
    names: tuple[str, ...]


@dataclass(frozen=True)
class AngularDimension:
    """An angle between two directions from a vertex."""

    view: str
    # vertex, first, second: the vertex and a point in each direction, view coordinates
    vertex: Point2
    first: Point2
    second: Point2
    arc_at: Point2  # position of the text on the dimension arc, paper
    text: str
    measured: float  # value on the solid, degrees
    names: tuple[str, ...]


@dataclass(frozen=True)
class Callout:
    """A leader with lines of text: a hole callout, a chamfer, a note on a face."""

    view: str
    at: Point2  # the point on the feature, view coordinates
    elbow: Point2  # point from which the leader is horizontal, paper
    lines: tuple[str, ...]  # text by line; `{depth}`, `{counterbore}` and the like are a `Symbol`
    names: tuple[str, ...]
    leftward: bool = False  # whether the text is left of the elbow


@dataclass(frozen=True)
class FeatureControlFrame:
    """A feature control frame on a leader: characteristic, tolerance, datum letters (ISO 1101)."""

    view: str
    at: Point2  # the point on the feature, view coordinates
    elbow: Point2  # end of the frame at which the leader begins, paper
    characteristic: Symbol
    tolerance: str
    datums: tuple[str, ...] = ()


@dataclass(frozen=True)
class DatumSymbol:
    """The filled triangle and framed letter of a datum (ISO 5459)."""

    view: str
    at: Point2  # the point on the feature, view coordinates
    frame_at: Point2  # centre of the letter's frame, paper
    letter: str


@dataclass(frozen=True)
class DatumTarget:
    """A datum target point: a cross on the face, and a divided circle with the target's name (ISO 5459)."""

    view: str
    at: Point2  # the point on the face, view coordinates
    centre: Point2  # of the circle, paper
    text: str  # letter and number, `A1`


@dataclass(frozen=True)
class HoleTag:
    """The name of a hole in the hole table, next to the hole."""

    view: str
    at: Point2  # centre of the hole, view coordinates
    middle: Point2  # of the text, paper
    text: str  # `A1`


@dataclass(frozen=True)
class SurfaceTextureSymbol:
    """A surface texture symbol with its requirement (`Ra 1`), its point on a line of the view (ISO 21920-1)."""

    view: str
    at: Point2  # its point, view coordinates
    text: str
    angle: float = 0.0  # of rotation, degrees


@dataclass(frozen=True)
class Balloon:
    """A numbered circle on a leader, for the assembly's parts list."""

    view: str
    at: Point2  # the point on the part, view coordinates
    centre: Point2  # of the circle, paper
    number: int


@dataclass(frozen=True)
class SectionMark:
    """Cutting plane of a section: wide ends of the line, arrows in the direction of sight, letters (ISO 128-3)."""

    view: str  # that shows the cutting line
    # start, end: of the cutting line, paper; a little outside the part
    start: Point2
    end: Point2
    sight: Point2  # unit vector in the direction of sight
    letter: str  # of the section


@dataclass(frozen=True)
class ReferenceArrow:
    """Arrow in the direction of sight of a view that is not in its place by projection, with its letter (ISO 128-3)."""

    view: str  # that shows the arrow
    tip: Point2  # paper; a little outside the part
    sight: Point2  # unit vector in the direction of sight
    letter: str  # label of that view


@dataclass(frozen=True)
class DetailMark:
    """The thin circle around the area of a detail view, and the view's letter."""

    view: str
    # centre, radius: view coordinates
    centre: Point2
    radius: float
    letter_at: Point2  # centre of the letter, paper
    letter: str


MeasuredDimension = LinearDimension | RadialDimension | AngularDimension
"""Written to DXF as DIMENSION entities."""

Annotation = (
    MeasuredDimension
    | Callout
    | FeatureControlFrame
    | DatumSymbol
    | DatumTarget
    | HoleTag
    | SurfaceTextureSymbol
    | Balloon
    | SectionMark
    | ReferenceArrow
    | DetailMark
)


@dataclass(frozen=True)
class Note:
    """A text on the sheet that belongs to no view."""

    at: Point2  # its lower left corner, paper
    lines: tuple[str, ...]  # from the top down
    height: float = TEXT_HEIGHT  # of capitals, mm
