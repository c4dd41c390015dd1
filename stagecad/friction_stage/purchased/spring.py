"""Compression spring that holds height pin 1 against its set screw, at installed length.

Part coordinates: axis along z, one end at z = 0, the other at the installed length.
"""

from __future__ import annotations

import itertools
import math

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.purchased.simple import ends
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.kernel import cq


def build(design: Design, compression: float = 0.0) -> cq.Solid:
    """Half turns of a torus that join without a kink; the first and last lie flat, as closed ends do.

    Each half turn is a semicircle in a plane through the y direction, so that at its ends, which lie over the x axis,
    the wire of one and of the next run parallel to y. Torus faces keep the solid small, and its volume has a closed
    form: wire section times the length of the semicircles. `compression`, mm, is counted from the middle of the height
    adjustment.
    """
    spring = design.spring
    length = spring.installed_length - compression
    wire = spring.wire_diameter / 2
    halves = 2 * round(spring.coils)
    rise = (length - 2 * wire) / halves
    reach = spring.outer_diameter / 2 - wire
    side = math.sqrt(reach**2 - (rise / 2) ** 2)
    heights = [wire + rise * index for index in range(halves + 1)]
    edges = []
    for index, (low, high) in enumerate(itertools.pairwise([heights[0], *heights, heights[-1]])):
        sign = 1 if index % 2 == 0 else -1
        edges.append(
            cq.Edge.makeThreePointArc(
                cq.Vector(sign * side, 0.0, low),
                cq.Vector(0.0, sign * (reach if high > low else side), (low + high) / 2),
                cq.Vector(-sign * side, 0.0, high),
            )
        )
    circle = cq.Wire.makeCircle(wire, cq.Vector(side, 0.0, heights[0]), cq.Vector(0.0, 1.0, 0.0))
    return cq.Solid.sweep(circle, [], cq.Wire.assembleEdges(edges), True, True).Solids()[0]


def datums(design: Design) -> dict[str, Datum]:
    return ends("end_1", "end_2", design.spring.installed_length)
