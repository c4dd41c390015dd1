"""The tooth bar: a stationary rail of soft iron on the base, whose teeth face those of the irons on the stage.

Part coordinates: origin in the middle of the footprint, in the plane of the feet, x along the travel, y across it, z up.
Both bars are the same part.

Features and what each is for
- Rail: long enough for the irons to stay over plain teeth at both ends of the travel, and to bridge the pockets of
  actuators 2 and 3; deep, so that it spans from end to end without sagging into the gap.
- Teeth: two groups, one under each iron, with ridges along the travel at the irons' pitch; none under the magnet,
  where they would only leak.
- Feet: wide at both ends, beyond the pockets; the underside between them is relieved, so that the bar stands on its feet
  alone and no clamp finger of the base is held down by it. Low, to keep the screw heads below the tooth crests.
- Screw holes: two through holes in each foot.
"""
from __future__ import annotations

from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all, edges_where, joined, plate, upright_edges
from stagecad.solids.holes import OVERRUN, repeated, stepped_hole
from stagecad.solids.tooth_iron import groove_spans, tooth_centres

NAME = "tooth_bar"


def pole_offset(design: Any) -> float:
    """Distance of each iron's middle from the bar's, mm: half a magnet and half an iron."""
    return (design.magnet.thickness + design.teeth.per_iron * design.teeth.pitch) / 2


def rail_width(design: Any) -> float:
    """Width of the rail under both irons and the magnet, mm."""
    return design.magnet.thickness + 2 * design.teeth.per_iron * design.teeth.pitch


def build(design: Any) -> cq.Solid:
    """The tooth bar as one solid, mm."""
    bar, teeth = design.tooth_bar, design.teeth
    width, shift = rail_width(design), pole_offset(design)
    middle = bar.length - 2 * bar.end_length
    at_end = (bar.length - bar.end_length) / 2
    foot = plate((0.0, 0.0, 0.0), bar.end_length, bar.foot_width, bar.end_height)
    foot = foot.chamfer(bar.edge_chamfer, None, upright_edges(foot)).Solids()[0]
    rail = plate((0.0, 0.0, bar.relief), middle, width, bar.height - bar.relief)
    body = joined(rail, repeated(foot, [(side * at_end, 0.0, 0.0) for side in (-1, 1)]))

    def at_root(p: cq.Vector) -> bool:
        return abs(abs(p.x) - middle / 2) < 1e-6 and abs(p.z - bar.end_height) < 1e-6 and abs(p.y) < width / 2

    body = body.fillet(bar.root_fillet, edges_where(body, at_root)).Solids()[0]
    centres = [side * shift + c for side in (-1, 1) for c in tooth_centres(design)]
    cutters: list[cq.Shape] = [
        plate((0.0, (low + high) / 2, bar.height - teeth.groove_depth), bar.length + 2 * OVERRUN, high - low,
              teeth.groove_depth + OVERRUN)
        for low, high in groove_spans(centres, teeth.width, width / 2 + OVERRUN)
    ]
    hole = stepped_hole((0, 0, bar.end_height), (0, 0, -1), [(bar.screw_hole, bar.end_height + OVERRUN)],
                        mouth_chamfer=bar.edge_chamfer)
    cutters += repeated(hole, [
        (side * at_end, step * bar.screw_spacing / 2, 0.0) for side in (-1, 1) for step in (-1, 1)
    ])
    return cut_all(body, cutters)
