"""Screw that holds a tooth bar on the base.

Part coordinates as in `socket_cap_screw`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stagecad.solids.purchased.socket_cap_screw import screw_datums, socket_cap_screw

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.parameters.dimension import Datum, Dimension

NAME = "bar_screw"


def build(design: Any) -> cq.Solid:
    """The screw as one solid, mm."""
    screw = design.screws.bar
    return socket_cap_screw(screw.diameter, screw.length, screw.head_diameter, screw.head_height, screw.socket_width)


def material(design: Any) -> str:
    return design.screws.bar.material


def part_number(design: Any) -> str:
    return design.screws.bar.part_number


def description(design: Any) -> str:
    return design.screws.bar.description


def datums(design: Any) -> dict[str, Datum]:
    return screw_datums(design.screws.bar.length)


def dimensions(design: Any) -> tuple[Dimension, ...]:
    """None: it is bought."""
    return ()
