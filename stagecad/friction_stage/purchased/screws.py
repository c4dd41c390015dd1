"""Hexagon socket head cap screws (ASME B18.3) of several lengths. Lengths in millimetres.

Part coordinates: origin in the bearing plane under the head, on the axis; the head rises along +z, the shank goes down.
The thread is cosmetic: the shank is a cylinder of the major diameter with a chamfered end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class SocketCapScrew:
    """One kind of screw."""

    key: str  # of its table below `screws` in the parameter file

    def _table(self, design: Design) -> Any:
        return getattr(design.screws, self.key)

    def build(self, design: Design) -> cq.Solid:
        """The screw as one solid, mm; the socket is half the head deep."""
        import cadquery as cq

        screw = self._table(design)
        shank, head = screw.diameter / 2, screw.head_diameter / 2
        chamfer, rim = 0.08 * screw.diameter, 0.06 * screw.head_height
        outline = [
            (0.0, -screw.length),
            (shank - chamfer, -screw.length),
            (shank, -screw.length + chamfer),
            (shank, 0.0),
            (head, 0.0),
            (head, screw.head_height - rim),
            (head - rim, screw.head_height),
            (0.0, screw.head_height),
        ]
        body = cq.Workplane("XZ").polyline(outline).close().revolve(360.0, (0, 0), (0, 1))
        across_corners = screw.socket_width / 0.8660254037844386
        floor = cq.Workplane("XY").workplane(offset=screw.head_height / 2)
        socket = floor.polygon(6, across_corners).extrude(screw.head_height)
        return body.cut(socket).solids().val()  # type: ignore[return-value]

    def thread(self, design: Design) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return self._table(design).diameter, self._table(design).length

    def datums(self, design: Design) -> dict[str, Datum]:
        """``seat``, ``head``: under the head, normal towards the shank; ``end``: of the shank."""
        levels = {"seat": 0.0, "head": 0.0, "end": -self._table(design).length}
        down, x = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
        return {name: Datum(name, (0.0, 0.0, level), down, x) for name, level in levels.items()}


PARTS = {
    "way_screw": SocketCapScrew("way"),
    "clamp_screw_long": SocketCapScrew("clamp_long"),
    "clamp_screw_short": SocketCapScrew("clamp_short"),
    "bar_screw": SocketCapScrew("bar"),
    "stop_screw": SocketCapScrew("stop"),
}
"""Screws of a bearing way (3/8"-16 x 1"), of the clamp slot at actuator 1 (6") and at 2 and 3 (4.5"), of a tooth bar
and the sensor bracket, of a stop bar."""
