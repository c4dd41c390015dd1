"""The machine taken apart: the pictures that the assembly's sheet and the procedure both show.

They are what takes longest on either sheet, so they are kept as plain numbers, and the second sheet reads what the
first one has worked out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drawings.line_cleaning import cleaned
from drawings.projection import hidden_lines
from drawings.sheet import scale_text
from drawings.view import PROJECTIONS, Arc, Curve, Polyline, Projection, Segment, View
from stagecad.solids.frame import Frame
from stagecad.solids.machine import MOVING

if TYPE_CHECKING:
    from drawings.visibility import Scene
    from stagecad.solids.assembly import Instance

SCALE = 0.5
"""Of the views of the whole machine."""
CHORD = 0.015
"""Greatest distance of a curve of these views from its chords, mm on the paper."""

FROM_BELOW = Projection(
    "from below",
    (1 / math.sqrt(2), 1 / math.sqrt(2), 0.0),
    (1 / math.sqrt(6), -1 / math.sqrt(6), 2 / math.sqrt(6)),
)
"""The isometric direction from below, for what hangs under the stage."""
EYES = {"exploded": PROJECTIONS["iso"], FROM_BELOW.name: FROM_BELOW}


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
    shown = scene.visible([(shape, frame) for _, shape, frame in pieces], projection)
    lines = hidden_lines(shown, projection, chord=chord, exact=exact)
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    label = "" if scale == SCALE else f"{name.upper()} ({scale_text(scale)})"
    parts = tuple((part, piece) for (part, _, _), piece in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale, label=label), parts)


def apart(instances: Iterable[Instance], scene: Scene, *, exact: bool = True) -> list[Picture]:
    """The machine taken apart, seen from above; from below as well where irons and magnets hang under the stage."""
    every = tuple(instances)
    hanging = tuple(instance for instance in every if instance.part in MOVING)
    groups = [("exploded", every, SCALE)]
    if len(hanging) > 1:
        groups.append((FROM_BELOW.name, hanging, SCALE / 2))
    return [
        picture(name, EYES[name], scene, [(i.part, i.shape, i.exploded) for i in shown], scale, exact=exact)
        for name, shown, scale in groups
    ]


def as_json(pictures: Sequence[Picture]) -> list[dict[str, Any]]:
    """Pictures as plain numbers."""
    return [
        {
            "name": one.view.name,
            "scale": one.view.scale,
            "label": one.view.label,
            "lines": [_numbers(curve) for curve in one.view.curves["VISIBLE"]],
            "pieces": [[part, [_numbers(curve) for curve in lines]] for part, lines in one.pieces],
        }
        for one in pictures
    ]


def from_json(documents: Iterable[Mapping[str, Any]]) -> list[Picture]:
    """What `as_json` gave, back again."""
    return [
        Picture(
            View(
                document["name"],
                EYES[document["name"]],
                {"VISIBLE": tuple(map(_curve, document["lines"]))},
                document["scale"],
                label=document["label"],
            ),
            tuple((part, tuple(map(_curve, lines))) for part, lines in document["pieces"]),
        )
        for document in documents
    ]


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
