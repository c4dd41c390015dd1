"""Views of an assembly: pieces in place that hide one another, and the picture as a JSON document for the cache."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any

from drawings.views.line_cleaning import cleaned
from drawings.views.projection import hidden_lines
from drawings.views.view import Arc, Curve, Cut, Polyline, Projection, Segment, View
from stagecad.solids.modelling.frame import Frame

if TYPE_CHECKING:
    from drawings.pictures.scene import MeshedShape

TOP, SECTION, EXPLODED, FROM_BELOW = "top", "section A-A", "exploded", "from below"
"""Names of the machine's pictures, and of their views."""
SCALE = 0.5
"""Of the views of the whole machine."""
CHORD = 0.015
"""Greatest distance of a polyline of these views from its curve, mm on the paper."""


@dataclass(frozen=True)
class Piece:
    """A shape of an assembly in place.

    Args:
        part: name of its part.
        shape: in its own coordinates.
        frame: position and orientation in the assembly.
    """

    part: str
    shape: MeshedShape
    frame: Frame


@dataclass(frozen=True)
class Picture:
    """One view of an assembly.

    Args:
        view: not yet placed.
        pieces: part of each piece, and its visible lines.
    """

    view: View
    pieces: tuple[tuple[str, tuple[Curve, ...]], ...]


def picture(
    name: str, projection: Projection, pieces: Sequence[Piece], scale: float = SCALE, *, exact: bool = True
) -> Picture:
    """The visible lines of an assembly.

    Args:
        name: of the view.
        projection: direction of view.
        pieces: everything that is drawn.
        scale: of the view, paper over part.
        exact: method of hidden-line removal (`drawings.views.projection.hidden_lines`).
    """
    from drawings.pictures.scene import visible_faces

    chord = CHORD / scale
    faces = visible_faces([(piece.shape, piece.frame) for piece in pieces], projection)
    lines = hidden_lines(faces, projection, chord=chord, exact=exact)
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    parts = tuple((piece.part, curves) for piece, curves in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale), parts)


def picture_document(shown: Picture) -> dict[str, Any]:
    """A picture as values that JSON can hold."""
    view = shown.view
    return {
        "name": view.name,
        "projection": astuple(view.projection),
        "scale": view.scale,
        "label": view.label,
        "cut": astuple(view.cut) if view.cut else None,
        "curves": {layer: _rows(curves) for layer, curves in view.curves.items()},
        "pieces": [(part, _rows(curves)) for part, curves in shown.pieces],
    }


def picture_of(document: Mapping[str, Any]) -> Picture:
    """The picture of a `picture_document`."""
    view = View(
        document["name"],
        Projection(*_tuples(document["projection"])),
        {layer: _curves(rows) for layer, rows in document["curves"].items()},
        document["scale"],
        label=document["label"],
        cut=Cut(*_tuples(document["cut"])) if document["cut"] else None,
    )
    return Picture(view, tuple((part, _curves(rows)) for part, rows in document["pieces"]))


_KINDS = {kind.__name__: kind for kind in (Segment, Arc, Polyline)}


def _rows(curves: Sequence[Curve]) -> list[tuple[Any, ...]]:
    """Each curve as the name of its class and its fields."""
    return [(type(curve).__name__, *vars(curve).values()) for curve in curves]


def _curves(rows: Sequence[Sequence[Any]]) -> tuple[Curve, ...]:
    return tuple(_KINDS[kind](*_tuples(fields)) for kind, *fields in rows)


def _tuples(value: Any) -> Any:
    """JSON arrays as tuples."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
