"""The tooth bar: a stationary rail of soft iron on the base, whose teeth face those of the irons on the stage.

Part coordinates: origin in the middle of the footprint, in the plane of the feet, x along the travel, y across it, z
up. Both bars are the same part.

Features and what each is for
- Rail: long enough for the irons to stay over plain teeth at both ends of the travel, and to bridge the pockets of
  actuators 2 and 3; deep, so that it spans from end to end without sagging into the gap.
- Teeth: two groups, one under each iron, with ridges along the travel at the irons' pitch; none under the magnet,
  where they would only leak.
- Channel under the magnet: as wide as it, deeper than the grooves: keeps the fields of the two poles apart.
- Feet: wide at both ends, beyond the pockets; the underside between them is relieved, so that the bar rests on its
  feet alone and no clamp finger of the base is held down by it. Low, to keep the screw heads below the tooth crests.
- Screw holes: two through holes in each foot.
"""

from __future__ import annotations

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import corners
from stagecad.friction_stage.parts.tooth_iron import declare_teeth, grooves, tooth_centres
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import (
    DOWN,
    DimensionDeclarations,
    FaceRequirements,
    X,
    Y,
    Z,
    fillet_inset,
    named,
)
from stagecad.solids.modelling.holes import (
    OVERRUN,
    cut_all,
    drilled,
    edges_where,
    joined,
    plate,
    repeated,
    upright_edges,
)
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "xy"

NOTES = (
    "Symmetric about both centre planes: a group of teeth on either side of the channel. Two off, alike.",
    "Anneal in vacuum or hydrogen; dimensions after annealing: leave datum A and teeth to grind. Oil against rust.",
)


def pole_offset(design: Design) -> float:
    """Distance of each iron's middle from the bar's, mm: half a magnet and half an iron."""
    return (design.magnet.thickness + design.teeth.per_iron * design.teeth.pitch) / 2


def rail_width(design: Design) -> float:
    """Width of the rail under both irons and the magnet, mm."""
    return design.magnet.thickness + 2 * design.teeth.per_iron * design.teeth.pitch


def build(design: Design) -> cq.Solid:
    """The tooth bar as one solid, mm."""
    bar, width, shift = design.tooth_bar, rail_width(design), pole_offset(design)
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
    floor, deep = (0.0, 0.0, bar.height - bar.channel_depth), bar.channel_depth + OVERRUN
    channel = plate(floor, bar.length + 2 * OVERRUN, design.magnet.thickness, deep)
    places, through = corners(bar.screw_span, bar.screw_spacing), (bar.screw_hole, bar.end_height + OVERRUN)
    holes = drilled(places, bar.end_height, through, chamfer=bar.edge_chamfer)
    return cut_all(body, [*grooves(design, centres, width, bar.length, bar.height), channel, *holes])


def datums(design: Design) -> dict[str, Datum]:
    """Seat on the base, plane of the tooth crests, and the seats of the screw heads."""
    bar = design.tooth_bar
    heads = [
        Datum(f"bar_screw_{i}", (x, y, bar.end_height), Z)
        for i, (x, y) in enumerate(corners(bar.screw_span, bar.screw_spacing), start=1)
    ]
    return named(Datum("seat", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), Datum("teeth", (0.0, 0.0, bar.height), Z), *heads)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the tooth bar."""
    d = DimensionDeclarations(design, "tooth_bar")
    shift = pole_offset(design)
    centres = [side * shift + c for side in (-1, 1) for c in tooth_centres(design)]
    _foot_dimensions(d, design, centres[0])
    _rail_dimensions(d.group(view="right"), design, centres)
    declare_teeth(d.group(view="right"), design, centres, design.tooth_bar.height, into=-1.0, groups=2)
    return tuple(d)


def _foot_dimensions(d: DimensionDeclarations, design: Design, crest: float) -> None:
    """Lengths of bar and feet, screw holes and edges; `crest` is the y of a tooth, mm."""
    bar, plan, front = design.tooth_bar, d.group(view="top"), d.group(view="front")
    end, root, low, wide = bar.length / 2, bar.length / 2 - bar.end_length, bar.end_height, bar.foot_width / 2
    foot, middle, inner = (end - 3, 0, 0), end - bar.end_length / 2, wide - 2
    front.linear("length", "length", (-end, 0, low / 2), (end, 0, low / 2))
    front.linear("height", "height", foot, (0, crest, bar.height), Z)
    plan.linear("foot length", "end_length", (root, inner, low / 2), (end, inner, low / 2), count=2)
    front.linear("foot height", "end_height", foot, (end - 3, 0, low), count=2)
    plan.linear("foot width", "foot_width", (middle, -wide, low / 2), (middle, wide, low / 2), count=2)
    front.linear("relief", "relief", foot, (0, 0, bar.relief), Z, note="between the feet")
    x, y = bar.screw_span / 2, bar.screw_spacing / 2
    plan.diameter("screw hole", "screw_hole", (x, y, low / 2), feature="screw hole", count=4, note="through")
    plan.linear("screw span", "screw_span", (-x, y, low), (x, y, low))
    plan.linear("screw spacing", "screw_spacing", (x, -y, low), (x, y, low), count=2)
    inset = fillet_inset(bar.root_fillet)
    front.radius("root fillet", "root_fillet", (root + inset, rail_width(design) / 4, low + inset), Y, count=2)
    c, note = bar.edge_chamfer / 2, "upright edges of the feet, mouths of the holes"
    plan.chamfer("edge chamfer", "edge_chamfer", (end - c, wide - c, low / 2), X, note=note)


def _rail_dimensions(d: DimensionDeclarations, design: Design, centres: list[float]) -> None:
    """Channel and width of the rail between the feet; `centres` are the y of the teeth, mm."""
    bar, teeth = design.tooth_bar, design.teeth
    half, width, deep = design.magnet.thickness / 2, rail_width(design) / 2, bar.height - bar.channel_depth
    flank, level = bar.height - (bar.channel_depth + teeth.groove_depth) / 2, (bar.relief + deep) / 2
    d.linear("channel width", "magnet.thickness", (0, -half, flank), (0, half, flank))
    d.depth("channel depth", "channel_depth", (0, 0, bar.height), (0, 0, deep))
    keys = ("teeth.pitch", "teeth.per_iron", "magnet.thickness")
    d.derived("rail width", 2 * width, keys, ((0, -width, level), (0, width, level)), Y)
    first, second, crest = centres[0], centres[len(centres) // 2], bar.height - teeth.groove_depth / 2
    flanks = (0, first - teeth.width / 2, crest), (0, second - teeth.width / 2, crest)
    d.derived("between the groups of teeth", second - first, keys, flanks, Y)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Feet in one plane, and crests parallel to it: the gap to the irons is the same along the travel."""
    f, bar, down = FaceRequirements(design), design.tooth_bar, DOWN
    feet = tuple((side * (bar.length - bar.end_length) / 2, 0.0, 0.0) for side in (-1, 1))
    shift = pole_offset(design)
    crests = tuple((0.0, side * shift + c, bar.height) for side in (-1, 1) for c in tooth_centres(design))
    f.datum("A", feet, down, "front")
    f.tolerance("flatness", "feet", "drawing.tolerance_x_xx", feet, down, "front", combined=True)
    level = ("parallelism", "crests to feet", "drawing.tolerance_x_xx", crests, Z, "front")
    f.tolerance(*level, datums=("A",), combined=True)
    return tuple(f)
