"""Rules for edges: chamfers and radii are smaller than the faces they are cut from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from stagecad.parameters.rules.registry import ROUNDING, given, length, rule

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

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
                yield f"{given(d, cut)} at both ends leaves nothing of {given(d, face)}"
    for small, large in _SMALLER:
        if d.value(small) >= d.value(large) - ROUNDING:
            yield f"{given(d, small)} is not smaller than {given(d, large)}"
    if 2.0 * d.tooth_iron.corner_radius >= d.derived.iron_width - ROUNDING:
        yield (
            f"{given(d, 'tooth_iron.corner_radius')} does not go into an iron of {length(d.derived.iron_width)} "
            f"({given(d, 'teeth.per_iron', 'teeth.pitch')})"
        )


@rule
def turned_edges(d: Design) -> Iterator[str]:
    """Turned parts keep their shoulders, crowns and walls."""
    pin, crowned, h, wall = d.height_pin_1, d.height_pin_2, d.holder, d.making.least_wall
    if 2.0 * pin.end_chamfer >= pin.diameter - pin.spigot_diameter - ROUNDING:
        yield (
            f"{given(d, 'height_pin_1.end_chamfer')} leaves no shoulder between "
            f"{given(d, 'height_pin_1.diameter', 'height_pin_1.spigot_diameter')}"
        )
    if 2.0 * crowned.crown_radius <= crowned.diameter + ROUNDING:
        yield (
            f"{given(d, 'height_pin_2.crown_radius')} is too small for a crown on {given(d, 'height_pin_2.diameter')}; "
            f"it must be more than {length(crowned.diameter / 2)}"
        )
    most = min(h.height - h.floor, (h.diameter - h.well_diameter) / 2 - wall)
    if h.index_depth > most + ROUNDING:
        yield f"{given(d, 'holder.index_depth')} cuts through {given(d, 'holder.height', 'holder.well_diameter')}"
    if h.edge_chamfer >= h.diameter / 2 - d.derived.piezo_circle - h.bore_diameter / 2 - ROUNDING:
        yield f"{given(d, 'holder.edge_chamfer')} reaches the bores of {given(d, 'holder.bore_diameter')}"
    if d.tip.hub_diameter / 2 >= d.derived.piezo_circle - d.tip.foot_diameter / 2 - ROUNDING:
        yield (
            f"{given(d, 'tip.hub_diameter')} reaches the feet of the tip "
            f"({given(d, 'actuator.piezo_spacing', 'tip.foot_diameter')})"
        )


@rule
def grooves(d: Design) -> Iterator[str]:
    """The grooves beside the drive surface leave a plate."""
    if d.sea.groove_depth + d.making.least_wall > d.stage.thickness + ROUNDING:
        yield f"{given(d, 'sea.groove_depth')} leaves too little of {given(d, 'stage.thickness')}"
