"""The dimensions of what holds an actuator in the base: bores of the height adjustment, clamping screws and slots."""

from __future__ import annotations

import math
from typing import Any

from stagecad.solids.modelling.dimensioning import Declarations, X, Y, Z
from stagecad.solids.parts.base_clamp import Clamp, clamps

DOWN = (0.0, 0.0, -1.0)


def declare_clamps(d: Declarations, design: Any) -> None:
    """Dimensions of the bores, screws and slots, in the order of the base's drawing."""
    _height_bores(d, design)
    _clamp_screws(d, design)
    first, _, second, _ = clamps(design)
    _clamp_slots(d, design, first)
    _other_clamp(d, design, second)


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


def _at(radius: float, out: tuple[float, float, float], z: float) -> tuple[float, float, float]:
    """The point at a radius from the first pocket's axis, mm."""
    return (radius * out[0], radius * out[1], z)


def base_middle(design: Any) -> float:
    """Half the base's height, mm: a depth at which slots are and bores are not."""
    return design.base.height / 2
