"""What is written on a sheet beside the views' lines, with its place settled; the document only draws it.

Places are in paper millimetres; the points a dimension measures are in the coordinates of its view at 1:1, so that
what the DXF entity measures is the part's true size. Every annotation knows the declarations it stands for, so that a
test can see that each is on the sheet once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drawings.views.view import Point2


@dataclass(frozen=True)
class LinearDimension:
    """A linear dimension: DXF DIMENSION, rotated; extension lines from two points, text on the line.

    Args:
        view: name of the view it belongs to.
        first, second: measured points, view coordinates.
        angle: direction measured along, degrees from u.
        line_at: a point the dimension line goes through, paper.
        text: as printed, with its decimals, count and tolerance (`2x 40.00`).
        text_at: centre of the text, paper; none where it stands in the middle of the line.
        measured: value on the solid, mm.
        names: declarations it stands for.
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
    """A diameter or radius dimension on a circle seen as one: DXF DIMENSION.

    Args:
        centre, radius: view coordinates.
        towards: direction of the leader from the centre, degrees.
        text_at: where the text stands, paper.
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
    """An angle between two directions at a vertex: DXF DIMENSION."""

    view: str
    vertex: Point2
    first: Point2
    second: Point2
    arc_at: Point2
    text: str
    measured: float
    names: tuple[str, ...]


Symbol = Literal["counterbore", "countersink", "depth", "diameter", "surface", "flatness", "parallelism",
                 "perpendicularity", "position", "cylindricity"]  # fmt: skip


@dataclass(frozen=True)
class Callout:
    """A leader with lines of text: a hole callout, a chamfer, a note on a face.

    Args:
        at: the point on the feature, view coordinates.
        elbow: where the leader turns level, paper.
        lines: text by line; `{depth}`, `{counterbore}` and the like stand for a `Symbol` drawn as geometry.
        leftward: whether the text stands left of the elbow.
    """

    view: str
    at: Point2
    elbow: Point2
    lines: tuple[str, ...]
    names: tuple[str, ...]
    leftward: bool = False


@dataclass(frozen=True)
class FeatureControlFrame:
    """A feature control frame on a leader: characteristic, tolerance, datum letters (ISO 1101)."""

    view: str
    at: Point2
    elbow: Point2
    characteristic: Symbol
    tolerance: str
    datums: tuple[str, ...] = ()


@dataclass(frozen=True)
class DatumSymbol:
    """The filled triangle and framed letter of a datum (ISO 5459)."""

    view: str
    at: Point2
    frame_at: Point2
    letter: str


@dataclass(frozen=True)
class SurfaceTextureSymbol:
    """A surface texture symbol with its requirement (`Ra 1`), its point on a line of the view (ISO 21920-1)."""

    view: str
    at: Point2
    text: str
    angle: float = 0.0


@dataclass(frozen=True)
class Balloon:
    """A numbered circle on a leader, for the assembly's parts list."""

    view: str
    at: Point2
    centre: Point2
    number: int


@dataclass(frozen=True)
class SectionMark:
    """Where a section is taken: thick ends of the cutting line, arrows in the direction of sight, letters (ISO 128-3).

    Args:
        view: the view that shows the cutting line.
        start, end: ends of the cutting line, paper; a little outside the part.
        sight: unit vector, the direction in which one looks at the cut.
        letter: of the section.
    """

    view: str
    start: Point2
    end: Point2
    sight: Point2
    letter: str


@dataclass(frozen=True)
class DetailMark:
    """The thin circle round what a detail view shows larger, and its letter.

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
    LinearDimension
    | RadialDimension
    | AngularDimension
    | Callout
    | FeatureControlFrame
    | DatumSymbol
    | SurfaceTextureSymbol
    | Balloon
    | SectionMark
    | DetailMark
)


@dataclass(frozen=True)
class Note:
    """A text on the sheet that belongs to no view: its lower left corner on the paper, one string a line."""

    at: Point2
    lines: tuple[str, ...]
    height: float = 3.5
    names: tuple[str, ...] = ()
