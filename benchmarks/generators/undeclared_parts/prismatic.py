"""Parts that are mostly of plane faces: plates, blocks, brackets, housings; and free forms."""

# The types of cadquery's fluent interface are not those that a checker can follow.
# pyright: basic

import math
from collections.abc import Callable

import cadquery as cq

W = cq.Workplane


def plate() -> W:
    return W("XY").box(60, 40, 8).faces(">Z").workplane().rect(44, 24, forConstruction=True).vertices().hole(5.5)


def pillow_block() -> W:
    block = W("XY").box(80, 60, 12).faces(">Z").workplane().hole(22)
    return (
        block.faces(">Z")
        .workplane()
        .rect(64, 44, forConstruction=True)
        .vertices()
        .cboreHole(5.5, 10, 5.5)
        .edges("|Z")
        .fillet(4)
    )


def angle_bracket() -> W:
    body = W("XY").box(60, 40, 8, centered=False).union(W("XY").box(8, 40, 50, centered=False))
    body = body.cut(W("XY").pushPoints([(30, 20), (48, 20)]).circle(3.3).extrude(8))
    body = body.cut(W("YZ").pushPoints([(10, 35), (30, 35)]).circle(2.75).extrude(8))
    return body.edges(cq.selectors.NearestToPointSelector((8, 20, 8))).fillet(5)


def slotted_plate() -> W:
    body = W("XY").box(100, 50, 6)
    body = body.faces(">Z").workplane().pushPoints([(-30, 0), (30, 0)]).slot2D(30, 8, 90).cutThruAll()
    return body.edges("|Z").fillet(6)


def pocketed_block() -> W:
    body = W("XY").box(80, 60, 25).faces(">Z").workplane().rect(50, 30).cutBlind(-12)
    body = body.edges("|Z and (not >X) and (not <X)").fillet(5)
    return body.faces("<Z").workplane().rect(66, 46, forConstruction=True).vertices().hole(4.2, 10)


def v_block() -> W:
    profile = [(-30, 0), (30, 0), (30, 40), (20, 40), (0, 20), (-20, 40), (-30, 40)]
    return W("XZ").polyline(profile).close().extrude(50)


def dovetail() -> W:
    profile = [(0, 0), (60, 0), (60, 20), (45, 20), (50, 10), (10, 10), (15, 20), (0, 20)]
    return W("XZ").polyline(profile).close().extrude(-80)


def t_nut() -> W:
    body = W("XY").box(30, 18, 8).union(W("XY").box(30, 10, 6).translate((0, 0, 7)))
    return body.faces(">Z").workplane().hole(5.0)


def countersunk_strip() -> W:
    return W("XY").box(120, 20, 5).faces(">Z").workplane().rarray(25, 1, 5, 1).cskHole(4.5, 9.0, 90)


def hole_grid() -> W:
    return (
        W("XY")
        .box(120, 80, 10, centered=False)
        .faces(">Z")
        .workplane(origin=(0, 0, 0))
        .center(60, 40)
        .rarray(20, 20, 5, 3)
        .hole(6)
    )


def link() -> W:
    body = W("XY").slot2D(90, 30).extrude(10)
    return body.faces(">Z").workplane().pushPoints([(-30, 0), (30, 0)]).hole(12)


def manifold() -> W:
    body = W("XY").box(80, 50, 40)
    body = body.faces("<X").workplane().hole(12, 70)
    body = body.faces(">Z").workplane().pushPoints([(-25, 0), (0, 0), (25, 0)]).hole(8, 20)
    return body.faces(">Y").workplane().center(12, 0).hole(10, 25)


def cover() -> W:
    body = W("XY").box(100, 70, 20).faces("<Z").shell(-4)
    return body.faces(">Z").workplane().rect(84, 54, forConstruction=True).vertices().hole(4.5)


def bearing_housing() -> W:
    body = W("XY").circle(45).extrude(22).faces(">Z").workplane().circle(30).extrude(8)
    body = body.faces(">Z").workplane().cboreHole(30, 42, 14)
    return body.faces("<Z").workplane().polarArray(38, 0, 360, 6).hole(5.5)


def yoke() -> W:
    body = W("XY").box(60, 40, 60).cut(W("XY").box(30, 40, 45).translate((0, 0, 7.5)))
    return body.faces(">X").workplane().center(0, 10).hole(14)


def stepped_block() -> W:
    profile = [(0, 0), (90, 0), (90, 15), (60, 15), (60, 30), (30, 30), (30, 45), (0, 45)]
    return W("XZ").polyline(profile).close().extrude(-40)


def gib() -> W:
    body = W("XY").box(140, 24, 10, centered=False).edges("|X and >Z").chamfer(2)
    return body.faces("<Z").workplane(origin=(0, 0, 0)).pushPoints([(20, -12), (70, -12), (120, -12)]).hole(5.0, 6)


def triangle_gusset() -> W:
    return W("XZ").polyline([(0, 0), (60, 0), (0, 45)]).close().extrude(-8)


def bearing_block() -> W:
    body = W("XY").box(90, 30, 12, centered=(True, True, False))
    body = body.union(W("XZ").center(0, 30).circle(24).extrude(15, both=True)).union(
        W("XY").box(48, 30, 30, centered=(True, True, False))
    )
    body = body.cut(W("XZ").center(0, 30).circle(13).extrude(20, both=True))
    return body.cut(W("XY").pushPoints([(-35, 0), (35, 0)]).circle(4.5).extrude(12))


def motor_mount() -> W:
    body = (
        W("XY")
        .box(60, 60, 6, centered=(True, True, False))
        .union(W("XZ").box(60, 56, 6, centered=(True, False, False)).translate((0, 30, 0)))
    )
    body = body.cut(W("XZ").center(0, 32).circle(11).extrude(40, both=True))
    body = body.cut(
        W("XZ").center(0, 32).rect(31, 31, forConstruction=True).vertices().circle(1.7).extrude(40, both=True)
    )
    return body.cut(W("XY").pushPoints([(-22, -20), (22, -20), (-22, 10), (22, 10)]).circle(2.7).extrude(6))


def rod_end_clevis() -> W:
    body = (
        W("XY")
        .box(24, 20, 40, centered=(True, True, False))
        .cut(W("XY").box(10, 20, 24, centered=(True, True, False)).translate((0, 0, 16)))
    )
    body = body.cut(W("YZ").center(0, 30).circle(5).extrude(15, both=True))
    return body.faces("<Z").workplane().hole(8.5, 12)


def square_flange() -> W:
    body = W("XY").rect(60, 60).extrude(8).edges("|Z").fillet(8)
    body = body.faces(">Z").workplane().circle(20).extrude(12).faces(">Z").workplane().hole(25)
    return body.faces("<Z").workplane().rect(44, 44, forConstruction=True).vertices().hole(6.6)


def crank_arm() -> W:
    body = W("XY").circle(15).extrude(12).union(W("XY").center(60, 0).circle(10).extrude(12))
    body = body.union(W("XY").box(60, 12, 8, centered=(False, True, False)))
    return body.cut(W("XY").circle(8).extrude(12)).cut(W("XY").center(60, 0).circle(4).extrude(12))


def mirror_plate() -> W:
    body = W("XY").box(50, 50, 10, centered=(True, True, False))
    body = body.faces(">Z").workplane().pushPoints([(-18, -18), (18, -18), (-18, 18)]).hole(6.35, 7)
    return body.faces(">Z").workplane(origin=(0, 0, 10)).hole(25.4)


def rail() -> W:
    profile = [(-10, 0), (10, 0), (10, 4), (6, 8), (10, 12), (10, 16), (-10, 16), (-10, 12), (-6, 8), (-10, 4)]
    body = W("YZ").polyline(profile).close().extrude(100)
    return body.faces(">Z").workplane(origin=(50, 0, 16)).pushPoints([(-30, 0), (0, 0), (30, 0)]).cboreHole(4.5, 8, 5)


def dowel_plate() -> W:
    body = W("XY").box(80, 40, 10, centered=False).edges("|Z").chamfer(3)
    body = body.cut(W("XY").pushPoints([(10, 10), (70, 30)]).circle(3).extrude(10))
    return body.cut(W("XY").pushPoints([(10, 30), (70, 10)]).circle(4.5).extrude(10))


def t_slot_table() -> W:
    body = W("XY").box(100, 60, 20, centered=(True, True, False))
    slot = W("YZ").polyline([(-4, 20), (4, 20), (4, 13), (7, 13), (7, 8), (-7, 8), (-7, 13), (-4, 13)]).close()
    cutter = slot.extrude(50, both=True)
    return body.cut(cutter.translate((0, -15, 0))).cut(cutter.translate((0, 15, 0)))


def u_channel() -> W:
    body = W("XY").box(120, 40, 30, centered=False).cut(W("XY").box(120, 32, 26, centered=False).translate((0, 4, 4)))
    return body.cut(W("XY").pushPoints([(20, 20), (60, 20), (100, 20)]).circle(3.3).extrude(4))


def ribbed_bracket() -> W:
    body = (
        W("XY")
        .box(60, 50, 8, centered=(False, True, False))
        .union(W("XY").box(8, 50, 60, centered=(False, True, False)))
    )
    rib = W("XZ").polyline([(8, 8), (48, 8), (8, 48)]).close().extrude(3, both=True)
    body = body.union(rib).cut(W("XY").pushPoints([(40, -17), (40, 17)]).circle(3.3).extrude(8))
    return body.cut(W("YZ").pushPoints([(-17, 45), (17, 45)]).circle(3.3).extrude(8))


def slotted_angle() -> W:
    body = W("XY").box(70, 40, 5, centered=False).union(W("XY").box(5, 40, 60, centered=False))
    body = body.cut(W("XY").center(40, 20).slot2D(30, 6.6).extrude(5))
    return body.cut(W("YZ").center(20, 40).slot2D(20, 5.5, 90).extrude(5))


def lofted_adapter() -> W:
    body = W("XY").rect(40, 40).workplane(offset=30).circle(12).loft(combine=True)
    return body.union(W("XY").box(60, 60, 6, centered=(True, True, False)).translate((0, 0, -6)))


def swept_handle() -> W:
    path = W("XZ").lineTo(0, 20).threePointArc((2.929, 27.071), (10, 30)).lineTo(60, 30)
    return W("XY").circle(5).sweep(path)


def truncated_pyramid() -> W:
    return W("XY").rect(50, 50).workplane(offset=25).rect(30, 30).loft(combine=True)


def hollow_box() -> W:
    body = W("XY").box(80, 50, 30, centered=(True, True, False)).edges("|Z").fillet(6).faces(">Z").shell(-3)
    return body.cut(W("XY").pushPoints([(-30, 0), (30, 0)]).circle(2.2).extrude(3))


def two_way_block() -> W:
    body = W("XY").box(50, 40, 30, centered=False).cut(W("XZ").center(25, 15).circle(7).extrude(-40))
    body = body.cut(W("YZ").center(20, 15).circle(4).extrude(50))
    return body.faces(">Z").workplane(origin=(0, 0, 30)).pushPoints([(8, 8), (42, 8), (8, 32), (42, 32)]).hole(5, 12)


def angled_holes() -> W:
    body = W("XY").box(80, 50, 30, centered=(True, True, False))
    for at, lean, turn, radius, deep in ((20, 30, 0, 4, 60), (-20, 45, -90, 2.5, 25)):
        drill = cq.Solid.makeCylinder(radius, deep + 20, cq.Vector(0, 0, -deep))
        drill = drill.rotate((0, 0, 0), (0, 1, 0), lean).rotate((0, 0, 0), (0, 0, 1), turn)
        body = body.cut(W(drill.translate((at, 0, 30))))
    return body


def ledged_housing() -> W:
    body = W("XY").box(120, 90, 45, centered=(True, True, False)).edges("|Z").fillet(8)
    body = body.cut(W("XY").workplane(offset=8).rect(96, 66).extrude(45).edges("|Z").fillet(5))
    body = body.cut(W("XY").workplane(offset=33).rect(106, 76).extrude(45).edges("|Z").fillet(5))
    body = body.faces(">Z").workplane(origin=(0, 0, 45)).rect(108, 78, forConstruction=True).vertices().hole(4.2, 14)
    body = body.cut(W("YZ").workplane(offset=48).center(0, 22).circle(9).extrude(20))
    return body.cut(W("XZ").workplane(offset=33).center(-25, 22).circle(6).extrude(20))


def ball_socket() -> W:
    body = W("XY").circle(20).extrude(30).cut(W("XY").workplane(offset=30).sphere(12))
    return body.faces("<Z").workplane().hole(8.5, 12)


def wedge_block() -> W:
    block = W("XZ").polyline([(0, 0), (70, 0), (70, 12), (40, 42), (0, 42)]).close().extrude(-50)
    slope = W(cq.Plane(origin=(55, 25, 27), xDir=(0, 1, 0), normal=(1, 0, 1)))
    block = block.cut(slope.rect(30, 24, forConstruction=True).vertices().circle(2.1).extrude(-12))
    return block.cut(slope.circle(8).extrude(-10))


def seat_housing() -> W:
    """A bore that is wider at both ends, with a groove, and a hole that ends in it."""
    body = W("XY").circle(30).extrude(45).cut(W("XY").circle(18).extrude(12)).cut(W("XY").circle(12).extrude(45))
    body = body.cut(W("XY").workplane(offset=20).circle(20).extrude(25))
    body = body.cut(W("XY").workplane(offset=38).circle(21.5).extrude(1.8))
    return body.cut(W("XZ").center(0, 16).circle(3).extrude(40))


def curved_slots() -> W:
    disc = W("XY").circle(50).extrude(8).faces(">Z").workplane().hole(20)
    (x, y), (u, v) = ((32 * math.cos(0.5), 32 * math.sin(0.5)), (3 * math.sin(0.5), 3 * math.cos(0.5)))
    slot = W("XY").moveTo(35 / 32 * x, -35 / 32 * y).threePointArc((35, 0), (35 / 32 * x, 35 / 32 * y))
    slot = slot.threePointArc((x - u, y + v), (29 / 32 * x, 29 / 32 * y)).threePointArc(
        (29, 0), (29 / 32 * x, -29 / 32 * y)
    )
    slot = slot.threePointArc((x - u, -y - v), (35 / 32 * x, -35 / 32 * y)).close().extrude(8)
    return disc.cut(slot).cut(slot.rotate((0, 0, 0), (0, 0, 1), 180))


def hollow_block() -> W:
    """A blind hole in an inner wall, which no view from outside shows."""
    block = W("XY").box(80, 60, 50).cut(W("XY").box(60, 60, 30))
    return block.cut(W("YZ").workplane(offset=30).circle(4).extrude(6))


def finned_base() -> W:
    """Fins, whose edges pass others in the view from below."""
    base = W("XY").box(80, 60, 6, centered=(True, True, False))
    for number in range(8):
        base = base.union(W("XY").box(2, 60, 25, centered=(True, True, False)).translate((-35 + 10 * number, 0, 5)))
    return base.faces("<Z").workplane().rect(60, 40, forConstruction=True).vertices().hole(3.3, 4)


def fine_plate() -> W:
    """A slot and a row of holes that are not legible at the scale of the whole."""
    plate = W("XY").box(800, 500, 20, centered=(True, True, False))
    plate = plate.faces(">Z").workplane().rect(700, 400, forConstruction=True).vertices().hole(14)
    plate = plate.cut(W("XY").workplane(offset=18).center(200, 100).slot2D(6, 1.5).extrude(5))
    return plate.cut(
        W("XY").workplane(offset=18.5).pushPoints([(200, 110), (203, 110), (206, 110)]).circle(0.5).extrude(5)
    )


def tapered_lever() -> W:
    """Flanks that narrow to the smaller boss, and no flat outside beside its bottom."""
    arm = W("XY").moveTo(0, 12).lineTo(70, 7).lineTo(70, -7).lineTo(0, -12).close().extrude(9)
    body = W("XY").circle(16).extrude(20).union(W("XY").center(70, 0).circle(10).extrude(14)).union(arm)
    body = body.cut(W("XY").circle(8).extrude(30)).cut(W("XY").center(70, 0).circle(4).extrude(30))
    return body.cut(W("XY").center(0, 8).rect(5, 5.6).extrude(30))


def gusseted_angle() -> W:
    """Round holes as wide as the slots."""
    foot, wall = W("XY").box(60, 50, 8, (True, False, False)), W("XY").box(60, 8, 55, (True, False, False))
    rib = W("YZ").moveTo(8, 8).lineTo(40, 8).lineTo(8, 45).close().extrude(3, both=True)
    body = foot.union(wall).union(rib).cut(W("XY").pushPoints([(-20, 32), (20, 32)]).slot2D(14, 6.6, 90).extrude(10))
    return body.cut(W("XZ").pushPoints([(-20, 40), (20, 40)]).circle(3.3).extrude(-10))


def heat_sink() -> W:
    """Equal slots in a row, in the middle of a plate."""
    body = W("XY").box(60, 80, 30, (True, True, False))
    for number in range(7):
        body = body.cut(W("XY").box(4, 80, 24, (True, True, False)).translate((7 * number - 21, 0, 6)))
    return body.cut(W("XY").rect(40, 60, forConstruction=True).vertices().circle(1.65).extrude(5))


def rack() -> W:
    """Equal teeth in a row, with slanting flanks."""
    tooth = [(0.5, 10), (2.14, 14.5), (4.14, 14.5), (5.78, 10)]
    teeth = [(6.283 * number + x, z) for number in range(8) for x, z in tooth]
    body = W("XZ").polyline([(0, 10), *teeth, (50.264, 10), (50.264, 0), (0, 0)]).close().extrude(12)
    return body.cut(W("XZ").pushPoints([(10, 5), (40, 5)]).circle(2.2).extrude(12))


def kinematic_plate() -> W:
    """Three grooves towards the axis, and holes between them."""
    body = W("XY").circle(40).extrude(10).cut(W("XY").circle(8).extrude(10))
    groove = W("YZ").polyline([(0, 6), (4, 10), (-4, 10)]).close().extrude(16).translate((22, 0, 0))
    for number in range(3):
        body = body.cut(groove.rotate((0, 0, 0), (0, 0, 1), 120 * number))
    return body.cut(W("XY").polarArray(30, 60, 360, 3).circle(2.25).extrude(10))


def dovetail_table() -> W:
    """A dovetail between two slots of the form of a T."""
    body = W("XY").box(100, 70, 35, (True, True, False))
    body = body.cut(W("XZ").polyline([(-18, 35), (-24, 25), (24, 25), (18, 35)]).close().extrude(40, both=True))
    slot = W("XZ").polyline([(34, 35), (34, 28), (30, 28), (30, 23), (44, 23), (44, 28), (40, 28), (40, 35)]).close()
    slot = slot.extrude(40, both=True)
    return body.cut(slot).cut(slot.mirror("YZ"))


def crossing_bores() -> W:
    """A grid of bores that cross on their axes, in three directions: 101 faces."""
    body = W("XY").box(120, 80, 50).edges("|Z").fillet(3)
    for side, columns, rows, diameter in (
        (">X", (20, 3), (18, 2), 10),
        (">Y", (18, 5), (18, 2), 7),
        (">Z", (18, 5), (20, 3), 6),
    ):
        face = body.faces(side).workplane(centerOption="CenterOfBoundBox")
        body = face.rarray(columns[0], rows[0], columns[1], rows[1]).hole(diameter)
    return body


def ribbed_angle() -> W:
    """Two plates with three ribs, holes between them, and chamfered edges."""
    body = W("XY").box(140, 90, 14, centered=(True, True, False))
    body = body.union(W("XZ").workplane(offset=-45).center(0, 54).rect(140, 80).extrude(14))
    for x in (-60, 0, 60):
        rib = W("YZ").workplane(offset=x - 5).polyline([(31, 14), (31, 80), (-30, 14)]).close()
        body = body.union(rib.extrude(10))
    body = body.faces("<Z").workplane().rarray(60, 60, 2, 2).hole(9)
    for columns, rows, size in ((60, 30, (6.6, 0, 0)), (40, 60, (4.5, 8, 4))):
        at = body.faces(">Y").workplane(centerOption="CenterOfBoundBox").rarray(columns, rows, 2, 2)
        body = at.cboreHole(*size) if size[1] else at.hole(size[0])
    return body.edges("|Z").edges(">Y or <Y").fillet(4).edges(">Z").chamfer(1)


PARTS: dict[str, Callable[[], W]] = {
    function.__name__: function
    for function in (
        plate, pillow_block, angle_bracket, slotted_plate, pocketed_block, v_block, dovetail, t_nut,
        countersunk_strip, hole_grid, link, manifold, cover, bearing_housing, yoke, stepped_block, gib,
        triangle_gusset, bearing_block, motor_mount, rod_end_clevis, square_flange, crank_arm, mirror_plate, rail,
        dowel_plate, t_slot_table, u_channel, ribbed_bracket, slotted_angle, lofted_adapter, swept_handle,
        truncated_pyramid, hollow_box, two_way_block, angled_holes, ledged_housing, ball_socket, wedge_block,
        seat_housing, curved_slots, hollow_block, finned_base, fine_plate, tapered_lever, gusseted_angle, heat_sink,
        rack, kinematic_plate, dovetail_table, crossing_bores, ribbed_angle,
    )
}  # fmt: skip
