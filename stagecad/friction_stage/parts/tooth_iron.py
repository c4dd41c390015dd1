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

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import (
    DOWN,
    DimensionDeclarations,
    FaceRequirements,
    Y,
    Z,
    fillet_inset,
    named,
)
from stagecad.solids.modelling.holes import OVERRUN, cut_all, edges_where, plate
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "xy"

NOTES = (
    "Teeth symmetric about the middle of the width, half a groove at either side. Four off, alike.",
    "Anneal in vacuum or hydrogen; dimensions after annealing: leave datum A and teeth to grind. Oil against rust.",
)


def tooth_centres(design: Design) -> list[float]:
    """Middle y of each tooth of one iron, mm, about the iron's own middle."""
    count, pitch = int(design.teeth.per_iron), design.teeth.pitch
    return [(i - (count - 1) / 2) * pitch for i in range(count)]


def grooves(design: Design, centres: list[float], width: float, length: float, crest: float) -> list[cq.Shape]:
    """Cutters between teeth at `centres` (y) over the whole width of iron or bar; crests at z = `crest`, mm."""
    teeth, edge, out = design.teeth, width / 2 + OVERRUN, 1 if crest > 0.0 else -1
    sides = [-edge, *(centre + side * teeth.width / 2 for centre in centres for side in (-1, 1)), edge]
    floor, high = crest - out * teeth.groove_depth, out * (teeth.groove_depth + OVERRUN)
    spans = zip(sides[::2], sides[1::2], strict=True)
    return [plate((0.0, (a + b) / 2, floor), length + 2 * OVERRUN, b - a, high) for a, b in spans]


def build(design: Design) -> cq.Solid:
    """The tooth iron as one solid, mm."""
    iron, width = design.tooth_iron, design.teeth.per_iron * design.teeth.pitch
    block = plate((0.0, 0.0, 0.0), iron.length, width, -iron.height, corner_radius=iron.corner_radius)
    block = block.chamfer(iron.edge_chamfer, None, edges_where(block, lambda p: abs(p.z) < 1e-6)).Solids()[0]
    return cut_all(block, grooves(design, tooth_centres(design), width, iron.length, -iron.height))


def datums(design: Design) -> dict[str, Datum]:
    """Seat on the stage, and the plane of the tooth crests."""
    height = design.tooth_iron.height
    return named(Datum("seat", (0.0, 0.0, 0.0), Z), Datum("teeth", (0.0, 0.0, -height), (0.0, 0.0, -1.0)))


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the tooth iron."""
    iron, d = design.tooth_iron, DimensionDeclarations(design, "tooth_iron")
    centres = tooth_centres(design)
    x, y, crest = iron.length / 2, design.teeth.per_iron * design.teeth.pitch / 2, -iron.height
    d.linear("length", "length", (-x, 0, crest / 4), (x, 0, crest / 4), view="top")
    d.linear("height", "height", (0, centres[0], 0), (0, centres[0], crest), view="right")
    if design.teeth.per_iron > 1:
        keys = ("teeth.pitch", "teeth.per_iron")
        d.derived("width", 2 * y, keys, ((0, -y, crest / 4), (0, y, crest / 4)), Y, view="top")
    inset = fillet_inset(iron.corner_radius)
    d.radius("corner radius", "corner_radius", (x - inset, y - inset, crest / 4), count=4, view="top")
    c = iron.edge_chamfer / 2
    d.chamfer("edge chamfer", "edge_chamfer", (0, y - c, -c), note="rim of the seat", view="right")
    declare_teeth(d.group(view="right"), design, centres, crest, into=1.0, groups=1)
    return tuple(d)


def declare_teeth(
    d: DimensionDeclarations, design: Design, centres: list[float], crest: float, *, into: float, groups: int
) -> None:
    """Dimensions of the teeth, equal on iron and bar: crests at z = `crest`, the iron on the side `into`, +1 or -1."""
    y, teeth = centres[0], design.teeth
    half, pitch, depth = teeth.width / 2, teeth.pitch, into * teeth.groove_depth
    flank, groove, body = crest + depth / 2, crest + depth, crest + 2 * depth
    name = "teeth" if groups == 1 else "teeth, a group on either side"
    d.counted(name, "teeth.per_iron", (0, y, crest), Y, count=groups, feature="teeth")
    d.group(count=len(centres)).linear("tooth width", "teeth.width", (0, y - half, flank), (0, y + half, flank))
    d.depth("groove depth", "teeth.groove_depth", (0, y, crest), (0, y + pitch / 2, groove), Z)
    steps = len(centres) // groups - 1
    first, last = (0, y - half, flank), (0, y + steps * pitch - half, flank)
    if steps > 1:
        d.pitch("tooth pitch", "teeth.pitch", first, last, steps)
    elif steps == 1:
        d.linear("tooth pitch", "teeth.pitch", first, last)
    else:
        d.linear("iron width", "teeth.pitch", (0, y - pitch / 2, body), (0, y + pitch / 2, body))


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Crests parallel to the seat: the gap to the bar is the same all over."""
    f, down = FaceRequirements(design), DOWN
    seat = ((0.0, 0.0, 0.0),)
    crests = tuple((0.0, y, -design.tooth_iron.height) for y in tooth_centres(design))
    f.datum("A", seat, Z, "right")
    level = ("parallelism", "crests to seat", "drawing.tolerance_x_xx", crests, down, "right")
    f.tolerance(*level, datums=("A",), combined=True)
    return tuple(f)
