"""The dimensions of the base by feature: block, way holes, pockets, height bores, clamps, holes for attachments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stagecad.friction_stage.parameters.derived import Derived, Place, corners, full_clamp_thread
from stagecad.friction_stage.parts.base_clamp import Clamp, clamps
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, X, Y, Z

if TYPE_CHECKING:
    from stagecad.friction_stage.design import Design


def base_dimensions(design: Design) -> tuple[Dimension, ...]:
    """All dimensions of the base, in the order of its drawing."""
    d, (first, _, second, _) = DimensionDeclarations(design, "base"), clamps(design)
    _block(d, design)
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


def _block(d: DimensionDeclarations, design: Design) -> None:
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
    d.remark(
        "set screw thread ends", ("base.set_screw_thread_start",), thread[1], "over the length shown", feature=feature
    )
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
    angle = math.radians(clamp.neck)
    out, hole = _radial(angle), (*clamp.relief_hole(design), low)
    z = -base.clamp_screw_depth / 2
    neck = _along(out, radius, z), _along(out, radius + base.clamp_neck, z)
    all_four.linear("clamp neck", "clamp_neck", *neck, out)
    all_four.diameter("clamp relief hole", "clamp_relief_hole", hole, on=_radial(angle, -1.0), note="through")
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
