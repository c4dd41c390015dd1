"""Rules for the sliding parts: pads on the ways, drive surface over the tip, holes of the stage, ways, way screws."""

import math
from collections.abc import Iterator

from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, length, rule, screw_length

DRILL_POINT = 1 / math.tan(math.radians(59.0))
"""Height of a twist drill's point over its radius (118 degrees)."""


@rule
def pad_proportion(d: Design) -> Iterator[str]:
    """Pads are 2 : 1."""
    pads = d.pads
    if abs(pads.length / pads.width / pads.ratio - 1.0) > pads.ratio_deviation + ROUNDING:
        yield (
            f"<pads.length, pads.width> make {pads.length / pads.width:.3g} : 1, but pads must be {pads.ratio:g} : 1; "
            f"make pads.width {length(pads.length / pads.ratio)} or pads.length {length(pads.width * pads.ratio)}"
        )


@rule
def pads_under_stage(d: Design) -> Iterator[str]:
    """Pads lie within the stage, and apart from each other."""
    pads, stage, wall = d.pads, d.stage, d.making.least_wall
    across = pads.spacing_across / 2 + pads.width / 2 + wall
    if across > stage.width / 2 + ROUNDING:
        yield (
            "<pads.spacing_across, pads.width> put the pads over the edge of a stage of <stage.width>; it must be at "
            f"least {length(2 * across)}"
        )
    along = pads.spacing_along / 2 + pads.length / 2 + wall
    if along > stage.length / 2 + ROUNDING:
        yield (
            "<pads.spacing_along, pads.length> put the pads over the end of a stage of <stage.length>; it must be at "
            f"least {length(2 * along)}"
        )
    if pads.spacing_along < pads.length + wall - ROUNDING:
        yield (
            f"<pads.spacing_along> leaves no gap between pads of <pads.length>; at least {length(pads.length + wall)} "
            "is needed"
        )


@rule
def pads_on_way(d: Design) -> Iterator[str]:
    """Pads stay on the ways' running faces at both ends of the travel."""
    pads, way, travel = d.pads, d.bearing_way, d.stage.travel
    needed = pads.spacing_along + pads.length + travel + 2 * way.edge_chamfer
    if needed > way.length + ROUNDING:
        yield (
            "at the ends of <stage.travel> the pads run off the way: <pads.spacing_along> and <pads.length> need a "
            f"bearing_way.length of {length(needed)}, but it is {length(way.length)}; the travel may be "
            f"{length(max(travel - needed + way.length, 0.0))}"
        )
    sideways = travel / 2 if d.actuator.fitted > 1 else 0.0
    inner, outer = d.base.way_gap / 2, d.base.way_gap / 2 + way.width - way.ledge_width
    low = pads.spacing_across / 2 - pads.width / 2 - sideways
    high = pads.spacing_across / 2 + pads.width / 2 + sideways
    if low < inner + way.edge_chamfer - ROUNDING or high > outer - way.edge_chamfer + ROUNDING:
        reach = " over the travel of the second axis" if sideways else ""
        yield (
            f"<pads.spacing_across, pads.width> make the pads run from {length(low)} to {length(high)} off the "
            f"middle{reach}, but the way's running face goes from {length(inner + way.edge_chamfer)} to "
            f"{length(outer - way.edge_chamfer)} (<base.way_gap, bearing_way.width>, <bearing_way.ledge_width>)"
        )


@rule
def drive_surface_over_tip(d: Design) -> Iterator[str]:
    """The drive surface covers every fitted tip at both ends of the travel."""
    stage, margin, nose = d.stage, d.sea.contact_margin, d.tip.nose_diameter / 2
    two_axes = d.actuator.fitted > 1
    for number, (x, y) in enumerate(d.derived.fitted_places, start=1):
        along = 2 * (abs(x) + stage.travel / 2 + margin)
        if along > stage.length + ROUNDING:
            yield (
                f"at the ends of <stage.travel> the tip of actuator {number} leaves the drive surface: <stage.length> "
                f"must be at least {length(along)}, with <sea.contact_margin>"
            )
        across = 2 * (abs(y) + nose + (stage.travel / 2 if two_axes else 0.0))
        if across > d.derived.drive_surface_width + ROUNDING:
            if two_axes and not d.sea.whole_underside:
                yield (
                    f"the tip of actuator {number} lies outside <sea.width>; with <actuator.fitted> set "
                    "sea.whole_underside = true"
                )
            else:
                key = "stage.width" if d.sea.whole_underside else "sea.width"
                yield (
                    f"<{key}> is too narrow for the tip of actuator {number} with <tip.nose_diameter>; it must be at "
                    f"least {length(across)}"
                )


@rule
def drive_surface_clear_of_pads(d: Design) -> Iterator[str]:
    """The strip of the drive surface and its grooves end before the pads begin."""
    if d.sea.whole_underside:
        return
    sea, pads = d.sea, d.pads
    edge = sea.width / 2 + sea.groove_width
    free = pads.spacing_across / 2 - pads.width / 2 - pads.root_fillet
    if edge > free + ROUNDING:
        yield (
            "<sea.width, sea.groove_width> reach the pads; the drive surface may be "
            f"{length(max(2 * (free - sea.groove_width), 0.0))} wide with <pads.spacing_across>"
        )


@rule
def crown_of_pads(d: Design) -> Iterator[str]:
    """The crown's sag stays within the pad's height and exceeds its tolerance; the pad's corners are within it."""
    pads = d.pads
    half = math.hypot(pads.length, pads.width) / 2
    sag = pads.crown_radius - math.sqrt(max(pads.crown_radius**2 - half**2, 0.0))
    if pads.crown_radius <= half or sag + pads.root_fillet > pads.height + ROUNDING:
        yield (
            f"<pads.crown_radius> falls away by {length(sag)} over the pad, more than <pads.height> less its root "
            "fillet; make the radius larger"
        )
    rise = pads.crown_radius - math.sqrt(max(pads.crown_radius**2 - pads.length**2 / 4, 0.0))
    if rise <= pads.sag_tolerance:
        most = (pads.length**2 / 4 + pads.sag_tolerance**2) / (2 * pads.sag_tolerance)
        yield (
            f"<pads.crown_radius> rises by {1e3 * rise:.2g} um over <pads.length>, not more than <pads.sag_tolerance>: "
            f"a pad may be hollow; make the radius less than {length(most)}"
        )
    if 2 * pads.corner_radius >= pads.width:
        yield "<pads.corner_radius> is half or more of <pads.width>"


@rule
def stage_holes(d: Design) -> Iterator[str]:
    """The stage's holes lie within it, clear of each other, and end above the drive surface."""
    stage, wall = d.stage, d.making.least_wall
    tap = d.threads.m6_tap_drill
    for count, size in (("stage.payload_columns", "stage.length"), ("stage.payload_rows", "stage.width")):
        needed = (d.value(count) - 1) * stage.payload_pitch + tap + 2 * wall
        if needed > d.value(size) + ROUNDING:
            yield (
                f"<{count}, stage.payload_pitch> put payload holes over the edge of <{size}>; it must be at least "
                f"{length(needed)}"
            )
    if stage.payload_pitch < tap + wall - ROUNDING:
        yield "<stage.payload_pitch> lets the payload holes run together"
    point = stage.payload_drill_depth + tap / 2 * DRILL_POINT
    if point > stage.thickness - d.making.least_floor + ROUNDING:
        yield (
            f"<stage.payload_drill_depth> and the drill's point reach {length(point)} deep, and would break through to "
            "the drive surface: <stage.thickness> less <making.least_floor> is left; make stage.payload_floor larger "
            "or the plate thicker"
        )
    reach = stage.dowel_spacing / 2 + stage.dowel_diameter / 2 + wall
    if (
        reach > stage.length / 2 + ROUNDING
        or stage.dowel_offset + stage.dowel_diameter / 2 + wall > stage.width / 2 + ROUNDING
    ):
        yield (
            "<stage.dowel_spacing, stage.dowel_offset> put the dowel holes over the edge of <stage.length, stage.width>"
        )
    target = d.threads.m4_tap_drill
    if target + 2 * wall > stage.thickness + ROUNDING:
        yield (
            "<stage.thickness> is too thin for the target holes in its end faces; at least "
            f"{length(target + 2 * wall)} is needed"
        )
    if (
        stage.target_spacing + target + 2 * wall > stage.width + ROUNDING
        or stage.target_spacing < target + wall - ROUNDING
    ):
        yield "<stage.target_spacing> does not fit the end face of <stage.width>"
    for x, y in d.derived.payload_places:
        apart = math.hypot(abs(x) - stage.dowel_spacing / 2, y - stage.dowel_offset)
        gap = apart - tap / 2 - stage.dowel_diameter / 2
        if gap < wall - ROUNDING:
            yield (
                "a dowel hole (<stage.dowel_spacing, stage.dowel_offset>) meets a payload hole "
                f"(<stage.payload_pitch>); move it by {length(wall - gap)} or more"
            )
            return


@rule
def ways_on_base(d: Design) -> Iterator[str]:
    """The full underside of the ways is on the base."""
    way, base = d.bearing_way, d.base
    if way.length > base.length + ROUNDING:
        yield "<bearing_way.length> is longer than <base.length>"
    needed = base.way_gap + 2 * way.width
    if needed > base.width + ROUNDING:
        yield f"<base.width> is too narrow for two ways: <base.way_gap, bearing_way.width> need {length(needed)}"


@rule
def way_ledge(d: Design) -> Iterator[str]:
    """Screw heads sit on the ledge, clear of its root, of the edge, and of each other."""
    way, head = d.bearing_way, d.screws.way.head_diameter
    if way.flange_thickness >= way.height:
        yield "<bearing_way.flange_thickness> leaves no ledge in <bearing_way.height>"
    elif way.height - way.flange_thickness <= way.ledge_fillet + way.edge_chamfer:
        yield (
            f"<bearing_way.height, bearing_way.flange_thickness> leave {length(way.height - way.flange_thickness)} of "
            "ledge, too little for <bearing_way.ledge_fillet, bearing_way.edge_chamfer>"
        )
    if way.ledge_width >= way.width:
        yield "<bearing_way.ledge_width> leaves no running face on <bearing_way.width>"
    if way.bolt_edge < head / 2 + way.edge_chamfer - ROUNDING:
        yield (
            f"<bearing_way.bolt_edge> lets the heads of {length(head)} overhang the way's outer edge; at least "
            f"{length(head / 2 + way.edge_chamfer)} is needed"
        )
    room = way.ledge_width - way.bolt_edge - way.ledge_fillet
    if room < head / 2 - ROUNDING:
        yield (
            f"<bearing_way.ledge_width, bearing_way.bolt_edge> leave {length(room)} between screw and ledge root, but "
            f"a head of <screws.way.head_diameter> needs {length(head / 2)}"
        )
    if way.bolt_hole <= d.screws.way.diameter:
        yield "<bearing_way.bolt_hole> does not let <screws.way.diameter> through"
    if way.bolt_spacing < head + d.making.least_wall - ROUNDING:
        yield (
            f"<bearing_way.bolt_spacing> lets the screw heads of {length(head)} touch; at least "
            f"{length(head + d.making.least_wall)} is needed"
        )
    margin = d.derived.way_screw_end_margin
    if margin < way.bolt_end - ROUNDING:
        yield (
            f"<bearing_way.bolt_count, bearing_way.bolt_spacing> leave {length(margin)} of ceramic beyond the last "
            "screw of <bearing_way.length>; <bearing_way.bolt_end> is required"
        )
    clear = d.base.way_gap / 2 + way.width - way.ledge_width
    top = way.flange_thickness + d.screws.way.head_height
    if d.stage.width / 2 > clear and top > d.derived.drive_surface_height - ROUNDING:
        yield (
            f"the heads of the way screws are {length(top)} high and enter a stage of <stage.width> that reaches over "
            f"them; make bearing_way.flange_thickness smaller or the stage narrower than {length(2 * clear)}"
        )


@rule
def way_screws(d: Design) -> Iterator[str]:
    """Way screws are long enough, and shorter than their holes."""
    where = "through <bearing_way.flange_thickness>"
    yield from screw_length(d, "screws.way", d.derived.way_screw_engagement, "base.way_thread_depth", where)
