"""declarations: a plate with one feature of each kind, for the picture of the declarations in the documentation."""

import math

from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Y, Z

NAME = "declarations"
PARAMETERS = {
    "length": "120.0 mm",
    "width": "70.0 mm",
    "thickness": "16.0 mm",
    "corner": "8.0 mm",
    "bore": "20 H7",
    "bore_place": "30.0 mm",
    "edge": "1.0 mm",
    "circle": "36.0 mm",
    "circle_hole": "4.2 mm",
    "screw_hole": "5.5 mm",
    "counterbore": "10.0 mm",
    "counterbore_depth": "5.5 mm",
    "screw_place": "105.0 mm",
    "screw_spacing": "44.0 mm",
    "thread_place": "70.0 mm",
    "thread_across": "20.0 mm",
    "thread_depth": "9.0 mm",
    "drill_depth": "12.0 mm",
    "pin": "4.0 mm",
    "pitch": "12.0 mm",
    "row": "10.0 mm",
    "oil_hole": "4.0 mm",
    "oil_place": "82.0 mm",
    "oil_angle": "60 deg",
    "flat": {"value": "0.02 mm", "tolerance": "X"},
    "place": {"value": "0.1 mm", "tolerance": "X"},
    "fine": {"value": "0.0016 mm", "tolerance": "X"},
}
VIEWS = ("top", "front")
NOTES = ("Example of the documentation.",)


def build(design):
    """The solid, mm: the middle of its lower face at the origin."""
    import cadquery as cq

    p = design.declarations
    x, y, t = p.length / 2, p.width / 2, p.thickness
    body = cq.Workplane("XY").box(p.length, p.width, t, centered=(True, True, False)).edges("|Z").fillet(p.corner)
    top = cq.Workplane("XY").workplane(offset=t)
    bore = p.bore_place - x
    body = body.cut(top.center(bore, 0).circle(p.bore / 2).extrude(-t))
    mouth = cq.Solid.makeCone(p.bore / 2 + p.edge, p.bore / 2, p.edge, cq.Vector(bore, 0, t), cq.Vector(0, 0, -1))
    body = body.cut(cq.Workplane(mouth))
    body = body.cut(top.center(bore, 0).polarArray(p.circle / 2, 45, 360, 4).circle(p.circle_hole / 2).extrude(-t))
    screws = [(p.screw_place - x, side * p.screw_spacing / 2) for side in (-1, 1)]
    body = body.cut(top.pushPoints(screws).circle(p.screw_hole / 2).extrude(-t))
    body = body.cut(top.pushPoints(screws).circle(p.counterbore / 2).extrude(-p.counterbore_depth))
    thread = top.center(p.thread_place - x, p.thread_across).circle(design.thread("m6").tap_drill / 2)
    body = body.cut(thread.extrude(-p.drill_depth))
    pins = [(number * p.pitch, p.row - y) for number in range(4)]
    body = body.cut(top.pushPoints(pins).circle(p.pin / 2).extrude(-t))
    lean = 90 - p.oil_angle
    drill = cq.Solid.makeCylinder(p.oil_hole / 2, 60, cq.Vector(0, 0, -30)).rotate((0, 0, 0), (0, 1, 0), -lean)
    return body.cut(cq.Workplane(drill.translate((p.oil_place - x, 0, t))))


def material(design):
    return "al_6061_t6"


def dimensions(design):
    """Each kind of dimension once or more."""
    d, p = DimensionDeclarations(design, NAME), design.declarations
    x, y, t, c = p.length / 2, p.width / 2, p.thickness, p.corner
    left, bore, oil = (-x, -y + c, t), p.bore_place - x, p.oil_place - x
    d.linear("length", "length", left, (x, -y + c, t), X, view="top")
    d.linear("width", "width", (x - c, -y, t), (x - c, y, t), Y, view="top")
    d.linear("thickness", "thickness", (x, -y + c, 0), (x, -y + c, t), Z, view="front")
    corner = c * (1 - math.sqrt(0.5))
    d.radius("corner", "corner", (-x + corner, -y + corner, t / 2), view="top", count=4)
    d.linear("place of the bore", "bore_place", left, (bore, 0, t), X, view="top")
    d.diameter("bore", "bore", (bore, 0, t / 2), on=X, view="top", note="through", feature="bore")
    middle = p.bore / 2 + p.edge / 2
    d.chamfer("edge of the bore", "edge", (bore + middle, 0, t - p.edge / 2), Z, view="section")
    turn = p.circle / 2 * math.sqrt(0.5)
    d.pitch_circle("circle", "circle", (bore, 0, t / 2), (bore + turn, turn, t / 2), 4, view="top")
    d.diameter("hole of the circle", "circle_hole", (bore + turn, turn, t / 2), view="top", count=4, note="through")
    at, half = p.screw_place - x, p.screw_spacing / 2
    screw = {"view": "top", "feature": "screw", "count": 2}
    d.diameter("screw hole", "screw_hole", (at, half, 1), on=X, note="through", **screw)
    d.diameter("counterbore", "counterbore", (at, half, t - 1), on=X, **screw)
    d.depth("counterbore depth", "counterbore_depth", (at, half, t), (at, half, t - p.counterbore_depth), **screw)
    d.linear("place of the screws", "screw_place", left, (at, -half, t), X, view="top")
    d.linear("spacing of the screws", "screw_spacing", (at, -half, t), (at, half, t), Y, view="top")
    thread = (p.thread_place - x, p.thread_across, t)
    d.tapped("thread", "m6", thread, DOWN, ("thread_depth", "drill_depth"))
    d.linear("place of the thread", "thread_place", left, thread, X, view="top")
    d.linear("thread from the bore", "thread_across", (bore, 0, t), thread, Y, view="top")
    first, last = (0.0, p.row - y, t), (3 * p.pitch, p.row - y, t)
    d.pitch("row of pins", "pitch", first, last, 3, view="top")
    d.diameter("pin", "pin", (0.0, p.row - y, t / 2), view="top", count=4, note="through")
    d.linear("place of the row", "row", (-x + c, -y, t), first, Y, view="top")
    lean = math.radians(p.oil_angle)
    inside = (oil + 6 * math.cos(lean), 0, t - 6 * math.sin(lean))
    touch = (math.sin(lean), 0, math.cos(lean))
    d.diameter("oil hole", "oil_hole", inside, (math.cos(lean), 0, -math.sin(lean)), on=touch, view="section")
    d.angle("angle of the oil hole", "oil_angle", (oil, 0, t), inside, X, view="section")
    d.linear("place of the oil hole", "oil_place", (-x, 0, t), (oil, 0, t), X, view="section")
    return tuple(d)


def requirements(design):
    """A datum system, and tolerances of form, orientation and location, and a roughness."""
    f, p = FaceRequirements(design), design.declarations
    x, bore = p.length / 2, p.bore_place - p.length / 2
    low, side = ((x - 12, 0, 0),), ((0, -p.width / 2, p.thickness / 2),)
    f.datum("A", low, DOWN, "section")
    f.datum("B", side, (0, -1, 0), "top")
    f.tolerance("flatness", "lower face", "declarations.flat", low, DOWN, "section")
    wall = ((bore, 0, p.thickness / 2), (bore + p.bore / 2, 0, p.thickness / 2))
    square = {"datums": ("A",), "round": True, "feature": "bore"}
    f.tolerance("perpendicularity", "bore", "declarations.place", wall, Z, "top", **square)
    f.texture("bore", "declarations.fine", ((bore + p.bore / 2, 0, p.thickness / 2),), (-1, 0, 0), "section")
    return tuple(f)
