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
from typing import TYPE_CHECKING

from stagecad.friction_stage.parameters.derived import Derived, Place, corners
from stagecad.friction_stage.parts.base_clamp import clamp_cutters, clamp_datums
from stagecad.friction_stage.parts.base_dimensions import base_dimensions
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement, Point
from stagecad.solids.modelling.dimensioning import FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, repeated, stepped_hole
from stagecad.solids.modelling.primitives import cut_all, edges_where, plate

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.friction_stage.design import Design

NAME = "base"

SYMMETRIC = "xy"
"""Axes whose middle plane is a plane of symmetry."""
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
        "Depths of holes, pockets and channels from the face they start in.",
    )


def build(design: Design) -> cq.Solid:
    """The base as one solid, mm."""
    base, threads = design.base, design.threads
    block, low = _block(design), -base.seat_height
    cutters: list[cq.Shape] = []

    def tapped(drill: float, depth: float, places: Sequence[Place], z: float, *, up: bool = False) -> None:
        hole = stepped_hole(
            (0, 0, z), (0, 0, 1 if up else -1), [(drill, depth)], mouth_chamfer=base.hole_chamfer, drill_point=True
        )
        cutters.extend(repeated(hole, [(x, y, 0.0) for x, y in places]))

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

    pin = stepped_hole(
        (0, 0, low), (0, 0, -1), [(base.setting_pin_hole, base.setting_pin_depth)], mouth_chamfer=base.hole_chamfer
    )
    edge = base.way_gap - base.setting_pin_hole
    cutters += repeated(pin, [(x, y, 0.0) for x, y in corners(base.setting_pin_spacing, edge)])

    for number, (x, y) in enumerate(Derived(design).actuator_places, start=1):
        cutters += _pocket(design, number, x, y)
    return cut_all(block, [*cutters, *clamp_cutters(design)])


def _block(design: Design) -> cq.Solid:
    """Block with a raised seat along either side, its outer edges chamfered."""
    base = design.base
    body = plate((0.0, 0.0, 0.0), base.length, base.width, -base.height)
    gap = 2 * Derived(design).seat_edge
    body = cut_all(
        body, [plate((0.0, 0.0, -base.seat_height), base.length + 2 * OVERRUN, gap, base.seat_height + OVERRUN)]
    )

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
    pocket = stepped_hole(
        (x, y, low),
        (0, 0, -1),
        [(base.pocket_diameter, base.pocket_bore), (base.pin_2_bore, base.pin_1_axis_depth + low)],
        mouth_chamfer=base.pocket_chamfer,
    )
    bore = stepped_hole(
        (face, y, -base.pin_1_axis_depth),
        (-side, 0, 0),
        [
            (base.set_screw_access, to_axis - base.set_screw_thread_start),
            (design.threads.unc_1_tap_drill, to_axis - base.set_screw_thread_end),
            (base.pin_1_bore, to_axis + base.pin_1_bore_end),
        ],
        mouth_chamfer=base.hole_chamfer,
    )
    vent_at = x - side * (base.pin_1_bore_end - base.vent_hole)
    vent = stepped_hole(
        (vent_at, y, -base.height),
        (0, 0, 1),
        [(base.vent_hole, base.height - base.pin_1_axis_depth)],
        mouth_chamfer=base.hole_chamfer,
    )
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


def material(design: Design) -> str:
    """Name of its material."""
    return design.base.material


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
        half = design.teeth.bar_spacing / 2
        found += [
            Datum(f"tooth_bar_{name}", (0.0, y, -base.seat_height), Z, X)
            for name, y in (("left", half), ("right", -half))
        ]
    return named(*found)


def _clip_place(design: Design, y: float, side: float) -> Point:
    """Middle of the floor under a lead clip, at the outer end of a lead channel."""
    base = design.base
    x = base.length / 2 - base.edge_chamfer - design.lead_clip.length / 2
    return (side * x, y, -base.seat_height - base.lead_channel_depth)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the base."""
    return base_dimensions(design)


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
    guide = (-base.pin_1_bore_end / 2, 0.0, -base.pin_1_axis_depth)
    wall = (guide[0], 0.0, guide[2] - base.pin_1_bore / 2)
    thread = ((base.set_screw_thread_start + base.set_screw_thread_end) / 2, 0.0, -base.pin_1_axis_depth)
    f.datum("D", (guide,), X, "section", round=True)
    straight = ("straightness", "bore of height pin 1", "drawing.tolerance_x_xx", (guide,), X, "section")
    f.tolerance(*straight, round=True)
    f.texture("bore of height pin 1", "bearing.way_roughness", (wall,), Z, "section", "reamed")
    f.tolerance(
        "coaxiality",
        "set screw thread",
        "drawing.function_position",
        (thread,),
        X,
        "section",
        datums=("D",),
        round=True,
        feature="set screw thread",
    )


def _hole_positions(f: FaceRequirements, design: Design) -> None:
    """Position tolerances of the holes in the top face."""
    base, derived = design.base, Derived(design)
    lift, bracket = (
        corners(base.lift_spacing_along, base.lift_spacing_across),
        corners(base.bracket_spacing_along, base.bracket_spacing_across),
    )
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
