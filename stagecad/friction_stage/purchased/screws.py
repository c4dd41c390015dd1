"""Hexagon socket head cap screws (ASME B18.3) of several lengths, and the set screw. Lengths in millimetres.

Part coordinates of a cap screw: origin in the bearing plane under the head, on the axis; the head rises along +z, the
shank goes down. Threads are cosmetic: cylinders of the major diameter with chamfered ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.purchased.simple import ends
from stagecad.parameters.dimension import Datum

if TYPE_CHECKING:
    import cadquery as cq


def with_socket(body: cq.Workplane, width: float, height: float) -> cq.Solid:
    """A screw with a hexagon socket from z = `height` to half of it, `width` across flats, mm."""
    import cadquery as cq

    floor = cq.Workplane("XY").workplane(offset=height / 2)
    socket = floor.polygon(6, width / 0.8660254037844386).extrude(height)
    return body.cut(socket).solids().val()  # type: ignore[return-value]


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
        return with_socket(body, screw.socket_width, screw.head_height)

    def thread(self, design: Design) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return self._table(design).diameter, self._table(design).length

    def datums(self, design: Design) -> dict[str, Datum]:
        """``seat``, ``head``: under the head, normal towards the shank; ``end``: of the shank."""
        levels = {"seat": 0.0, "head": 0.0, "end": -self._table(design).length}
        down, x = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
        return {name: Datum(name, (0.0, 0.0, level), down, x) for name, level in levels.items()}


class SetScrew:
    """Socket set screw that pushes height pin 1 from the side face of the base.

    Origin at the flat end that pushes, on the axis; the socket end is at z = length.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        """A cylinder chamfered at both ends, with a socket half its length deep."""
        import cadquery as cq

        screw = design.set_screw
        body = cq.Workplane("XY").circle(screw.diameter / 2).extrude(screw.length)
        return with_socket(body.faces("<Z or >Z").chamfer(0.06 * screw.diameter), screw.socket_width, screw.length)

    @staticmethod
    def thread(design: Design) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return design.set_screw.diameter, design.set_screw.length

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return ends("end", "socket", design.set_screw.length)


PARTS = {
    "way_screw": SocketCapScrew("way"),
    "clamp_screw_long": SocketCapScrew("clamp_long"),
    "clamp_screw_short": SocketCapScrew("clamp_short"),
    "bar_screw": SocketCapScrew("bar"),
    "stop_screw": SocketCapScrew("stop"),
    "set_screw": SetScrew,
}
"""Screws of a bearing way (3/8"-16 x 1"), of the clamp slot at actuator 1 (6") and at 2 and 3 (4.5"), of a tooth bar
and the sensor bracket, of a stop bar; the set screw (1"-8 x 1")."""
