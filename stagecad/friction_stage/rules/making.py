"""Rules of manufacture and assembly: reach of cutters and drills, access of hex keys."""

from collections.abc import Iterator
from dataclasses import dataclass

from stagecad.parameters.design import Design
from stagecad.parameters.rules import ROUNDING, length, rule

_ON_BOTH_SIDES = (
    ("stage.edge_chamfer", ("stage.thickness",)),
    ("stage.corner_radius", ("stage.length", "stage.width")),
    ("bearing_way.edge_chamfer", ("bearing_way.ledge_width", "bearing_way.flange_thickness")),
    ("base.edge_chamfer", ("base.height",)),
    ("tip.edge_chamfer", ("tip.arm_thickness", "tip.arm_width")),
    ("holder.edge_chamfer", ("holder.height",)),
    ("height_pin_1.end_chamfer", ("height_pin_1.length", "height_pin_1.spigot_length", "height_pin_1.spigot_diameter")),
    ("height_pin_2.end_chamfer", ("height_pin_2.length", "height_pin_2.diameter")),
    ("tooth_bar.edge_chamfer", ("tooth_bar.end_height",)),
    ("tooth_iron.edge_chamfer", ("tooth_iron.height",)),
    ("tooth_iron.corner_radius", ("tooth_iron.length",)),
    ("magnet.edge_chamfer", ("magnet.length", "magnet.thickness", "magnet.height")),
)
"""Chamfers and radii cut from both ends of a length."""

_SMALLER = (
    ("stage.edge_chamfer", "stage.corner_radius"),
    ("tooth_iron.edge_chamfer", "tooth_iron.corner_radius"),
    ("pads.corner_radius", "pads.width"),
    ("tip.cone_diameter", "tip.hub_diameter"),
)
"""Pairs of which the first is smaller."""


@rule
def edges(d: Design) -> Iterator[str]:
    """Between two chamfers or radii of one face something is left of it."""
    for cut, faces in _ON_BOTH_SIDES:
        for face in faces:
            if 2.0 * d.value(cut) >= d.value(face) - ROUNDING:
                yield f"<{cut}> at both ends leaves nothing of <{face}>"
    for small, large in _SMALLER:
        if d.value(small) >= d.value(large) - ROUNDING:
            yield f"<{small}> is not smaller than <{large}>"
    if 2.0 * d.tooth_iron.corner_radius >= d.derived.iron_width - ROUNDING:
        yield (
            f"<tooth_iron.corner_radius> does not go into an iron of {length(d.derived.iron_width)} "
            "(<teeth.per_iron, teeth.pitch>)"
        )


@rule
def turned_edges(d: Design) -> Iterator[str]:
    """Turned parts keep their shoulders, crowns and walls."""
    pin, crowned, h, wall = d.height_pin_1, d.height_pin_2, d.holder, d.making.least_wall
    if 2.0 * pin.end_chamfer >= pin.diameter - pin.spigot_diameter - ROUNDING:
        yield (
            "<height_pin_1.end_chamfer> leaves no shoulder between "
            "<height_pin_1.diameter, height_pin_1.spigot_diameter>"
        )
    if 2.0 * crowned.crown_radius <= crowned.diameter + ROUNDING:
        yield (
            "<height_pin_2.crown_radius> is too small for a crown on <height_pin_2.diameter>; it must be more than "
            f"{length(crowned.diameter / 2)}"
        )
    most = min(h.height - h.floor, (h.diameter - h.well_diameter) / 2 - wall)
    if h.index_depth > most + ROUNDING:
        yield "<holder.index_depth> cuts through <holder.height, holder.well_diameter>"
    if h.edge_chamfer >= h.diameter / 2 - d.derived.piezo_circle - h.bore_diameter / 2 - ROUNDING:
        yield "<holder.edge_chamfer> reaches the bores of <holder.bore_diameter>"
    if d.tip.hub_diameter / 2 >= d.derived.piezo_circle - d.tip.foot_diameter / 2 - ROUNDING:
        yield "<tip.hub_diameter> reaches the feet of the tip (<actuator.piezo_spacing, tip.foot_diameter>)"


@rule
def grooves(d: Design) -> Iterator[str]:
    """The grooves beside the drive surface leave a plate."""
    if d.sea.groove_depth + d.making.least_wall > d.stage.thickness + ROUNDING:
        yield "<sea.groove_depth> leaves too little of <stage.thickness>"


SLOT, BORE = "making.slot_depth_ratio", "making.bore_depth_ratio"


@dataclass(frozen=True)
class Reach:
    """A feature that a tool has to reach the end of."""

    name: str  # for messages
    size: str  # key of the tool's diameter: width of a slot, diameter of a bore; twice a corner's radius
    depth: float  # to be reached, mm
    limit: str  # key of the greatest depth over the diameter
    factor: float = 1.0  # diameter of the tool over the value of `size`


def reaches(d: Design) -> list[Reach]:
    """The deep slots, pockets and bores of the machine."""
    base, holder = d.base, d.holder
    bore = base.length / 2 + base.pin_1_bore_end
    found = [
        Reach("a lead slot of the holder", "holder.lead_slot_width", holder.height - holder.floor, SLOT),
        Reach("a lead channel of the base", "base.lead_channel_width", base.lead_channel_depth, SLOT),
        Reach("the pocket in the stage", "stage.iron_pocket_corner", d.stage.iron_pocket_depth, SLOT, 2.0),
        Reach("the bore of height pin 1", "base.pin_1_bore", bore, BORE),
        Reach("the vent of the bore", "base.vent_hole", base.height - base.pin_1_axis_depth, BORE),
        Reach("the ejector hole of the holder", "holder.ejector_hole", holder.floor, BORE),
    ]
    if not d.sea.whole_underside:
        found.append(Reach("a groove of the drive surface", "sea.groove_width", d.sea.groove_depth, SLOT))
    return [one for one in found if d.teeth.fitted or "pocket" not in one.name]


@rule
def key_access(d: Design) -> Iterator[str]:
    """A hex key reaches every screw of ways and tooth bars from above; the stage may be moved along its travel."""
    stage, screws = d.stage, d.screws
    row = d.base.width / 2 - d.bearing_way.bolt_edge - screws.way.head_diameter / 2
    if stage.width / 2 > row + ROUNDING:
        yield f"<stage.width> covers the way screws: no key reaches them; it must be at most {length(2 * row)}"
    if d.teeth.fitted:
        end = d.tooth_bar.screw_span / 2 - screws.bar.head_diameter / 2
        if (stage.length - stage.travel) / 2 > end + ROUNDING:
            yield (
                "<stage.length> covers the screws of the tooth bars: no key reaches them; it must be at most "
                f"{length(2 * end + stage.travel)}"
            )


_TAPPED = ("stage", "base", "holder", "stop_bar")
"""Parts with tapped holes."""


@rule
def threads_in_metal(d: Design) -> Iterator[str]:
    """No thread is tapped into a ceramic or a glass."""
    for part in _TAPPED:
        if d.material(f"{part}.material").strength_kind == "fracture":
            yield (
                f"<{part}.material> is brittle, and no holes are tapped in it; choose a metal, as its threads hold "
                "screws"
            )


@rule
def tool_reach(d: Design) -> Iterator[str]:
    """A cutter or drill is not so long for its diameter that it bends or breaks."""
    for one in reaches(d):
        tool, most = d.value(one.size) * one.factor, d.value(one.limit)
        if one.depth > most * tool + ROUNDING:
            yield (
                f"{one.name} cannot be cut: it is {length(one.depth)} deep with <{one.size}>, and <{one.limit}>; "
                f"{one.size} would be right at {length(one.depth / most / one.factor)}"
            )
