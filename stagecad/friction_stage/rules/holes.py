"""Rules for the holes of the base: edge distance, walls between holes, lengths of screws.

Every hole is a cylinder, upright or along the travel; the wall between two holes has a least thickness.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

from stagecad.friction_stage.parameters.derived import corners, full_clamp_thread
from stagecad.friction_stage.rules.sliding import DRILL_POINT
from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, given, length, rule, screw_length
from stagecad.parameters.threads import BOTTOMING_TAP


@dataclass(frozen=True)
class Hole:
    """A hole as a straight cylinder, mm, base coordinates."""

    name: str  # for messages
    keys: tuple[str, ...]  # parameters that place it
    # start, end: ends of its axis; equal in x and y for an upright hole, in y and z for one along the travel
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float  # of the cylinder
    own: int = 0  # pocket whose mechanism it belongs to; holes of one mechanism may intersect

    @property
    def upright(self) -> bool:
        return self.start[2] != self.end[2]


def _upright(
    name: str, keys: tuple[str, ...], at: tuple[float, float], drill: float, depth: float, mouth: float = 0.0
) -> Hole:
    """A hole from a face of the top of the base at the height `mouth`."""
    return Hole(name, keys, (*at, mouth), (*at, mouth - depth), drill / 2)


def _tapped(
    name: str, keys: tuple[str, ...], at: tuple[float, float], drill: float, depth: float, mouth: float = 0.0
) -> Hole:
    return _upright(name, keys, at, drill, depth + drill / 2 * DRILL_POINT, mouth)


def base_holes(d: Design) -> list[Hole]:
    """Every hole of the base."""
    base, t, derived, low = d.base, d.threads, d.derived, -d.base.seat_height
    holes: list[Hole] = []
    for at in derived.way_screw_places:
        keys = ("bearing_way.bolt_edge", "bearing_way.bolt_spacing")
        holes.append(_tapped("a way screw's hole", keys, at, t.unc_3_8_tap_drill, base.way_drill_depth))
    for at in corners(base.lift_spacing_along, base.lift_spacing_across):
        keys = ("base.lift_spacing_along", "base.lift_spacing_across")
        holes.append(_tapped("a lifting hole", keys, at, t.m10_tap_drill, base.lift_drill_depth))
    for at in corners(base.bracket_spacing_along, base.bracket_spacing_across):
        keys = ("base.bracket_spacing_along", "base.bracket_spacing_across")
        holes.append(_tapped("a bracket hole", keys, at, t.m6_tap_drill, base.bracket_drill_depth, low))
    for at in corners(base.setting_pin_spacing, base.way_gap - base.setting_pin_hole):
        keys = ("base.setting_pin_spacing", "base.setting_pin_hole")
        holes.append(_upright("a setting-pin hole", keys, at, base.setting_pin_hole, base.setting_pin_depth, low))
    if d.teeth.fitted:
        bar, across = d.tooth_bar, d.teeth.bar_spacing / 2
        for x, y in corners(bar.screw_span, bar.screw_spacing):
            for side in (-1, 1):
                keys = ("tooth_bar.screw_span", "tooth_bar.screw_spacing", "teeth.bar_spacing")
                at = (x, side * across + y)
                holes.append(_tapped("a tooth bar's hole", keys, at, t.m5_tap_drill, base.bar_drill_depth, low))
    along, across = base.foot_spacing_along / 2, base.foot_spacing_across / 2
    for x, y in ((-along, 0.0), (along, -across), (along, across)):
        point = base.foot_drill_depth + t.m10_tap_drill / 2 * DRILL_POINT
        keys = ("base.foot_spacing_along", "base.foot_spacing_across")
        holes.append(Hole("a foot hole", keys, (x, y, -base.height), (x, y, point - base.height), t.m10_tap_drill / 2))
    return [*holes, *_mechanisms(d)]


def _mechanisms(d: Design) -> list[Hole]:
    """Pockets, height screws' bores, clamp screws, lead channels (as round ones)."""
    base = d.base
    holes: list[Hole] = []
    for number, (x, y) in enumerate(d.derived.actuator_places, start=1):
        side = 1.0 if number == 1 else -1.0
        face = side * base.length / 2
        name = f"pocket {number}"
        pocket = _upright(name, ("base.actuator_spacing",), (x, y), base.pocket_diameter, base.pocket_depth)
        holes.append(replace(pocket, own=number))
        z = -base.pin_1_axis_depth
        inner, thread = x - side * base.pin_1_bore_end, x + side * base.set_screw_thread_start
        name = f"the bore of height pin 1 of pocket {number}"
        keys = ("base.pin_1_axis_depth", "base.pin_1_bore_end")
        bore = max(base.pin_1_bore, d.threads.unc_1_tap_drill)
        holes.append(Hole(name, keys, (inner, y, z), (thread, y, z), bore / 2, number))
        name, keys = f"the set screw's access to pocket {number}", ("base.pin_1_axis_depth", "base.set_screw_access")
        holes.append(Hole(name, keys, (thread, y, z), (face, y, z), base.set_screw_access / 2, number))
        channel = base.lead_channel_width / 2
        z = -max(base.lead_channel_depth - channel, 0.0) - base.seat_height
        name = f"the lead channel of pocket {number}"
        holes.append(Hole(name, ("base.lead_channel_width",), (x, y, z), (face, y, z), channel, number))
        offsets = {1: (1.0, -1.0), 2: (1.0,), 3: (-1.0,)}[number]
        slot = x + base.clamp_slot_1 if number == 1 else x + base.clamp_slot_2
        end = slot - side * (base.clamp_slot_width / 2 + base.clamp_thread_depth)
        for offset in offsets:
            at = (y + offset * base.clamp_screw_offset, -base.clamp_screw_depth)
            keys = ("base.clamp_screw_offset", "base.clamp_screw_depth")
            name = f"the clamp screw's hole of pocket {number}"
            holes.append(Hole(name, keys, (end, *at), (face, *at), base.clamp_hole / 2))
            head = face - side * base.clamp_counterbore_depth
            holes.append(Hole(name, keys, (head, *at), (face, *at), base.clamp_counterbore / 2))
    return holes


def _gap(a: Hole, b: Hole) -> float:
    """Thickness of the material between two holes, mm; negative where they intersect."""
    spans = zip(a.start, a.end, b.start, b.end)
    steps = [max(min(p, q) - max(r, s), min(r, s) - max(p, q), 0.0) for p, q, r, s in spans]
    if a.upright and b.upright:
        return max(math.hypot(steps[0], steps[1]) - a.radius - b.radius, steps[2])
    if a.upright or b.upright:
        upright, level = (a, b) if a.upright else (b, a)
        top, bottom = max(upright.start[2], upright.end[2]), min(upright.start[2], upright.end[2])
        z = level.start[2]
        over = max(bottom - (z + level.radius), (z - level.radius) - top)
        across = steps[1] - a.radius - b.radius
        # Beyond the level hole's flat end, only the distance along the travel counts.
        return max(across, over, steps[0] - upright.radius)
    return max(math.hypot(steps[1], steps[2]) - a.radius - b.radius, steps[0])


@rule
def holes_apart(d: Design) -> Iterator[str]:
    """Holes of the base do not come too close to each other: pockets clear of screws, and bores of each other."""
    wall = d.making.least_wall
    for a, b, gap in _close_pairs(tuple(base_holes(d)), wall):
        how = f"leave {length(gap)} between them" if gap > 0 else "meet"
        keys = tuple(dict.fromkeys((*a.keys, *b.keys)))
        yield f"{a.name} and {b.name} {how}; {length(wall)} is needed: {given(d, *keys)}"


@lru_cache(maxsize=32)
def _close_pairs(holes: tuple[Hole, ...], wall: float) -> tuple[tuple[Hole, Hole, float], ...]:
    """Pairs of holes with less than a wall between them, mm, the first pair of each two names; with their gap."""
    found: dict[tuple[str, str], tuple[Hole, Hole, float]] = {}
    for a, b in combinations(holes, 2):
        stepped = not a.upright and not b.upright and a.start[1:] == b.start[1:] and a.name == b.name
        if (a.own and a.own == b.own) or stepped or (a.name, b.name) in found:
            continue
        gap = _gap(a, b)
        if gap < wall - ROUNDING:
            found[a.name, b.name] = (a, b, gap)
    return tuple(found.values())


@rule
def holes_in_base(d: Design) -> Iterator[str]:
    """Holes of the base keep their distance from its edges, and blind ones end inside it."""
    base, wall = d.base, d.making.least_wall
    half = (base.length / 2, base.width / 2)
    reported: set[str] = set()
    for hole in base_holes(d):
        if hole.name in reported:
            continue
        if hole.upright:
            reach = [abs(hole.start[axis]) + hole.radius + wall - half[axis] for axis in (0, 1)]
            over = max(reach)
            if hole.start[2] > -base.height and -hole.end[2] + wall > base.height + ROUNDING:
                reported.add(hole.name)
                yield f"{hole.name} goes {length(-hole.end[2])} deep, through <base.height>"
                continue
        else:
            inner = max(abs(hole.start[0]) + wall - half[0], 0.0) if abs(hole.start[0]) < half[0] + ROUNDING else wall
            over = max(
                inner,
                abs(hole.start[1]) + hole.radius + wall - half[1],
                -hole.start[2] + hole.radius + wall - base.height,
            )
        if over > ROUNDING:
            reported.add(hole.name)
            yield (
                f"{hole.name} comes too close to an edge of the base (<base.length, base.width, base.height>): "
                f"{length(over)} is missing of <making.least_wall>; {given(d, *hole.keys)}"
            )


@rule
def pockets_between_ways(d: Design) -> Iterator[str]:
    """The pockets do not reach under the ways."""
    base, wall = d.base, d.making.least_wall
    for number, (_, y) in enumerate(d.derived.actuator_places, start=1):
        free = base.way_gap / 2 - abs(y) - base.pocket_diameter / 2 - base.pocket_chamfer
        if free < wall - ROUNDING:
            yield (
                f"pocket {number} reaches under a way: <base.actuator_spacing, base.pocket_diameter> and "
                f"<base.way_gap> leave {length(free)}, and {length(wall)} is needed"
            )
            return


@rule
def holes_and_seats(d: Design) -> Iterator[str]:
    """Holes from the seats of the ways lie on them, the others beside them, with their chamfers."""
    edge, chamfer = d.derived.seat_edge, d.base.hole_chamfer
    reported: set[str] = set()
    for hole in base_holes(d):
        if not hole.upright or hole.own or hole.start[2] <= -d.base.height or hole.name in reported:
            continue
        on_seat = hole.start[2] == 0.0
        over = (edge - abs(hole.start[1]) if on_seat else abs(hole.start[1]) - edge) + hole.radius + chamfer
        if over >= -ROUNDING:
            reported.add(hole.name)
            yield (
                f"{hole.name} meets the edge of a seat of the ways, {length(edge)} off the middle "
                f"(<base.way_gap, base.seat_overhang>): move it by more than {length(over)}; "
                f"{given(d, *hole.keys, 'base.hole_chamfer')}"
            )


@rule
def height_bores(d: Design) -> Iterator[str]:
    """The bore of height pin 1 runs below the pockets' floors, and its thread begins inside the base."""
    base, wall = d.base, d.making.least_wall
    bore = max(base.pin_1_bore, d.threads.unc_1_tap_drill)
    floor = base.pin_1_axis_depth - bore / 2 - base.pocket_depth
    if floor < wall - ROUNDING:
        yield (
            f"<base.pocket_depth, base.pin_1_axis_depth, base.pin_1_bore> leave {length(floor)} of floor between "
            f"pocket and wedge pin; {length(wall)} is needed"
        )
    shortest = base.length / 2 - max(abs(x) for x, _ in d.derived.actuator_places)
    if base.set_screw_thread_start > shortest + ROUNDING:
        yield (
            f"<base.set_screw_thread_start> lies outside the base, whose side face is {length(shortest)} from "
            "actuators 2 and 3; make base.length larger"
        )
    if base.set_screw_thread_end >= base.set_screw_thread_start:
        yield "<base.set_screw_thread_end> is not inside of <base.set_screw_thread_start>"
    if base.vent_hole >= base.pin_1_bore:
        yield "<base.vent_hole> is wider than <base.pin_1_bore>"


@rule
def clamp_screws(d: Design) -> Iterator[str]:
    """Clamp screws reach their threads, and end inside them; heads sink into their counterbores."""
    base = d.base
    back = min(x for x, _ in d.derived.actuator_places)
    grips = (
        ("screws.clamp_long", "base.clamp_slot_1", base.length / 2 - base.clamp_slot_1),
        ("screws.clamp_short", "base.clamp_slot_2", base.length / 2 + back + base.clamp_slot_2),
    )
    for name, slot, to_slot in grips:
        screw = getattr(d.screws, name.split(".")[1])
        engaged = screw.length - (to_slot - base.clamp_counterbore_depth) - base.clamp_slot_width / 2
        where = f"beyond the slot (<base.length, {slot}, base.clamp_counterbore_depth>)"
        yield from screw_length(d, name, engaged, "base.clamp_thread_depth", where)
        if full_clamp_thread(d) < engaged <= base.clamp_thread_depth:
            yield (
                f"<{name}.length> jams: {where} it goes {length(engaged)} deep, but the thread is full for "
                f"{length(full_clamp_thread(d))} of <base.clamp_thread_depth>"
            )
        if screw.head_diameter >= base.clamp_counterbore:
            yield f"<{name}.head_diameter> does not go into <base.clamp_counterbore>"
        if screw.diameter >= base.clamp_hole:
            yield f"<{name}.diameter> does not go through <base.clamp_hole>"
        if screw.head_height > base.clamp_counterbore_depth:
            yield f"<{name}.head_height> projects from <base.clamp_counterbore_depth>"


@rule
def clamp_fingers(d: Design) -> Iterator[str]:
    """Clamp slots cut the pocket's wall, and leave lug, neck and screw their material."""
    base, wall = d.base, d.making.least_wall
    radius = base.pocket_diameter / 2
    for key in ("base.clamp_slot_1", "base.clamp_slot_2"):
        if d.value(key) + base.clamp_slot_width >= radius - base.clamp_floor_slot:
            yield f"<{key}> misses the pocket of <base.pocket_diameter>"
    distance = base.clamp_screw_offset - base.clamp_hole / 2 - radius
    if distance < wall - ROUNDING:
        yield (
            f"<base.clamp_screw_offset> leaves {length(distance)} between the clamp screw and the pocket; "
            f"{length(wall)} is needed"
        )
    beyond = base.clamp_reach - base.clamp_screw_offset - base.clamp_hole / 2
    if beyond < wall - ROUNDING:
        yield (
            "<base.clamp_reach> cuts the clamp screw's hole at <base.clamp_screw_offset>; at least "
            f"{length(base.clamp_reach + wall - beyond)} is needed"
        )
    drilled = base.clamp_slot_width / 2 + base.clamp_thread_depth + base.clamp_slot_width / 2
    if drilled + wall > base.clamp_lug + ROUNDING:
        yield (
            "<base.clamp_thread_depth> goes through <base.clamp_lug>; the lug must be at least "
            f"{length(drilled + wall)}"
        )
    if base.clamp_screw_depth - base.clamp_counterbore / 2 < wall - ROUNDING:
        yield "<base.clamp_screw_depth> lets <base.clamp_counterbore> break through the top"


@rule
def clamp_necks(d: Design) -> Iterator[str]:
    """A clamp's finger reaches from its slot past the lug to its neck, and stays clear of the pins' bores."""
    base, wall = d.base, d.making.least_wall
    radius = base.pocket_diameter / 2
    circle = radius + base.clamp_neck + base.clamp_relief_hole / 2
    floor = radius - base.clamp_floor_slot / 2
    for angle, key, slot in (
        ("base.clamp_neck_angle_1", "base.clamp_slot_1", base.clamp_slot_1),
        ("base.clamp_neck_angle_2", "base.clamp_slot_2", -base.clamp_slot_2),
    ):
        neck = math.radians(d.value(angle))
        if circle * math.cos(neck) > slot - base.clamp_lug + ROUNDING or abs(slot) >= floor:
            low = math.degrees(math.acos(max(-1.0, min(1.0, (slot - base.clamp_lug) / circle))))
            least = math.ceil(10 * low) / 10
            yield (
                f"<{angle}> puts the neck into the clamp's lug (<{key}, base.clamp_lug>); it must be at least "
                f"{least:g} deg"
            )
            continue
        corner = (floor * math.sin(neck) - base.clamp_floor_slot, floor * math.sin(math.acos(slot / floor)))
        bore = max(base.pin_1_bore, base.set_screw_access) / 2
        if corner[0] < base.pin_1_bore / 2 + wall or corner[1] - base.clamp_floor_slot / 2 < bore + wall:
            yield f"<{angle}, {key}> lead the clamp's floor slot into the bore of height pin 1"


TAPPED = {
    "base.way": "unc_3_8",
    "base.bar": "m5",
    "base.foot": "m10",
    "base.lift": "m10",
    "base.bracket": "m6",
    "height_pin_1.withdrawal": "m5",
    "holder.lift": "m4",
    "stage.payload": "m6",
    "stage.target": "m4",
    "stop_bar.sensor": "m5",
}
"""Blind threads, by the beginning of their keys."""


@rule
def thread_depths(d: Design) -> Iterator[str]:
    """A bottoming tap reaches the end of every thread before that of its hole."""
    for name, thread in TAPPED.items():
        deepest = d.value(f"{name}_drill_depth") - BOTTOMING_TAP * d.value(f"threads.{thread}_pitch")
        drawn = d.derived.end_stops or not name.startswith("stop_bar")
        if drawn and d.value(f"{name}_thread_depth") > deepest + ROUNDING:
            yield (
                f"<{name}_thread_depth> is deeper than <{name}_drill_depth> less {BOTTOMING_TAP:g} pitches for the "
                f"tap, {length(deepest)}"
            )
