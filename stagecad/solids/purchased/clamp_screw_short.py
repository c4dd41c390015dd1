"""Screw that closes the clamp slot of actuator 2 or 3 (3/8"-16 x 4.5"), reached from a side face.

Part coordinates as in `socket_cap_screw`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stagecad.solids.purchased.socket_cap_screw import screw_datums, socket_cap_screw

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.parameters.dimension import Datum, Dimension

NAME = "clamp_screw_short"


def build(design: Any) -> cq.Solid:
    """The screw as one solid, mm."""
    screw = design.screws.clamp_short
    return socket_cap_screw(screw.diameter, screw.length, screw.head_diameter, screw.head_height, screw.socket_width)


def material(design: Any) -> str:
    return design.screws.clamp_short.material


def part_number(design: Any) -> str:
    return design.screws.clamp_short.part_number


def description(design: Any) -> str:
    return design.screws.clamp_short.description


def datums(design: Any) -> dict[str, Datum]:
    return screw_datums(design.screws.clamp_short.length)


def dimensions(design: Any) -> tuple[Dimension, ...]:
    """None: it is bought."""
    return ()
