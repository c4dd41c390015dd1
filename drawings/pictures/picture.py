"""Pictures of pieces that hide one another, kept as plain numbers: they take long, and several sheets show them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.pictures.depth_refinement import CloseUp
from drawings.views.line_cleaning import cleaned
from drawings.views.projection import hidden_lines
from drawings.views.view import Arc, Curve, Cut, Point2, Polyline, Projection, Segment, View
from stagecad.solids.modelling.frame import Frame, Matrix

if TYPE_CHECKING:
    from drawings.pictures.visibility import Scene, Standing

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
        exact: how lines are hidden (`drawings.views.projection.hidden_lines`).
    """
    chord = CHORD / scale
    standing = scene.standing([(shape, frame) for _, shape, frame in pieces], projection)
    wires = {kind: scene.wire(kind) for kind in {shape for _, shape, _ in pieces}}
    twins = _twins(pieces, standing, [number for number, (_, kind, _) in enumerate(pieces) if not wires[kind]])
    shown = standing.visible(twins)
    rest = [None if wires[kind] else shape for shape, (_, kind, _) in zip(shown, pieces, strict=True)]
    lines = hidden_lines(rest, projection, unasked=twins, chord=chord, exact=exact)
    for number, first in twins.items():
        here, there = (projection.to_view(pieces[which][2].shift) for which in (number, first))
        lines[number] = tuple(_moved(curve, (here[0] - there[0], here[1] - there[1])) for curve in lines[first])
    for number, (_, kind, frame) in enumerate(pieces):
        wire = wires[kind]
        if wire is not None and shown[number] is not None:
            seen = standing.close_up(number, wire.radius / FINE)
            lines = [tuple(_outside(piece, seen)) for piece in lines]
            lines[number] = tuple(wire.outlines(frame, projection, seen, chord))
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    parts = tuple((part, piece) for (part, _, _), piece in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale), parts)


def _twins(pieces: Sequence[tuple[str, str, Frame]], standing: Standing, numbers: Sequence[int]) -> dict[int, int]:
    """Pieces that nothing hides, each with the first of its shape that stands as it does and is hidden by nothing.

    In parallel projection both look the same, but for the place.
    """
    alike: dict[tuple[str, Matrix], list[int]] = {}
    for number in numbers:
        _, shape, frame = pieces[number]
        alike.setdefault((shape, frame.rotation), []).append(number)
    found: dict[int, int] = {}
    for several in alike.values():
        free = [number for number in several if standing.foremost(number)] if len(several) > 1 else []
        found |= dict.fromkeys(free[1:], *free[:1])
    return found


def _moved(curve: Curve, by: Point2) -> Curve:
    """A curve in another place of its view."""

    def at(point: Point2) -> Point2:
        return (point[0] + by[0], point[1] + by[1])

    match curve:
        case Segment():
            return Segment(at(curve.start), at(curve.end))
        case Arc():
            return replace(curve, centre=at(curve.centre))
        case Polyline():
            return Polyline(tuple(map(at, curve.points)))


def _outside(curves: Sequence[Curve], seen: CloseUp) -> Iterator[Curve]:
    """Visible curves without what a wire hides of them."""
    for curve in curves:
        if seen.meets(curve):
            yield from seen.without_hidden(curve)
        else:
            yield curve


def packed(shown: Picture) -> tuple[dict[str, Any], np.ndarray]:
    """A picture as plain values: what it is, and the numbers of all its curves in a row.

    There are so many numbers that they take six times as long as text.
    """
    view = shown.view
    groups = [*view.curves.values(), *(lines for _, lines in shown.pieces)]
    head = {
        "name": view.name,
        "projection": [view.projection.name, view.projection.right, view.projection.up],
        "scale": view.scale,
        "label": view.label,
        "cut": [view.cut.point, view.cut.normal, view.cut.letter] if view.cut else None,
        "layers": list(view.curves),
        "parts": [part for part, _ in shown.pieces],
        "counts": [[_count(curve) for curve in group] for group in groups],
    }
    return head, np.array([number for group in groups for curve in group for number in _numbers(curve)])


def unpacked(head: Mapping[str, Any], numbers: np.ndarray) -> Picture:
    """What `packed` gave, back again."""
    name, right, up = head["projection"]
    cut = None
    if head["cut"]:
        point, normal, letter = head["cut"]
        cut = Cut(tuple(point), tuple(normal), letter)
    left = iter(numbers.tolist())
    groups = [tuple(_curve(count, left) for count in counts) for counts in head["counts"]]
    layers = head["layers"]
    view = View(
        head["name"],
        Projection(name, tuple(right), tuple(up)),
        dict(zip(layers, groups)),
        head["scale"],
        label=head["label"],
        cut=cut,
    )
    return Picture(view, tuple(zip(head["parts"], groups[len(layers) :], strict=True)))


def _count(curve: Curve) -> int:
    """Points of a polyline; 0 stands for a segment, -1 for an arc."""
    match curve:
        case Segment():
            return 0
        case Arc():
            return -1
        case Polyline():
            return len(curve.points)


def _numbers(curve: Curve) -> Iterable[float]:
    match curve:
        case Segment():
            return (*curve.start, *curve.end)
        case Arc():
            return (*curve.centre, curve.radius, curve.start_angle, curve.end_angle)
        case Polyline():
            return chain.from_iterable(curve.points)


def _curve(count: int, left: Iterator[float]) -> Curve:
    if count == 0:
        return Segment((next(left), next(left)), (next(left), next(left)))
    if count == -1:
        return Arc((next(left), next(left)), next(left), next(left), next(left))
    numbers = tuple(islice(left, 2 * count))
    return Polyline(tuple(zip(numbers[::2], numbers[1::2])))
