"""The actuator tip: an aluminium spider on three piezos whose nose drives the stage by friction.

Part coordinates: origin on the tip's axis in the plane of the piezos' ends, x along the travel, y across it, z up. The
apex is at z = tip height h; piezos 1 and 2 are at x = -D/2 and +D/2, piezo 3 on the axis x = 0 at +y, all three on a
bolt circle R = D / sqrt(3) around the apex's axis, so that equal strokes lift the apex straight up.

Features and what each is for
- Feet: round bosses over the piezos. Each has a shallow spot-faced seat, flat, on which the piezo's domed end rests
  (a dome on a flat leaves the stack no bending), in a recess that centres the dome and holds the adhesive. The gap
  around the dome stays open: solvent enters there and releases the tip when a piezo is replaced.
- Arms: the shortest way from the feet to the hub; thin, since the tip's mass sets the actuator's first resonance.
- Hub and cone: the cone on the hub's disc carries the drive force from the nose to the arms; fillets at the roots,
  where the cutter leaves them and where alternating stress would start a crack.
- Nose: spherical cap, coated with friction material; its radius sets the contact's pressure and stiffness.
- Relief: blind bore from below that takes mass out of the hub; it opens downwards, so no air is trapped.
"""

from __future__ import annotations

import math

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import cut_all, drilled, edges_where, joined, revolved, stepped_hole, upright_edges
from stagecad.solids.modelling.kernel import cq

TURNED, SYMMETRIC = 3, "x"
TREATMENT = "anodise the nose: see notes"


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheet."""
    layer = 1e3 * design.tip.coating_thickness
    return (
        "Feet and arms at the corners of an equilateral triangle about the nose; symmetric about each arm.",
        f"Nose coated: {design.materials[design.tip.coating_material].description.lower()}, layer {layer:g} um, seats "
        "masked; dimensions and roughness after coating.",
    )


def build(design: Design) -> cq.Solid:
    """The tip as one solid, mm."""
    tip, apex = design.tip, design.actuator.tip_height
    underside = -tip.seat_depth
    top = underside + tip.arm_thickness
    nose = tip.nose_diameter / 2
    shoulder = apex - (tip.nose_radius - math.sqrt(tip.nose_radius**2 - nose**2))
    axis = cq.Vector(0, 0, 1)

    hub = cq.Solid.makeCylinder(tip.hub_diameter / 2, tip.arm_thickness, cq.Vector(0, 0, underside), axis)
    limbs: list[cq.Shape] = []
    radius = Derived(design).piezo_circle
    for x, y in Derived(design).piezo_places:
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
    body = joined(body, [revolved(profile)])
    round_edges = [e for e in edges_where(body, lambda p: abs(p.z - top) < 1e-6) if e.geomType() == "CIRCLE"]
    root = [e for e in round_edges if abs(e.radius() - tip.cone_diameter / 2) < 1e-6]
    body = body.fillet(tip.cone_fillet, root).Solids()[0]

    seats = drilled(Derived(design).piezo_places, underside, (tip.seat_diameter, tip.seat_depth), up=True)
    relief = stepped_hole((0, 0, underside), (0, 0, 1), (tip.relief_diameter, tip.relief_depth), point=True)
    return cut_all(body, [*seats, relief])


def datums(design: Design) -> dict[str, Datum]:
    """Apex, and the seats of the piezos' ends."""
    seats = [
        Datum(f"piezo_{i}", (x, y, 0.0), (0.0, 0.0, -1.0))
        for i, (x, y) in enumerate(Derived(design).piezo_places, start=1)
    ]
    return named(Datum("apex", (0.0, 0.0, design.actuator.tip_height), Z), *seats)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the tip."""
    d, tip, low = DimensionDeclarations(design, "tip"), design.tip, -design.tip.seat_depth
    _arm_dimensions(d, design)
    _nose_dimensions(d.group(view="front"), design)
    relief, mid = d.group(view="bottom", feature="relief bore"), low + tip.arm_thickness / 2 + tip.seat_depth / 2
    relief.diameter("relief bore", "relief_diameter", (0, 0, mid), on=X)
    relief.depth("relief depth", "relief_depth", (0, 0, low), (0, 0, low + tip.relief_depth))
    return tuple(d)


def _arm_dimensions(d: DimensionDeclarations, design: Design) -> None:
    tip, apex, low = design.tip, design.actuator.tip_height, -design.tip.seat_depth
    (x1, y1), (x2, _), (_, y3) = Derived(design).piezo_places
    mid, half, hub = low + tip.arm_thickness / 2 + tip.seat_depth / 2, tip.arm_width / 2, tip.hub_diameter / 2
    top, bottom, front = d.group(view="top"), d.group(view="bottom"), d.group(view="front")
    section = d.group(view="section")
    note = "3 seats on an equilateral triangle about the nose"
    bottom.linear("piezo spacing", "actuator.piezo_spacing", (x1, y1, low), (x2, y1, low), note=note)
    section.linear("tip height", "actuator.tip_height", (0, y3, 0), (0, 0, apex), Z, note="from the seats")
    front.linear("arm thickness", "arm_thickness", (0, hub + 3, low), (0, hub + 3, low + tip.arm_thickness))

    # Upright fillets at arm 3: tangent to its side and, outside, to hub and foot.
    def fillet_centre(radius: float) -> tuple[float, float]:
        x = half + tip.root_fillet
        return x, math.sqrt((radius + tip.root_fillet) ** 2 - x**2)

    centre = fillet_centre(hub)
    to_hub = (-centre[0] / math.hypot(*centre), -centre[1] / math.hypot(*centre))
    bisector = (to_hub[0] - 1.0, to_hub[1])
    x, y = (c + tip.root_fillet * b / math.hypot(*bisector) for c, b in zip(centre, bisector, strict=True))
    straight = (centre[1] + y3 - fillet_centre(tip.foot_diameter / 2)[1]) / 2
    top.linear("arm width", "arm_width", (-half, straight, mid), (half, straight, mid), count=3)
    top.radius("root fillet", "root_fillet", (x, y, mid), count=12)
    c = tip.edge_chamfer / 2
    top.chamfer("edge chamfer", "edge_chamfer", (half - c, straight, low + c), note="outline, both faces")
    top.diameter("foot", "foot_diameter", (0, y3, mid), on=Y, count=3)
    seat = bottom.group(feature="seat", count=3)
    seat.diameter("seat", "seat_diameter", (x1, y1, low / 2), on=X, note="flat")
    seat.depth("seat depth", "seat_depth", (x1, y1, low), (x1, y1, 0))
    top.diameter("hub", "hub_diameter", (0, 0, mid), on=(0.0, -1.0, 0.0))


def _nose_dimensions(d: DimensionDeclarations, design: Design) -> None:
    tip, apex, top = design.tip, design.actuator.tip_height, -design.tip.seat_depth + design.tip.arm_thickness
    rim = apex - (tip.nose_radius - math.sqrt(tip.nose_radius**2 - tip.nose_diameter**2 / 4))
    d.diameter("cone at its root", "cone_diameter", (0, 0, top), on=Y, note="before the fillet")
    d.diameter("nose at its rim", "nose_diameter", (0, 0, rim), on=Y)
    d.radius("nose", "nose_radius", (0, 0, apex), note="spherical; friction coating")
    d.radius("cone fillet", "cone_fillet", _on_cone_fillet(design, top, rim))


def _on_cone_fillet(design: Design, top: float, shoulder: float) -> tuple[float, float, float]:
    """A point in the middle of the fillet between the hub's face and the cone."""
    tip = design.tip
    foot, rim, radius = tip.cone_diameter / 2, tip.nose_diameter / 2, tip.cone_fillet
    size = math.hypot(rim - foot, shoulder - top)
    outward = ((shoulder - top) / size, (foot - rim) / size)
    # The fillet's centre is one radius off both the face and the cone's line.
    centre = foot + radius * (1 - outward[1]) / outward[0]
    way = (-outward[0], -outward[1] - 1.0)
    r = centre + radius * way[0] / math.hypot(*way)
    return (r, 0.0, top + radius + radius * way[1] / math.hypot(*way))


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Seats in one plane, so that three equal piezos hold the nose upright."""
    f, down = FaceRequirements(design), DOWN
    seats = tuple((x, y, 0.0) for x, y in Derived(design).piezo_places)
    f.tolerance("flatness", "seats", "drawing.tolerance_x_xx", seats, down, "section", combined=True)
    f.texture("seats", "bearing.way_roughness", seats, down, "section")
    f.texture("nose", "drive.roughness", ((0.0, 0.0, design.actuator.tip_height),), Z, "front")
    return tuple(f)
