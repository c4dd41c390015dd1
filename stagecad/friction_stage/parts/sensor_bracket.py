"""The sensor bracket: an angle on the back of a stop bar that carries the interferometer beyond the end of the base.

Part coordinates: origin on the face against the stop bar, half-way between the two screws; x away from the stop bar, y
across, z up.

Features and what each is for
- Flange: below the underside of the stage, which passes over it at the end of its travel.
- Arm: as low as the beam has to be at half the height of the stage; long enough that the interferometer stands clear of
  the mirror at the end of the travel.
- Clearance holes in the flange, for the screws into the stop bar, and in the arm, for those of the interferometer.
"""

from __future__ import annotations

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import DimensionDeclarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, plate, repeated, stepped_hole
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "y"

NOTES = ("Symmetric about the middle of the width.",)


def optics_places(design: Design) -> list[float]:
    """Places x of the interferometer's screws on the middle line, mm."""
    first = design.sensor_bracket.optics
    return [first, first + design.interferometer.screw_spacing]


def build(design: Design) -> cq.Solid:
    """The sensor bracket as one solid, mm."""
    bracket = design.sensor_bracket
    low, high = -(bracket.drop + bracket.thickness), bracket.rise
    block = plate((bracket.length / 2, 0.0, low), bracket.length, bracket.width, high - low)
    over = bracket.length - bracket.flange + OVERRUN
    middle, wide = (bracket.flange + over / 2, 0.0, -bracket.drop), bracket.width + 2 * OVERRUN
    above = plate(middle, over, wide, high + bracket.drop + OVERRUN)
    screw = stepped_hole((bracket.flange, 0, 0), (-1, 0, 0), (bracket.screw_hole, bracket.flange + OVERRUN))
    half = design.stop_bar.sensor_spacing / 2
    holes = repeated(screw, [(0.0, y, 0.0) for y in (-half, half)])
    places, through = [(x, 0.0) for x in optics_places(design)], (bracket.optics_hole, bracket.thickness + OVERRUN)
    return cut_all(block, [above, *holes, *drilled(places, -bracket.drop, through)])


def datums(design: Design) -> dict[str, Datum]:
    """Face against the stop bar, seats of the screw heads and of the interferometer."""
    bracket, half = design.sensor_bracket, design.stop_bar.sensor_spacing / 2
    heads = [Datum(f"bar_screw_{i}", (bracket.flange, y, 0.0), X, Y) for i, y in enumerate((-half, half), start=1)]
    front = (Derived(design).interferometer_front, 0.0, -bracket.drop)
    return named(Datum("seat", (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), Z), *heads, Datum("interferometer_1", front, Z, X))


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the sensor bracket."""
    bracket, d = design.sensor_bracket, DimensionDeclarations(design, "sensor_bracket")
    plan, front, side = d.group(view="top"), d.group(view="front"), d.group(view="right")
    end, half, low = bracket.length, bracket.width / 2, -(bracket.drop + bracket.thickness)
    level = low + bracket.thickness / 2
    plan.linear("length", "length", (0, half - 1, level), (end, half - 1, level), X)
    plan.linear("width", "width", (end - 1, -half, level), (end - 1, half, level), Y)
    front.linear("flange thickness", "flange", (0, half - 1, 0), (bracket.flange, half - 1, 0))
    front.linear("arm thickness", "thickness", (end - 1, half - 1, low), (end - 1, half - 1, -bracket.drop))
    spread = design.stop_bar.sensor_spacing / 2
    screw = (bracket.flange / 2, spread, 0)
    side.diameter("screw hole", "screw_hole", screw, X, feature="screw hole", count=2, note="through")
    side.linear("screw spacing", "stop_bar.sensor_spacing", (bracket.flange, -spread, 0), (bracket.flange, spread, 0))
    side.linear("screws to top", "rise", screw, (bracket.flange / 2, half - 1, bracket.rise), Z)
    side.linear("screws to arm", "drop", screw, (end - 1, half - 1, -bracket.drop), Z)
    first, last = ((x, 0, level) for x in optics_places(design))
    plan.diameter("optics hole", "optics_hole", first, feature="optics hole", count=2, note="through")
    plan.linear("optics spacing", "interferometer.screw_spacing", first, last)
    plan.linear("optics from stop bar", "optics", (0, half - 1, level), first, X)
    return tuple(d)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """The seat of the interferometer square to the face on the stop bar, so that its beam is along the travel."""
    f, bracket = FaceRequirements(design), design.sensor_bracket
    end, half = bracket.length, bracket.width / 2
    arm = ((end - 1, half - 1, -bracket.drop),)
    f.datum("A", ((0.0, half - 1, 0.0),), (-1.0, 0.0, 0.0), "top")
    f.datum("B", ((end - 1, half, -bracket.drop - bracket.thickness / 2),), Y, "top")
    f.tolerance("perpendicularity", "arm", "drawing.function_position", arm, Z, "front", datums=("A",))
    return tuple(f)
