"""slide_bed: bed of the slide, a plate with two walls that bear the screw."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DimensionDeclarations, X, Y, Z, named

NAME = "slide_bed"
PARAMETERS = {
    "length": "380.0 mm",
    "width": "100.0 mm",
    "thickness": "20.0 mm",
    "wall": "20.0 mm",
    "wall_height": "60.0 mm",
    "bore": "12.00 mm",
    "axis_height": "35.0 mm",
}


def build(design):
    """The solid, mm: the upper face of the plate at z = 0."""
    import cadquery as cq

    p = design.slide_bed
    body = cq.Workplane("XY").box(p.length, p.width, p.thickness, centered=(True, True, False))
    body = body.translate((0, 0, -p.thickness))
    for side in (-1, 1):
        wall = cq.Workplane("XY").box(p.wall, p.width, p.wall_height, centered=(True, True, False))
        body = body.union(wall.translate((side * (p.length - p.wall) / 2, 0, 0)))
    bores = cq.Workplane("YZ").center(0, p.axis_height).circle(p.bore / 2).extrude(p.length, both=True)
    return body.cut(bores)


def material(design):
    return "al_6061_t6"


def datums(design):
    """`top`: of the plate; `bearing`: inner face of the left wall, on the screw's axis."""
    p = design.slide_bed
    inner = (-p.length / 2 + p.wall, 0, p.axis_height)
    return named(Datum("top", (0, 0, 0), Z, X), Datum("bearing", inner, X, Z))


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.slide_bed
    x, y, inner = p.length / 2, p.width / 2, p.length / 2 - p.wall
    d.linear("length", "length", (-x, -y, -p.thickness), (x, -y, -p.thickness), view="front")
    d.linear("thickness", "thickness", (x, -y, -p.thickness), (x, -y, 0), Z, view="right")
    d.linear("wall height", "wall_height", (inner, -y, 0), (inner, -y, p.wall_height), Z, view="front")
    d.linear("wall", "wall", (inner, -y, p.wall_height), (x, -y, p.wall_height), X, view="front", count=2)
    d.linear("width", "width", (x, -y, p.wall_height), (x, y, p.wall_height), Y, view="right")
    d.linear("height of the axis", "axis_height", (x, -y, 0), (x, 0, p.axis_height), Z, view="right")
    d.diameter("bore", "bore", (x, 0, p.axis_height), X, view="right", count=2)
    return tuple(d)
