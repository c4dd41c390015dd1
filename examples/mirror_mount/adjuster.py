"""adjuster: screw with a ball end and a knurled head."""

from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DimensionDeclarations, X, Z, named

NAME = "adjuster"
PARAMETERS = {
    "thread": "6.0 mm",
    "end_radius": "2.00 mm",
    "end": "= 2*end_radius",
    "end_length": "7.0 mm",
    "length": "26.0 mm",
    "head": "14.0 mm",
    "head_length": "9.0 mm",
    "edge": "0.5 mm",
}


def build(design):
    """The solid, mm: its axis along z, the middle of the ball end at the origin, the head below."""
    import cadquery as cq

    p = design.adjuster
    end, thread, head = p.end / 2, p.thread / 2, p.head / 2
    shoulder, seat = p.end_radius - p.end_length, p.end_radius - p.length
    below = seat - p.head_length
    outline = cq.Workplane("XZ").moveTo(0, below).lineTo(head, below).lineTo(head, seat).lineTo(thread, seat)
    outline = outline.lineTo(thread, shoulder - p.edge).lineTo(thread - p.edge, shoulder)
    outline = outline.lineTo(end, shoulder).lineTo(end, 0).radiusArc((0, end), -end).close()
    return outline.revolve(360, (0, 0, 0), (0, 1, 0))


def material(design):
    return "sus416"


def thread(design):
    """Major diameter and length of the thread, mm: its engagement in a tapped hole is no clash."""
    return design.adjuster.thread, design.adjuster.length


def datums(design):
    """`ball`: middle of the ball end."""
    return named(Datum("ball", (0, 0, 0), Z, X))


def dimensions(design):
    d, p = DimensionDeclarations(design, NAME), design.adjuster
    tip, shoulder, seat = p.end_radius, p.end_radius - p.end_length, p.end_radius - p.length
    below, top = seat - p.head_length, (0, 0, tip)
    d.remark("thread", (f"{NAME}.thread",), (p.thread / 2, 0, -15), "M6; full length", view="front")
    d.diameter("thread diameter", "thread", (0, 0, -15), on=X, view="front")
    d.radius("ball end", "end_radius", top, view="front", note="spherical")
    d.diameter("end", "end", (0, 0, -2), on=X, view="front")
    d.linear("end length", "end_length", top, (p.end / 2, 0, shoulder), Z, view="front")
    d.linear("length", "length", top, (p.head / 2, 0, seat), Z, view="front")
    d.linear("head length", "head_length", (p.head / 2, 0, seat), (p.head / 2, 0, below), Z, view="front")
    d.diameter("head", "head", (0, 0, below + 2), on=X, view="front")
    d.chamfer("edge", "edge", ((p.thread - p.edge) / 2, 0, shoulder - p.edge / 2), Z, view="front")
    return tuple(d)
