"""The magnet: a bar magnetised across the travel, bonded between two tooth irons in a pocket of the stage.

It drives its flux out of one iron's teeth, through the gap into the stationary bar, and back into the other iron's: a
closed circuit, whose pull preloads the pads and whose teeth hold the stage on its line.

Part coordinates: origin in the middle of the face that goes to the pocket's floor, x along the travel, y across it (the
direction of magnetisation), z up; the magnet hangs below z = 0. Edges are broken: sintered magnets chip.
"""

from __future__ import annotations

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum, Dimension
from stagecad.solids.modelling.dimensioning import DimensionDeclarations, Z, named
from stagecad.solids.modelling.holes import plate
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "xy"

NOTES = ("Two off, alike. Dimensions after plating. Magnetised to saturation along the thickness; mark one pole face.",)


def build(design: Design) -> cq.Solid:
    """The magnet as one solid, mm."""
    m = design.magnet
    block = plate((0.0, 0.0, 0.0), m.length, m.thickness, -m.height)
    return block.chamfer(m.edge_chamfer, None, block.Edges()).Solids()[0]


def datums(design: Design) -> dict[str, Datum]:
    """The face on the pocket's floor, and the opposite one."""
    return named(Datum("seat", (0.0, 0.0, 0.0), Z), Datum("face", (0.0, 0.0, -design.magnet.height), (0.0, 0.0, -1.0)))


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the magnet."""
    m, d = design.magnet, DimensionDeclarations(design, "magnet")
    x, y, mid, c = m.length / 2, m.thickness / 2, -m.height / 2, m.edge_chamfer / 2
    d.linear("length", "length", (-x, 0, mid), (x, 0, mid), view="front")
    d.linear("thickness", "thickness", (0, -y, mid), (0, y, mid), view="top", note="magnetised this way")
    d.linear("height", "height", (0, 0, 0), (0, 0, -m.height), view="front")
    d.chamfer("edge chamfer", "edge_chamfer", (0, y - c, -c), note="all edges", view="right")
    return tuple(d)
