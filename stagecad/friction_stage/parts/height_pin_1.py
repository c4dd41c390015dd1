"""Height pin 1: the wedge. Pushed along its bore by the set screw, it lifts height pin 2, against the spring.

Part coordinates: axis along z, origin on the axis at mid-length, +z towards the set screw; the wedge face looks to +x.
At mid-stroke the origin is below the axis of height pin 2.

Features and what each is for
- Shank: turned, a sliding fit in its bore; it passes through the set screw's thread, so pin and spring go in from the
  side face and come out again. End chamfers lead it in.
- Wedge face: milled flat along the whole length, sloping against the axis; pushed away from the screw the pin grows
  thicker under height pin 2, which rests on it flat and so keeps both pins from turning. The slope is far below the
  angle of friction: it locks by itself. The flat also lets air pass along the bore.
- Spigot: centres the spring on the other end (the flat runs out over it).
- Withdrawal thread: tapped in the screw's end, to draw the pin out with any M5 screw.
"""

from __future__ import annotations

import math

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, stepped_hole, turned
from stagecad.solids.modelling.kernel import cq

TREATMENT = "hard anodise: see notes"


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheet."""
    layer = 1e3 * design.height_pin_1.coating_thickness
    return (f"Hard anodised all over, tapped hole masked, layer {layer:g} um; dimensions and roughness after coating.",)


def build(design: Design) -> cq.Solid:
    """Height pin 1 as one solid, mm."""
    pin = design.height_pin_1
    half, radius, spigot, chamfer = pin.length / 2, pin.diameter / 2, pin.spigot_diameter / 2, pin.end_chamfer
    tail = -half - pin.spigot_length
    thin = [(0.0, tail), (spigot - chamfer, tail), (spigot, tail + chamfer), (spigot, -half)]
    lower, upper = [(radius - chamfer, -half), (radius, -half + chamfer)], [(radius, half - chamfer)]
    blank = turned((0, 0, 0), (0, 0, 1), [*thin, *lower, *upper, (radius - chamfer, half), (0.0, half)])
    # All material above the sloping face is removed, spigot included: the cutter runs out over it.
    start, end, side = tail - OVERRUN, half + OVERRUN, -radius - OVERRUN
    low, high = (pin.flat_height + pin.slope * z for z in (start, end))
    outline = ((low, start), (high, end), (2 * radius, end), (2 * radius, start))
    over = cq.Wire.makePolygon([(x, side, z) for x, z in outline], close=True)
    wedge = cq.Solid.extrudeLinear(over, [], cq.Vector(0, 2 * (radius + OVERRUN), 0))
    tapped = (design.threads.m5_tap_drill, pin.withdrawal_drill_depth)
    return cut_all(blank, [wedge, stepped_hole((0, 0, half), (0, 0, -1), tapped, chamfer=chamfer, point=True)])


def datums(design: Design) -> dict[str, Datum]:
    """Axis and wedge face at mid-length, and both ends."""
    pin = design.height_pin_1
    half, size = pin.length / 2, math.hypot(1.0, pin.slope)
    normal, slope = (1.0 / size, 0.0, -pin.slope / size), (pin.slope / size, 0.0, 1.0 / size)
    return named(
        Datum("axis", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), X),
        Datum("wedge", (pin.flat_height, 0.0, 0.0), normal, slope),
        Datum("screw_end", (0.0, 0.0, half), Z, X),
        Datum("spring_end", (0.0, 0.0, -half), (0.0, 0.0, -1.0), X),
    )


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of height pin 1."""
    pin, d = design.height_pin_1, DimensionDeclarations(design, "height_pin_1")
    half, radius, back = pin.length / 2, pin.diameter / 2, (-1.0, 0.0, 0.0)
    front, wedge, end = d.group(view="front"), (pin.flat_height, 0, 0), (-radius + 2, 0, -half)
    d.diameter("diameter", "diameter", (0, 0, 0), on=back, view="right")
    front.linear("length", "length", end, (-radius + 2, 0, half))
    note = f"from the axis, {half:g} mm from the shoulder of the spigot"
    front.linear("wedge face height", "flat_height", (0, 0, 0), wedge, note=note)
    front.slope("wedge slope", "slope", wedge, Z, note="rise over run", exact=True)
    tail = -half - pin.spigot_length
    front.diameter("spigot", "spigot_diameter", (0, 0, (tail - half) / 2), on=back)
    front.linear("spigot length", "spigot_length", end, (0, 0, tail), Z)
    d.tapped("withdrawal hole", "m5", (0, 0, half), DOWN, ("withdrawal_thread_depth", "withdrawal_drill_depth"))
    c, note = pin.end_chamfer / 2, "all turned edges and the hole's mouth"
    front.chamfer("end chamfer", "end_chamfer", (-(radius - c), 0, half - c), note=note)
    return tuple(d)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """A wedge face that supports height pin 2 in full, and a shank that guides it."""
    f, wedge, back = FaceRequirements(design), datums(design)["wedge"], (0.0, 0.0, -design.height_pin_1.length / 4)
    face = ((wedge.origin,), wedge.normal, "front")
    f.datum("A", (back,), Z, "right", round=True)
    f.tolerance("angularity", "wedge face to shank", "drawing.wedge_angularity", *face, datums=("A",))
    f.tolerance("cylindricity", "shank", "drawing.tolerance_x_xx", (back,), Z, "front", round=True)
    side = (-design.height_pin_1.diameter / 2, 0.0, back[2])
    f.texture("shank", "drawing.fit_roughness", (side,), (-1.0, 0.0, 0.0), "front")
    f.texture("wedge face", "bearing.way_roughness", (wedge.origin,), wedge.normal, "front")
    return tuple(f)
