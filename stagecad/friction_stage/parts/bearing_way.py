"""The bearing way: a rail, lapped on top and bottom, bolted to the base along its outer edge.

Part coordinates: origin in the middle of the footprint, on the bedded underside; x along the travel, y across it with
the inner edge (the one towards the actuator) at +y, z up. The two ways are the same part: the right one (y < 0) stands
as here, the left one is turned half a turn about z.

Features and what each is for
- Rail: the pads slide on its top between the inner edge and the ledge; top and bottom are lapped, since both the
  smoothness of motion and the stiffness of the bedded joint come from these faces.
- Ledge along the outer edge: the screw heads sit on it, below the running face, and clamp a flange of uniform
  thickness 1.5 bolt diameters. (A counterbore so close to the edge would leave a wall of 2 mm of ceramic.)
- Fillet at the ledge's root: a sharp inner corner in a ceramic starts a crack.
- Clearance holes: a row of through holes at the spacing that makes the bolted joint stiffest.
- Chamfers on every outer edge: ceramic edges chip, and a chip on the running face is the end of a film of 2 um.
"""

from __future__ import annotations

from stagecad.friction_stage.design import Design
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
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, edges_where, plate
from stagecad.solids.modelling.kernel import cq

SYMMETRIC = "x"


def notes(design: Design) -> tuple[str, ...]:
    """Notes of the sheet."""
    pair = 1e3 * design.bearing_way.pair_tolerance
    return (
        "Row of holes symmetric about the middle of the length.",
        f"Two off, lapped together as a pair: heights equal within {pair:g} um, both marked with one number.",
        "Flatness of the face filtered by a Gaussian filter of 0.8 mm cut-off (ISO 12781-2).",
    )


def bolt_places(design: Design) -> list[tuple[float, float]]:
    """Places (x, y) of the screws in part coordinates, mm: one row, centred on the length."""
    way = design.bearing_way
    count = int(way.bolt_count)
    return [((i - (count - 1) / 2) * way.bolt_spacing, -way.width / 2 + way.bolt_edge) for i in range(count)]


def build(design: Design) -> cq.Solid:
    """The bearing way as one solid, mm."""
    way = design.bearing_way
    body = plate((0.0, 0.0, 0.0), way.length, way.width, way.height)
    ledge = plate(
        (0.0, -way.width / 2 + way.ledge_width / 2 - OVERRUN / 2, way.flange_thickness),
        way.length + 2 * OVERRUN,
        way.ledge_width + OVERRUN,
        way.height,
    )
    body = cut_all(body, [ledge])
    root = -way.width / 2 + way.ledge_width

    def at_root(p: cq.Vector) -> bool:
        return abs(p.y - root) < 1e-6 and abs(p.z - way.flange_thickness) < 1e-6

    body = body.fillet(way.ledge_fillet, edges_where(body, at_root)).Solids()[0]

    def outer(p: cq.Vector) -> bool:
        on_end, on_side = abs(abs(p.x) - way.length / 2) < 1e-6, abs(abs(p.y) - way.width / 2) < 1e-6
        on_top = abs(p.z - way.height) < 1e-6 or abs(p.z) < 1e-6
        on_ledge = abs(p.z - way.flange_thickness) < 1e-6 and p.y < root
        on_riser = abs(p.y - root) < 1e-6 and p.z > way.flange_thickness
        return on_end + on_side + on_top + on_ledge + on_riser >= 2

    body = body.chamfer(way.edge_chamfer, None, edges_where(body, outer)).Solids()[0]
    flange = way.flange_thickness
    through = (way.bolt_hole, flange + OVERRUN)
    return cut_all(body, drilled(bolt_places(design), flange, through, chamfer=way.hole_chamfer))


def datums(design: Design) -> dict[str, Datum]:
    """Bed, running face, and the seats of the screw heads."""
    way = design.bearing_way
    root = -way.width / 2 + way.ledge_width
    screws = [
        Datum(f"way_screw_{i}", (x, y, way.flange_thickness), Z)
        for i, (x, y) in enumerate(bolt_places(design), start=1)
    ]
    return named(
        Datum("bottom", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
        Datum("top", (0.0, (root + way.width / 2) / 2, way.height), Z),
        *screws,
    )


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the bearing way."""
    way, d = design.bearing_way, DimensionDeclarations(design, "bearing_way")
    x, y, top, flange = way.length / 2, way.width / 2, way.height, way.flange_thickness
    root, bolts = -y + way.ledge_width, bolt_places(design)
    bolt, row = bolts[0]
    plan, side = d.group(view="top"), d.group(view="right")
    plan.linear("length", "length", (-x, y / 2, top / 2), (x, y / 2, top / 2))
    plan.linear("width", "width", (0, -y, flange / 2), (0, y, flange / 2))
    side.linear("height", "height", (0, 0, 0), (0, 0, top))
    side.linear("ledge width", "ledge_width", (0, -y, flange / 2), (0, root, (flange + top) / 2 + 1), Y)
    side.linear("flange thickness", "flange_thickness", (x - 4, row, 0), (x - 4, row, flange))
    inset = fillet_inset(way.ledge_fillet)
    side.radius("ledge fillet", "ledge_fillet", (0, root - inset, flange + inset), X)
    hole, mouth = plan.group(feature="screw hole"), (bolt, row, flange)
    hole.diameter("screw hole", "bolt_hole", (bolt, row, flange / 2), count=len(bolts), note="through")
    hole.counted("screw holes", "bolt_count", mouth, X)
    plan.pitch("screw spacing", "bolt_spacing", mouth, (bolts[-1][0], row, flange), len(bolts) - 1)
    plan.linear("screw row to edge", "bolt_edge", (bolt, -y, flange / 2), mouth, Y)
    c = way.edge_chamfer / 2
    side.chamfer("edge chamfer", "edge_chamfer", (0, y - c, top - c), note="all outer edges")
    c = way.hole_chamfer / 2
    plan.chamfer("hole chamfer", "hole_chamfer", (bolt + way.bolt_hole / 2 + c, row, flange - c), count=len(bolts))
    return tuple(d)


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Lapped running face and bed: the motion is as straight as they are, the joint as stiff."""
    f, way = FaceRequirements(design), design.bearing_way
    ledge, down = -way.width / 2 + way.ledge_width, DOWN
    bed, run = ((0.0, way.width / 4, 0.0),), ((0.0, (ledge + way.width / 2) / 2, way.height),)
    f.datum("A", bed, down, "right")
    f.tolerance("flatness", "bed", "bearing.way_straightness", bed, down, "right")
    f.tolerance("flatness", "running face", "bearing.way_straightness", run, Z, "right")
    f.tolerance("parallelism", "running face to bed", "drawing.tolerance_x_xx", run, Z, "right", datums=("A",))
    f.texture("bed", "bearing.way_roughness", bed, down, "right", "lapped")
    f.texture("running face", "bearing.way_roughness", run, Z, "right", "lapped")
    return tuple(f)
