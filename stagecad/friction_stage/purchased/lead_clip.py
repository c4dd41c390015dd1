"""Lead clip: a slotted block of silicone rubber, bonded into the end of a lead channel, that holds the leads.

Part coordinates: origin in the middle of its underside, x along the channel, z up; the slot is open at the top.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, X
from stagecad.solids.modelling.holes import OVERRUN, cut_all, plate

if TYPE_CHECKING:
    import cadquery as cq


def build(design: Design) -> cq.Solid:
    """A block that fills the channel, with its slot, mm."""
    clip, deep = design.lead_clip, design.base.lead_channel_depth
    block = plate((0.0, 0.0, 0.0), clip.length, design.base.lead_channel_width, deep)
    slot = plate(
        (0.0, 0.0, deep - clip.slot_depth), clip.length + 2 * OVERRUN, clip.slot_width, clip.slot_depth + OVERRUN
    )
    return cut_all(block, [slot])


def datums(design: Design) -> dict[str, Datum]:
    return {"seat": Datum("seat", (0.0, 0.0, 0.0), DOWN, X)}
