"""The stop bar: an angle across either end of the base that carries the buffers of the end stops.

Part coordinates: origin on the underside, half-way between the two screws; x outwards along the travel, y across it, z
up. The bar at +x stands as here, the other one is turned half a turn about z.

Features and what each is for
- Foot: stands on the top of the base beyond the tooth bars, and bridges the lead channel.
- Nose: reaches over the low ends of the tooth bars and their screws; the buffers are bonded to its face, at the
  height of the tooth irons.
- Counterbored holes: for the two screws, whose heads are below the stage.
- Tapped holes in the back: for the sensor bracket, at either end.
"""

from __future__ import annotations

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, plate, repeated, stepped_hole
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "y"

NOTES = ("Symmetric about the middle of the length. Two off, alike.",)


def screw_places(design: Design) -> list[tuple[float, float]]:
    """Places (x, y) of the screws in part coordinates, mm."""
    half = design.base.bracket_spacing_across / 2
    return [(0.0, -half), (0.0, half)]


def build(design: Design) -> cq.Solid:
    """The stop bar as one solid, mm."""
    bar = design.stop_bar
    block = plate(((bar.overhang - bar.reach) / 2, 0.0, 0.0), bar.reach + bar.overhang, bar.length, bar.height)
    open_end = bar.reach - bar.foot + OVERRUN
    below = plate((-bar.foot - open_end / 2, 0.0, -OVERRUN), open_end, bar.length + 2 * OVERRUN, bar.relief + OVERRUN)
    sunk = bar.height - bar.grip
    holes = drilled(screw_places(design), bar.height, (bar.counterbore, sunk), (bar.screw_hole, bar.height + OVERRUN))
    back = (bar.overhang, 0, bar.height - bar.sensor_depth)
    tapped = stepped_hole(back, (-1, 0, 0), (design.threads.m5_tap_drill, bar.sensor_drill_depth), point=True)
    half = bar.sensor_spacing / 2
    return cut_all(block, [below, *holes, *repeated(tapped, [(0.0, y, 0.0) for y in (-half, half)])])


def datums(design: Design) -> dict[str, Datum]:
    """Seat on the base, seats of the screw heads and of the buffers."""
    bar = design.stop_bar
    heads = [Datum(f"stop_screw_{i}", (x, y, bar.grip), Z) for i, (x, y) in enumerate(screw_places(design), start=1)]
    middle = bar.height - design.buffer.height / 2
    inwards = (-1.0, 0.0, 0.0)
    buffers = [
        Datum(f"buffer_{i}", (-bar.reach, y, middle), inwards, Y)
        for i, y in enumerate(Derived(design).buffer_places, start=1)
    ]
    back = Datum("sensor_bracket", (bar.overhang, 0.0, bar.height - bar.sensor_depth), X, Z)
    return named(Datum("seat", (0.0, 0.0, 0.0), DOWN, X), back, *heads, *buffers)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the stop bar."""
    bar, d = design.stop_bar, DimensionDeclarations(design, "stop_bar")
    end, (x, y) = bar.length / 2, screw_places(design)[1]
    plan, front = d.group(view="top"), d.group(view="front")
    out, side = bar.overhang, end - 2
    plan.linear("length", "length", (x, -end, bar.height / 2), (x, end, bar.height / 2), Y)
    front.linear("height", "height", (out - 1, side, 0), (out - 1, side, bar.height))
    front.linear("height of the nose", "relief", (out - 1, side, 0), (-bar.foot - 1, side, bar.relief), Z)
    axis = (x, y, bar.grip / 2)
    front.linear("screws to nose", "reach", (-bar.reach, side, bar.height - 1), axis, X)
    front.linear("screws to foot", "foot", (-bar.foot, side, bar.relief / 2), axis, X)
    front.linear("screws to back", "overhang", axis, (out, side, bar.height / 2), X)
    hole = plan.group(feature="screw hole", count=2)
    hole.diameter("screw hole", "screw_hole", axis, note="through")
    top, floor = (x, y, bar.height), (x, y + bar.counterbore / 2 - 0.5, bar.grip)
    hole.diameter("counterbore", "counterbore", (x, y, (bar.height + bar.grip) / 2), on=X)
    d.linear("grip", "grip", (x, side, 0), floor, Z, count=2, view="section")
    plan.linear("screw spacing", "base.bracket_spacing_across", (x, -y, bar.height), top)
    level, spread = bar.height - bar.sensor_depth, bar.sensor_spacing / 2
    right, mouth = d.group(view="right"), (out, spread, level)
    right.tapped("sensor hole", "m5", mouth, (-1.0, 0.0, 0.0), ("sensor_thread_depth", "sensor_drill_depth"), count=2)
    right.linear("sensor spacing", "sensor_spacing", (out, -spread, level), mouth)
    right.linear("sensor holes to top", "sensor_depth", mouth, (out / 2, side, bar.height), Z)
    return tuple(d)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Datums of the general geometrical tolerance: the seat, the back and an end."""
    f, bar = FaceRequirements(design), design.stop_bar
    out, end = bar.overhang, bar.length / 2
    f.datum("A", ((out - 1, end - 2, 0.0),), DOWN, "front")
    f.datum("B", ((out, end - 2, bar.height / 2),), X, "top")
    f.datum("C", ((out - 1, end, bar.height / 2),), Y, "top")
    return tuple(f)
