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
  shallow grooves bound it: the lap runs out into them and the coating's mask ends there.
- Iron pockets: one over each toothed bar, taking the irons and the magnet between them; corners have the cutter's
  radius, smaller than the irons' own, so that these seat. A tapped hole through the roof lets squeezed-out adhesive
  and air escape and takes the jack screw that pushes the irons out again.
- Payload holes: grid of blind tapped holes on the payload face (through holes would break the sea).
- Dowel holes: two reamed holes, through, so that no air is trapped under a dowel; they place a payload repeatably.
- Target holes: two tapped holes in each end face for the target of the probe or the mirror of the interferometer.
"""
from __future__ import annotations

from typing import Any

import cadquery as cq

from stagecad.solids.blocks import cut_all, edges_where, joined, plate
from stagecad.solids.holes import OVERRUN, repeated, stepped_hole

NAME = "stage"


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
        (0.0, 0.0, top), (0, 0, -1), [(threads.m6_tap_drill, s.payload_drill_depth)],
        mouth_chamfer=s.hole_chamfer, drill_point=True,
    )
    cutters += repeated(hole, [(x, y, 0.0) for x, y in payload_grid(design)])
    dowel = stepped_hole((0.0, 0.0, top), (0, 0, -1), [(s.dowel_diameter, top + OVERRUN)], mouth_chamfer=s.hole_chamfer)
    cutters += repeated(dowel, [(side * s.dowel_spacing / 2, s.dowel_offset, 0.0) for side in (-1, 1)])
    for end in (-1, 1):
        target = stepped_hole(
            (end * s.length / 2, 0.0, top / 2), (-end, 0, 0), [(threads.m4_tap_drill, s.target_drill_depth)],
            mouth_chamfer=s.hole_chamfer, drill_point=True,
        )
        cutters += repeated(target, [(0.0, side * s.target_spacing / 2, 0.0) for side in (-1, 1)])
    if design.teeth.fitted:
        pocket = plate(
            (0.0, 0.0, -OVERRUN), s.iron_pocket_length, s.iron_pocket_width, OVERRUN + s.iron_pocket_depth,
            corner_radius=s.iron_pocket_corner,
        )
        jack = stepped_hole((0.0, 0.0, top), (0, 0, -1), [(threads.m3_tap_drill, top)], mouth_chamfer=s.hole_chamfer)
        places = [(0.0, side * design.teeth.bar_spacing / 2, 0.0) for side in (-1, 1)]
        cutters += repeated(pocket, places) + repeated(jack, places)
        groove = plate(
            (0.0, 0.0, -OVERRUN), s.length + 2 * OVERRUN, sea.groove_width, OVERRUN + sea.groove_depth
        )
        edge = (sea.width + sea.groove_width) / 2
        cutters += repeated(groove, [(0.0, side * edge, 0.0) for side in (-1, 1)])
    return cut_all(body, cutters)


def _with_islands(design: Any, body: cq.Solid) -> cq.Solid:
    """The plate with its islands: each a rounded prism whose foot is a piece of a large sphere."""
    pads = design.pads
    # The prism reaches up into the plate, so that the fuse meets no coinciding faces but the sphere's own.
    prism = plate(
        (0.0, 0.0, design.stage.thickness / 2), pads.length, pads.width, -(design.stage.thickness / 2 + pads.height),
        corner_radius=pads.corner_radius,
    )
    # Poles along y: the sphere's seam and poles stay off the crown, which is then one plain face.
    ball = cq.Solid.makeSphere(pads.crown_radius, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), -90, 90, 360).rotate(
        cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 90.0
    ).moved(cq.Location(cq.Vector(0, 0, pads.crown_radius - pads.height)))
    island = prism.intersect(ball).Solids()[0]
    centres = pad_centres(design)
    body = joined(body, repeated(island, [(x, y, 0.0) for x, y in centres]))

    def at_root(p: cq.Vector) -> bool:
        return abs(p.z) < 1e-6 and any(
            abs(p.x - x) <= pads.length / 2 + 1e-6 and abs(p.y - y) <= pads.width / 2 + 1e-6 for x, y in centres
        )

    return body.fillet(pads.root_fillet, edges_where(body, at_root)).Solids()[0]
