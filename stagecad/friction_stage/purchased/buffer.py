"""Buffer of an end stop: a block of polyurethane, cut from strip and bonded to the nose of a stop bar.

Part coordinates: origin in the middle of the bonded face, z out of it, x along its width, y along its height.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, X, Z
from stagecad.solids.modelling.holes import plate

if TYPE_CHECKING:
    import cadquery as cq


def build(design: Design) -> cq.Solid:
    """A block, mm."""
    buffer = design.buffer
    return plate((0.0, 0.0, 0.0), buffer.width, buffer.height, buffer.length)


def datums(design: Design) -> dict[str, Datum]:
    return {
        "seat": Datum("seat", (0.0, 0.0, 0.0), DOWN, X),
        "face": Datum("face", (0.0, 0.0, design.buffer.length), Z, X),
    }
