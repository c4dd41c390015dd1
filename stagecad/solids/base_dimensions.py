"""The dimensions of the base, by feature: block, ways, pockets, height bores, clamps, and what is bolted on."""

from __future__ import annotations

import math
from typing import Any

from stagecad.solids.base_clamp import Clamp, clamps
from stagecad.solids.base_places import bar_hole_places, pocket_centres, way_hole_places
from stagecad.solids.declare import Declarations, X, Y, Z
from stagecad.solids.holes import corners

DOWN = (0.0, 0.0, -1.0)


def declare_base(d: Declarations, design: Any) -> None:
    """All dimensions of the base, in the order of its drawing."""
    _block(d, design)
    _ways(d, design)
    _pockets(d, design)
    _height_bores(d, design)
    _clamp_screws(d, design)
    first, _, second, _ = clamps(design)
    _clamp_slots(d, design, first)
    _other_clamp(d, design, second)
    _attachments(d, design)


def _block(d: Declarations, design: Any) -> None:
    base = design.base
    x, y, low = base.length / 2, base.width / 2, -base.height
    d.linear("length", "base.length", (-x, 0, low / 10), (x, 0, low / 10), view="top")
    d.linear("width", "base.width", (0, -y, low / 2), (0, y, low / 2), view="top")
    d.linear("height", "base.height", (x - 3, y - 3, low), (x - 3, y - 3, 0), view="front")
    c = base.edge_chamfer / 2
    d.chamfer("edge chamfer", "base.edge_chamfer", (0, y - c, -c), note="all outer edges", view="front")


def _ways(d: Declarations, design: Any) -> None:
    base = design.base
    places = way_hole_places(design)
    (x, y), (x2, _) = places[:2]
    d.tapped(
        "way hole",
        "unc_3_8",
        (x, y, 0.0),
        DOWN,
        thread_depth="base.way_thread_depth",
        drill_depth="base.way_drill_depth",
        count=len(places),
    )
    d.counted(
        "way holes in a row", "bearing_way.bolt_count", (x, y, 0), X, feature="way hole", view="top", note="2 rows"
    )
    d.linear("way hole spacing", "bearing_way.bolt_spacing", (x, y, 0), (x2, y, 0), count=len(places) - 2, view="top")
    d.linear(
        "way hole row to side",
        "bearing_way.bolt_edge",
        (x, base.width / 2, -base.height / 2),
        (x, y, 0),
        Y,
        count=2,
        view="top",
    )
    c = base.hole_chamfer / 2
    d.chamfer(
        "hole chamfer",
        "base.hole_chamfer",
        (x + design.threads.unc_3_8_tap_drill / 2 + c, y, -c),
        note="mouths of all screw, pin, vent and side bores",
        view="top",
    )
    far, gap, hole = base.setting_pin_spacing / 2, base.way_gap / 2, base.setting_pin_hole
    axis, deep = gap - hole / 2, -base.setting_pin_depth
    d.linear(
        "way gap",
        "base.way_gap",
        (far, -gap, deep / 2),
        (far, gap, deep / 2),
        view="top",
        note="over the setting-pin holes",
    )
    pin = "setting-pin hole"
    d.diameter(pin, "base.setting_pin_hole", (far, axis, deep / 2), feature=pin, count=4, note="reamed", view="top")
    d.depth(
        "setting-pin hole depth",
        "base.setting_pin_depth",
        (far, axis, 0),
        (far, axis, deep),
        feature=pin,
        count=4,
        view="top",
    )
    d.linear("setting-pin spacing", "base.setting_pin_spacing", (-far, axis, 0), (far, axis, 0), count=2, view="top")


def _pockets(d: Declarations, design: Any) -> None:
    base = design.base
    _, (x, y), (_, y3) = pocket_centres(design)
    radius, floor = base.pocket_diameter / 2, -base.pocket_depth
    pocket = "pocket"
    d.diameter(
        "pocket",
        "base.pocket_diameter",
        (0, 0, floor / 2),
        on=(-1.0, 0.0, 0.0),
        feature=pocket,
        count=3,
        view="top",
        note="sliding fit of the holder",
    )
    d.depth(
        "pocket depth", "base.pocket_depth", (0, 0, 0), (0, radius / 2, floor), Z, feature=pocket, count=3, view="top"
    )
    d.linear(
        "pocket spacing",
        "base.actuator_spacing",
        (x, y3, 0),
        (x, y, 0),
        view="top",
        note="3 pockets on an equilateral triangle",
    )
    c = base.pocket_chamfer / 2
    d.chamfer("pocket chamfer", "base.pocket_chamfer", (-(radius + c), 0, -c), count=3, view="top")
    half, deep, out = base.lead_channel_width / 2, -base.lead_channel_depth, base.length / 2 - 20
    channel = "lead channel"
    d.linear(
        "lead channel width",
        "base.lead_channel_width",
        (out, -half, deep / 2),
        (out, half, deep / 2),
        count=3,
        view="right",
        feature=channel,
    )
    d.depth(
        "lead channel depth",
        "base.lead_channel_depth",
        (out, 0, 0),
        (out, 0, deep),
        count=3,
        view="right",
        feature=channel,
    )


def _height_bores(d: Declarations, design: Any) -> None:
    base = design.base
    deep, floor = -base.pin_1_axis_depth, -base.pocket_depth
    d.diameter(
        "pin 2 bore",
        "base.pin_2_bore",
        (0, 0, (floor + deep) / 2 + base.pin_1_bore / 4),
        on=Y,
        count=3,
        view="section",
        note="sliding fit of height pin 2",
    )
    d.linear(
        "pin 1 axis depth",
        "base.pin_1_axis_depth",
        (base.length / 2 - 3, base.width / 2 - 3, 0),
        (-20, 0, deep),
        Z,
        count=3,
        view="section",
    )
    start, end, out = base.set_screw_thread_start, base.set_screw_thread_end, base.length / 2
    bore = "pin 1 bore"
    d.diameter(
        bore,
        "base.pin_1_bore",
        (-base.pin_1_bore_end / 2, 0, deep),
        X,
        on=Z,
        feature=bore,
        count=3,
        view="section",
        note="sliding fit of height pin 1",
    )
    d.linear(
        "pin 1 bore end",
        "base.pin_1_bore_end",
        (0, 0, floor / 2),
        (-base.pin_1_bore_end, 0, deep),
        X,
        count=3,
        view="section",
    )
    middle = (start + end) / 2
    drill = design.threads.unc_1_tap_drill / 2
    d.add(
        "tap_drill",
        "set screw thread",
        "threads.unc_1_tap_drill",
        ((middle, 0, deep), (middle, 0, deep - drill)),
        X,
        note="1-8 UNC",
        count=3,
        view="section",
    )
    d.linear(
        "set screw thread start",
        "base.set_screw_thread_start",
        (0, 0, floor / 2),
        (start, 0, deep),
        X,
        count=3,
        view="section",
    )
    d.linear(
        "set screw thread end",
        "base.set_screw_thread_end",
        (0, 0, floor / 2),
        (end, 0, deep),
        X,
        count=3,
        view="section",
    )
    d.diameter(
        "set screw access", "base.set_screw_access", ((start + out) / 2, 0, deep), X, on=Z, count=3, view="section"
    )
    vent = -(base.pin_1_bore_end - base.vent_hole)
    d.diameter(
        "vent",
        "base.vent_hole",
        (vent, 0, -base.height + 5),
        on=X,
        count=3,
        view="section",
        note="from the underside into the bore",
    )
    low = -base.height + 5
    d.derived(
        "vent to the bore's end",
        base.vent_hole,
        ("base.pin_1_bore_end", "base.vent_hole"),
        (-base.pin_1_bore_end, 0, deep),
        (vent, 0, low),
        X,
        count=3,
        view="section",
    )


def _clamp_screws(d: Declarations, design: Any) -> None:
    base, (clamp, *_) = design.base, clamps(design)
    face, y, z = base.length / 2, base.clamp_screw_offset, -base.clamp_screw_depth
    count = len(clamps(design))
    hole, seat = "clamp screw hole", face - base.clamp_counterbore_depth
    d.linear(
        "clamp screw depth",
        "base.clamp_screw_depth",
        (face - 3, base.width / 2 - 3, 0),
        (face, y, z),
        Z,
        count=count,
        view="right",
    )
    d.linear("clamp screw offset", "base.clamp_screw_offset", (0, 0, z), (face, y, z), Y, count=count, view="right")
    d.diameter(
        "clamp counterbore",
        "base.clamp_counterbore",
        ((face + seat) / 2, y, z),
        X,
        on=Z,
        feature=hole,
        count=count,
        view="right",
    )
    d.depth(
        "clamp counterbore depth",
        "base.clamp_counterbore_depth",
        (face, y, z),
        (seat, y, z),
        feature=hole,
        count=count,
        view="right",
    )
    d.diameter(
        "clamp clearance hole",
        "base.clamp_hole",
        (face - 50, y, z),
        X,
        on=Z,
        feature=hole,
        count=count,
        view="right",
        note="to the gap slot",
    )
    wall = clamp.slot - base.clamp_slot_width / 2
    d.depth(
        "clamp thread hole depth",
        "base.clamp_thread_depth",
        (wall, y, z),
        (wall - base.clamp_thread_depth, y, z),
        feature=hole,
        count=count,
        view="section",
        note="3/8-16 UNC in the lug, from the slot",
    )


def _clamp_slots(d: Declarations, design: Any, clamp: Clamp) -> None:
    base, low = design.base, -base_middle(design)
    slot, reach, radius = clamp.slot, base.clamp_reach, base.pocket_diameter / 2
    half = base.clamp_slot_width / 2
    y = (base.clamp_screw_offset + radius) / 2
    d.linear(
        "clamp slot width",
        "base.clamp_slot_width",
        (slot - half, y, low),
        (slot + half, y, low),
        view="top",
        note="through the whole depth, all clamps",
    )
    d.linear("clamp slot 1", "base.clamp_slot_1", (0, 0, low / 4), (slot, reach, low), X, count=2, view="top")
    d.linear("clamp reach", "base.clamp_reach", (0, 0, low / 4), (slot, reach, low), Y, count=4, view="top")
    d.linear(
        "clamp lug", "base.clamp_lug", (slot, reach, low), (slot - base.clamp_lug, reach, low), count=4, view="top"
    )
    angle = math.radians(clamp.neck)
    out = (math.cos(angle), math.sin(angle), 0.0)
    hole = clamp.relief_hole(design)
    d.linear(
        "clamp neck",
        "base.clamp_neck",
        _at(radius, out, -base.clamp_screw_depth / 2),
        _at(radius + base.clamp_neck, out, -base.clamp_screw_depth / 2),
        out,
        count=4,
        view="top",
    )
    d.diameter(
        "clamp relief hole",
        "base.clamp_relief_hole",
        (hole[0], hole[1], low),
        on=(-out[0], -out[1], 0.0),
        count=4,
        view="top",
        note="through",
    )
    d.angle(
        "clamp neck angle 1",
        "base.clamp_neck_angle_1",
        (0, 0, low / 4),
        (hole[0], hole[1], low),
        X,
        count=2,
        view="top",
    )
    middle = (clamp.start_angle(radius) + angle) / 2
    out, inner = (math.cos(middle), math.sin(middle), 0.0), radius - base.clamp_floor_slot
    below = -(base.pocket_depth + base.height) / 2
    d.linear(
        "clamp floor slot",
        "base.clamp_floor_slot",
        _at(inner, out, below),
        _at(radius, out, below),
        out,
        count=4,
        view="top",
        note="through the pocket's floor, along its wall, from gap slot to neck angle",
    )


def _other_clamp(d: Declarations, design: Any, clamp: Clamp) -> None:
    """What differs at pockets 2 and 3."""
    low = -base_middle(design)
    (x, y), hole = clamp.centre, clamp.relief_hole(design)
    corner = clamp.place(clamp.slot, design.base.clamp_reach)
    d.linear("clamp slot 2", "base.clamp_slot_2", (x, y, low / 4), (*corner, low), X, count=2, view="top")
    d.angle(
        "clamp neck angle 2",
        "base.clamp_neck_angle_2",
        (x, y, low / 4),
        (*hole, low),
        (clamp.head, 0.0, 0.0),
        count=2,
        view="top",
    )


def _attachments(d: Declarations, design: Any) -> None:
    base = design.base
    _pattern(d, "lifting hole", "m10", "base.lift", corners(base.lift_spacing_along, base.lift_spacing_across))
    _pattern(d, "bracket hole", "m6", "base.bracket", corners(base.bracket_spacing_along, base.bracket_spacing_across))
    x, y, low = base.foot_spacing_along / 2, base.foot_spacing_across / 2, -base.height
    d.tapped(
        "foot hole",
        "m10",
        (x, y, low),
        Z,
        thread_depth="base.foot_thread_depth",
        drill_depth="base.foot_drill_depth",
        shows_drill=False,
        view="bottom",
        count=3,
    )
    d.linear("foot spacing along", "base.foot_spacing_along", (-x, 0, low), (x, y, low), X, view="bottom")
    d.linear("foot spacing across", "base.foot_spacing_across", (x, -y, low), (x, y, low), view="bottom")
    if not design.teeth.fitted:
        return
    bar, places = design.tooth_bar, bar_hole_places(design)
    span, spacing, apart = bar.screw_span / 2, bar.screw_spacing / 2, design.teeth.bar_spacing / 2
    low, high = apart - spacing, apart + spacing
    d.tapped(
        "tooth bar hole",
        "m5",
        (span, high, 0.0),
        DOWN,
        thread_depth="base.bar_thread_depth",
        drill_depth="base.bar_drill_depth",
        count=len(places),
    )
    d.linear("tooth bar hole span", "tooth_bar.screw_span", (-span, high, 0), (span, high, 0), view="top")
    d.linear("tooth bar hole spacing", "tooth_bar.screw_spacing", (span, low, 0), (span, high, 0), count=4, view="top")
    d.linear(
        "tooth bar spacing",
        "teeth.bar_spacing",
        (span, -high, 0),
        (span, low, 0),
        view="top",
        note="between like holes of both bars",
    )


def _pattern(d: Declarations, feature: str, thread: str, keys: str, places: list[tuple[float, float]]) -> None:
    """Four tapped holes in the top, with their spacings."""
    (x1, y1), (_, y2), (x2, _) = places[:3]
    d.tapped(
        feature,
        thread,
        (x1, y1, 0.0),
        DOWN,
        thread_depth=f"{keys}_thread_depth",
        drill_depth=f"{keys}_drill_depth",
        count=len(places),
    )
    d.linear(f"{feature} spacing along", f"{keys}_spacing_along", (x1, y1, 0), (x2, y1, 0), view="top")
    d.linear(f"{feature} spacing across", f"{keys}_spacing_across", (x1, y1, 0), (x1, y2, 0), view="top")


def base_middle(design: Any) -> float:
    """Half the base's height, mm: a depth at which slots are and bores are not."""
    return design.base.height / 2


def _at(radius: float, out: tuple[float, float, float], z: float) -> tuple[float, float, float]:
    """The point at a radius from the first pocket's axis, mm."""
    return (radius * out[0], radius * out[1], z)
