"""Height pin 2: rests on the wedge of height pin 1 and carries the piezo holder.

Part coordinates: axis along z, origin where the axis meets the sloping lower end, x towards the set screw, z up.

Features and what each is for
- Shank: turned, a sliding fit in the base's vertical bore.
- Lower end: cut to the wedge's slope, so that the two meet in a face, stiff and without turning.
- Crown: the upper end is a piece of a large sphere; the holder, guided by its pocket, is pushed up at one point and not
  tilted by a pin that tilts in its bore.
- Chamfer: leads the crowned end in, and leaves no edge to raise a burr under the holder.
"""

from __future__ import annotations

import math

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import DimensionDeclarations, FaceRequirements, X, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, revolved
from stagecad.solids.modelling.kernel import cq

TREATMENT = "hard anodise: see notes"


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheet."""
    layer = 1e3 * design.height_pin_1.coating_thickness
    return (f"Hard anodised all over, layer {layer:g} um; dimensions and roughness after coating.",)


def build(design: Design) -> cq.Solid:
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
    blank = revolved(profile)
    reach = radius + OVERRUN
    low = foot - OVERRUN
    outline = ((-reach, -reach * slope), (reach, reach * slope), (reach, low), (-reach, low))
    under = cq.Wire.makePolygon([(x, -reach, z) for x, z in outline], close=True)
    return cut_all(blank, [cq.Solid.extrudeLinear(under, [], cq.Vector(0, 2 * reach, 0))])


def datums(design: Design) -> dict[str, Datum]:
    """Axis and sloping end, and the crown."""
    slope = design.height_pin_1.slope
    size = math.hypot(1.0, slope)
    return named(
        Datum("axis", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), X),
        Datum("wedge", (0.0, 0.0, 0.0), (slope / size, 0.0, -1.0 / size), (1.0 / size, 0.0, slope / size)),
        Datum("top", (0.0, 0.0, design.height_pin_2.length), Z, X),
    )


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of height pin 2."""
    pin = design.height_pin_2
    d, top, c = DimensionDeclarations(design, "height_pin_2").group(view="front"), pin.length, pin.end_chamfer
    d.diameter("diameter", "diameter", (0, 0, top / 2), on=X)
    d.linear("length", "length", (0, 0, 0), (0, 0, top), note="on the axis")
    d.slope("slope of the lower end", "height_pin_1.slope", (0, 0, 0), X, note="rise over run", exact=True)
    d.radius("crown", "crown_radius", (0, 0, top), note="spherical", tolerance=None, reference=True)
    rim = pin.diameter / 2 - c
    sag, limit = pin.crown_radius - math.sqrt(pin.crown_radius**2 - rim**2), pin.sag_tolerance
    keys = ("height_pin_2.crown_radius", "height_pin_2.diameter", "height_pin_2.end_chamfer")
    ends, fields = ((0, 0, top), (2 * rim, 0, top)), {"kind": "sag", "tolerance": None, "deviations": (-limit, limit)}
    d.derived("crown height", sag, keys, ends, X, **fields)
    edge = top - pin.crown_radius + math.sqrt(pin.crown_radius**2 - rim**2)
    d.chamfer("end chamfer", "end_chamfer", (rim + c / 2, 0, edge - c / 2))
    return tuple(d)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """A lower end that meets the wedge in full, and a shank that its bore guides."""
    f, wedge, middle = FaceRequirements(design), datums(design)["wedge"], (0.0, 0.0, design.height_pin_2.length / 2)
    face = ((wedge.origin,), wedge.normal, "front")
    f.datum("A", (middle,), Z, "front", round=True)
    f.tolerance("angularity", "lower end to shank", "drawing.wedge_angularity", *face, datums=("A",))
    f.tolerance("cylindricity", "shank", "drawing.tolerance_x_xx", (middle,), Z, "front", round=True)
    side = (-design.height_pin_2.diameter / 2, 0.0, middle[2])
    f.texture("shank", "drawing.fit_roughness", (side,), (-1.0, 0.0, 0.0), "front")
    f.texture("lower end", "bearing.way_roughness", (wedge.origin,), wedge.normal, "front")
    return tuple(f)
