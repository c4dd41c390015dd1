"""back_plate: fixed plate of the mount with the seat of the ball and the threads of two adjusters."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named

NAME = "back_plate"
PARAMETERS = {
    "side": "60.0 mm",
    "thickness": "12.0 mm",
    "bore": "28.0 mm",
    "spacing": "40.00 mm",
    "seat": "6 H7",
    "seat_depth": "3.00 mm",
    "foot_spacing": "30.0 mm",
    "foot_thread_depth": "10.0 mm",
    "foot_drill_depth": "13.0 mm",
    "flatness": {"value": "0.02 mm", "tolerance": "X"},
    "square": {"value": "0.05 mm", "tolerance": "X"},
    "roughness": {"value": "0.0008 mm", "tolerance": "X"},
}


def build(design):
    """The solid, mm: the face towards the mirror at z = 0; its middle on the optical axis."""
    import cadquery as cq

    p = design.back_plate
    half, t = p.spacing / 2, p.thickness
    body = cq.Workplane("XY").box(p.side, p.side, t, centered=(True, True, False)).translate((0, 0, -t))
    top = cq.Workplane("XY")
    body = body.cut(top.circle(p.bore / 2).extrude(-t))
    body = body.cut(top.center(-half, -half).circle(p.seat / 2).extrude(-p.seat_depth))
    threads = top.pushPoints([(half, -half), (-half, half)]).circle(design.thread("m6").tap_drill / 2)
    body = body.cut(threads.extrude(-t))
    side = cq.Workplane("XZ").workplane(offset=p.side / 2).center(0, -t / 2)
    places = [(-p.foot_spacing / 2, 0), (p.foot_spacing / 2, 0)]
    return body.cut(side.pushPoints(places).circle(design.thread("m4").tap_drill / 2).extrude(-p.foot_drill_depth))


def material(design):
    return "al_6061_t6"


def datums(design):
    """`pivot`: middle of the ball; `adjuster_1`, `adjuster_2`: of the threads, towards the heads; `foot`: below."""
    p = design.back_plate
    half, t = p.spacing / 2, p.thickness
    ball = (-half, -half, design.steel_ball.diameter / 2 - p.seat_depth)
    return named(
        Datum("pivot", ball, Z, X),
        Datum("adjuster_1", (half, -half, 0), DOWN, X),
        Datum("adjuster_2", (-half, half, 0), DOWN, X),
        Datum("foot", (0, -p.side / 2, -t / 2), (0, -1, 0), X),
    )


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.back_plate
    half, edge, t = p.spacing / 2, p.side / 2, p.thickness
    d.linear("length", "side", (-edge, -edge, 0), (edge, -edge, 0), view="top")
    d.linear("width", "side", (edge, -edge, 0), (edge, edge, 0), Y, view="top")
    d.linear("thickness", "thickness", (edge, -edge, -t), (edge, -edge, 0), Z, view="front")
    d.diameter("bore", "bore", (0, 0, -t / 2), view="top", note="through")
    d.linear("spacing", "spacing", (-half, -half, 0), (half, -half, 0), X, view="top")
    d.linear("spacing across", "spacing", (-half, -half, 0), (-half, half, 0), Y, view="top")
    d.diameter("seat of the ball", "seat", (-half, -half, -1), view="top", feature="seat")
    d.depth("depth of the seat", "seat_depth", (-half, -half, 0), (-half, -half, -p.seat_depth), feature="seat")
    d.tapped("adjuster", "m6", (half, -half, 0), DOWN, count=2)
    depths, front = ("foot_thread_depth", "foot_drill_depth"), p.foot_spacing / 2
    d.tapped("foot", "m4", (-front, -edge, -t / 2), Y, depths, count=2, view="front")
    d.linear("foot spacing", "foot_spacing", (-front, -edge, -t / 2), (front, -edge, -t / 2), X, view="front")
    keys = (f"{NAME}.thickness",)
    d.derived("foot height", t / 2, keys, ((edge, -edge, -t), (front, -edge, -t / 2)), Z, view="front")
    return tuple(d)


def requirements(design):
    f, edge, t = FaceRequirements(design), design.back_plate.side / 2, design.back_plate.thickness
    front, foot = ((edge - 8, -edge + 8, 0),), ((edge - 5, -edge, -t / 2),)
    f.datum("A", front, Z, "front")
    f.datum("B", foot, (0, -1, 0), "top")
    f.tolerance("flatness", "front face", "back_plate.flatness", front, Z, "front")
    f.tolerance("perpendicularity", "foot", "back_plate.square", foot, (0, -1, 0), "top", datums=("A",))
    seat = ((-design.back_plate.spacing / 2 + 3, -design.back_plate.spacing / 2, -1),)
    f.texture("seat", "back_plate.roughness", seat, X, "section")
    return tuple(f)
