"""The pictures of the whole machine that its sheets show: from above, cut through actuator 1, and taken apart."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from drawings.pictures.mesh_section import cut_piece
from drawings.pictures.picture import EXPLODED, FROM_BELOW, SCALE, SECTION, TOP, Picture, picture
from drawings.pictures.visibility import DEFLECTION, MeshedFaces, Scene
from drawings.views.section import hatch
from drawings.views.view import PROJECTIONS, Cut, Projection
from stagecad.solids.assembly.machine import MOVING
from stagecad.solids.modelling.frame import UNMOVED, Frame

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

    from stagecad.solids.assembly.assemble import Instance

EYE_BELOW = Projection(
    FROM_BELOW,
    (1 / math.sqrt(2), 1 / math.sqrt(2), 0.0),
    (1 / math.sqrt(6), -1 / math.sqrt(6), 2 / math.sqrt(6)),
)
"""The isometric direction from below, for what hangs under the stage."""

WHOLE = ("way_screw", "clamp_screw_long", "clamp_screw_short", "bar_screw", "set_screw", "height_pin_1", "height_pin_2",
         "piezo", "spring")  # fmt: skip
"""What a section leaves whole: fasteners, pins and springs (ISO 128-3)."""


def machine_picture(
    name: str,
    instances: Sequence[Instance],
    scene: Scene,
    *,
    exact: bool = True,
) -> Picture | None:
    """One picture of the machine; none of it from below where no irons and magnets hang under the stage.

    Args:
        name: of the picture.
        instances: everything that stands in the machine.
        scene: of the solids, by `Instance.shape`.
        exact: how lines are hidden (`drawings.views.projection.project`).
    """
    match name:
        case "top":
            standing = [(i.part, i.shape, i.frame) for i in instances]
            return picture(TOP, PROJECTIONS["top"], scene, standing, exact=exact)
        case "section A-A":
            return _section(instances, scene, exact=exact)
        case "exploded":
            apart = [(i.part, i.shape, i.exploded) for i in instances]
            return picture(EXPLODED, PROJECTIONS["iso"], scene, apart, exact=exact)
        case "from below":
            hanging = [(i.part, i.shape, i.exploded) for i in instances if i.part in MOVING]
            if len(hanging) < 2:
                return None
            return picture(FROM_BELOW, EYE_BELOW, scene, hanging, exact=exact)
        case _:
            raise ValueError(f"there is no picture '{name}' of the machine")


def _section(instances: Sequence[Instance], scene: Scene, *, exact: bool) -> Picture:
    """The machine cut through the axis of actuator 1 along the travel."""
    cut = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
    front = PROJECTIONS["front"]
    left: dict[str, MeshedFaces] = {}
    cut_faces: dict[int, tuple[TopoDS_Shape, ...]] = {}
    covers: list[np.ndarray] = []
    pieces: list[tuple[str, str, Frame]] = []
    for number, instance in enumerate(instances):
        low, high = scene.reach(instance.shape, instance.frame, (0.0, 1.0, 0.0))
        if high < DEFLECTION:
            continue
        if low > -DEFLECTION or instance.part in WHOLE:
            if low < 0.0:
                covers.append(scene.in_plane(instance.shape, instance.frame, cut, front))
            pieces.append((instance.part, instance.shape, instance.frame))
            continue
        name = f"{instance.name} cut"
        left[name], cut_faces[number] = cut_piece(scene, instance.shape, instance.frame, cut)
        pieces.append((instance.part, name, UNMOVED))
    hatched = [
        line
        for number, faces in cut_faces.items()
        for line in hatch(faces, front, SCALE, falling=bool(number % 2), covers=covers)
    ]
    shown = picture(SECTION, front, scene.with_more(left), pieces, exact=exact)
    curves = {**shown.view.curves, "HATCH": tuple(hatched)}
    return replace(shown, view=replace(shown.view, curves=curves, label="A-A", cut=cut))
