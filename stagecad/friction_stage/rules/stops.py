"""Rules for end stops, sensor and lead clips: they pass clear of the stage, and fit on the base."""

from collections.abc import Iterator

from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, length, rule, screw_length

MM = 1e-3
CLEAR = 0.5
"""Least clearance of parts that pass each other, mm."""
PASSING = 0.2
"""Least clearance of the mirror over the stop bars, mm: their heights are toleranced by 0.1 each."""


@rule
def buffers(d: Design) -> Iterator[str]:
    """Buffers stand in pairs, meet the part of the irons that stands out, and are clear of stage and tooth bars."""
    if not d.derived.end_stops:
        return
    buffer, out = d.buffer, d.tooth_iron.height - d.stage.iron_pocket_depth
    if d.end_stop.count % 2:
        yield "<end_stop.count>: buffers stand in pairs beside the middle; 0, 2 or 4 at either end"
    top, low = (d.end_stop.height / MM + side * buffer.height / 2 for side in (1, -1))
    if -top < CLEAR - ROUNDING:
        yield (
            f"<end_stop.height, buffer.height> leave {length(-top)} between buffers and stage; {length(CLEAR)} is "
            "needed"
        )
    if -low > min(out, out + d.teeth.gap - CLEAR) + ROUNDING:
        yield (
            f"<end_stop.height, buffer.height> put the buffers below the irons, which stand out by {length(out)} "
            "(<tooth_iron.height, stage.iron_pocket_depth>)"
        )
    if buffer.width > d.derived.iron_width + ROUNDING:
        yield (
            f"<buffer.width> is wider than a tooth iron of {length(d.derived.iron_width)} "
            "(<teeth.per_iron, teeth.pitch>)"
        )


@rule
def stop_bars(d: Design) -> Iterator[str]:
    """Stop bars stand on the base beyond the tooth bars, and their nose passes over the screws of these."""
    if not d.derived.end_stops:
        return
    bar, base, wall, screw = d.stop_bar, d.base, d.making.least_wall, d.screws.stop
    axis = base.bracket_spacing_along / 2
    if axis - bar.foot < d.tooth_bar.length / 2 + CLEAR - ROUNDING:
        yield (
            "<stop_bar.foot, base.bracket_spacing_along> put the stop bars on the tooth bars of <tooth_bar.length>; "
            f"stop_bar.foot may be {length(axis - d.tooth_bar.length / 2 - CLEAR)}"
        )
    if axis + bar.overhang > base.length / 2 - base.edge_chamfer + ROUNDING:
        yield "<stop_bar.overhang, base.bracket_spacing_along> reach over the end of <base.length>"
    low = d.tooth_bar.end_height + d.screws.bar.head_height + CLEAR
    if bar.relief < low - ROUNDING:
        yield f"<stop_bar.relief> puts the nose on the screws of the tooth bars; at least {length(low)}"
    if bar.height - bar.relief < 2 * wall - ROUNDING:
        yield f"<stop_bar.height, stop_bar.relief> leave a nose of less than {length(2 * wall)}"
    if bar.reach < bar.foot + wall - ROUNDING:
        yield (
            "<stop_bar.reach, stop_bar.foot> leave no nose; the buffers have to be nearer to the middle "
            "(<base.bracket_spacing_along, stage.travel, buffer.length>)"
        )
    if min(bar.foot, bar.overhang, (bar.length - base.bracket_spacing_across) / 2) < bar.counterbore / 2 + wall:
        yield (
            "<stop_bar.counterbore> breaks through a side of the stop bar "
            "(<stop_bar.foot, stop_bar.overhang, stop_bar.length, base.bracket_spacing_across>)"
        )
    if bar.counterbore <= screw.head_diameter or bar.screw_hole <= screw.diameter:
        yield "<stop_bar.counterbore, stop_bar.screw_hole> do not let <screws.stop.part_number> in"
    if bar.height - bar.grip < screw.head_height - ROUNDING or bar.screw_hole >= bar.counterbore:
        yield "<stop_bar.grip, stop_bar.height> do not sink the heads of <screws.stop.head_height>"
    where = "under <stop_bar.grip>"
    yield from screw_length(d, "screws.stop", screw.length - bar.grip, "base.bracket_thread_depth", where)


@rule
def sensor(d: Design) -> Iterator[str]:
    """The sensor bracket is clear of stage and base, its screws hold, and the mirror covers the target holes."""
    if not d.derived.end_stops:
        return
    bar, bracket, optics, wall = d.stop_bar, d.sensor_bracket, d.interferometer, d.making.least_wall
    drill, head = d.threads.m5_tap_drill, d.screws.bar.head_diameter / 2
    if bar.sensor_depth < drill / 2 + wall - ROUNDING or bracket.rise > bar.sensor_depth + ROUNDING:
        yield "<stop_bar.sensor_depth, sensor_bracket.rise> bring thread or bracket over the stop bar"
    if bracket.rise < bracket.screw_hole / 2 + wall - ROUNDING or bracket.screw_hole <= d.screws.bar.diameter:
        yield "<sensor_bracket.rise, sensor_bracket.screw_hole> leave no wall over the screws"
    bottom = bar.height - bar.sensor_depth - bracket.drop - bracket.thickness
    if bracket.drop < head + CLEAR - ROUNDING or bottom < CLEAR - ROUNDING:
        yield (
            "<sensor_bracket.drop, sensor_bracket.thickness> put the arm on the screws or on the base: it has to be "
            f"{length(head + CLEAR)} below the screws, and is {length(bottom)} over the base"
        )
    if bar.sensor_spacing / 2 + head + CLEAR > bracket.width / 2 or bar.sensor_spacing < drill + wall:
        yield "<stop_bar.sensor_spacing> puts the screws off <sensor_bracket.width>"
    edge = (d.base.bracket_spacing_across - bar.counterbore - bar.sensor_spacing - drill) / 2
    if edge < wall - ROUNDING:
        yield "<stop_bar.sensor_spacing> does not fit the stop bar"
    if bar.sensor_drill_depth + drill > bar.overhang + bar.foot - wall:
        yield "<stop_bar.sensor_drill_depth> goes through the foot of the stop bar"
    engaged, where = d.screws.bar.length - bracket.flange, "through <sensor_bracket.flange>"
    yield from screw_length(d, "screws.bar", engaged, "stop_bar.sensor_thread_depth", where)
    front = d.derived.interferometer_front
    if front < bracket.flange + d.screws.bar.head_height + CLEAR or front + optics.length > bracket.length + ROUNDING:
        yield (
            f"<sensor_bracket.length> does not carry the interferometer, from {length(front)} to "
            f"{length(front + optics.length)} beyond the stop bar"
        )
    if (
        optics.screw_spacing + bracket.optics_hole + 2 * wall > optics.length
        or optics.screw_spacing < bracket.optics_hole + wall
    ):
        yield "<interferometer.screw_spacing> does not fit <interferometer.length>"
    if optics.beam_height > optics.height - wall:
        yield "<interferometer.beam_height, interferometer.height> put the beam over the optics"
    mirror, spacing = d.mirror, d.stage.target_spacing
    if mirror.width < spacing + mirror.screw_hole + 2 * wall - ROUNDING or mirror.height < mirror.screw_hole + 2 * wall:
        yield "<mirror.width, mirror.height> do not cover <stage.target_spacing>"
    below, room = (mirror.height - d.stage.thickness) / 2, -d.end_stop.height / MM - d.buffer.height / 2
    if below > room - PASSING + ROUNDING:
        yield (
            f"<mirror.height, stage.thickness> let the mirror hang {length(below)} below the stage; "
            f"{length(room - PASSING)} is free above the stop bars and their buffers"
        )


@rule
def lead_clips(d: Design) -> Iterator[str]:
    """The lead clips have walls beside and below their slot, and end within their channels."""
    clip, base = d.lead_clip, d.base
    side, floor = (base.lead_channel_width - clip.slot_width) / 2, base.lead_channel_depth - clip.slot_depth
    if min(side, floor) < CLEAR - ROUNDING:
        yield (
            f"<lead_clip.slot_width, lead_clip.slot_depth> leave {length(min(side, floor))} of a clip in "
            f"<base.lead_channel_width, base.lead_channel_depth>; {length(CLEAR)} is needed"
        )
    room = (
        base.length / 2
        - base.edge_chamfer
        - max(
            side * x + base.pocket_diameter / 2 + base.pocket_chamfer
            for side, (x, _) in zip((1.0, -1.0, -1.0), d.derived.actuator_places, strict=True)
        )
    )
    if clip.length > room + ROUNDING:
        yield f"<lead_clip.length> is longer than the lead channels of {length(room)}"
