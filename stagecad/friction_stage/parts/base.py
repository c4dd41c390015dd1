"""The base: an Invar block that houses the actuators, carries the bearing ways, and takes every adjustment.

Part coordinates: origin in the plane of the seats of the ways at actuator 1, x along the travel, y across it, z up: the
assembly frame. The block is symmetric about y = 0, for thermal stability.

Features and what each is for
- Block: two raised seats along the sides, lapped in one plane, on which the ways are bedded: a lap need not clear the
  whole top with its holes. The ways overhang their seats by their own chamfer; chamfered outer edges.
- Way holes: two rows of blind tapped holes for the 3/8 inch screws of the ways, deep enough for their thread.
- Setting-pin holes: reamed holes along the inner edge of each way, for pins against which a way is pushed while its
  screws are tightened; the pins come out afterwards.
- Pockets: three bores for the piezo holders, on an equilateral triangle; only pocket 1 is fitted for one axis. The
  floor is clear of the holder, which rests on height pin 2 alone.
- Pin bores: a vertical guide for height pin 2 in each pocket's floor and, crossing it below, a horizontal bore for
  height pin 1, stepped down from the side face: access for the wrench, thread of the set screw, guide of the pin, flat
  end on which the spring rests. All from one face in one set-up; pin and spring pass through the thread. A vent from
  the underside lets the air out of its blind end.
- Clamps: see `base_clamp`.
- Lead channels: grooves in the top from each pocket to the side face its set screw is on, for the piezos' leads.
- Tooth bar holes, bracket holes: tapped, for the bars with the stationary teeth and for the stop bars.
- Lifting holes in the top corners (the block weighs some 90 kg), and three foot holes in the underside: three feet
  carry the block without bending it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived, Place, corners, full_clamp_thread, full_set_screw_thread
from stagecad.friction_stage.parts.base_clamp import Clamp, clamp_cutters, clamp_datums, clamps
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement, Point
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, edges_where, plate, stepped_hole
from stagecad.solids.modelling.kernel import cq


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the base, in the order of its drawing."""
    d, (first, _, second, _) = DimensionDeclarations(design, "base"), clamps(design)
    _block_dimensions(d, design)
    _way_holes(d, design)
    _setting_pins(d, design)
    _pockets(d, design)
    _height_bores(d.group(count=3, view="section"), design)
    _clamp_screws(d.group(count=len(clamps(design))), design, first)
    _clamp_slots(d.group(view="top"), design, first)
    _second_clamp(d.group(view="top", count=2), design, second)
    _attachments(d, design)
    if design.teeth.fitted:
        _tooth_bar_holes(d, design)
    return tuple(d)


def _block_dimensions(d: DimensionDeclarations, design: Design) -> None:
    base = design.base
    x, y, low = base.length / 2, base.width / 2, -base.height
    d.linear("length", "length", (-x, 0, low / 10), (x, 0, low / 10), view="top")
    d.linear("width", "width", (0, -y, low / 2), (0, y, low / 2), view="top")
    d.linear("height", "height", (x - 3, y - 3, low), (x - 3, y - 3, 0), view="front")
    end, edge, deep = d.group(view="right"), Derived(design).seat_edge, -base.seat_height
    end.linear("seat height", "seat_height", (x - 3, edge - 3, deep), (x - 3, y - 3, 0), Z, count=2)
    end.linear("seat gap", "seat_gap", (0, -edge, deep / 2), (0, edge, deep / 2))
    c = base.edge_chamfer / 2
    d.chamfer("edge chamfer", "edge_chamfer", (x - c, (edge + y) / 2, -c), note="all outer edges", view="front")


def _way_holes(d: DimensionDeclarations, design: Design) -> None:
    base, places = design.base, Derived(design).way_hole_places
    (x, y), (x2, _) = places[:2]
    hole, side = (x, y, 0), (x, base.width / 2, -base.height / 2)
    table, top = d.group(view="top", table="top"), d.group(view="top")
    table.tapped("way hole", "unc_3_8", hole, DOWN, ("way_thread_depth", "way_drill_depth"), count=len(places))
    table.counted("way holes in a row", "bearing_way.bolt_count", hole)
    table.linear("way hole spacing", "bearing_way.bolt_spacing", hole, (x2, y, 0))
    table.linear("way hole row to side", "bearing_way.bolt_edge", side, hole, Y)
    c = base.hole_chamfer / 2
    mouth = (x + design.threads.unc_3_8_tap_drill / 2 + c, y, -c)
    top.chamfer("hole chamfer", "hole_chamfer", mouth, note="mouths of all screw, pin, vent and side bores")


def _setting_pins(d: DimensionDeclarations, design: Design) -> None:
    base, top, pin = design.base, d.group(view="top", table="top"), "setting-pin hole"
    x, gap, mouth = base.setting_pin_spacing / 2, base.way_gap / 2, -base.seat_height
    low = mouth - base.setting_pin_depth
    y, middle = gap - base.setting_pin_hole / 2, (mouth + low) / 2
    top.linear("way gap", "way_gap", (x, -gap, middle), (x, gap, middle))
    top.diameter(pin, "setting_pin_hole", (x, y, middle), feature=pin, count=4, note="reamed")
    top.depth("setting-pin hole depth", "setting_pin_depth", (x, y, mouth), (x, y, low), feature=pin, count=4)
    top.linear("setting-pin spacing", "setting_pin_spacing", (-x, y, mouth), (x, y, mouth))


def _pockets(d: DimensionDeclarations, design: Design) -> None:
    base = design.base
    _, (x, y), (_, y3) = Derived(design).actuator_places
    mouth, left = -base.seat_height, (-1.0, 0.0, 0.0)
    radius, floor = base.pocket_diameter / 2, mouth - base.pocket_bore
    top = d.group(view="top")
    pocket = top.group(feature="pocket", count=3)
    pocket.diameter("pocket", "pocket_diameter", (0, 0, floor / 2), on=left)
    pocket.depth("pocket depth", "pocket_bore", (0, 0, mouth), (0, radius / 2, floor), Z)
    note = "3 pockets on an equilateral triangle"
    top.linear("pocket spacing", "actuator_spacing", (x, y3, 0), (x, y, 0), note=note, exact=True)
    keys, ends = ("base.actuator_spacing",), ((0, 0, 0), (x, y, 0))
    top.derived("pocket 1 to pockets 2 and 3", abs(x), keys, ends, X, exact=True)
    c = base.pocket_chamfer / 2
    top.chamfer("pocket chamfer", "pocket_chamfer", (-(radius + c), 0, mouth - c), count=3)
    channel = d.group(view="right", feature="lead channel", count=3)
    half, deep, out = base.lead_channel_width / 2, mouth - base.lead_channel_depth, base.length / 2 - 20
    channel.linear(
        "lead channel width", "lead_channel_width", (out, -half, (mouth + deep) / 2), (out, half, (mouth + deep) / 2)
    )
    channel.depth("lead channel depth", "lead_channel_depth", (out, 0, mouth), (out, 0, deep))
    z, note = -base.pin_1_axis_depth, "axes of height bores and lead channels"
    d.derived(
        "left side bores", 2 * y, keys, ((-base.length / 2, -y, z), (-base.length / 2, y, z)), Y, view="left", note=note
    )


def _height_bores(d: DimensionDeclarations, design: Design) -> None:
    """Bores of the height adjustment in pocket 1: pin 2 upright, pin 1 and set screw along x, and the vent."""
    base = design.base
    deep, floor, low = -base.pin_1_axis_depth, -base.pocket_depth, -base.height + 5
    start, end, out = base.set_screw_thread_start, base.set_screw_thread_end, base.length / 2
    axis, edge, blind = (0, 0, floor / 2), (out - 3, base.width / 2 - 3, 0), (-base.pin_1_bore_end, 0, deep)
    guide = (0, 0, (floor + deep) / 2 + base.pin_1_bore / 4)
    d.diameter("pin 2 bore", "pin_2_bore", guide, on=Y)
    d.linear("pin 1 axis depth", "pin_1_axis_depth", edge, (-20, 0, deep), Z)
    bore, guide = "pin 1 bore", (-base.pin_1_bore_end / 2, 0, deep)
    d.diameter(bore, "pin_1_bore", guide, X, on=Z)
    d.linear("pin 1 bore end", "pin_1_bore_end", axis, blind, X)
    middle, touch = (start + end) / 2, deep - design.threads.unc_1_tap_drill / 2
    thread = ((middle, 0, deep), (middle, 0, touch))
    feature = "set screw thread"
    named = {"note": "1-8 UNC", "major": design.thread("unc_1").major, "feature": feature}
    d.add("tap_drill", feature, "threads.unc_1_tap_drill", thread, X, **named)
    text = f"over the length shown, full from {full_set_screw_thread(design):.1f} by a bottoming tap"
    d.remark("set screw thread ends", ("base.set_screw_thread_start",), thread[1], text, feature=feature)
    d.linear("set screw thread start", "set_screw_thread_start", axis, (start, 0, deep), X)
    d.linear("set screw thread end", "set_screw_thread_end", axis, (end, 0, deep), X)
    d.diameter("set screw access", "set_screw_access", ((start + out) / 2, 0, deep), X, on=Z)
    vent = (-(base.pin_1_bore_end - base.vent_hole), 0, low)
    d.diameter("vent", "vent_hole", vent, on=X, note="from the underside into the bore")
    keys = ("base.pin_1_bore_end", "base.vent_hole")
    d.derived("vent to the bore's end", base.vent_hole, keys, (blind, vent), X)


def _clamp_screws(d: DimensionDeclarations, design: Design, clamp: Clamp) -> None:
    base = design.base
    face, y, z = base.length / 2, base.clamp_screw_offset, -base.clamp_screw_depth
    mouth, seat = (face, y, z), face - base.clamp_counterbore_depth
    right = d.group(view="right")
    right.linear("clamp screw depth", "clamp_screw_depth", (face - 3, base.width / 2 - 3, 0), mouth, Z)
    right.linear("clamp screw offset", "clamp_screw_offset", (0, 0, z), mouth, Y, count=2)
    far = abs(clamps(design)[2].place(0.0, y)[1])
    keys, ends = ("base.actuator_spacing", "base.clamp_screw_offset"), ((-face, -far, z), (-face, far, z))
    d.group(count=1).derived(
        "clamp screws of pockets 2 and 3", 2 * far, keys, ends, Y, view="left", note="clamp screws"
    )
    hole = right.group(feature="clamp screw hole")
    hole.diameter("clamp counterbore", "clamp_counterbore", ((face + seat) / 2, y, z), X, on=Z)
    ring = (seat, y, z + (base.clamp_counterbore + base.clamp_hole) / 4)
    hole.depth("clamp counterbore depth", "clamp_counterbore_depth", mouth, ring, X)
    hole.diameter("clamp clearance hole", "clamp_hole", (face - 50, y, z), X, on=Z, note="to the gap slot")
    wall = clamp.slot - base.clamp_slot_width / 2
    lug, note = (wall - base.clamp_thread_depth, y, z), "drilled from the gap slot into the lug"
    hole.depth("clamp thread hole depth", "clamp_thread_depth", (wall, y, z), lug, view="section", note=note)
    drill, at = "threads.unc_3_8_tap_drill", ((wall + lug[0]) / 2, y, z)
    touch = (at[0], y - design.threads.unc_3_8_tap_drill / 2, z)
    thread = design.thread("unc_3_8")
    hole.add("tap_drill", "clamp thread", drill, (at, touch), X, note=thread.designation, major=thread.major)
    full = f"beyond the slot, full over a length of {full_clamp_thread(design):.1f} by a bottoming tap"
    hole.remark("clamp thread length", ("base.clamp_thread_depth",), touch, full)


def _clamp_slots(d: DimensionDeclarations, design: Design, clamp: Clamp) -> None:
    base, low = design.base, -design.base.height / 2
    slot, reach, radius, half = clamp.slot, base.clamp_reach, base.pocket_diameter / 2, base.clamp_slot_width / 2
    axis, end, all_four = (0, 0, low / 4), (slot, reach, low), d.group(count=4)
    y, note = (base.clamp_screw_offset + radius) / 2, "through the whole depth, all clamps"
    d.linear("clamp slot width", "clamp_slot_width", (slot - half, y, low), (slot + half, y, low), note=note)
    d.linear("clamp slot 1", "clamp_slot_1", axis, end, X, count=2)
    all_four.linear("clamp reach", "clamp_reach", axis, end, Y)
    all_four.linear("clamp lug", "clamp_lug", end, (slot - base.clamp_lug, reach, low))
    angle, into = math.radians(clamp.neck), "through, on the middle line of the slanting slot"
    out, hole = _radial(angle), (*clamp.relief_hole(design), low)
    z = -base.clamp_screw_depth / 2
    neck = _along(out, radius, z), _along(out, radius + base.clamp_neck, z)
    all_four.linear("clamp neck", "clamp_neck", *neck, out)
    all_four.diameter("clamp relief hole", "clamp_relief_hole", hole, on=_radial(angle, -1.0), note=into)
    d.angle("clamp neck angle 1", "clamp_neck_angle_1", axis, hole, X, count=2)
    out = _radial((clamp.start_angle(radius) + angle) / 2)
    z = -(base.pocket_depth + base.height) / 2
    wall = _along(out, radius - base.clamp_floor_slot, z), _along(out, radius, z)
    note = "through the pocket's floor, along its wall, from gap slot to neck angle"
    all_four.linear("clamp floor slot", "clamp_floor_slot", *wall, out, note=note)


def _second_clamp(d: DimensionDeclarations, design: Design, clamp: Clamp) -> None:
    """The dimensions that differ at pockets 2 and 3."""
    low = -design.base.height / 2
    axis, hole = (*clamp.centre, low / 4), (*clamp.relief_hole(design), low)
    d.linear("clamp slot 2", "clamp_slot_2", axis, (*clamp.place(clamp.slot, design.base.clamp_reach), low), X)
    d.angle("clamp neck angle 2", "clamp_neck_angle_2", axis, hole, (clamp.head, 0.0, 0.0))


def _radial(angle: float, sign: float = 1.0) -> Point:
    """Horizontal unit vector at an angle from x, rad, times `sign`."""
    return (sign * math.cos(angle), sign * math.sin(angle), 0.0)


def _along(out: Point, radius: float, z: float) -> Point:
    """The point at a distance from the axis of pocket 1 in the direction `out`, mm."""
    return (radius * out[0], radius * out[1], z)


def _attachments(d: DimensionDeclarations, design: Design) -> None:
    base = design.base
    _rectangle(d, "lifting hole", "m10", "lift", corners(base.lift_spacing_along, base.lift_spacing_across), 0.0)
    bracket = corners(base.bracket_spacing_along, base.bracket_spacing_across)
    _rectangle(d, "bracket hole", "m6", "bracket", bracket, -base.seat_height)
    x, y, low = base.foot_spacing_along / 2, base.foot_spacing_across / 2, -base.height
    bottom = d.group(view="bottom")
    bottom.tapped("foot hole", "m10", (x, y, low), Z, ("foot_thread_depth", "foot_drill_depth"), count=3)
    bottom.linear("foot spacing along", "foot_spacing_along", (-x, 0, low), (x, y, low), X)
    bottom.linear("foot spacing across", "foot_spacing_across", (x, -y, low), (x, y, low))


def _rectangle(
    d: DimensionDeclarations, feature: str, thread: str, key: str, places: Sequence[Place], z: float
) -> None:
    """Four tapped holes in the top, with their spacings; z of their mouths, mm."""
    (x1, y1), (_, y2), (x2, _) = places[:3]
    first, depths = (x1, y1, z), (f"{key}_thread_depth", f"{key}_drill_depth")
    table = d.group(view="top", table="top")
    table.tapped(feature, thread, first, DOWN, depths, count=len(places))
    table.linear(f"{feature} spacing along", f"{key}_spacing_along", first, (x2, y1, z))
    table.linear(f"{feature} spacing across", f"{key}_spacing_across", first, (x1, y2, z))


def _tooth_bar_holes(d: DimensionDeclarations, design: Design) -> None:
    bar, top = design.tooth_bar, d.group(view="top", table="top")
    x, half, middle = bar.screw_span / 2, bar.screw_spacing / 2, design.teeth.bar_spacing / 2
    low, high, mouth = middle - half, middle + half, -design.base.seat_height
    hole, count = (x, high, mouth), len(Derived(design).bar_hole_places)
    top.tapped("tooth bar hole", "m5", hole, DOWN, ("bar_thread_depth", "bar_drill_depth"), count=count)
    top.linear("tooth bar hole span", "tooth_bar.screw_span", (-x, high, mouth), hole)
    top.linear("tooth bar hole spacing", "tooth_bar.screw_spacing", (x, low, mouth), hole)
    top.linear("tooth bar spacing", "teeth.bar_spacing", (x, -high, mouth), (x, low, mouth))


SYMMETRIC = "xy"
TOLERANCE = 1e-6


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheets."""
    return (
        "Pocket 1 in the middle of length and width; symmetric about the plane of pocket 1 along the length.",
        "Way holes, setting-pin, lifting, bracket and tooth bar holes also symmetric about the middle of the length.",
        "Pockets 2 and 3 as pocket 1, their height bores, lead channels and clamps towards the opposite side face.",
        "Hole table: X and Y theoretically exact, from the axis of pocket 1, X to the right.",
        "Flatness of the face filtered by a Gaussian filter of 0.8 mm cut-off (ISO 12781-2).",
        "Cut clamp slots after the pockets, and finish the pockets last.",
        "Depths from the face in which a feature starts; of reamed holes full depth, the drill up to 3 mm deeper.",
    )


def build(design: Design) -> cq.Solid:
    """The base as one solid, mm."""
    base, threads = design.base, design.threads
    block, low = _block(design), -base.seat_height
    cutters: list[cq.Shape] = []

    def tapped(drill: float, depth: float, places: Sequence[Place], z: float, *, up: bool = False) -> None:
        cutters.extend(drilled(places, z, (drill, depth), up=up, chamfer=base.hole_chamfer, point=True))

    tapped(threads.unc_3_8_tap_drill, base.way_drill_depth, Derived(design).way_hole_places, 0.0)
    lift = corners(base.lift_spacing_along, base.lift_spacing_across)
    tapped(threads.m10_tap_drill, base.lift_drill_depth, lift, 0.0)
    bracket = corners(base.bracket_spacing_along, base.bracket_spacing_across)
    tapped(threads.m6_tap_drill, base.bracket_drill_depth, bracket, low)
    along, across = base.foot_spacing_along / 2, base.foot_spacing_across / 2
    feet = [(-along, 0.0), (along, -across), (along, across)]
    tapped(threads.m10_tap_drill, base.foot_drill_depth, feet, -base.height, up=True)
    if design.teeth.fitted:
        tapped(threads.m5_tap_drill, base.bar_drill_depth, Derived(design).bar_hole_places, low)

    pins = corners(base.setting_pin_spacing, base.way_gap - base.setting_pin_hole)
    cutters += drilled(pins, low, (base.setting_pin_hole, base.setting_pin_depth), chamfer=base.hole_chamfer)

    for number, (x, y) in enumerate(Derived(design).actuator_places, start=1):
        cutters += _pocket(design, number, x, y)
    return cut_all(block, [*cutters, *clamp_cutters(design)])


def _block(design: Design) -> cq.Solid:
    """Block with a raised seat along either side, its outer edges chamfered."""
    base = design.base
    body = plate((0.0, 0.0, 0.0), base.length, base.width, -base.height)
    gap = 2 * Derived(design).seat_edge
    between = plate((0.0, 0.0, -base.seat_height), base.length + 2 * OVERRUN, gap, base.seat_height + OVERRUN)
    body = cut_all(body, [between])

    def outer(p: cq.Vector) -> bool:
        on_side = max(abs(p.x) - base.length / 2, abs(p.y) - base.width / 2) > -TOLERANCE
        return on_side or p.z < -base.height + TOLERANCE

    return body.chamfer(base.edge_chamfer, None, edges_where(body, outer)).Solids()[0]


def reach_side(pocket: int) -> float:
    """The side face from which a pocket's height screw is reached: +1 for +x (pocket 1), -1 for -x (2 and 3)."""
    return 1.0 if pocket == 1 else -1.0


def _pocket(design: Design, number: int, x: float, y: float) -> list[cq.Shape]:
    """Cutters of one actuator pocket with its pin bores, vent and lead channel."""
    base, low = design.base, -design.base.seat_height
    side = reach_side(number)
    face = side * base.length / 2
    to_axis = abs(face - x)
    room, guide = (base.pocket_diameter, base.pocket_bore), (base.pin_2_bore, base.pin_1_axis_depth + low)
    pocket = stepped_hole((x, y, low), (0, 0, -1), room, guide, chamfer=base.pocket_chamfer)
    steps = (
        (base.set_screw_access, to_axis - base.set_screw_thread_start),
        (design.threads.unc_1_tap_drill, to_axis - base.set_screw_thread_end),
        (base.pin_1_bore, to_axis + base.pin_1_bore_end),
    )
    bore = stepped_hole((face, y, -base.pin_1_axis_depth), (-side, 0, 0), *steps, chamfer=base.hole_chamfer)
    below = (x - side * (base.pin_1_bore_end - base.vent_hole), y, -base.height)
    up_to_bore = (base.vent_hole, base.height - base.pin_1_axis_depth)
    vent = stepped_hole(below, (0, 0, 1), up_to_bore, chamfer=base.hole_chamfer)
    channel = plate(
        ((x + face + side * OVERRUN) / 2, y, low - base.lead_channel_depth),
        to_axis + OVERRUN,
        base.lead_channel_width,
        base.lead_channel_depth + OVERRUN,
    )
    return [pocket, bore, vent, channel]


def defined_by_note(design: Design, point: Point) -> str:
    """What defines faces beside the dimensions: slots of the clamps by detail X, pockets 2 and 3 as pocket 1."""
    x, y, z = point
    base = design.base
    reach = max(base.clamp_reach + base.clamp_slot_width, base.pocket_diameter / 2 + base.clamp_floor_slot)
    for number, (px, py) in enumerate(Derived(design).actuator_places, start=1):
        if math.hypot(x - px, y - py) < reach + base.clamp_relief_hole and z > -base.height + TOLERANCE:
            return "detail X and section A-A, as pocket 1" if number > 1 else "detail X"
        if number > 1 and abs(y - py) < base.set_screw_access and z < -base.pocket_depth:
            return "note: as pocket 1"
    return ""


def datums(design: Design) -> dict[str, Datum]:
    """Seats of the ways, pockets, pin bores, springs, clamp screws and tooth bars."""
    base, way = design.base, design.bearing_way
    across = (base.way_gap + way.width) / 2
    found = [
        Datum("top", (0.0, 0.0, 0.0), Z),
        Datum("bearing_way_left", (0.0, across, 0.0), Z, (-1.0, 0.0, 0.0)),
        Datum("bearing_way_right", (0.0, -across, 0.0), Z),
    ]
    for k, (x, y) in enumerate(Derived(design).actuator_places, start=1):
        side = (reach_side(k), 0.0, 0.0)
        found += [
            Datum(f"pocket_{k}", (x, y, 0.0), Z),
            Datum(f"pin_1_bore_{k}", (x, y, -base.pin_1_axis_depth), side, Z),
            Datum(f"pin_2_bore_{k}", (x, y, -base.pocket_depth), Z, side),
            Datum(f"lead_clip_{k}", _clip_place(design, y, side[0]), Z, side),
            Datum(f"spring_{k}", (x - side[0] * base.pin_1_bore_end, y, -base.pin_1_axis_depth), side, Z),
        ]
    found += clamp_datums(design)
    if Derived(design).end_stops:
        x = base.bracket_spacing_along / 2
        ends = enumerate((x, -x), start=1)
        found += [Datum(f"stop_bar_{i}", (x, 0.0, -base.seat_height), Z, (x / abs(x), 0.0, 0.0)) for i, x in ends]
    if design.teeth.fitted:
        sides = {"left": design.teeth.bar_spacing / 2, "right": -design.teeth.bar_spacing / 2}
        found += [Datum(f"tooth_bar_{name}", (0.0, y, -base.seat_height), Z, X) for name, y in sides.items()]
    return named(*found)


def _clip_place(design: Design, y: float, side: float) -> Point:
    """Middle of the floor under a lead clip, at the outer end of a lead channel."""
    base = design.base
    x = base.length / 2 - base.edge_chamfer - design.lead_clip.length / 2
    return (side * x, y, -base.seat_height - base.lead_channel_depth)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Seats of the ways in one plane, with the flatness required of them once bolted on; pockets upright on it."""
    f, base = FaceRequirements(design), design.base
    seats = tuple((0.0, side * (base.width / 2 - 3), 0.0) for side in (1, -1))
    f.datum("A", seats, Z, "front")
    f.tolerance("flatness", "seats", "bearing.way_straightness", seats, Z, "front", combined=True)
    f.texture("seats", "bearing.way_roughness", seats, Z, "front", "lapped")
    _bore_requirements(f, design)
    _hole_positions(f, design)
    return tuple(f)


def _bore_requirements(f: FaceRequirements, design: Design) -> None:
    """Middle planes as datums, pockets upright and in place, and the guide of pin 1."""
    base, places = design.base, Derived(design).actuator_places
    x, y, low = base.length / 2, base.width / 2, -base.height / 2
    f.datum("B", ((x / 2, y, low), (x / 2, -y, low)), Y, "top", median=True)
    f.datum("C", ((x, y / 2, low), (-x, y / 2, low)), X, "top", median=True)
    pockets = tuple((px, py, -base.pocket_depth / 2) for px, py in places)
    common = {"round": True, "feature": "pocket"}
    axes = (pockets, Z, "top")
    f.tolerance("perpendicularity", "pocket", "drawing.tolerance_x_xx", *axes, datums=("A",), **common)
    f.tolerance("position", "pocket", "drawing.function_position", *axes, datums=("A", "B", "C"), **common)
    walls = tuple((px - base.pocket_diameter / 2, py, pz) for px, py, pz in pockets)
    f.texture("pocket", "drawing.fit_roughness", walls, X, "top", feature="pocket")
    guide = (-base.pin_1_bore_end / 2, 0.0, -base.pin_1_axis_depth)
    wall = (guide[0], 0.0, guide[2] - base.pin_1_bore / 2)
    thread = ((base.set_screw_thread_start + base.set_screw_thread_end) / 2, 0.0, -base.pin_1_axis_depth)
    f.datum("D", (guide,), X, "section", round=True)
    f.tolerance("straightness", "bore of height pin 1", "drawing.tolerance_x_xx", (guide,), X, "section", round=True)
    deep = (-base.pocket_depth - base.pin_1_axis_depth) / 2 + base.pin_1_bore / 4
    upright = ((-base.pin_2_bore / 2, 0.0, deep),)
    f.texture("bore of height pin 2", "drawing.fit_roughness", upright, X, "section", "reamed")
    f.texture("bore of height pin 1", "bearing.way_roughness", (wall,), Z, "section", "reamed")
    name, of_guide = "set screw thread", {"datums": ("D",), "round": True, "feature": "set screw thread"}
    f.tolerance("coaxiality", name, "drawing.function_position", (thread,), X, "section", **of_guide)


def _hole_positions(f: FaceRequirements, design: Design) -> None:
    """Position tolerances of the holes in the top face."""
    base, derived = design.base, Derived(design)
    lift = corners(base.lift_spacing_along, base.lift_spacing_across)
    bracket = corners(base.bracket_spacing_along, base.bracket_spacing_across)
    pins = corners(base.setting_pin_spacing, base.way_gap - base.setting_pin_hole)
    patterns = {
        "way hole": (derived.way_hole_places, base.way_drill_depth),
        "setting-pin hole": (pins, base.setting_pin_depth),
        "lifting hole": (lift, base.lift_drill_depth),
        "bracket hole": (bracket, base.bracket_drill_depth),
    }
    if design.teeth.fitted:
        patterns["tooth bar hole"] = (derived.bar_hole_places, base.bar_drill_depth)
    for name, (places, depth) in patterns.items():
        key = "drawing.function_position" if name.startswith("setting") else "drawing.hole_position"
        points = tuple((x, y, -depth / 2) for x, y in places)
        f.tolerance("position", name, key, points, Z, "top", datums=("A", "B", "C"), round=True, feature=name)
    wall = tuple((x - base.setting_pin_hole / 2, y, -base.setting_pin_depth / 2) for x, y in pins)
    f.texture("setting-pin hole", "drawing.fit_roughness", wall, X, "top", feature="setting-pin hole")
