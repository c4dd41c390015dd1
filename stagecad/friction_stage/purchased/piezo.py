"""Piezo stack in the holder, which lifts one arm of the tip.

Part coordinates: origin at the middle of its flat foot, axis along +z, apex of its rounded end at z = length. The end
is a piece of a sphere, so that the tip's seat meets it in one place and does not bend the stack.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum

if TYPE_CHECKING:
    import cadquery as cq


def build(design: Design) -> cq.Solid:
    """A cylinder with a chamfered foot and a spherical end, turned from one outline, mm."""

    import cadquery as cq

    piezo = design.piezo
    radius, length, crown = piezo.diameter / 2, piezo.length, piezo.end_radius
    shoulder = length - crown + math.sqrt(crown**2 - radius**2)
    middle = math.asin(radius / crown) / 2
    foot = 0.04 * piezo.diameter
    outline = (
        cq.Workplane("XZ")
        .moveTo(0.0, 0.0)
        .lineTo(radius - foot, 0.0)
        .lineTo(radius, foot)
        .lineTo(radius, shoulder)
        .threePointArc((crown * math.sin(middle), length - crown * (1.0 - math.cos(middle))), (0.0, length))
        .close()
    )
    return outline.revolve(360.0, (0, 0), (0, 1)).solids().val()  # type: ignore[return-value]


def datums(design: Design) -> dict[str, Datum]:
    return {
        "foot": Datum("foot", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
        "end": Datum("end", (0.0, 0.0, design.piezo.length), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    }
