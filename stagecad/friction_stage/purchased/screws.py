"""Hexagon socket head cap screws (ASME B18.3) of several lengths, and the set screw. Lengths in millimetres.

Part coordinates of a cap screw: origin in the bearing plane under the head, on the axis; the head rises along +z, the
shank goes down. Threads are cosmetic: cylinders of the major diameter with chamfered ends.
"""

from __future__ import annotations

from dataclasses import dataclass

from stagecad.declared.standard_part import CAP, StandardScrew
from stagecad.friction_stage.design import Design
from stagecad.friction_stage.purchased.simple import ends
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.kernel import cq


@dataclass(frozen=True)
class SocketCapScrew:
    """One kind of cap screw, of the sizes in its table."""

    key: str  # of its table below `screws` in the parameter file

    def _screw(self, design: Design) -> StandardScrew:
        table = getattr(design.screws, self.key)
        head = {"outer": table.head_diameter, "height": table.head_height, "socket": table.socket_width}
        return StandardScrew(CAP, self.key, {"diameter": table.diameter, **head}, table.length)

    def build(self, design: Design) -> cq.Solid:
        """The screw as one solid, mm; the socket is half the head deep."""
        return self._screw(design).build(design)

    def thread(self, design: Design) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return self._screw(design).thread(design)

    def datums(self, design: Design) -> dict[str, Datum]:
        """``seat``, ``head``: under the head, normal towards the shank; ``end``: of the shank."""
        return self._screw(design).datums(design)


class SetScrew:
    """Socket set screw that pushes height pin 1 from the side face of the base.

    Origin at the flat end that pushes, on the axis; the socket end is at z = length.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        """A cylinder chamfered at both ends, with a socket half its length deep."""
        screw = design.set_screw
        body = cq.Workplane("XY").circle(screw.diameter / 2).extrude(screw.length)
        floor = cq.Workplane("XY").workplane(offset=screw.length / 2)
        socket = floor.polygon(6, screw.socket_width / 0.75**0.5).extrude(screw.length)
        body = body.faces("<Z or >Z").chamfer(0.06 * screw.diameter).cut(socket)
        return body.solids().val()  # type: ignore[return-value]

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
