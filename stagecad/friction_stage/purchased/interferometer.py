"""Interferometer: the optics that measure the position of the mirror on the stage.

Part coordinates: origin on the underside at the front, in the middle of the width; x along the beam, away from the
mirror, y across, z up. A spacer below the optics sets the height of the beam.
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
    optics = design.interferometer
    return plate((optics.length / 2, 0.0, 0.0), optics.length, optics.width, optics.height)


def datums(design: Design) -> dict[str, Datum]:
    beam = (0.0, 0.0, design.interferometer.beam_height)
    return {"seat": Datum("seat", (0.0, 0.0, 0.0), DOWN, X), "beam": Datum("beam", beam, (-1.0, 0.0, 0.0), Z)}
