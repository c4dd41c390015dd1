"""The stage: an aluminium plate that slides on convex islands, is driven on its sea, and carries the payload.

Part coordinates: origin at mid-length and mid-width on the underside (the plane of the sea); x along the travel,
y across it, z up. The payload face is at z = thickness, the islands hang below z = 0. At mid-travel the part frame
is the assembly frame raised to the height of the sea.

Features and what each is for
- Plate: as light as stiffness at the payload allows; all suspension hardware that can be is on the base. Rounded
  upright corners and chamfered edges for handling.
- Islands: pads of 2 : 1 proud of the underside, crowned so that they ride on their middle whatever the way's and the
  plate's errors, carrying the PTFE film. Three of them fix height, pitch and roll and no more (a fourth is for
  gravity preload). A fillet at the root is what the bull-nosed cutter leaves.
- Sea: strip of the underside along the travel, lapped and coated with friction material, where the tip drives. Two
  shallow grooves bound it: the lap runs out into them and the coating's mask ends there. (For two axes the whole
  underside is sea, and there are no grooves.)
- Iron pockets: one over each toothed bar, taking the irons and the magnet between them; corners have the cutter's
  radius, smaller than the irons' own, so that these seat. A tapped hole through the roof lets squeezed-out adhesive
  and air escape and takes the jack screw that pushes the irons out again.
- Payload holes: grid of blind tapped holes on the payload face (through holes would break the sea).
- Dowel holes: two reamed holes, through, so that no air is trapped under a dowel; they place a payload repeatably.
- Target holes: two tapped holes in each end face for the target of the probe or the mirror of the interferometer.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement
from stagecad.solids.modelling.dimensioning import Declarations, FaceRequirements, X, Y, Z, named
from stagecad.solids.modelling.holes import OVERRUN, repeated, stepped_hole
from stagecad.solids.modelling.primitives import cut_all, edges_where, joined, plate
from stagecad.solids.parts.tooth_bar import pole_offset

if TYPE_CHECKING:
    import cadquery as cq

NAME = "stage"

NOTES = (
    "Holes, pads, sea and pockets symmetric about the middle of length and width where no distance is given.",
    "The single pad of three is in the middle of the length.",
)


def pad_centres(design: Any) -> list[tuple[float, float]]:
    """Centres (x, y) of the islands, mm: two at +y, and at -y one in the middle (three pads) or two (four pads)."""
    along, across = design.pads.spacing_along / 2, design.pads.spacing_across / 2
    far = [(0.0, -across)] if design.pads.count == 3 else [(-along, -across), (along, -across)]
    return [(-along, across), (along, across), *far]


def payload_grid(design: Any) -> list[tuple[float, float]]:
    """Places (x, y) of the payload's tapped holes, mm, centred on the plate."""
    s = design.stage
    columns, rows, pitch = int(s.payload_columns), int(s.payload_rows), s.payload_pitch
    return [
        ((i - (columns - 1) / 2) * pitch, (j - (rows - 1) / 2) * pitch) for i in range(columns) for j in range(rows)
    ]


def build(design: Any) -> cq.Solid:
    """The stage as one solid, mm."""
    s, sea, threads = design.stage, design.sea, design.threads
    body = plate((0.0, 0.0, 0.0), s.length, s.width, s.thickness, corner_radius=s.corner_radius)
    rim = edges_where(body, lambda p: abs(p.z) < 1e-9 or abs(p.z - s.thickness) < 1e-9)
    body = body.chamfer(s.edge_chamfer, None, rim)
    body = _with_islands(design, body)

    cutters: list[cq.Shape] = []
    top = s.thickness
    hole = stepped_hole(
        (0.0, 0.0, top),
        (0, 0, -1),
        [(threads.m6_tap_drill, s.payload_drill_depth)],
        mouth_chamfer=s.hole_chamfer,
        drill_point=True,
    )
    cutters += repeated(hole, [(x, y, 0.0) for x, y in payload_grid(design)])
    dowel = stepped_hole((0.0, 0.0, top), (0, 0, -1), [(s.dowel_diameter, top + OVERRUN)], mouth_chamfer=s.hole_chamfer)
    cutters += repeated(dowel, [(side * s.dowel_spacing / 2, s.dowel_offset, 0.0) for side in (-1, 1)])
    for end in (-1, 1):
        target = stepped_hole(
            (end * s.length / 2, 0.0, top / 2),
            (-end, 0, 0),
            [(threads.m4_tap_drill, s.target_drill_depth)],
            mouth_chamfer=s.hole_chamfer,
            drill_point=True,
        )
        cutters += repeated(target, [(0.0, side * s.target_spacing / 2, 0.0) for side in (-1, 1)])
    if design.teeth.fitted:
        pocket = plate(
            (0.0, 0.0, -OVERRUN),
            s.iron_pocket_length,
            s.iron_pocket_width,
            OVERRUN + s.iron_pocket_depth,
            corner_radius=s.iron_pocket_corner,
        )
        jack = stepped_hole((0.0, 0.0, top), (0, 0, -1), [(threads.m3_tap_drill, top)], mouth_chamfer=s.hole_chamfer)
        places = [(0.0, side * design.teeth.bar_spacing / 2, 0.0) for side in (-1, 1)]
        cutters += repeated(pocket, places) + repeated(jack, places)
    if not sea.whole_underside:
        groove = plate((0.0, 0.0, -OVERRUN), s.length + 2 * OVERRUN, sea.groove_width, OVERRUN + sea.groove_depth)
        edge = (sea.width + sea.groove_width) / 2
        cutters += repeated(groove, [(0.0, side * edge, 0.0) for side in (-1, 1)])
    return cut_all(body, cutters)


def _with_islands(design: Any, body: cq.Solid) -> cq.Solid:
    """The plate with its islands: each a rounded prism whose foot is a piece of a large sphere."""
    import cadquery as cq

    pads = design.pads
    # The prism reaches up into the plate, so that the fuse meets no coinciding faces but the sphere's own.
    prism = plate(
        (0.0, 0.0, design.stage.thickness / 2),
        pads.length,
        pads.width,
        -(design.stage.thickness / 2 + pads.height),
        corner_radius=pads.corner_radius,
    )
    # Poles along y: the sphere's seam and poles stay off the crown, which is then one plain face.
    ball = (
        cq.Solid.makeSphere(pads.crown_radius, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), -90, 90, 360)
        .rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 90.0)
        .moved(cq.Location(cq.Vector(0, 0, pads.crown_radius - pads.height)))
    )
    island = prism.intersect(ball).Solids()[0]
    centres = pad_centres(design)
    body = joined(body, repeated(island, [(x, y, 0.0) for x, y in centres]))

    def at_root(p: cq.Vector) -> bool:
        return abs(p.z) < 1e-6 and any(
            abs(p.x - x) <= pads.length / 2 + 1e-6 and abs(p.y - y) <= pads.width / 2 + 1e-6 for x, y in centres
        )

    return body.fillet(pads.root_fillet, edges_where(body, at_root)).Solids()[0]


def material(design: Any) -> str:
    """Name of its material."""
    return design.stage.material


def datums(design: Any) -> dict[str, Datum]:
    """Crowns of the pads, payload face, sea, and the seats of irons and magnets."""
    s, down = design.stage, (0.0, 0.0, -1.0)
    crown = -design.pads.height
    found = [Datum(f"pad_{i}", (x, y, crown), down) for i, (x, y) in enumerate(sorted(pad_centres(design)), start=1)]
    found += [
        Datum("pads", (0.0, 0.0, crown), down),
        Datum("top", (0.0, 0.0, s.thickness), Z),
        Datum("sea", (0.0, 0.0, 0.0), down),
    ]
    if design.teeth.fitted:
        seats = [side * design.teeth.bar_spacing / 2 for side in (-1, 1)]
        poles = [seat + side * pole_offset(design) for seat in seats for side in (-1, 1)]
        roof = s.iron_pocket_depth
        found += [Datum(f"tooth_iron_{i}", (0.0, y, roof), down) for i, y in enumerate(poles, start=1)]
        found += [Datum(f"magnet_{i}", (0.0, y, roof), down) for i, y in enumerate(seats, start=1)]
    return named(*found)


def dimensions(design: Any) -> tuple[Dimension, ...]:
    """Every dimension of the stage."""
    d = Declarations(design)
    _plate_dimensions(d, design)
    _island_dimensions(d, design)
    _underside_dimensions(d, design)
    return tuple(d)


def _plate_dimensions(d: Declarations, design: Any) -> None:
    s = design.stage
    x, y, top = s.length / 2, s.width / 2, s.thickness
    d.linear("length", "stage.length", (-x, 0, top / 2), (x, 0, top / 2), view="top")
    d.linear("width", "stage.width", (0, -y, top / 2), (0, y, top / 2), view="top")
    d.linear("thickness", "stage.thickness", (x - 10, y - 10, 0), (x - 10, y - 10, top), view="front")
    nook = s.corner_radius * (1 - math.sqrt(0.5))
    d.radius("corner radius", "stage.corner_radius", (x - nook, y - nook, top / 2), count=4, view="top")
    c = s.edge_chamfer / 2
    d.chamfer("edge chamfer", "stage.edge_chamfer", (0, y - c, top - c), note="all outer edges", view="front")

    columns, rows = int(s.payload_columns), int(s.payload_rows)
    (px, py), pitch = payload_grid(design)[0], s.payload_pitch
    hole = "payload hole"
    d.tapped(
        hole,
        "m6",
        (px, py, top),
        (0, 0, -1),
        thread_depth="stage.payload_thread_depth",
        drill_depth="stage.payload_drill_depth",
        count=columns * rows,
    )
    d.counted("payload columns", "stage.payload_columns", (px, py, top), X, feature=hole, view="top")
    d.counted("payload rows", "stage.payload_rows", (px, py, top), Y, feature=hole, view="top")
    d.linear(
        "payload pitch",
        "stage.payload_pitch",
        (px, py, top),
        (px + pitch, py, top),
        view="top",
        count=columns + rows - 2,
        note="both ways",
    )
    c = s.hole_chamfer / 2
    d.chamfer(
        "hole chamfer",
        "stage.hole_chamfer",
        (px + design.threads.m6_tap_drill / 2 + c, py, top - c),
        note="mouths of all holes",
        view="top",
    )

    far = s.dowel_spacing / 2
    d.diameter(
        "dowel hole",
        "stage.dowel_diameter",
        (far, s.dowel_offset, top / 2),
        feature="dowel hole",
        count=2,
        note="reamed, through",
        view="top",
    )
    d.linear(
        "dowel spacing", "stage.dowel_spacing", (-far, s.dowel_offset, top), (far, s.dowel_offset, top), view="top"
    )
    d.linear(
        "dowel offset",
        "stage.dowel_offset",
        (x, 0, top),
        (far, s.dowel_offset, top),
        Y,
        view="top",
        note="from the middle",
    )
    step = s.target_spacing / 2
    d.linear(
        "target spacing",
        "stage.target_spacing",
        (x, -step, top / 2),
        (x, step, top / 2),
        view="right",
        count=2,
        note="at mid-thickness",
    )
    d.tapped(
        "target hole",
        "m4",
        (x, step, top / 2),
        (-1, 0, 0),
        thread_depth="stage.target_thread_depth",
        drill_depth="stage.target_drill_depth",
        view="right",
        count=4,
    )


def _island_dimensions(d: Declarations, design: Any) -> None:
    pads = design.pads
    (x, y), (x2, _), (_, far) = pad_centres(design)[:3]
    half, side, crown = pads.length / 2, pads.width / 2, -pads.height
    d.counted("pads", "pads.count", (x, y, crown), Z, view="bottom", feature="pad", note="PTFE film on the crowns")
    d.linear("pad length", "pads.length", (x - half, y, crown / 2), (x + half, y, crown / 2), view="bottom")
    d.linear("pad width", "pads.width", (x, y - side, crown / 2), (x, y + side, crown / 2), view="bottom")
    d.linear("pad height", "pads.height", (x, y, 0), (x, y, crown), view="front")
    d.radius("pad crown", "pads.crown_radius", (x, y, crown), view="front", note="spherical crown, all pads")
    nook = pads.corner_radius * (1 - math.sqrt(0.5))
    d.radius("pad corner", "pads.corner_radius", (x + half - nook, y + side - nook, crown / 2), view="bottom")
    root = pads.root_fillet * (1 - math.sqrt(0.5))
    d.radius("pad root fillet", "pads.root_fillet", (x, y + side + root, -root), view="bottom")
    d.linear("pad spacing along", "pads.spacing_along", (x, y, crown), (x2, y, crown), view="bottom")
    d.linear(
        "pad spacing across",
        "pads.spacing_across",
        (x, y, crown),
        (pad_centres(design)[2][0], far, crown),
        Y,
        view="bottom",
    )


def _underside_dimensions(d: Declarations, design: Any) -> None:
    s, sea = design.stage, design.sea
    if not sea.whole_underside:
        x, half, deep = s.length / 2 - 5, sea.width / 2, sea.groove_depth
        d.linear(
            "sea width",
            "sea.width",
            (x, -half, deep / 2),
            (x, half, deep / 2),
            view="bottom",
            note="friction coating between the grooves",
        )
        d.linear(
            "sea groove width",
            "sea.groove_width",
            (x, half, deep / 2),
            (x, half + sea.groove_width, deep / 2),
            count=2,
            view="bottom",
        )
        middle = half + sea.groove_width / 2
        d.depth("sea groove depth", "sea.groove_depth", (x, middle, 0), (x, middle, deep), count=2, view="bottom")
    if not design.teeth.fitted:
        return
    y, deep = design.teeth.bar_spacing / 2, s.iron_pocket_depth
    along, across = s.iron_pocket_length / 2, s.iron_pocket_width / 2
    d.linear("iron pocket spacing", "teeth.bar_spacing", (0, -y, deep), (0, y, deep), view="bottom")
    d.linear(
        "iron pocket length",
        "stage.iron_pocket_length",
        (-along, y, deep / 2),
        (along, y, deep / 2),
        count=2,
        view="bottom",
    )
    d.linear(
        "iron pocket width",
        "stage.iron_pocket_width",
        (0, y - across, deep / 2),
        (0, y + across, deep / 2),
        count=2,
        view="bottom",
    )
    d.depth(
        "iron pocket depth", "stage.iron_pocket_depth", (along - 3, y, 0), (along - 3, y, deep), count=2, view="bottom"
    )
    nook = s.iron_pocket_corner * (1 - math.sqrt(0.5))
    d.radius(
        "iron pocket corner",
        "stage.iron_pocket_corner",
        (along - nook, y + across - nook, deep / 2),
        count=8,
        view="bottom",
    )
    d.tapped("jack hole", "m3", (0, y, s.thickness), (0, 0, -1), count=2)


def requirements(design: Any) -> tuple[FaceRequirement, ...]:
    """A sea parallel to the plane of the pads' crowns: the tip's load stays the same along the travel."""
    f, down = FaceRequirements(design), (0.0, 0.0, -1.0)
    crowns = tuple((x, y, -design.pads.height) for x, y in sorted(pad_centres(design)))
    sea = ((0.0, 0.0, 0.0),)
    f.datum("A", crowns, down, "front")
    f.keeps("parallelism", "sea to pads", "drawing.tolerance_x_xx", sea, down, "front", datums=("A",))
    f.smooth("sea", "drive.roughness", sea, down, "front", "lapped")
    return tuple(f)
