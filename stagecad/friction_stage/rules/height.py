"""Rules for the stack of heights under the tip: pins, holder, piezos, tip."""

import math
from collections.abc import Iterator

from stagecad.friction_stage.parameters.derived import full_set_screw_thread
from stagecad.friction_stage.rules.sliding import DRILL_POINT
from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, length, rule

UNDER_TIP = {
    "base.pin_1_axis_depth": -1.0,
    **dict.fromkeys(("height_pin_1.flat_height", "height_pin_2.length", "holder.floor", "piezo.length"), 1.0),
    "actuator.tip_height": 1.0,
}
"""Dimensions from the top of the base to the tip's apex, with the height adjustment in the middle, and their signs."""
STACK = ("bearing_way.height", "pads.height", *UNDER_TIP)
"""The lengths that determine the height of the apex above the drive surface."""


@rule
def tip_reaches_stage(d: Design) -> Iterator[str]:
    """The height adjustment brings the tip to the drive surface, whatever the tolerances of the parts between."""
    derived = d.derived
    off = derived.tip_apex - derived.drive_surface_height
    spread = sum(d.plus_minus(key) for key in STACK)
    if abs(off) + spread > derived.height_adjustment + ROUNDING:
        where = f"{length(abs(off))} {'above' if off > 0 else 'below'}" if abs(off) > ROUNDING else "at"
        yield (
            f"the tip may not reach the stage: its apex is {where} the drive surface at "
            f"{length(derived.drive_surface_height)}, tolerances add up to {length(spread)} in either direction, and "
            f"the height adjustment covers {length(derived.height_adjustment)} "
            "(<height_pin_1.stroke, height_pin_1.slope, base.pin_1_axis_depth>); base.pin_1_axis_depth would be right "
            f"at {length(d.base.pin_1_axis_depth + off)}"
        )


@rule
def fits(d: Design) -> Iterator[str]:
    """A part that slides in a bore has clearance, below a limit."""
    guided = (
        ("height_pin_1.diameter", "base.pin_1_bore"),
        ("height_pin_2.diameter", "base.pin_2_bore"),
        ("holder.diameter", "base.pocket_diameter"),
        ("piezo.diameter", "holder.bore_diameter"),
    )
    most = d.making.largest_fit
    for pin, bore in guided:
        nominal = d.value(bore) - d.value(pin)
        (pin_low, pin_high), (bore_low, bore_high) = d.deviations(pin), d.deviations(bore)
        least, greatest = nominal + bore_low - pin_high, nominal + bore_high - pin_low
        if least <= 0.0:
            fits = f": the least clearance is {length(least)}" if nominal >= 0.0 else ""
            yield f"<{pin}> does not go into <{bore}>{fits}"
        elif greatest > most + ROUNDING:
            yield f"<{pin}> is loose in <{bore}>: up to {length(greatest)} of clearance, and <making.largest_fit>"
    if d.tip.seat_diameter <= d.piezo.diameter:
        yield "<piezo.diameter> does not go into <tip.seat_diameter>"


@rule
def wedge(d: Design) -> Iterator[str]:
    """Pin 2 is fully on the wedge over the stroke, and the wedge leaves enough of pin 1."""
    one, two = d.height_pin_1, d.height_pin_2
    reach = one.stroke / 2 + two.diameter / 2
    if reach > one.length / 2 - one.end_chamfer + ROUNDING:
        yield (
            "<height_pin_1.length> is too short: pin 2 of <height_pin_2.diameter> leaves the wedge over "
            f"<height_pin_1.stroke>; at least {length(2 * (reach + one.end_chamfer))} is needed"
        )
    rise = one.slope * one.length / 2
    if one.flat_height + rise > one.diameter / 2 - ROUNDING or one.flat_height - rise < ROUNDING:
        yield (
            "the wedge of <height_pin_1.slope, height_pin_1.length> leaves the pin: its flat goes from "
            f"{length(one.flat_height - rise)} to {length(one.flat_height + rise)} over the axis of "
            "<height_pin_1.diameter>"
        )
    guided = -d.derived.wedge_height - d.derived.height_adjustment - d.base.pocket_depth
    if guided < two.diameter - ROUNDING:
        yield (
            f"height pin 2 is guided over {length(guided)} in its bore, less than <height_pin_2.diameter>; make "
            "height_pin_2.length longer or base.pocket_clearance smaller"
        )


@rule
def height_screw(d: Design) -> Iterator[str]:
    """Set screw, spring and pin 1 pass each other in their bore over the whole stroke."""
    base, one, screw, spring = d.base, d.height_pin_1, d.set_screw, d.spring
    minor = d.threads.unc_1_tap_drill
    for key in ("height_pin_1.diameter", "spring.outer_diameter"):
        if d.value(key) >= minor:
            yield f"<{key}> does not pass the set screw's thread of <threads.unc_1_tap_drill>"
    if base.pin_1_bore >= minor:
        yield "<base.pin_1_bore> takes away the set screw's thread of <threads.unc_1_tap_drill>"
    if base.set_screw_access <= screw.diameter:
        yield "<base.set_screw_access> does not let <set_screw.diameter> through"
    low, high = one.length / 2 - one.stroke / 2, one.length / 2 + one.stroke / 2 + screw.length
    full = full_set_screw_thread(d)
    if full > low + ROUNDING or base.set_screw_thread_start < high - ROUNDING:
        yield (
            f"the set screw leaves its thread: over <height_pin_1.stroke> it runs from {length(low)} to {length(high)} "
            f"off the actuator's axis, but the thread is full from {length(full)}, 1.5 pitches after "
            "<base.set_screw_thread_end>, to <base.set_screw_thread_start>"
        )
    if spring.outer_diameter >= base.pin_1_bore:
        yield "<spring.outer_diameter> does not go into <base.pin_1_bore>"
    if one.spigot_diameter >= spring.outer_diameter - 2 * spring.wire_diameter:
        yield (
            "<height_pin_1.spigot_diameter> does not go into the spring of "
            "<spring.outer_diameter, spring.wire_diameter>"
        )
    longest = spring.installed_length + one.stroke / 2
    if longest > spring.free_length + ROUNDING:
        yield (
            f"the spring goes loose: <spring.installed_length, height_pin_1.stroke> stretch it to {length(longest)}, "
            "beyond <spring.free_length>"
        )
    shortest, solid = spring.installed_length - one.stroke / 2, spring.coils * spring.wire_diameter
    if shortest < solid - ROUNDING:
        yield (
            f"the spring is pressed solid: <spring.installed_length, height_pin_1.stroke> leave it {length(shortest)}, "
            f"but its coils take {length(solid)}"
        )
    if shortest <= one.spigot_length:
        yield "<height_pin_1.spigot_length> meets the bore's end over <height_pin_1.stroke>"


@rule
def holder_bores(d: Design) -> Iterator[str]:
    """Bores, well and lifting holes lie within the holder with walls between them."""
    h, wall = d.holder, d.making.least_wall
    circle, bore = d.derived.piezo_circle, d.holder.bore_diameter
    needed = 2 * (circle + bore / 2 + wall)
    if needed > h.diameter + ROUNDING:
        yield (
            "<actuator.piezo_spacing> puts the piezos' bores over the edge of <holder.diameter>; it must be at least "
            f"{length(needed)}"
        )
    if d.actuator.piezo_spacing < bore + wall - ROUNDING:
        yield f"<actuator.piezo_spacing> lets the piezos' bores of {length(bore)} run together"
    if circle - bore / 2 - h.well_diameter / 2 < wall - ROUNDING:
        yield (
            "<holder.well_diameter> runs into the piezos' bores; it may be "
            f"{length(max(2 * (circle - bore / 2 - wall), 0.0))}"
        )
    tap = d.threads.m4_tap_drill
    if h.lift_radius + tap / 2 + wall > h.diameter / 2 + ROUNDING:
        yield "<holder.lift_radius> puts the lifting holes over the edge of <holder.diameter>"
    apart = math.sqrt(circle**2 + h.lift_radius**2 - circle * h.lift_radius)
    if apart < (bore + tap) / 2 + wall - ROUNDING or h.lift_radius < (h.well_diameter + tap) / 2 + wall - ROUNDING:
        yield "<holder.lift_radius> lets the lifting holes meet the piezos' bores or the well"
    if h.ejector_hole >= d.piezo.diameter:
        yield "<holder.ejector_hole> leaves no floor under <piezo.diameter>"
    if not h.floor + tap / 2 <= h.clamp_height <= h.height - tap / 2 - wall:
        yield "<holder.clamp_height> lies outside the bores of <holder.height, holder.floor>"


@rule
def tip_over_holder(d: Design) -> Iterator[str]:
    """The tip hangs free over the holder, and the holder under the stage."""
    derived, tip, making = d.derived, d.tip, d.making
    gap = derived.piezo_plane - tip.seat_depth - derived.holder_top
    if gap < making.least_wall - ROUNDING:
        yield (
            f"the tip comes within {length(gap)} of the holder: <piezo.length, holder.floor, holder.height>; lower "
            f"holder.height by {length(making.least_wall - gap)}"
        )
    headroom = derived.drive_surface_height - derived.holder_top - derived.height_adjustment
    if headroom <= 0.0:
        yield "the holder, raised by the height adjustment, meets the stage; lower <holder.height>"
    if abs(d.base.pocket_bore + d.base.seat_height - d.base.pocket_depth) > ROUNDING:
        yield (
            "<base.pocket_bore, base.seat_height> are not <base.pocket_depth> together; leave base.pocket_bore out, "
            "so that it is computed"
        )
    floor = d.base.pocket_depth + derived.holder_bottom - derived.height_adjustment
    if floor < -ROUNDING:
        yield (
            f"<base.pocket_depth> stops the holder {length(-floor)} before the height adjustment is at its lowest; "
            f"make base.pocket_clearance at least {length(derived.height_adjustment)}"
        )


@rule
def tip_body(d: Design) -> Iterator[str]:
    """Nose, cone, hub, feet and relief of the tip leave each other room."""
    tip, wall = d.tip, d.making.least_wall
    if tip.nose_diameter >= 2 * tip.nose_radius:
        yield "<tip.nose_diameter> is wider than a nose of <tip.nose_radius>"
        return
    sag = tip.nose_radius - math.sqrt(tip.nose_radius**2 - tip.nose_diameter**2 / 4)
    low = tip.arm_thickness - tip.seat_depth + tip.cone_fillet
    if d.actuator.tip_height - sag < low + ROUNDING:
        yield (
            "<actuator.tip_height> leaves no cone over <tip.arm_thickness> and a nose of <tip.nose_radius>; at least "
            f"{length(low + sag)} is needed"
        )
    root = tip.cone_fillet + tip.edge_chamfer
    if tip.cone_diameter < tip.nose_diameter or tip.hub_diameter < tip.cone_diameter + 2 * root - ROUNDING:
        yield (
            "<tip.nose_diameter, tip.cone_diameter, tip.hub_diameter> must grow downwards, the hub by fillet and "
            f"chamfer of {length(root)} on either side"
        )
    if tip.foot_diameter < tip.seat_diameter + 2 * wall - ROUNDING:
        yield (
            "<tip.foot_diameter> leaves too little wall around <tip.seat_diameter>; at least "
            f"{length(tip.seat_diameter + 2 * wall)} is needed"
        )
    if tip.seat_depth >= tip.arm_thickness - wall + ROUNDING:
        yield "<tip.seat_depth> cuts through <tip.arm_thickness>"
    deep = tip.relief_depth + tip.relief_diameter / 2 * DRILL_POINT
    if deep + wall > d.actuator.tip_height + tip.seat_depth - sag + ROUNDING:
        yield (
            f"<tip.relief_depth> and the drill's point reach {length(deep)} up, into the nose of a tip of "
            "<actuator.tip_height>"
        )
    if tip.relief_diameter + 2 * wall > tip.nose_diameter + ROUNDING:
        yield "<tip.relief_diameter> leaves too little wall in a cone of <tip.nose_diameter>"
    if tip.arm_width > tip.foot_diameter - ROUNDING:
        yield "<tip.arm_width> is wider than <tip.foot_diameter>"
