"""slide_carriage: carriage of the slide with the thread of its nut."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, X, Y, Z, named

NAME = "slide_carriage"
PARAMETERS = {
    "length": "80.0 mm",
    "width": "90.0 mm",
    "height": "50.0 mm",
    "thread": "14.0 mm",
    "axis_height": "35.0 mm",
}


def build(design):
    """The solid, mm: its lower face at z = 0."""
    import cadquery as cq

    p = design.slide_carriage
    block = cq.Workplane("XY").box(p.length, p.width, p.height, centered=(True, True, False))
    return block.cut(cq.Workplane("YZ").center(0, p.axis_height).circle(p.thread / 2).extrude(p.length, both=True))


def material(design):
    return "al_6061_t6"


def datums(design):
    return named(Datum("bottom", (0, 0, 0), DOWN, X), Datum("top", (0, 0, design.slide_carriage.height), Z, X))


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.slide_carriage
    x, y = p.length / 2, p.width / 2
    d.linear("length", "length", (-x, -y, p.height), (x, -y, p.height), view="top")
    d.linear("width", "width", (-x, -y, p.height), (-x, y, p.height), Y, view="top")
    d.linear("height", "height", (x, -y, 0), (x, -y, p.height), Z, view="right")
    d.linear("height of the axis", "axis_height", (x, y, 0), (x, 0, p.axis_height), Z, view="right")
    d.diameter("core of the thread", "thread", (x, 0, p.axis_height), X, view="right")
    return tuple(d)
