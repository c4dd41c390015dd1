"""steel_ball: bearing ball on which the front plate turns."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, X, named

NAME = "steel_ball"
PART_NUMBER = "ISO 3290-1 - 6 G10"
PARAMETERS = {"diameter": "6 mm"}


def build(design):
    """The solid, mm: its middle at the origin."""
    import cadquery as cq

    return cq.Workplane("XY").sphere(design.steel_ball.diameter / 2)


def material(design):
    return "steel"


def datums(design):
    return named(Datum("middle", (0, 0, 0), DOWN, X))


def dimensions(design):
    return ()
