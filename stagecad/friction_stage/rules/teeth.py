"""Rules for magnets and teeth: pockets, gap, and overlap over the whole travel."""

from collections.abc import Iterator

from stagecad.friction_stage.rules.sliding import DRILL_POINT
from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, length, rule, screw_length


@rule
def teeth_for_one_axis(d: Design) -> Iterator[str]:
    """Teeth hold the stage to one axis."""
    if not d.teeth.fitted:
        return
    if d.actuator.fitted > 1:
        yield (
            "<actuator.fitted, teeth.fitted>: teeth constrain the stage to one axis; set teeth.fitted = false and "
            "preload by gravity"
        )
    if d.sea.whole_underside:
        yield (
            "<sea.whole_underside, teeth.fitted>: the irons' pockets interrupt the drive surface; set teeth.fitted = "
            "false"
        )


@rule
def tooth_shape(d: Design) -> Iterator[str]:
    """Teeth are narrower than their pitch, and grooves leave iron behind them."""
    if not d.teeth.fitted:
        return
    teeth = d.teeth
    if teeth.width >= teeth.pitch:
        yield "<teeth.width> leaves no groove in <teeth.pitch>"
    for key in ("tooth_iron.height", "tooth_bar.height"):
        back = d.value(key) - teeth.groove_depth
        if back < d.making.least_wall - ROUNDING:
            yield (
                f"<teeth.groove_depth> leaves {length(back)} of <{key}> behind the teeth; "
                f"{length(d.making.least_wall)} is needed"
            )


@rule
def tooth_gap(d: Design) -> Iterator[str]:
    """The gap between stage and bar is as specified, also below the magnet."""
    if not d.teeth.fitted:
        return
    roof = d.derived.drive_surface_height + d.stage.iron_pocket_depth + d.base.seat_height
    crest = roof - d.tooth_iron.height
    gap = crest - d.tooth_bar.height
    if abs(gap - d.teeth.gap) > ROUNDING:
        yield (
            f"<tooth_bar.height> leaves a gap of {length(gap)} under the irons, but <teeth.gap>; it would be right at "
            f"{length(crest - d.teeth.gap)}"
        )
    magnet = roof - d.magnet.height
    if magnet - d.tooth_bar.height < d.teeth.gap - ROUNDING:
        yield "<magnet.height> hangs lower than the irons' teeth (<tooth_iron.height>)"


@rule
def iron_pockets(d: Design) -> Iterator[str]:
    """Irons and magnet fit their pocket at the limits of their tolerances; the pocket fits the stage, clear of drive
    surface, pads and holes."""
    if not d.teeth.fitted:
        return
    stage, wall = d.stage, d.making.least_wall
    shortest, narrowest = (
        d.value(key) + d.deviations(key)[0] for key in ("stage.iron_pocket_length", "stage.iron_pocket_width")
    )
    for key in ("tooth_iron.length", "magnet.length"):
        longest = d.value(key) + d.deviations(key)[1]
        if longest >= shortest:
            yield (
                f"<{key}>, at most {length(longest)}, does not go into <stage.iron_pocket_length>, at least "
                f"{length(shortest)}"
            )
    # An iron has the class of the pitch.
    filled = 2 * (d.derived.iron_width + d.deviations("teeth.pitch")[1])
    filled += d.magnet.thickness + d.deviations("magnet.thickness")[1]
    if filled >= narrowest:
        yield (
            f"two irons and a magnet take {length(filled)} at most (<teeth.per_iron, teeth.pitch, magnet.thickness>), "
            f"and do not go into <stage.iron_pocket_width>, at least {length(narrowest)}"
        )
    if stage.iron_pocket_corner >= d.tooth_iron.corner_radius:
        yield (
            "<tooth_iron.corner_radius> does not fit a pocket with <stage.iron_pocket_corner>; the iron's corner "
            "radius must be larger"
        )
    if stage.iron_pocket_depth + wall > stage.thickness + ROUNDING:
        yield "<stage.iron_pocket_depth> leaves too little of <stage.thickness>"
    middle, half = d.teeth.bar_spacing / 2, stage.iron_pocket_width / 2
    edge = d.sea.width / 2 + d.sea.groove_width
    if middle - half < edge + wall - ROUNDING:
        yield (
            "<teeth.bar_spacing> puts the irons' pockets into the drive surface of <sea.width>; it must be at least "
            f"{length(2 * (edge + wall + half))}"
        )
    pads = d.pads.spacing_across / 2 - d.pads.width / 2 - d.pads.root_fillet
    if middle + half > pads - wall + ROUNDING:
        yield (
            f"<teeth.bar_spacing> puts the irons' pockets under the pads; it may be {length(2 * (pads - wall - half))} "
            "at <pads.spacing_across>"
        )
    yield from _pocket_and_holes(d)


def _pocket_and_holes(d: Design) -> Iterator[str]:
    stage, wall, tap = d.stage, d.making.least_wall, d.threads.m6_tap_drill
    left = stage.thickness - stage.iron_pocket_depth - stage.payload_drill_depth - tap / 2 * DRILL_POINT
    if left >= d.making.least_floor - ROUNDING:
        return
    middle = d.teeth.bar_spacing / 2
    for x, y in d.derived.payload_places:
        along = abs(x) - stage.iron_pocket_length / 2 - tap / 2
        across = abs(y - middle) - stage.iron_pocket_width / 2 - tap / 2
        if max(along, across) < wall - ROUNDING:
            yield (
                "a payload hole (<stage.payload_pitch>) breaks into an iron pocket "
                f"(<stage.iron_pocket_length, teeth.bar_spacing>); move it by {length(wall - max(along, across))} or "
                "more"
            )
            return


@rule
def bars(d: Design) -> Iterator[str]:
    """The bars lie between the ways, clear of the tip, and under the irons over the whole travel."""
    if not d.teeth.fitted:
        return
    bar, base, wall = d.tooth_bar, d.base, d.making.least_wall
    toothed = bar.length - 2 * bar.end_length
    needed = d.tooth_iron.length + d.stage.travel
    if toothed < needed - ROUNDING:
        yield (
            f"<tooth_bar.length, tooth_bar.end_length> leave {length(toothed)} of teeth, but the irons of "
            f"<tooth_iron.length> need {length(needed)} over <stage.travel>"
        )
    if bar.length > base.length + ROUNDING:
        yield "<tooth_bar.length> is longer than <base.length>"
    width = max(bar.foot_width, 2 * d.derived.iron_width + d.magnet.thickness)
    outer = d.teeth.bar_spacing / 2 + width / 2
    if outer + wall > base.way_gap / 2 + ROUNDING:
        yield (
            "<teeth.bar_spacing, tooth_bar.foot_width> put the bars against the ways; base.way_gap must be at least "
            f"{length(2 * (outer + wall))}"
        )
    reach = d.derived.piezo_circle + d.tip.foot_diameter / 2
    inner = d.teeth.bar_spacing / 2 - d.derived.iron_width - d.magnet.thickness / 2
    if inner < reach + wall - ROUNDING:
        yield (
            f"<teeth.bar_spacing> puts the bars into the tip, whose foot reaches {length(reach)} "
            "(<actuator.piezo_spacing, tip.foot_diameter>)"
        )
    engaged, where = d.screws.bar.length - bar.end_height, "through <tooth_bar.end_height>"
    yield from screw_length(d, "screws.bar", engaged, "base.bar_thread_depth", where)
    if bar.screw_hole <= d.screws.bar.diameter:
        yield "<tooth_bar.screw_hole> does not let <screws.bar.diameter> through"
    if bar.end_height + d.screws.bar.head_height > d.derived.drive_surface_height + base.seat_height - ROUNDING:
        yield "the heads of the bars' screws on <tooth_bar.end_height> meet the stage"
    if bar.end_height >= bar.height:
        yield "<tooth_bar.end_height> is no lower than <tooth_bar.height>"
    deepest = max(bar.channel_depth, d.teeth.groove_depth)
    if bar.height - deepest <= max(bar.end_height + bar.root_fillet, bar.relief + wall):
        yield (
            "<tooth_bar.height> leaves no bar between its feet of <tooth_bar.end_height> and a channel or groove "
            f"{length(deepest)} deep"
        )
    if bar.channel_depth <= d.teeth.groove_depth:
        yield "<tooth_bar.channel_depth> is no deeper than <teeth.groove_depth>"
    foot, place, screw = bar.length / 2 - bar.end_length, bar.screw_span / 2, d.screws.bar
    if place - screw.head_diameter / 2 < foot + bar.root_fillet or place + bar.screw_hole / 2 + wall > bar.length / 2:
        low = 2 * (foot + bar.root_fillet) + screw.head_diameter
        high = bar.length - bar.screw_hole - 2 * wall
        yield (
            "<tooth_bar.screw_span> does not put the screws on the feet; with "
            f"<tooth_bar.length, tooth_bar.end_length> it must lie from {length(low)} to {length(high)}"
        )
    if bar.screw_spacing + bar.screw_hole + 2 * wall > bar.foot_width + ROUNDING:
        yield (
            "<tooth_bar.screw_spacing> puts the screws off the feet; with <tooth_bar.foot_width> it must be at most "
            f"{length(bar.foot_width - bar.screw_hole - 2 * wall)}"
        )
