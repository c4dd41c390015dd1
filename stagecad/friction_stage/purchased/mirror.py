"""Plane mirror of the interferometer, on the target holes in an end face of the stage.

Part coordinates: origin in the middle of the face against the stage, z out of it, x along its width, y upright.
Its mass is a part of the payload's (`payload.mass`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, X, Z
from stagecad.solids.modelling.holes import OVERRUN, cut_all, plate, repeated, stepped_hole

if TYPE_CHECKING:
    import cadquery as cq


def build(design: Design) -> cq.Solid:
    """A block with a clearance hole at either target hole, mm."""
    mirror = design.mirror
    hole = stepped_hole((0, 0, mirror.thickness), (0, 0, -1), [(mirror.screw_hole, mirror.thickness + OVERRUN)])
    half = design.stage.target_spacing / 2
    block = plate((0.0, 0.0, 0.0), mirror.width, mirror.height, mirror.thickness)
    return cut_all(block, repeated(hole, [(-half, 0.0, 0.0), (half, 0.0, 0.0)]))


def datums(design: Design) -> dict[str, Datum]:
    return {
        "seat": Datum("seat", (0.0, 0.0, 0.0), DOWN, X),
        "face": Datum("face", (0.0, 0.0, design.mirror.thickness), Z, X),
    }
