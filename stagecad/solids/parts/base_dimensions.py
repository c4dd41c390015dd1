"""The dimensions of the base, by feature: block, ways, pockets, what is bolted on; its clamps have their own file."""

from __future__ import annotations

from typing import Any

from stagecad.solids.modelling.dimensioning import Declarations, X, Y, Z
from stagecad.solids.modelling.holes import corners
from stagecad.solids.parts.base_clamp_dimensions import declare_clamps
from stagecad.solids.parts.base_positions import bar_hole_places, pocket_centres, way_hole_places

DOWN = (0.0, 0.0, -1.0)


def declare_base(d: Declarations, design: Any) -> None:
    """All dimensions of the base, in the order of its drawing."""
    _block(d, design)
    _ways(d, design)
    _pockets(d, design)
    declare_clamps(d, design)
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
