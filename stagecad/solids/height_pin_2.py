"""Height pin 2: stands on the wedge of height pin 1 and carries the piezo holder.

Part coordinates: axis along z, origin where the axis meets the sloping lower end, x towards the set screw, z up.

Features and what each is for
- Shank: turned, a sliding fit in the base's vertical bore.
- Lower end: cut to the wedge's slope, so that the two meet in a face, stiff and without turning.
- Crown: the upper end is a piece of a large sphere; the holder, guided by its pocket, is pushed up at one point and not
  tilted by a pin that leans in its bore.
- Chamfer: leads the crowned end in, and leaves no edge to raise a burr under the holder.
"""
from __future__ import annotations

import math
from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all
from stagecad.solids.holes import OVERRUN

NAME = "height_pin_2"


def build(design: Any) -> cq.Solid:
    """Height pin 2 as one solid, mm."""
    pin, slope = design.height_pin_2, design.height_pin_1.slope
    radius, chamfer, crown = pin.diameter / 2, pin.end_chamfer, pin.crown_radius
    foot = -radius * slope - OVERRUN
    rim = radius - chamfer

    def crown_height(r: float) -> float:
        return pin.length - crown + math.sqrt(crown**2 - r**2)

    profile = cq.Workplane("XZ").moveTo(0, foot).lineTo(radius, foot).lineTo(radius, crown_height(rim) - chamfer)
    profile = profile.lineTo(rim, crown_height(rim))
    profile = profile.threePointArc((rim / 2, crown_height(rim / 2)), (0, pin.length)).close()
    blank = profile.revolve(360, (0, 0), (0, 1)).val()
    reach = radius + OVERRUN
    under = cq.Wire.makePolygon(
        [(-reach, -reach, -reach * slope), (reach, -reach, reach * slope),
         (reach, -reach, foot - OVERRUN), (-reach, -reach, foot - OVERRUN)], close=True)
    return cut_all(blank, [cq.Solid.extrudeLinear(under, [], cq.Vector(0, 2 * reach, 0))])
