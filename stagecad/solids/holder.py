"""The piezo holder: an Invar cylinder that stands three piezos upright and takes the drive's side load off them.

Part coordinates: origin on the axis in the bottom face, x along the travel, y across it, z up. Bores 1, 2 and 3 lie as
the piezos under the tip: 1 and 2 at x = -D/2 and +D/2, 3 at +y.

Features and what each is for
- Body: a close sliding fit in the base's pocket, in which it is raised by height pin 2 and then clamped; chamfers top
  and bottom lead it in.
- Bores: guide each piezo over most of its length, since the drive loads them sideways, and end in a floor it stands on.
- Ejector holes: through each floor, to push a defective piezo out from below, and to let the air out of a close bore.
- Clamp holes: tapped from the side into each bore near the floor, for a soft-tipped set screw that holds the piezo's
  foot and leaves its stroke free. (Screws are set before the holder goes into the pocket.)
- Well and lead slots: each bore opens through a narrow slot into a well in the middle, by which the leads come out at
  the top: there is no room for them between holder and pocket.
- Lifting holes: tapped in the top face between the bores, to pull the holder out of its pocket.
- Index notches: keys in the rim on the +x and -x sides; a gauge laid through the base's lead channel into one of them
  sets the piezos' line along the travel before the clamps are drawn.
"""
from __future__ import annotations

import math
from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all, edges_where, plate
from stagecad.solids.holes import OVERRUN, repeated, stepped_hole
from stagecad.solids.tip import bolt_circle_radius, piezo_places

NAME = "holder"


def build(design: Any) -> cq.Solid:
    """The holder as one solid, mm."""
    h, threads = design.holder, design.threads
    axis = cq.Vector(0, 0, 1)
    body = cq.Solid.makeCylinder(h.diameter / 2, h.height, cq.Vector(0, 0, 0), axis)
    body = body.chamfer(h.edge_chamfer, None, edges_where(body, lambda p: p.z < 1e-6 or p.z > h.height - 1e-6))
    body = body.Solids()[0]

    cutters: list[cq.Shape] = []
    places = piezo_places(design)
    bore = stepped_hole(
        (0, 0, h.height), (0, 0, -1), [(h.bore_diameter, h.height - h.floor), (h.ejector_hole, h.height + OVERRUN)],
        mouth_chamfer=h.bore_chamfer,
    )
    cutters += repeated(bore, [(x, y, 0.0) for x, y in places])
    cutters.append(stepped_hole((0, 0, h.height), (0, 0, -1), [(h.well_diameter, h.height - h.floor)],
                                mouth_chamfer=h.bore_chamfer))
    radius, outside = bolt_circle_radius(design), h.diameter / 2
    for x, y in places:
        angle = math.degrees(math.atan2(y, x))
        slot = cq.Solid.makeBox(radius, h.lead_slot_width, h.height - h.floor + OVERRUN,
                                cq.Vector(0, -h.lead_slot_width / 2, h.floor))
        cutters.append(slot.rotate(cq.Vector(0, 0, 0), axis, angle))
        c, s = x / radius, y / radius
        cutters.append(stepped_hole((outside * c, outside * s, h.clamp_height), (-c, -s, 0),
                                    [(threads.m4_tap_drill, outside - radius)], mouth_chamfer=h.bore_chamfer))
    for k in range(3):
        angle = math.radians(30.0 + 120.0 * k)
        cutters.append(stepped_hole((h.lift_radius * math.cos(angle), h.lift_radius * math.sin(angle), h.height),
                                    (0, 0, -1), [(threads.m4_tap_drill, h.lift_drill_depth)],
                                    mouth_chamfer=h.bore_chamfer, drill_point=True))
    for side in (-1, 1):
        middle = side * (outside - (h.index_depth - OVERRUN) / 2)
        cutters.append(plate((middle, 0.0, h.height - h.index_depth), h.index_depth + OVERRUN, h.index_width,
                             h.index_depth + OVERRUN))
    return cut_all(body, cutters)
