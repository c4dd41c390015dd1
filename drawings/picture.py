"""Pictures of pieces that hide one another, kept as plain numbers: they take long, and several sheets show them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drawings.close_up import CloseUp
from drawings.line_cleaning import cleaned
from drawings.projection import hidden_lines
from drawings.view import Arc, Curve, Cut, Polyline, Projection, Segment, View
from stagecad.solids.frame import Frame

if TYPE_CHECKING:
    from drawings.visibility import Scene

TOP, SECTION, EXPLODED, FROM_BELOW = "top", "section A-A", "exploded", "from below"
"""Names of the machine's pictures, and of their views."""
SCALE = 0.5
"""Of the views of the whole machine."""
CHORD = 0.015
"""Greatest distance of a curve of these views from its chords, mm on the paper."""

FINE = 25
"""Pixels to the radius of a wire where its outlines are sorted into seen and hidden."""


@dataclass(frozen=True)
class Picture:
    """One view of pieces that hide one another.

    Args:
        view: not yet placed.
        pieces: part of each piece, and its visible lines.
    """

    view: View
    pieces: tuple[tuple[str, tuple[Curve, ...]], ...]


def picture(
    name: str,
    projection: Projection,
    scene: Scene,
    pieces: Sequence[tuple[str, str, Frame]],
    scale: float = SCALE,
    *,
    exact: bool = True,
) -> Picture:
    """A view of what is visible.

    Args:
        scene: holds the shapes.
        pieces: part, name of its shape, and where it stands.
        exact: how lines are hidden (`drawings.projection.hidden_lines`).
    """
    chord = CHORD / scale
    standing = scene.standing([(shape, frame) for _, shape, frame in pieces], projection)
    shown = standing.visible()
    wires = {kind: scene.wire(kind) for kind in {shape for _, shape, _ in pieces}}
    rest = [None if wires[kind] else shape for shape, (_, kind, _) in zip(shown, pieces, strict=True)]
    lines = hidden_lines(rest, projection, chord=chord, exact=exact)
    for number, (_, kind, frame) in enumerate(pieces):
        wire = wires[kind]
        if wire is not None and shown[number] is not None:
            seen = standing.close_up(number, wire.radius / FINE)
            lines = [tuple(_outside(piece, seen)) for piece in lines]
            lines[number] = tuple(wire.outlines(frame, projection, seen, chord))
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    parts = tuple((part, piece) for (part, _, _), piece in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale), parts)


def _outside(curves: Sequence[Curve], seen: CloseUp) -> Iterator[Curve]:
    """Visible curves without what a wire hides of them."""
    for curve in curves:
        if seen.meets(curve):
            yield from seen.without_hidden(curve)
        else:
            yield curve


def as_json(shown: Picture) -> dict[str, Any]:
    """A picture as plain numbers."""
    view = shown.view
    return {
        "name": view.name,
        "projection": [view.projection.name, view.projection.right, view.projection.up],
        "scale": view.scale,
        "label": view.label,
        "cut": [view.cut.point, view.cut.normal, view.cut.letter] if view.cut else None,
        "lines": {layer: [_numbers(curve) for curve in curves] for layer, curves in view.curves.items()},
        "pieces": [[part, [_numbers(curve) for curve in lines]] for part, lines in shown.pieces],
    }


def from_json(document: Mapping[str, Any]) -> Picture:
    """What `as_json` gave, back again."""
    name, right, up = document["projection"]
    cut = None
    if document["cut"]:
        point, normal, letter = document["cut"]
        cut = Cut(tuple(point), tuple(normal), letter)
    view = View(
        document["name"],
        Projection(name, tuple(right), tuple(up)),
        {layer: tuple(map(_curve, curves)) for layer, curves in document["lines"].items()},
        document["scale"],
        label=document["label"],
        cut=cut,
    )
    return Picture(view, tuple((part, tuple(map(_curve, lines))) for part, lines in document["pieces"]))


def _numbers(curve: Curve) -> list[Any]:
    match curve:
        case Segment():
            return ["segment", *curve.start, *curve.end]
        case Arc():
            return ["arc", *curve.centre, curve.radius, curve.start_angle, curve.end_angle]
        case Polyline():
            return ["polyline", *(value for point in curve.points for value in point)]


def _curve(numbers: Sequence[Any]) -> Curve:
    kind, *values = numbers
    if kind == "segment":
        x0, y0, x1, y1 = values
        return Segment((x0, y0), (x1, y1))
    if kind == "arc":
        x, y, radius, start, end = values
        return Arc((x, y), radius, start, end)
    return Polyline(tuple(zip(values[::2], values[1::2])))
