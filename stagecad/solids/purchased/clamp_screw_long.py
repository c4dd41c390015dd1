"""Screw that closes the clamp slot of actuator 1 (3/8"-16 x 6"), reached from a side face.

Part coordinates as in `socket_cap_screw`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stagecad.solids.purchased.socket_cap_screw import screw_datums, socket_cap_screw

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.parameters.dimension import Datum, Dimension

NAME = "clamp_screw_long"


def build(design: Any) -> cq.Solid:
    """The screw as one solid, mm."""
    screw = design.screws.clamp_long
    return socket_cap_screw(screw.diameter, screw.length, screw.head_diameter, screw.head_height, screw.socket_width)


def material(design: Any) -> str:
    return design.screws.clamp_long.material


def part_number(design: Any) -> str:
    return design.screws.clamp_long.part_number


def description(design: Any) -> str:
    return design.screws.clamp_long.description


def datums(design: Any) -> dict[str, Datum]:
    return screw_datums(design.screws.clamp_long.length)


def dimensions(design: Any) -> tuple[Dimension, ...]:
    """None: it is bought."""
    return ()
