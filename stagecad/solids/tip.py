"""The actuator tip: an aluminium spider on three piezos whose nose drives the stage by friction.

Part coordinates: origin on the tip's axis in the plane of the piezos' ends, x along the travel, y across it, z up. The
apex is at z = tip height h; piezos 1 and 2 are at x = -D/2 and +D/2, piezo 3 on the axis x = 0 at +y, all three on a
bolt circle R = D / sqrt(3) around the apex's axis, so that equal strokes lift the apex straight up.

Features and what each is for
- Feet: round bosses over the piezos. Each has a shallow spot-faced seat, flat, on which the piezo's domed end stands
  (a dome on a flat leaves the stack no bending), in a recess that centres the dome and holds the adhesive.
- Arms: the shortest way from the feet to the hub; thin, since the tip's mass sets the actuator's first resonance.
- Hub and cone: the cone on the hub's disc; carry the drive force from the nose to the arms; fillets at the roots, where the cutter leaves them and
  where alternating stress would start a crack.
- Nose: spherical cap, coated with friction material; its radius sets the contact's pressure and stiffness.
- Relief: blind bore from below that takes mass out of the hub; it opens downwards, so no air is trapped.
"""
from __future__ import annotations

import math
from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all, edges_where, joined, upright_edges
from stagecad.solids.holes import repeated, stepped_hole

NAME = "tip"


def bolt_circle_radius(design: Any) -> float:
    """R = D / sqrt(3), mm: the circle through three piezos at mutual distance D."""
    return design.actuator.piezo_spacing / math.sqrt(3.0)


def piezo_places(design: Any) -> list[tuple[float, float]]:
    """Axes (x, y) of piezos 1, 2, 3 around the tip's axis, mm."""
    radius, half = bolt_circle_radius(design), design.actuator.piezo_spacing / 2
    return [(-half, -radius / 2), (half, -radius / 2), (0.0, radius)]


def build(design: Any) -> cq.Solid:
    """The tip as one solid, mm."""
    tip, apex = design.tip, design.actuator.tip_height
    underside = -tip.seat_depth
    top = underside + tip.arm_thickness
    nose = tip.nose_diameter / 2
    shoulder = apex - (tip.nose_radius - math.sqrt(tip.nose_radius**2 - nose**2))
    axis = cq.Vector(0, 0, 1)

    hub = cq.Solid.makeCylinder(tip.hub_diameter / 2, tip.arm_thickness, cq.Vector(0, 0, underside), axis)
    limbs: list[cq.Shape] = []
    radius = bolt_circle_radius(design)
    for x, y in piezo_places(design):
        limbs.append(cq.Solid.makeCylinder(tip.foot_diameter / 2, tip.arm_thickness, cq.Vector(x, y, underside), axis))
        arm = cq.Solid.makeBox(radius, tip.arm_width, tip.arm_thickness, cq.Vector(0, -tip.arm_width / 2, underside))
        limbs.append(arm.rotate(cq.Vector(0, 0, 0), axis, math.degrees(math.atan2(y, x))))
    body = joined(hub, limbs)
    body = body.fillet(tip.root_fillet, upright_edges(body)).Solids()[0]
    rim = edges_where(body, lambda p: abs(p.z - top) < 1e-6 or abs(p.z - underside) < 1e-6)
    body = body.chamfer(tip.edge_chamfer, None, rim).Solids()[0]

    # Cone and nose are one turned profile on the hub; the cap's arc is exact.
    half = math.asin(nose / tip.nose_radius) / 2
    mid = (tip.nose_radius * math.sin(half), apex - tip.nose_radius * (1 - math.cos(half)))
    profile = cq.Workplane("XZ").moveTo(0, 0).lineTo(tip.cone_diameter / 2, 0).lineTo(tip.cone_diameter / 2, top)
    profile = profile.lineTo(nose, shoulder).threePointArc(mid, (0, apex)).close()
    body = joined(body, [profile.revolve(360, (0, 0), (0, 1)).val()])
    root = [
        e for e in edges_where(body, lambda p: abs(p.z - top) < 1e-6)
        if e.geomType() == "CIRCLE" and abs(e.radius() - tip.cone_diameter / 2) < 1e-6
    ]
    body = body.fillet(tip.cone_fillet, root).Solids()[0]

    seat = stepped_hole((0, 0, underside), (0, 0, 1), [(tip.seat_diameter, tip.seat_depth)])
    relief = stepped_hole((0, 0, underside), (0, 0, 1), [(tip.relief_diameter, tip.relief_depth)], drill_point=True)
    return cut_all(body, [*repeated(seat, [(x, y, 0.0) for x, y in piezo_places(design)]), relief])
