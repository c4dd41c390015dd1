"""The stage: an aluminium plate that slides on convex islands, is driven on its drive surface, and carries the payload.

Part coordinates: origin at mid-length and mid-width on the underside (the drive surface); x along the travel,
y across it, z up. The payload face is at z = thickness, the islands hang below z = 0. At mid-travel the part frame
is the assembly frame raised to the height of the drive surface.

Features and what each is for
- Plate: as light as stiffness at the payload allows; all suspension hardware that can be is on the base. Rounded
  upright corners and chamfered edges for handling.
- Islands: pads of 2 : 1 proud of the underside, crowned so that they ride on their middle whatever the way's and the
  plate's errors, carrying the PTFE film. Three of them determine height, pitch and roll (a fourth is for
  gravity preload). A fillet at the root is what the bull-nosed cutter leaves.
- Drive surface: strip of the underside along the travel, lapped and coated with friction material, on which the tip
  acts. Two shallow grooves bound it: lapping and the mask of the coating end there. (For two axes the whole underside
  is drive surface, without grooves.)
- Iron pockets: one over each toothed bar, taking the irons and the magnet between them; corners have the cutter's
  radius, smaller than the irons' own, so that these seat. A tapped hole through the roof lets squeezed-out adhesive
  and air escape and takes the jack screw that pushes the irons out again.
- Payload holes: grid of blind tapped holes on the payload face (through holes would break the drive surface).
- Dowel holes: two reamed holes, through, so that no air is trapped under a dowel; they place a payload repeatably.
- Target holes: two tapped holes in each end face for the target of the probe or the mirror of the interferometer.
"""

from __future__ import annotations

import math

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.friction_stage.parts.tooth_bar import pole_offset
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement, Point
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
    stepped_hole,
)
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "xy"
TREATMENT = "anodise, PTFE: see notes"


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheet."""
    film, coating = 1e6 * design.bearing.film_thickness, 1e6 * design.drive.sea_coating_thickness
    words = [
        "Holes, pads, drive surface and pockets symmetric about the middle of length and width where no distance is "
        "given.",
        f"Crowns coated with PTFE, {film:g} um thick, after finishing, by a coater; dimensions before coating.",
        f"Drive surface hard anodised, layer {coating:g} um, then lapped; dimensions and roughness after coating. "
        "All else masked.",
        "Datum A: common tangent plane of the crowns at A1 to A" + f"{design.pads.count}.",
    ]
    if design.pads.count == 3:
        words.insert(1, "The single pad of three is in the middle of the length.")
    return tuple(words)


def build(design: Design) -> cq.Solid:
    """The stage as one solid, mm."""
    s, sea, threads = design.stage, design.sea, design.threads
    body = plate((0.0, 0.0, 0.0), s.length, s.width, s.thickness, corner_radius=s.corner_radius)
    rim = edges_where(body, lambda p: abs(p.z) < 1e-9 or abs(p.z - s.thickness) < 1e-9)
    body = body.chamfer(s.edge_chamfer, None, rim)
    body = _with_pads(design, body)

    cutters: list[cq.Shape] = []
    top, mouth = s.thickness, s.hole_chamfer
    tapped = (threads.m6_tap_drill, s.payload_drill_depth)
    cutters += drilled(Derived(design).payload_places, top, tapped, chamfer=mouth, point=True)
    dowels = [(side * s.dowel_spacing / 2, s.dowel_offset) for side in (-1, 1)]
    cutters += drilled(dowels, top, (s.dowel_diameter, top + OVERRUN), chamfer=mouth)
    tapped = (threads.m4_tap_drill, s.target_drill_depth)
    for end in (-1, 1):
        target = stepped_hole((end * s.length / 2, 0.0, top / 2), (-end, 0, 0), tapped, chamfer=mouth, point=True)
        cutters += repeated(target, [(0.0, side * s.target_spacing / 2, 0.0) for side in (-1, 1)])
    if design.teeth.fitted:
        sizes = s.iron_pocket_length, s.iron_pocket_width, OVERRUN + s.iron_pocket_depth
        pocket = plate((0.0, 0.0, -OVERRUN), *sizes, corner_radius=s.iron_pocket_corner)
        rows = [side * design.teeth.bar_spacing / 2 for side in (-1, 1)]
        cutters += repeated(pocket, [(0.0, y, 0.0) for y in rows])
        cutters += drilled([(0.0, y) for y in rows], top, (threads.m3_tap_drill, top), chamfer=mouth)
    if not sea.whole_underside:
        groove = plate((0.0, 0.0, -OVERRUN), s.length + 2 * OVERRUN, sea.groove_width, OVERRUN + sea.groove_depth)
        cutters += repeated(groove, [(0.0, side * (sea.width + sea.groove_width) / 2, 0.0) for side in (-1, 1)])
    return cut_all(body, cutters)


def _with_pads(design: Design, body: cq.Solid) -> cq.Solid:
    """The plate with its islands: each a rounded prism whose foot is a piece of a large sphere."""
    pads = design.pads
    # The prism reaches up into the plate, so that the fuse meets no coinciding faces but the sphere's own.
    half = design.stage.thickness / 2
    sizes = pads.length, pads.width, -(half + pads.height)
    prism = plate((0.0, 0.0, half), *sizes, corner_radius=pads.corner_radius)
    # Poles along y: the sphere's seam and poles stay off the crown, which is then one plain face.
    ball = (
        cq.Solid.makeSphere(pads.crown_radius, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), -90, 90, 360)
        .rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 90.0)
        .moved(cq.Location(cq.Vector(0, 0, pads.crown_radius - pads.height)))
    )
    island = prism.intersect(ball).Solids()[0]
    centres = Derived(design).pad_places
    body = joined(body, repeated(island, [(x, y, 0.0) for x, y in centres]))

    def at_root(p: cq.Vector) -> bool:
        return abs(p.z) < 1e-6 and any(
            abs(p.x - x) <= pads.length / 2 + 1e-6 and abs(p.y - y) <= pads.width / 2 + 1e-6 for x, y in centres
        )

    return body.fillet(pads.root_fillet, edges_where(body, at_root)).Solids()[0]


def defined_by_note(design: Design, point: Point) -> str:
    """What defines faces beside the dimensions: the height of the target holes."""
    s = design.stage
    in_end = s.length / 2 - abs(point[0]) < s.target_drill_depth and abs(abs(point[1]) - s.target_spacing / 2) < 1e-3
    return "note: at mid-thickness" if in_end and abs(point[2] - s.thickness / 2) < 1e-3 else ""


def datums(design: Design) -> dict[str, Datum]:
    """Crowns of the pads, payload face, drive surface, and the seats of irons and magnets."""
    s, down = design.stage, DOWN
    crown = -design.pads.height
    found = [
        Datum(f"pad_{i}", (x, y, crown), down) for i, (x, y) in enumerate(sorted(Derived(design).pad_places), start=1)
    ]
    found += [
        Datum("pads", (0.0, 0.0, crown), down),
        Datum("top", (0.0, 0.0, s.thickness), Z),
        Datum("drive_surface", (0.0, 0.0, 0.0), down),
        Datum("mirror_1", (-s.length / 2, 0.0, s.thickness / 2), (-1.0, 0.0, 0.0), Y),
    ]
    if design.teeth.fitted:
        seats = [side * design.teeth.bar_spacing / 2 for side in (-1, 1)]
        poles = [seat + side * pole_offset(design) for seat in seats for side in (-1, 1)]
        roof = s.iron_pocket_depth
        found += [Datum(f"tooth_iron_{i}", (0.0, y, roof), down) for i, y in enumerate(poles, start=1)]
        found += [Datum(f"magnet_{i}", (0.0, y, roof), down) for i, y in enumerate(seats, start=1)]
    return named(*found)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the stage."""
    d = DimensionDeclarations(design, "stage")
    _plate_dimensions(d, design)
    _payload_hole_dimensions(d, design)
    _dowel_and_target_dimensions(d, design)
    _pad_dimensions(d.group(view="bottom"), design)
    if not design.sea.whole_underside:
        _drive_surface_dimensions(d.group(view="bottom"), design)
    if design.teeth.fitted:
        _iron_pocket_dimensions(d.group(view="bottom"), design)
        d.tapped("jack hole", "m3", (0, design.teeth.bar_spacing / 2, design.stage.thickness), DOWN, count=2)
    return tuple(d)


def _plate_dimensions(d: DimensionDeclarations, design: Design) -> None:
    s = design.stage
    x, y, top = s.length / 2, s.width / 2, s.thickness
    d.linear("length", "length", (-x, 0, top / 2), (x, 0, top / 2), view="top")
    d.linear("width", "width", (0, -y, top / 2), (0, y, top / 2), view="top")
    d.linear("thickness", "thickness", (x - 10, y - 10, 0), (x - 10, y - 10, top), view="front")
    inset = fillet_inset(s.corner_radius)
    d.radius("corner radius", "corner_radius", (x - inset, y - inset, top / 2), count=4, view="top")
    c = s.edge_chamfer / 2
    d.chamfer("edge chamfer", "edge_chamfer", (x - c, 0, top - c), note="all outer edges", view="front")


def _payload_hole_dimensions(d: DimensionDeclarations, design: Design) -> None:
    s, (x, y), top = design.stage, Derived(design).payload_places[0], design.stage.thickness
    count, hole = s.payload_columns * s.payload_rows, (x, y, top)
    d.tapped("payload hole", "m6", hole, DOWN, ("payload_thread_depth", "payload_drill_depth"), count=count)
    d.counted("payload columns", "payload_columns", hole, X, feature="payload hole", view="top")
    d.counted("payload rows", "payload_rows", hole, Y, feature="payload hole", view="top")
    d.pitch("payload pitch", "payload_pitch", hole, (-x, y, top), s.payload_columns - 1, view="top", exact=True)
    keys, rows = ("stage.payload_pitch", "stage.payload_rows"), s.payload_rows - 1
    ends = ((x, y, top), (x, -y, top))
    d.derived("payload pitch across", s.payload_pitch, keys, ends, Y, kind="pitch", count=rows, view="top", exact=True)
    c = s.hole_chamfer / 2
    mouth = (x + design.threads.m6_tap_drill / 2 + c, y, top - c)
    d.chamfer("hole chamfer", "hole_chamfer", mouth, note="mouths of all holes", view="top")


def _dowel_and_target_dimensions(d: DimensionDeclarations, design: Design) -> None:
    s = design.stage
    end, top, x, y = s.length / 2, s.thickness, s.dowel_spacing / 2, s.dowel_offset
    plan = d.group(view="top")
    hole, middle = (x, y, top), (x, y, top / 2)
    plan.diameter("dowel hole", "dowel_diameter", middle, feature="dowel hole", count=2, note="reamed, through")
    plan.linear("dowel spacing", "dowel_spacing", (-x, y, top), hole, exact=True)
    plan.linear("dowel offset", "dowel_offset", (end, 0, top), hole, Y, note="from the middle", exact=True)
    y = s.target_spacing / 2
    side, hole = d.group(view="right"), (end, y, top / 2)
    side.linear("target spacing", "target_spacing", (end, -y, top / 2), hole, count=2, note="at mid-thickness")
    depths = ("target_thread_depth", "target_drill_depth")
    side.tapped("target hole", "m4", hole, (-1, 0, 0), depths, count=4, extra="2 in each end face")


def _pad_dimensions(d: DimensionDeclarations, design: Design) -> None:
    pads, places = design.pads, Derived(design).pad_places
    (x, y), (x2, _), (x3, y3) = places[:3]
    half, side, low = pads.length / 2, pads.width / 2, -pads.height
    crown, middle = (x, y, low), low / 2
    d.counted("pads", "pads.count", crown, Z, feature="pad", note="with PTFE film")
    every = d.group(count=pads.count)
    every.linear("pad length", "pads.length", (x3 - half, y3, middle), (x3 + half, y3, middle))
    every.linear("pad width", "pads.width", (x, y - side, middle), (x, y + side, middle))
    every.linear("pad height", "pads.height", (x, y, 0), crown, view="right")
    d.radius("pad crown", "pads.crown_radius", crown, view="front", note="spherical", tolerance=None, reference=True)
    sag = pads.crown_radius - math.sqrt(pads.crown_radius**2 - half**2)
    ends, tolerance = (crown, (x + pads.length, y, low)), pads.sag_tolerance
    keys, limits = ("pads.crown_radius", "pads.length"), (-tolerance, tolerance)
    fields = {"kind": "sag", "tolerance": None, "deviations": limits, "view": "front", "note": "all pads"}
    d.derived("pad crown height", sag, keys, ends, X, **fields)
    inset = fillet_inset(pads.corner_radius)
    d.radius("pad corner", "pads.corner_radius", (x + half - inset, y + side - inset, middle), count=4 * pads.count)
    inset = fillet_inset(pads.root_fillet)
    root = (x, y + side + inset, -inset)
    d.radius("pad root fillet", "pads.root_fillet", root, X, view="right", note="all pads")
    # The places of the datum targets are theoretically exact (ISO 5459).
    d.linear("pad spacing along", "pads.spacing_along", crown, (x2, y, low), exact=True)
    d.linear("pad spacing across", "pads.spacing_across", crown, (x3, y3, low), Y, exact=True)


def _drive_surface_dimensions(d: DimensionDeclarations, design: Design) -> None:
    sea = design.sea
    x, half, deep = design.stage.length / 2 - 5, sea.width / 2, sea.groove_depth
    outer, middle = half + sea.groove_width, half + sea.groove_width / 2
    inner, note = (x, half, deep / 2), "friction coating between the grooves"
    d.linear("drive surface width", "sea.width", (x, -half, deep / 2), inner, note=note)
    d.linear("drive surface groove width", "sea.groove_width", inner, (x, outer, deep / 2), count=2)
    d.depth("drive surface groove depth", "sea.groove_depth", (x, middle, 0), (x, middle, deep), count=2)


def _iron_pocket_dimensions(d: DimensionDeclarations, design: Design) -> None:
    s, y, deep = design.stage, design.teeth.bar_spacing / 2, design.stage.iron_pocket_depth
    x, across, middle = s.iron_pocket_length / 2, s.iron_pocket_width / 2, deep / 2
    low, high, pair = y - across, y + across, d.group(count=2)
    d.linear("iron pocket spacing", "teeth.bar_spacing", (0, -y, deep), (0, y, deep))
    pair.linear("iron pocket length", "iron_pocket_length", (-x, y, middle), (x, y, middle))
    pair.linear("iron pocket width", "iron_pocket_width", (0, low, middle), (0, high, middle))
    pair.depth("iron pocket depth", "iron_pocket_depth", (x - 3, y, 0), (x - 3, y, deep), view="section")
    inset = fillet_inset(s.iron_pocket_corner)
    d.radius("iron pocket corner", "iron_pocket_corner", (x - inset, high - inset, middle), count=8)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """A drive surface parallel to the plane of the pads' crowns: the tip's load stays the same along the travel."""
    f, down = FaceRequirements(design), DOWN
    crowns = tuple((x, y, -design.pads.height) for x, y in sorted(Derived(design).pad_places))
    surface = ((0.0, 0.0, 0.0),)
    f.datum("A", crowns, down, "front", targets="bottom")
    f.tolerance("parallelism", "drive surface to pads", "drawing.tolerance_x_xx", surface, down, "right", datums=("A",))
    f.texture("drive surface", "drive.roughness", surface, down, "right", "lapped")
    f.texture("crowns of the pads", "pads.roughness", crowns, down, "front", "all pads")
    s, middle = design.stage, design.stage.thickness / 2
    x, y = s.length / 2, s.width / 2
    f.datum("B", ((0.0, y, middle), (0.0, -y, middle)), Y, "top", median=True)
    f.datum("C", ((x, 0.0, middle), (-x, 0.0, middle)), X, "top", median=True)
    payload = tuple((x, y, s.thickness - s.payload_drill_depth / 2) for x, y in Derived(design).payload_places)
    dowels = tuple((side * s.dowel_spacing / 2, s.dowel_offset, middle) for side in (-1, 1))
    for hole, key, places in (
        ("payload hole", "drawing.hole_position", payload),
        ("dowel hole", "drawing.function_position", dowels),
    ):
        f.tolerance("position", hole, key, places, Z, "top", datums=("A", "B", "C"), round=True, feature=hole)
    wall = (dowels[1][0] - s.dowel_diameter / 2, dowels[1][1], middle)
    f.texture("dowel hole", "drawing.fit_roughness", (wall,), X, "top", feature="dowel hole")
    return tuple(f)
