"""The tooth bar: a stationary rail of soft iron on the base, whose teeth face those of the irons on the stage.

Part coordinates: origin in the middle of the footprint, in the plane of the feet, x along the travel, y across it, z
up. Both bars are the same part.

Features and what each is for
- Rail: long enough for the irons to stay over plain teeth at both ends of the travel, and to bridge the pockets of
  actuators 2 and 3; deep, so that it spans from end to end without sagging into the gap.
- Teeth: two groups, one under each iron, with ridges along the travel at the irons' pitch; none under the magnet,
  where they would only leak.
- Channel under the magnet: as wide as it, deeper than the grooves: keeps the fields of the two poles apart.
- Feet: wide at both ends, beyond the pockets; the underside between them is relieved, so that the bar stands on its
  feet alone and no clamp finger of the base is held down by it. Low, to keep the screw heads below the tooth crests.
- Screw holes: two through holes in each foot.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import Declarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, corners, repeated, stepped_hole
from stagecad.solids.modelling.primitives import cut_all, edges_where, joined, plate, upright_edges
from stagecad.solids.parts.tooth_iron import declare_teeth, groove_spans, tooth_centres

if TYPE_CHECKING:
    import cadquery as cq

NAME = "tooth_bar"

NOTES = ("Symmetric about both centre planes: a group of teeth on either side of the channel. Two off, alike.",)


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
        plate(
            (0.0, (low + high) / 2, bar.height - teeth.groove_depth),
            bar.length + 2 * OVERRUN,
            high - low,
            teeth.groove_depth + OVERRUN,
        )
        for low, high in groove_spans(centres, teeth.width, width / 2 + OVERRUN)
    ]
    cutters.append(
        plate(
            (0.0, 0.0, bar.height - bar.channel_depth),
            bar.length + 2 * OVERRUN,
            design.magnet.thickness,
            bar.channel_depth + OVERRUN,
        )
    )
    hole = stepped_hole(
        (0, 0, bar.end_height), (0, 0, -1), [(bar.screw_hole, bar.end_height + OVERRUN)], mouth_chamfer=bar.edge_chamfer
    )
    cutters += repeated(hole, [(x, y, 0.0) for x, y in corners(bar.screw_span, bar.screw_spacing)])
    return cut_all(body, cutters)


def material(design: Any) -> str:
    """Name of its material."""
    return design.tooth_bar.material


def datums(design: Any) -> dict[str, Datum]:
    """Seat on the base, plane of the tooth crests, and the seats of the screw heads."""
    bar = design.tooth_bar
    heads = [
        Datum(f"bar_screw_{i}", (x, y, bar.end_height), Z)
        for i, (x, y) in enumerate(corners(bar.screw_span, bar.screw_spacing), start=1)
    ]
    return named(
        Datum("seat", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
        Datum("teeth", (0.0, 0.0, bar.height), Z),
        *heads,
    )


def dimensions(design: Any) -> tuple[Dimension, ...]:
    """Every dimension of the tooth bar."""
    bar, d = design.tooth_bar, Declarations(design)
    x, middle, low = bar.length / 2, bar.length / 2 - bar.end_length, bar.end_height
    width, shift = rail_width(design) / 2, pole_offset(design)
    centres = [side * shift + c for side in (-1, 1) for c in tooth_centres(design)]
    d.linear("length", "tooth_bar.length", (-x, 0, low / 2), (x, 0, low / 2), view="front")
    d.linear("height", "tooth_bar.height", (x - 3, 0, 0), (0, centres[0], bar.height), Z, view="front")
    d.linear(
        "foot length",
        "tooth_bar.end_length",
        (middle, bar.foot_width / 2 - 2, low / 2),
        (x, bar.foot_width / 2 - 2, low / 2),
        count=2,
        view="top",
    )
    d.linear("foot height", "tooth_bar.end_height", (x - 3, 0, 0), (x - 3, 0, low), count=2, view="front")
    wide = bar.foot_width / 2
    at_end = x - bar.end_length / 2
    d.linear(
        "foot width", "tooth_bar.foot_width", (at_end, -wide, low / 2), (at_end, wide, low / 2), count=2, view="top"
    )
    d.linear("relief", "tooth_bar.relief", (x - 3, 0, 0), (0, 0, bar.relief), Z, view="front", note="between the feet")
    span, spacing = bar.screw_span / 2, bar.screw_spacing / 2
    d.diameter(
        "screw hole",
        "tooth_bar.screw_hole",
        (span, spacing, low / 2),
        feature="screw hole",
        count=4,
        note="through",
        view="top",
    )
    d.linear("screw span", "tooth_bar.screw_span", (-span, spacing, low), (span, spacing, low), view="top")
    d.linear(
        "screw spacing", "tooth_bar.screw_spacing", (span, -spacing, low), (span, spacing, low), count=2, view="top"
    )
    nook = bar.root_fillet * (1 - math.sqrt(0.5))
    d.radius("root fillet", "tooth_bar.root_fillet", (middle + nook, width / 2, low + nook), Y, count=2, view="front")
    c = bar.edge_chamfer / 2
    d.chamfer(
        "edge chamfer",
        "tooth_bar.edge_chamfer",
        (x - c, wide - c, low / 2),
        X,
        view="top",
        note="upright edges of the feet, mouths of the holes",
    )
    half, deep = design.magnet.thickness / 2, bar.height - bar.channel_depth
    flank = bar.height - (bar.channel_depth + design.teeth.groove_depth) / 2
    d.linear("channel width", "magnet.thickness", (0, -half, flank), (0, half, flank), view="right")
    d.depth("channel depth", "tooth_bar.channel_depth", (0, 0, bar.height), (0, 0, deep), view="right")
    keys, level = ("teeth.pitch", "teeth.per_iron", "magnet.thickness"), (bar.relief + deep) / 2
    d.derived("rail width", 2 * width, keys, (0, -width, level), (0, width, level), view="right")
    second = centres[len(centres) // 2]
    half = design.teeth.width / 2
    crest = bar.height - design.teeth.groove_depth / 2
    d.derived(
        "between the groups of teeth",
        second - centres[0],
        keys,
        (0, centres[0] - half, crest),
        (0, second - half, crest),
        view="right",
    )
    declare_teeth(d, design, centres, bar.height, into=-1.0, groups=2)
    return tuple(d)


def requirements(design: Any) -> tuple[FaceRequirement, ...]:
    """Feet in one plane, and crests parallel to it: the gap to the irons is the same along the travel."""
    f, bar, down = FaceRequirements(design), design.tooth_bar, (0.0, 0.0, -1.0)
    feet = tuple((side * (bar.length - bar.end_length) / 2, 0.0, 0.0) for side in (-1, 1))
    shift = pole_offset(design)
    crests = tuple((0.0, side * shift + c, bar.height) for side in (-1, 1) for c in tooth_centres(design))
    f.datum("A", feet, down, "front")
    f.keeps("flatness", "feet", "drawing.tolerance_x_xx", feet, down, "front", combined=True)
    f.keeps("parallelism", "crests to feet", "drawing.tolerance_x_xx", crests, Z, "front", datums=("A",), combined=True)
    return tuple(f)
