"""The tooth iron: a pole of soft iron on the stage, with teeth along the travel that face the teeth of a bar.

Part coordinates: origin in the middle of the seat (the face on the pocket's floor), x along the travel, y across it,
z up; the iron hangs below z = 0, its tooth crests at z = -height.

Features and what each is for
- Block of homogeneous soft iron of low hysteresis, two to a magnet; upright corners rounded more than the pocket's.
- Teeth: ridges along the travel, at the pitch of the bar's. Moving along them changes nothing; moving across them meets
  the magnetic stiffness that keeps the stage on its line. Half a groove at either side keeps the pitch across the
  magnet. Crests keep sharp edges (the field works there); all other edges are broken.
"""
from __future__ import annotations

from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all, edges_where, plate
from stagecad.solids.holes import OVERRUN

NAME = "tooth_iron"


def tooth_centres(design: Any) -> list[float]:
    """Middle y of each tooth of one iron, mm, about the iron's own middle."""
    count, pitch = int(design.teeth.per_iron), design.teeth.pitch
    return [(i - (count - 1) / 2) * pitch for i in range(count)]


def groove_spans(centres: list[float], width: float, edge: float) -> list[tuple[float, float]]:
    """The stretches of y between the teeth, from -edge to +edge, mm."""
    sides = [-edge]
    for centre in centres:
        sides += [centre - width / 2, centre + width / 2]
    sides.append(edge)
    return list(zip(sides[::2], sides[1::2], strict=True))


def build(design: Any) -> cq.Solid:
    """The tooth iron as one solid, mm."""
    iron, teeth = design.tooth_iron, design.teeth
    width = teeth.per_iron * teeth.pitch
    block = plate((0.0, 0.0, 0.0), iron.length, width, -iron.height, corner_radius=iron.corner_radius)
    block = block.chamfer(iron.edge_chamfer, None, edges_where(block, lambda p: abs(p.z) < 1e-6)).Solids()[0]
    return cut_all(block, [
        plate((0.0, (low + high) / 2, -iron.height + teeth.groove_depth), iron.length + 2 * OVERRUN, high - low,
              -(teeth.groove_depth + OVERRUN))
        for low, high in groove_spans(tooth_centres(design), teeth.width, width / 2 + OVERRUN)
    ])
