"""Rules of manufacture and assembly: reach of cutters and drills, access of hex keys."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stagecad.parameters.rules.registry import ROUNDING, given, length, rule

if TYPE_CHECKING:
    from stagecad.parameters.design import Design


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
        yield (
            f"{given(d, 'stage.width')} covers the way screws: no key reaches them; it must be at most "
            f"{length(2 * row)}"
        )
    if d.teeth.fitted:
        end = d.tooth_bar.screw_span / 2 - screws.bar.head_diameter / 2
        if (stage.length - stage.travel) / 2 > end + ROUNDING:
            yield (
                f"{given(d, 'stage.length')} covers the screws of the tooth bars: no key reaches them; it must be at "
                f"most {length(2 * end + stage.travel)}"
            )


_TAPPED = ("stage", "base", "holder", "stop_bar")
"""Parts with tapped holes."""


@rule
def threads_in_metal(d: Design) -> Iterator[str]:
    """No thread is tapped into a ceramic or a glass."""
    for part in _TAPPED:
        if d.material(f"{part}.material").strength_kind == "fracture":
            yield (
                f"{given(d, f'{part}.material')} is brittle, and no holes are tapped in it; choose a metal, as its "
                "threads hold screws"
            )


@rule
def tool_reach(d: Design) -> Iterator[str]:
    """A cutter or drill is not so long for its diameter that it bends or breaks."""
    for one in reaches(d):
        tool, most = d.value(one.size) * one.factor, d.value(one.limit)
        if one.depth > most * tool + ROUNDING:
            yield (
                f"{one.name} cannot be cut: it is {length(one.depth)} deep with {given(d, one.size)}, and "
                f"{given(d, one.limit)}; {one.size} would be right at {length(one.depth / most / one.factor)}"
            )
