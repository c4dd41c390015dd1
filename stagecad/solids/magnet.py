"""The magnet: a bar magnetised across the travel, bonded between two tooth irons in a pocket of the stage.

It drives its flux out of one iron's teeth, through the gap into the stationary bar, and back into the other iron's: a
closed circuit, whose pull preloads the pads and whose teeth hold the stage on its line.

Part coordinates: origin in the middle of the face that goes to the pocket's floor, x along the travel, y across it (the
direction of magnetisation), z up; the magnet hangs below z = 0. Edges are broken: sintered magnets chip.
"""
from __future__ import annotations

from typing import Any

import cadquery as cq

from stagecad.solids.blocks import plate

NAME = "magnet"


def build(design: Any) -> cq.Solid:
    """The magnet as one solid, mm."""
    m = design.magnet
    block = plate((0.0, 0.0, 0.0), m.length, m.thickness, -m.height)
    return block.chamfer(m.edge_chamfer, None, block.Edges()).Solids()[0]
