"""Hexagon socket head cap screws (ASME B18.3), shared by the lengths that are bought. Lengths in millimetres.

Part coordinates: origin in the bearing plane under the head, on the axis; the head rises along +z, the shank goes down.
The thread is cosmetic: the shank is a cylinder of the major diameter with a chamfered end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.parameters.dimension import Datum

if TYPE_CHECKING:
    import cadquery as cq


def socket_cap_screw(
    diameter: float, length: float, head_diameter: float, head_height: float, socket_width: float
) -> cq.Solid:
    """The screw as one solid.

    Args:
        diameter: major diameter of the thread.
        length: from under the head to the end.
        head_diameter, head_height: of the cylindrical head.
        socket_width: of the hexagon, across its flats; the socket is half the head deep.
    """
    import cadquery as cq

    chamfer = 0.08 * diameter
    rim = 0.06 * head_height
    outline = [
        (0.0, -length),
        (diameter / 2 - chamfer, -length),
        (diameter / 2, -length + chamfer),
        (diameter / 2, 0.0),
        (head_diameter / 2, 0.0),
        (head_diameter / 2, head_height - rim),
        (head_diameter / 2 - rim, head_height),
        (0.0, head_height),
    ]
    body = cq.Workplane("XZ").polyline(outline).close().revolve(360.0, (0, 0), (0, 1))
    across_corners = socket_width / 0.8660254037844386
    socket = cq.Workplane("XY").workplane(offset=head_height / 2).polygon(6, across_corners).extrude(head_height)
    return body.cut(socket).solids().val()  # type: ignore[return-value]


def screw_datums(length: float) -> dict[str, Datum]:
    """``seat``: under the head, normal towards the shank; ``end``: of the shank."""
    return {
        "seat": Datum("seat", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
        "end": Datum("end", (0.0, 0.0, -length), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
    }
