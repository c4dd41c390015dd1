"""The pictures of the whole machine: from above, cut through actuator 1, exploded, and from below."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.pictures.picture import EXPLODED, FROM_BELOW, SCALE, SECTION, TOP, Picture, Piece, picture
from drawings.pictures.scene import DEFLECTION, MeshedShape, meshed, moved
from drawings.views.section import cut_faces, cut_shape, hatch, in_plane
from drawings.views.view import PROJECTIONS, Cut, Projection
from stagecad.solids.assembly.machine import MOVING
from stagecad.solids.modelling.frame import UNMOVED

if TYPE_CHECKING:
    from stagecad.solids.assembly.assemble import Instance

EYE_BELOW = Projection(
    FROM_BELOW,
    (1 / math.sqrt(2), 1 / math.sqrt(2), 0.0),
    (1 / math.sqrt(6), -1 / math.sqrt(6), 2 / math.sqrt(6)),
)
"""The isometric direction from below, for the parts under the stage."""

_FASTENERS = ("way_screw", "clamp_screw_long", "clamp_screw_short", "bar_screw", "set_screw")
NOT_CUT = (*_FASTENERS, "height_pin_1", "height_pin_2", "piezo", "spring")
"""Parts that a section shows whole: fasteners, pins and springs (ISO 128-3)."""


def machine_picture(
    name: str, instances: Sequence[Instance], scene: Mapping[str, MeshedShape], *, exact: bool = True
) -> Picture | None:
    """One picture of the machine; None for the picture from below where no irons and magnets are under the stage.

    Args:
        name: of the picture.
        instances: all parts in place.
        scene: shapes by `Instance.shape` (`drawings.pictures.scene.scene_of`).
        exact: method of hidden-line removal (`drawings.views.projection.project`).
    """
    match name:
        case "top":
            pieces = [Piece(i.part, scene[i.shape], i.frame) for i in instances]
            return picture(TOP, PROJECTIONS["top"], pieces, exact=exact)
        case "section A-A":
            return _section(instances, scene, exact=exact)
        case "exploded":
            pieces = [Piece(i.part, scene[i.shape], i.exploded) for i in instances]
            return picture(EXPLODED, PROJECTIONS["iso"], pieces, exact=exact)
        case "from below":
            pieces = [Piece(i.part, scene[i.shape], i.exploded) for i in instances if i.part in MOVING]
            return picture(FROM_BELOW, EYE_BELOW, pieces, exact=exact) if len(pieces) > 1 else None
        case _:
            raise ValueError(f"there is no picture '{name}' of the machine")


def _section(instances: Sequence[Instance], scene: Mapping[str, MeshedShape], *, exact: bool) -> Picture:
    """The machine cut through the axis of actuator 1 along the travel."""
    cut = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
    front = PROJECTIONS["front"]
    pieces: list[Piece] = []
    faces_in_plane: dict[int, list[Any]] = {}
    covers: list[np.ndarray] = []
    for number, instance in enumerate(instances):
        shape, frame = scene[instance.shape], instance.frame
        vertices = shape.placed_vertices(frame)
        low, high = vertices[:, 1].min(), vertices[:, 1].max()
        if high < DEFLECTION:
            continue
        if low > -DEFLECTION or instance.part in NOT_CUT:
            if low < 0.0:
                covers.append(in_plane(vertices, shape.triangles, cut, front))
            pieces.append(Piece(instance.part, shape, frame))
            continue
        left = meshed(cut_shape(moved(shape.shape, frame), cut))
        faces_in_plane[number] = list(cut_faces(left.shape, cut))
        pieces.append(Piece(instance.part, left, UNMOVED))
    # The hatch of neighbouring parts runs in different directions.
    hatched = [
        line
        for number, faces in faces_in_plane.items()
        for line in hatch(faces, front, SCALE, falling=bool(number % 2), covers=covers)
    ]
    shown = picture(SECTION, front, pieces, exact=exact)
    curves = {**shown.view.curves, "HATCH": tuple(hatched)}
    return replace(shown, view=replace(shown.view, curves=curves, label="A-A", cut=cut))
