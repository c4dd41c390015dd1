"""Socket set screw (1"-8 x 1") that pushes height pin 1 from the side face of the base.

Part coordinates: origin at the flat end that pushes, on the axis; the socket end is at z = length. Thread cosmetic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum

if TYPE_CHECKING:
    import cadquery as cq


def build(design: Design) -> cq.Solid:
    """A cylinder of the major diameter, chamfered at both ends, with a hexagon socket half its length deep, mm."""
    import cadquery as cq

    screw = design.set_screw
    radius, length = screw.diameter / 2, screw.length
    chamfer = 0.06 * screw.diameter
    body = cq.Workplane("XY").circle(radius).extrude(length).faces("<Z or >Z").chamfer(chamfer)
    across_corners = screw.socket_width / 0.8660254037844386
    socket = cq.Workplane("XY").workplane(offset=length / 2).polygon(6, across_corners).extrude(length)
    return body.cut(socket).solids().val()  # type: ignore[return-value]


def thread(design: Design) -> tuple[float, float]:
    """Major diameter and length of the thread, mm."""
    return design.set_screw.diameter, design.set_screw.length


def datums(design: Design) -> dict[str, Datum]:
    return {
        "end": Datum("end", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
        "socket": Datum("socket", (0.0, 0.0, design.set_screw.length), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    }
