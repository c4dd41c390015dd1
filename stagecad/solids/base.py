"""The base: an Invar block that houses the actuators, carries the bearing ways, and takes every adjustment.

Part coordinates: origin on the top face at actuator 1, x along the travel, y across it, z up: the assembly frame. The
block is symmetric about y = 0, as thermal stability asks.

Features and what each is for
- Block: flat lapped top, on which the ways are bedded; chamfered edges.
- Way holes: two rows of blind tapped holes for the 3/8 inch screws of the ways, deep enough for their thread.
- Setting-pin holes: reamed holes along the inner edge of each way, for pins against which a way is pushed while its
  screws are tightened; the pins come out afterwards.
- Pockets: three bores for the piezo holders, on an equilateral triangle; only pocket 1 is fitted for one axis. The
  floor is clear of the holder, which stands on height pin 2 alone.
- Pin bores: a vertical guide for height pin 2 in each pocket's floor and, crossing it below, a horizontal bore for
  height pin 1, stepped down from the side face: access for the wrench, thread of the set screw, guide of the pin, flat
  end on which the spring rests. All from one face in one set-up; pin and spring pass through the thread. A vent from
  the underside lets the air out of its blind end.
- Clamps: see `base_clamp`.
- Lead channels: grooves in the top from each pocket to the side face its set screw is on, for the piezos' leads.
- Tooth bar holes, bracket holes: tapped, for the bars with the stationary teeth and for the sensors' brackets.
- Lifting holes in the top corners (the block weighs some 90 kg), and three foot holes in the underside: three feet
  carry the block without bending it.
"""
from __future__ import annotations

import math
from typing import Any

import cadquery as cq

from stagecad.solids.base_clamp import clamp_cutters, pocket_centres
from stagecad.solids.blocks import cut_all, plate
from stagecad.solids.holes import OVERRUN, repeated, stepped_hole

NAME = "base"

Place = tuple[float, float, float]


def reach_side(pocket: int) -> float:
    """The side face from which a pocket's height screw is reached: +1 for +x (pocket 1), -1 for -x (2 and 3)."""
    return 1.0 if pocket == 1 else -1.0


def way_hole_places(design: Any) -> list[tuple[float, float]]:
    """Places (x, y) of the tapped holes under the ways, mm: the left way's (y > 0) first, each by rising x."""
    way = design.bearing_way
    count = int(way.bolt_count)
    across = design.base.way_gap / 2 + way.width - way.bolt_edge
    return [((i - (count - 1) / 2) * way.bolt_spacing, side * across) for side in (1, -1) for i in range(count)]


def bar_hole_places(design: Any) -> list[tuple[float, float]]:
    """Places (x, y) of the tapped holes for the tooth bars' screws, mm."""
    bar = design.tooth_bar
    along = (bar.length - bar.end_length) / 2
    across = design.teeth.bar_spacing / 2
    return [
        (x, side * across + step)
        for side in (1, -1) for x in (-along, along) for step in (-bar.screw_spacing / 2, bar.screw_spacing / 2)
    ]


def corners(along: float, across: float) -> list[tuple[float, float]]:
    """The four points (x, y) of a rectangle about the origin."""
    return [(sx * along / 2, sy * across / 2) for sx in (-1, 1) for sy in (-1, 1)]


def build(design: Any) -> cq.Solid:
    """The base as one solid, mm."""
    base, threads = design.base, design.threads
    block = plate((0.0, 0.0, 0.0), base.length, base.width, -base.height)
    block = block.chamfer(base.edge_chamfer, None, block.Edges()).Solids()[0]
    cutters: list[cq.Shape] = []

    def tapped(drill: float, depth: float, places: list[tuple[float, float]], *, up: bool = False) -> None:
        z = -base.height if up else 0.0
        hole = stepped_hole((0, 0, z), (0, 0, 1 if up else -1), [(drill, depth)],
                            mouth_chamfer=base.hole_chamfer, drill_point=True)
        cutters.extend(repeated(hole, [(x, y, 0.0) for x, y in places]))

    tapped(threads.unc_3_8_tap_drill, base.way_drill_depth, way_hole_places(design))
    tapped(threads.m10_tap_drill, base.lift_drill_depth, corners(base.lift_spacing_along, base.lift_spacing_across))
    tapped(threads.m6_tap_drill, base.bracket_drill_depth,
           corners(base.bracket_spacing_along, base.bracket_spacing_across))
    along, across = base.foot_spacing_along / 2, base.foot_spacing_across / 2
    tapped(threads.m10_tap_drill, base.foot_drill_depth, [(-along, 0.0), (along, -across), (along, across)], up=True)
    if design.teeth.fitted:
        tapped(threads.m5_tap_drill, base.bar_drill_depth, bar_hole_places(design))

    pin = stepped_hole((0, 0, 0), (0, 0, -1), [(base.setting_pin_hole, base.setting_pin_depth)],
                       mouth_chamfer=base.hole_chamfer)
    edge = base.way_gap - base.setting_pin_hole
    cutters += repeated(pin, [(x, y, 0.0) for x, y in corners(base.setting_pin_spacing, edge)])

    for number, (x, y) in enumerate(pocket_centres(design), start=1):
        cutters += _pocket(design, number, x, y)
    return cut_all(block, [*cutters, *clamp_cutters(design)])


def _pocket(design: Any, number: int, x: float, y: float) -> list[cq.Shape]:
    """Cutters of one actuator pocket with its pin bores, vent and lead channel."""
    base = design.base
    side = reach_side(number)
    face = side * base.length / 2
    to_axis = abs(face - x)
    pocket = stepped_hole(
        (x, y, 0), (0, 0, -1),
        [(base.pocket_diameter, base.pocket_depth), (base.pin_2_bore, base.pin_1_axis_depth)],
        mouth_chamfer=base.pocket_chamfer,
    )
    bore = stepped_hole(
        (face, y, -base.pin_1_axis_depth), (-side, 0, 0),
        [
            (base.set_screw_access, to_axis - base.set_screw_thread_start),
            (design.threads.unc_1_tap_drill, to_axis - base.set_screw_thread_end),
            (base.pin_1_bore, to_axis + base.pin_1_bore_end),
        ],
        mouth_chamfer=base.hole_chamfer,
    )
    vent_at = x - side * (base.pin_1_bore_end - base.vent_hole)
    vent = stepped_hole((vent_at, y, -base.height), (0, 0, 1),
                        [(base.vent_hole, base.height - base.pin_1_axis_depth)], mouth_chamfer=base.hole_chamfer)
    channel = plate(((x + face + side * OVERRUN) / 2, y, -base.lead_channel_depth), to_axis + OVERRUN,
                    base.lead_channel_width, base.lead_channel_depth + OVERRUN)
    return [pocket, bore, vent, channel]
