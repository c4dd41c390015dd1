"""foot: plate below the mount, screwed to the back plate and to the table."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named

NAME = "foot"
PARAMETERS = {
    "length": "60.0 mm",
    "width": "50.0 mm",
    "thickness": "10.0 mm",
    "row": "8.0 mm",
    "hole": "4.5 mm",
    "counterbore": "8.0 mm",
    "counterbore_depth": "4.6 mm",
    "slot": "6.6 mm",
    "slot_length": "12.0 mm",
    "slot_row": "36.0 mm",
    "slot_spacing": "44.0 mm",
}


def build(design):
    """The solid, mm: its upper face at z = 0, the edge below the back plate at y = 0."""
    import cadquery as cq

    p, q = design.foot, design.back_plate
    body = cq.Workplane("XY").box(p.length, p.width, p.thickness, centered=(True, False, False))
    body = body.translate((0, 0, -p.thickness))
    holes = [(-q.foot_spacing / 2, p.row), (q.foot_spacing / 2, p.row)]
    below = cq.Workplane("XY").workplane(offset=-p.thickness)
    body = body.cut(below.pushPoints(holes).circle(p.hole / 2).extrude(p.thickness))
    body = body.cut(below.pushPoints(holes).circle(p.counterbore / 2).extrude(p.counterbore_depth))
    slots = [(-p.slot_spacing / 2, p.slot_row), (p.slot_spacing / 2, p.slot_row)]
    return body.cut(below.pushPoints(slots).slot2D(p.slot_length + p.slot, p.slot, 90).extrude(p.thickness))


def material(design):
    return "al_6061_t6"


def datums(design):
    """`top`: between its two screws; `screw_1`, `screw_2`: seats of their heads, seen from below."""
    p, half = design.foot, design.back_plate.foot_spacing / 2
    seat = -p.thickness + p.counterbore_depth
    return named(
        Datum("top", (0, p.row, 0), Z, X),
        Datum("screw_1", (-half, p.row, seat), DOWN, X),
        Datum("screw_2", (half, p.row, seat), DOWN, X),
    )


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.foot
    x, y, half, slots = p.length / 2, p.width, design.back_plate.foot_spacing / 2, p.slot_spacing / 2
    low, high = p.slot_row - p.slot_length / 2, p.slot_row + p.slot_length / 2
    d.linear("length", "length", (-x, 0, -p.thickness), (x, 0, -p.thickness), view="bottom")
    d.linear("width", "width", (x, 0, -p.thickness), (x, y, -p.thickness), Y, view="bottom")
    d.linear("thickness", "thickness", (x, 0, -p.thickness), (x, 0, 0), Z, view="front")
    at, mouth = (half, p.row, -1), (half, p.row, -p.thickness)
    floor = (half, p.row, -p.thickness + p.counterbore_depth)
    d.diameter("hole", "hole", at, on=X, view="bottom", feature="screw", count=2, note="through")
    wide = (half, p.row, -p.thickness + 1)
    d.diameter("counterbore", "counterbore", wide, on=X, view="bottom", feature="screw", count=2)
    d.depth("counterbore depth", "counterbore_depth", mouth, floor, feature="screw", count=2)
    d.linear("hole spacing", "back_plate.foot_spacing", (-half, p.row, -p.thickness), mouth, X, view="bottom")
    d.linear("row", "row", (-x, 0, -p.thickness), (-half, p.row, -p.thickness), Y, view="bottom")
    wall = p.slot / 2
    d.linear("slot", "slot", (slots - wall, p.slot_row, 0), (slots + wall, p.slot_row, 0), X, view="bottom", count=2)
    d.linear("slot length", "slot_length", (slots, low, 0), (slots, high, 0), Y, view="bottom")
    d.linear("slot spacing", "slot_spacing", (-slots, high, 0), (slots, high, 0), X, view="bottom")
    d.derived("slots from the edge", low, (f"{NAME}.slot_row",), ((-x, 0, 0), (-slots, low, 0)), Y, view="bottom")
    return tuple(d)


def requirements(design):
    f = FaceRequirements(design)
    f.datum("A", ((design.foot.length / 2 - 4, 4, 0),), Z, "front")
    return tuple(f)
