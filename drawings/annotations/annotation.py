"""Annotations of a sheet with their places: dimensions, callouts, tolerances, datums, marks, notes.

Coordinates are either view coordinates (mm at 1:1, so that a DIMENSION entity measures the part's true size) or paper
coordinates (mm). `names` are the declarations that an annotation shows; each is on a sheet once.
"""

from __future__ import annotations

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
    """A distance along a direction: two extension lines, the dimension line between them, the text on it.

    Args:
        view: name of the view it belongs to.
        first, second: measured points, view coordinates.
        angle: direction of measurement, degrees from u.
        line_at: a point on the dimension line, paper.
        text: as printed, with its decimals, count and tolerance (`2x 40.00`).
        measured: value on the solid, mm.
        text_at: centre of the text, paper; None for the middle of the dimension line.
    """

    view: str
    first: Point2
    second: Point2
    angle: float
    line_at: Point2
    text: str
    measured: float
    names: tuple[str, ...]
    text_at: Point2 | None = None


@dataclass(frozen=True)
class RadialDimension:
    """A diameter or radius on a leader to a circle in true shape.

    Args:
        centre, radius: view coordinates.
        towards: direction of the leader from the centre, degrees.
        text_at: centre of the text, paper.
        measured: value on the solid, mm.
    """

    view: str
    kind: Literal["diameter", "radius"]
    centre: Point2
    radius: float
    towards: float
    text: str
    text_at: Point2
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class AngularDimension:
    """An angle between two directions from a vertex.

    Args:
        vertex, first, second: the vertex and a point in each direction, view coordinates.
        arc_at: position of the text on the dimension arc, paper.
        measured: value on the solid, degrees.
    """

    view: str
    vertex: Point2
    first: Point2
    second: Point2
    arc_at: Point2
    text: str
    measured: float
    names: tuple[str, ...]


@dataclass(frozen=True)
class Callout:
    """A leader with lines of text: a hole callout, a chamfer, a note on a face.

    Args:
        at: the point on the feature, view coordinates.
        elbow: point from which the leader is horizontal, paper.
        lines: text by line; `{depth}`, `{counterbore}` and the like are a `Symbol`.
        leftward: whether the text is left of the elbow.
    """

    view: str
    at: Point2
    elbow: Point2
    lines: tuple[str, ...]
    names: tuple[str, ...]
    leftward: bool = False


@dataclass(frozen=True)
class FeatureControlFrame:
    """A feature control frame on a leader: characteristic, tolerance, datum letters (ISO 1101).

    Args:
        at: the point on the feature, view coordinates.
        elbow: end of the frame at which the leader begins, paper.
    """

    view: str
    at: Point2
    elbow: Point2
    characteristic: Symbol
    tolerance: str
    datums: tuple[str, ...] = ()


@dataclass(frozen=True)
class DatumSymbol:
    """The filled triangle and framed letter of a datum (ISO 5459).

    Args:
        at: the point on the feature, view coordinates.
        frame_at: centre of the letter's frame, paper.
    """

    view: str
    at: Point2
    frame_at: Point2
    letter: str


@dataclass(frozen=True)
class DatumTarget:
    """A datum target point: a cross on the face, and a divided circle with the target's name (ISO 5459).

    Args:
        at: the point on the face, view coordinates.
        centre: of the circle, paper.
        text: letter and number, `A1`.
    """

    view: str
    at: Point2
    centre: Point2
    text: str


@dataclass(frozen=True)
class HoleTag:
    """The name of a hole in the hole table, next to the hole.

    Args:
        at: centre of the hole, view coordinates.
        middle: of the text, paper.
        text: `A1`.
    """

    view: str
    at: Point2
    middle: Point2
    text: str


@dataclass(frozen=True)
class SurfaceTextureSymbol:
    """A surface texture symbol with its requirement (`Ra 1`), its point on a line of the view (ISO 21920-1).

    Args:
        at: its point, view coordinates.
        angle: of rotation, degrees.
    """

    view: str
    at: Point2
    text: str
    angle: float = 0.0


@dataclass(frozen=True)
class Balloon:
    """A numbered circle on a leader, for the assembly's parts list.

    Args:
        at: the point on the part, view coordinates.
        centre: of the circle, paper.
    """

    view: str
    at: Point2
    centre: Point2
    number: int


@dataclass(frozen=True)
class SectionMark:
    """Cutting plane of a section: wide ends of the cutting line, arrows in the direction of sight, letters (ISO 128-3).

    Args:
        view: that shows the cutting line.
        start, end: of the cutting line, paper; a little outside the part.
        sight: unit vector in the direction of sight.
        letter: of the section.
    """

    view: str
    start: Point2
    end: Point2
    sight: Point2
    letter: str


@dataclass(frozen=True)
class ReferenceArrow:
    """Arrow in the direction of sight of a view that is not in its place by projection, with its letter (ISO 128-3).

    Args:
        view: that shows the arrow.
        tip: paper; a little outside the part.
        sight: unit vector in the direction of sight.
        letter: label of that view.
    """

    view: str
    tip: Point2
    sight: Point2
    letter: str


@dataclass(frozen=True)
class DetailMark:
    """The thin circle around the area of a detail view, and the view's letter.

    Args:
        centre, radius: view coordinates.
        letter_at: centre of the letter, paper.
    """

    view: str
    centre: Point2
    radius: float
    letter_at: Point2
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
    """A text on the sheet that belongs to no view.

    Args:
        at: its lower left corner, paper.
        lines: from the top down.
        height: of capitals, mm.
    """

    at: Point2
    lines: tuple[str, ...]
    height: float = TEXT_HEIGHT
