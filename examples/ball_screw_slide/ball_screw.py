"""ball_screw: rolled ball screw with journals."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import X, Z, named

NAME = "ball_screw"
PART_NUMBER = "BS 16x5"  # with a part number it is bought: no drawing
PARAMETERS = {"length": "340.0 mm", "diameter": "16.0 mm", "journal": "12.0 mm", "journal_length": "20.0 mm"}


def build(design):
    """The solid, mm: its axis along x, the thread from x = 0 to its length, a journal at each end."""
    import cadquery as cq

    p = design.ball_screw
    thread = cq.Workplane("YZ").circle(p.diameter / 2).extrude(p.length)
    journals = cq.Workplane("YZ").circle(p.journal / 2).extrude(p.length + 2 * p.journal_length)
    return thread.union(journals.translate((-p.journal_length, 0, 0)))


def material(design):
    return "steel"


def datums(design):
    """`shoulder`: end of the thread at its fixed journal, on the axis."""
    return named(Datum("shoulder", (0, 0, 0), (-1, 0, 0), Z), Datum("end", (design.ball_screw.length, 0, 0), X, Z))


def dimensions(design):
    return ()
