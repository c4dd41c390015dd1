"""front_plate: plate that carries the mirror, with cone, groove and plane for three balls."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z, named

NAME = "front_plate"
PARAMETERS = {
    "side": "60.0 mm",
    "thickness": "14.0 mm",
    "mirror": "25.4 H8",
    "mirror_depth": "7.0 mm",
    "opening": "20.0 mm",
    "spacing": "40.00 mm",
    "cone": "5.00 mm",
    "groove": "5.00 mm",
    "groove_length": "12.0 mm",
    "clamp_height": "10.0 mm",
    "flatness": {"value": "0.01 mm", "tolerance": "X"},
    "parallel": {"value": "0.02 mm", "tolerance": "X"},
}

NOTES = ("Groove: V of 90°, its bottom in line with the cone.",)


def build(design):
    """The solid, mm: the face with cone, groove and plane at z = 0; its middle on the optical axis."""
    import cadquery as cq

    p = design.front_plate
    half, t, deep = p.spacing / 2, p.thickness, p.groove / 2
    body = cq.Workplane("XY").box(p.side, p.side, t, centered=(True, True, False))
    body = body.cut(cq.Workplane("XY").circle(p.opening / 2).extrude(t))
    body = body.cut(cq.Workplane("XY").workplane(offset=t).circle(p.mirror / 2).extrude(-p.mirror_depth))
    cone = cq.Solid.makeCone(p.cone / 2, 0, p.cone / 2, cq.Vector(-half, -half, 0), cq.Vector(0, 0, 1))
    section = [(-half - deep, 0), (-half + deep, 0), (-half, deep)]
    groove = cq.Workplane("YZ").workplane(offset=half - p.groove_length / 2).polyline(section).close()
    body = body.cut(cq.Workplane(cone)).cut(groove.extrude(p.groove_length))
    side = cq.Workplane("XZ").workplane(offset=-p.side / 2).center(0, p.clamp_height)
    return body.cut(side.circle(design.thread("m3").tap_drill / 2).extrude(p.side / 2 - p.mirror / 2 + 2))


def material(design):
    return "al_6061_t6"


def datums(design):
    """`pivot`: middle of the ball in the cone, below the plate; `mirror`: floor of its bore; `clamp`: its thread."""
    p = design.front_plate
    half, radius = p.spacing / 2, design.steel_ball.diameter / 2
    ball = p.cone / 2 - 2**0.5 * radius
    return named(
        Datum("pivot", (-half, -half, ball), DOWN, X),
        Datum("mirror", (0, 0, p.thickness - p.mirror_depth), Z, X),
        Datum("clamp", (0, p.side / 2, p.clamp_height), Y, X),
    )


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.front_plate
    half, edge, t, deep = p.spacing / 2, p.side / 2, p.thickness, p.groove / 2
    d.linear("length", "side", (-edge, -edge, 0), (edge, -edge, 0), view="bottom")
    d.linear("width", "side", (-edge, -edge, 0), (-edge, edge, 0), Y, view="bottom")
    d.linear("thickness", "thickness", (edge, -edge, 0), (edge, -edge, t), Z, view="right")
    d.diameter("mirror", "mirror", (0, 0, t - 1), on=X, view="top", feature="mirror")
    d.depth("mirror depth", "mirror_depth", (0, 0, t), (0, 0, t - p.mirror_depth), feature="mirror")
    d.diameter("opening", "opening", (0, 0, 1), on=X, view="bottom", note="through")
    d.diameter("cone countersink", "cone", (-half, -half, 0), view="bottom", note="x 90°")
    keys = (f"{NAME}.side", f"{NAME}.spacing")
    across = ((-edge, -edge, 0), (-half, -half, 0))
    d.derived("cone from the side", edge - half, keys, across, X, view="bottom")
    d.derived("cone from the lower side", edge - half, keys, across, Y, view="bottom")
    d.linear("groove", "groove", (half, -half - deep, 0), (half, -half + deep, 0), Y, view="bottom")
    left, right = half - p.groove_length / 2, half + p.groove_length / 2
    end = ((-half, -half, 0), (left, -half + deep, 0))
    d.derived("groove from the cone", left + half, (f"{NAME}.spacing",), end, X, view="bottom")
    d.linear("groove length", "groove_length", (left, -half + deep, 0), (right, -half + deep, 0), X, view="bottom")
    d.tapped("clamp", "m3", (0, edge, p.clamp_height), (0, -1, 0), view="back", extra="to the mirror's bore")
    d.linear("clamp height", "clamp_height", (edge, edge, 0), (0, edge, p.clamp_height), Z, view="back")
    return tuple(d)


def defined_by_note(design, point):
    """The walls of the groove, which the note describes."""
    p = design.front_plate
    deep, (x, y, z) = p.groove / 2, point
    inside = abs(x - p.spacing / 2) < p.groove_length / 2 and abs(y + p.spacing / 2) < deep and 0 < z < deep
    return NOTES[0] if inside else ""


def requirements(design):
    f, p = FaceRequirements(design), design.front_plate
    edge, t = p.side / 2, p.thickness
    back, seat = ((edge - 6, -edge + 6, 0),), ((p.opening / 2 + 1, 0, t - p.mirror_depth),)
    f.datum("A", back, DOWN, "right")
    f.tolerance("flatness", "plane of the adjuster", "front_plate.flatness", back, DOWN, "right")
    f.tolerance("parallelism", "seat of the mirror", "front_plate.parallel", seat, Z, "section", datums=("A",))
    return tuple(f)
