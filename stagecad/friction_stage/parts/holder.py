"""The piezo holder: an Invar cylinder that holds three piezos upright and takes the drive's side load off them.

Part coordinates: origin on the axis in the bottom face, x along the travel, y across it, z up. Bores 1, 2 and 3 lie as
the piezos under the tip: 1 and 2 at x = -D/2 and +D/2, 3 at +y.

Features and what each is for
- Body: a close sliding fit in the base's pocket, in which it is raised by height pin 2 and then clamped; chamfers top
  and bottom lead it in.
- Bores: guide each piezo over most of its length, since the drive loads them sideways, and end in a supporting floor.
- Ejector holes: through each floor, to push a defective piezo out from below, and to let the air out of a close bore.
- Clamp holes: tapped from the side into each bore near the floor, for a soft-tipped set screw that holds the piezo's
  foot and leaves its stroke free. (Screws are set before the holder goes into the pocket.)
- Well and lead slots: each bore opens through a narrow slot into a well in the middle, by which the leads come out at
  the top: there is no room for them between holder and pocket.
- Lifting holes: tapped in the top face between the bores, to pull the holder out of its pocket.
- Index notches: keys in the rim on the +x and -x sides; a gauge laid through the base's lead channel into one of them
  sets the piezos' line along the travel before the clamps are drawn.
"""

from __future__ import annotations

import math

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum, Dimension, FaceRequirement, Point
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, FaceRequirements, X, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, edges_where, plate, stepped_hole
from stagecad.solids.modelling.kernel import cq

TURNED, SYMMETRIC = 3, "x"

NOTES = (
    "Bores on an equilateral triangle about the axis; clamp holes in line with them, through to the bore.",
    "Lifting holes midway between the bores; index notches on the diameter parallel to the line of two bores.",
)


def build(design: Design) -> cq.Solid:
    """The holder as one solid, mm."""
    h, threads = design.holder, design.threads
    axis = cq.Vector(0, 0, 1)
    body = cq.Solid.makeCylinder(h.diameter / 2, h.height, cq.Vector(0, 0, 0), axis)
    body = body.chamfer(h.edge_chamfer, None, edges_where(body, lambda p: p.z < 1e-6 or p.z > h.height - 1e-6))
    body = body.Solids()[0]

    cutters: list[cq.Shape] = []
    places = Derived(design).piezo_places
    bore, ejector = (h.bore_diameter, h.height - h.floor), (h.ejector_hole, h.height + OVERRUN)
    cutters += drilled(places, h.height, bore, ejector, chamfer=h.bore_chamfer)
    well = (h.well_diameter, h.height - h.floor)
    cutters.append(stepped_hole((0, 0, h.height), (0, 0, -1), well, chamfer=h.bore_chamfer))
    radius, outside = Derived(design).piezo_circle, h.diameter / 2
    for x, y in places:
        angle = math.degrees(math.atan2(y, x))
        corner = cq.Vector(0, -h.lead_slot_width / 2, h.floor)
        slot = cq.Solid.makeBox(radius, h.lead_slot_width, h.height - h.floor + OVERRUN, corner)
        cutters.append(slot.rotate(cq.Vector(0, 0, 0), axis, angle))
        c, s = x / radius, y / radius
        side, tapped = (outside * c, outside * s, h.clamp_height), (threads.m4_tap_drill, outside - radius)
        cutters.append(stepped_hole(side, (-c, -s, 0), tapped, chamfer=h.bore_chamfer))
    lift = (threads.m4_tap_drill, h.lift_drill_depth)
    for k in range(3):
        angle = math.radians(30.0 + 120.0 * k)
        top = (h.lift_radius * math.cos(angle), h.lift_radius * math.sin(angle), h.height)
        cutters.append(stepped_hole(top, (0, 0, -1), lift, chamfer=h.bore_chamfer, point=True))
    deep = h.index_depth + OVERRUN
    for sign in (-1, 1):
        floor = (sign * (outside - (h.index_depth - OVERRUN) / 2), 0.0, h.height - h.index_depth)
        cutters.append(plate(floor, deep, h.index_width, deep))
    return cut_all(body, cutters)


def defined_by_note(design: Design, point: Point) -> str:
    """What defines faces beside the dimensions: the roots of the index notches."""
    h = design.holder
    at_root = abs(abs(point[0]) - (h.diameter / 2 - h.index_depth)) < 1e-3 and abs(point[1]) < h.index_width
    return "note: index notches as deep radially" if at_root else ""


def datums(design: Design) -> dict[str, Datum]:
    """Bottom, top, and the floors under the piezos."""
    h = design.holder
    floors = [Datum(f"piezo_{i}", (x, y, h.floor), Z) for i, (x, y) in enumerate(Derived(design).piezo_places, start=1)]
    return named(Datum("bottom", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), Datum("top", (0.0, 0.0, h.height), Z), *floors)


def dimensions(design: Design) -> tuple[Dimension, ...]:
    """Every dimension of the holder."""
    d = DimensionDeclarations(design, "holder")
    h = design.holder
    middle, edge, note = (0, 0, h.floor / 2), (0, -h.diameter / 2 + 4, h.height), "sliding fit in the base's pocket"
    d.diameter("diameter", "diameter", middle, on=X, view="front", note=note)
    d.linear("height", "height", (0, 0, 0), edge, Z, view="front")
    _bore_dimensions(d.group(view="top"), design)
    _screw_hole_dimensions(d, design)
    _edge_dimensions(d, design)
    return tuple(d)


def _bore_dimensions(d: DimensionDeclarations, design: Design) -> None:
    h, middle = design.holder, (design.holder.height + design.holder.floor) / 2
    (x1, y1), (x2, _), (_, y3) = Derived(design).piezo_places
    note = "3 bores on an equilateral triangle about the axis"
    d.linear("piezo spacing", "actuator.piezo_spacing", (x1, y1, h.height), (x2, y1, h.height), note=note, exact=True)
    bore = d.group(feature="piezo bore", count=3)
    bore.diameter("piezo bore", "bore_diameter", (x1, y1, middle), note="to the floor, see A-A")
    d.linear("floor", "floor", (0, y3, 0), (0, y3, h.floor), count=3, view="section", note="floors of the bores")
    keys, ends = ("holder.floor",), ((0, 0, 0), (0, 0, h.floor))
    d.derived("well floor", h.floor, keys, ends, Z, tolerance="X.X", view="section", note="well, slots")
    bore.diameter("ejector hole", "ejector_hole", (x1, y1, h.floor / 2), note="through")
    d.diameter("well", "well_diameter", (0, 0, middle), on=(0.0, -1.0, 0.0))
    y, half = (h.well_diameter / 2 + y3 - h.bore_diameter / 2) / 2, h.lead_slot_width / 2
    left, right, note = (-half, y, middle), (half, y, middle), "bore to well, down to the floor"
    d.linear("lead slot width", "lead_slot_width", left, right, count=3, note=note)


def _screw_hole_dimensions(d: DimensionDeclarations, design: Design) -> None:
    h, y = design.holder, design.holder.diameter / 2
    clamp, lift = (0, y, h.clamp_height), (0.0, -h.lift_radius, h.height)
    back = d.group(view="back", count=3)
    back.tapped("clamp hole", "m4", clamp, (0, -1, 0))
    back.linear("clamp hole height", "clamp_height", (0, y - 3, 0), clamp, Z)
    d.linear("lifting hole radius", "lift_radius", (0, 0, h.height), lift, count=3, view="top")
    d.tapped("lifting hole", "m4", lift, DOWN, ("lift_thread_depth", "lift_drill_depth"), count=3)


def _edge_dimensions(d: DimensionDeclarations, design: Design) -> None:
    h, (x, y), outside = design.holder, Derived(design).piezo_places[0], design.holder.diameter / 2
    notch, half, z = outside - h.index_depth / 2, h.index_width / 2, h.height - h.index_depth / 2
    edge, root = (0, -outside + 4, h.height), (notch, 0, h.height - h.index_depth)
    d.linear("index notch width", "index_width", (notch, -half, z), (notch, half, z), count=2, view="top")
    d.linear("index notch depth", "index_depth", edge, root, Z, count=2, view="front", note="and as deep radially")
    c = h.edge_chamfer / 2
    d.chamfer("edge chamfer", "edge_chamfer", (outside - c, 0, c), note="both ends", view="front")
    c = h.bore_chamfer / 2
    mouth = (x - h.bore_diameter / 2 - c, y, h.height - c)
    d.chamfer("bore chamfer", "bore_chamfer", mouth, note="mouths of all holes", view="top")


def requirements(design: Design) -> tuple[FaceRequirement, ...]:
    """Piezos upright in the pocket: their floors square to the diameter that the pocket guides."""
    f, h = FaceRequirements(design), design.holder
    # A place beside the ejector hole in the middle of each bore's floor, that of bore 3 first.
    aside = (h.ejector_hole + h.bore_diameter) / 4
    floors = tuple((x, y + aside, h.floor) for x, y in reversed(Derived(design).piezo_places))
    axis = (0.0, 0.0, h.floor / 2)
    bottom = ((0.0, -(h.diameter / 2 - h.edge_chamfer) / 2, 0.0),)
    bores = tuple((x, y, (h.height + h.floor) / 2) for x, y in Derived(design).piezo_places)
    f.datum("A", (axis,), Z, "front", round=True)
    f.tolerance("cylindricity", "diameter", "drawing.tolerance_x_xx", (axis,), Z, "front", round=True)
    f.texture("diameter", "drawing.fit_roughness", ((-h.diameter / 2, 0.0, h.height / 2),), (-1.0, 0.0, 0.0), "front")
    upright = ("perpendicularity", "floors", "drawing.tolerance_x_xx", floors, Z, "section")
    f.tolerance(*upright, datums=("A",), combined=True)
    f.texture("floors", "bearing.way_roughness", floors, Z, "section", "bore floors")
    f.tolerance("perpendicularity", "bottom", "drawing.tolerance_x_xx", bottom, DOWN, "front", datums=("A",))
    f.texture("bottom", "bearing.way_roughness", bottom, DOWN, "front")
    place = ("position", "bores", "drawing.function_position", bores, Z, "top")
    f.tolerance(*place, datums=("A",), round=True, feature="piezo bore")
    return tuple(f)
