"""Views of an assembly: pieces in place that hide one another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drawings.views.line_cleaning import cleaned
from drawings.views.projection import hidden_lines
from drawings.views.view import Curve, Projection, View
from stagecad.solids.modelling.frame import Frame

if TYPE_CHECKING:
    from drawings.pictures.scene import MeshedShape

TOP, SECTION, SIDE_SECTION = "top", "section A-A", "section B-B"
EXPLODED, FROM_BELOW = "exploded", "from below"
"""Names of the machine's pictures, and of their views."""
SCALE = 0.5
"""Scale of the views of the whole machine."""
CHORD = 0.015
"""Greatest distance of a polyline of these views from its curve, mm on the paper."""


@dataclass(frozen=True)
class Piece:
    """A shape of an assembly in place."""

    part: str  # name of its part
    shape: MeshedShape  # in its own coordinates
    frame: Frame  # position and orientation in the assembly


@dataclass(frozen=True)
class Picture:
    """One view of an assembly."""

    view: View  # not yet placed
    pieces: tuple[tuple[str, tuple[Curve, ...]], ...]  # part of each piece, and its visible lines


def picture(
    name: str, projection: Projection, pieces: Sequence[Piece], scale: float = SCALE, *, exact: bool = True
) -> Picture:
    """The visible lines of an assembly."""
    from drawings.pictures.scene import visible_faces

    chord = CHORD / scale
    faces = visible_faces([(piece.shape, piece.frame) for piece in pieces], projection)
    lines = hidden_lines(faces, projection, chord=chord, exact=exact)
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    parts = tuple((piece.part, curves) for piece, curves in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale), parts)
