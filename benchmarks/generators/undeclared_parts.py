"""Parts that nobody declared: shapes of the kind that CadQuery's public examples and tests show, written anew.

Each function gives a workplane without dimensions, for the proposal of dimensions (`benchmarks.part_sheets`).
"""

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


def flange() -> W:
    disc = W("XY").circle(40).extrude(12).faces(">Z").workplane().hole(20)
    return disc.faces(">Z").workplane().polarArray(30, 0, 360, 6).hole(5.5)


def hub() -> W:
    body = W("XY").circle(45).extrude(10).faces(">Z").workplane().circle(20).extrude(25)
    body = body.faces(">Z").workplane().hole(16)
    return body.faces("<Z").workplane().polarArray(34, 45, 360, 4).hole(7).faces(">Z").edges().chamfer(1)


def stepped_shaft() -> W:
    shaft = W("YZ").circle(10).extrude(30).faces(">X").workplane().circle(15).extrude(60)
    shaft = shaft.faces(">X").workplane().circle(8).extrude(25)
    return shaft.faces("<X or >X").edges().chamfer(1.0)


def keyed_shaft() -> W:
    shaft = stepped_shaft()
    key = W("XY").workplane(offset=15 - 4).center(60, 0).slot2D(28, 8).extrude(20)
    return shaft.cut(key)


def bushing() -> W:
    body = W("XY").circle(12).extrude(30).union(W("XY").circle(18).extrude(5))
    return body.faces(">Z").workplane().hole(16)


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


def hexagon_standoff() -> W:
    return W("XY").polygon(6, 12).extrude(30).faces(">Z").workplane().hole(4.2)


def spacer_tube() -> W:
    return W("XY").circle(15).circle(10).extrude(40)


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


def pulley() -> W:
    profile = [(0, 0), (20, 0), (20, 4), (14, 8), (14, 14), (20, 18), (20, 22), (0, 22)]
    return W("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0)).faces(">Z").workplane().hole(8)


def ball_stud() -> W:
    shaft = W("XY").circle(5).extrude(30)
    return shaft.union(W("XY").sphere(9).translate((0, 0, 36)))


def clamp_ring() -> W:
    ring = (
        W("XY")
        .circle(30)
        .circle(20)
        .extrude(15)
        .union(W("XY").box(16, 20, 15).translate((35, 0, 7.5)).cut(W("XY").circle(20).extrude(15)))
    )
    ring = ring.cut(W("XY").box(40, 3, 15).translate((35, 0, 7.5)))
    return ring.faces(">Y").workplane(origin=(37, 0, 7.5)).hole(5.5)


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


def hexagon_nut() -> W:
    return W("XY").polygon(6, 20.785).extrude(8).faces(">Z").workplane().hole(10.2)


def shoulder_screw_blank() -> W:
    body = W("YZ").circle(8).extrude(6).faces(">X").workplane().circle(5).extrude(25)
    body = body.faces(">X").workplane().circle(3.9).extrude(12)
    return body.faces(">X").edges().chamfer(0.8)


def grooved_pin() -> W:
    body = W("YZ").circle(6).extrude(50)
    ring = W("YZ").workplane(offset=40).circle(7).circle(5).extrude(1.3)
    return body.cut(ring).faces("<X or >X").edges().chamfer(1.0)


def round_nut() -> W:
    body = W("XY").circle(22).circle(12).extrude(10)
    return body.cut(W("XY").polarArray(22, 0, 360, 4).rect(6, 6).extrude(10))


def spring_seat() -> W:
    body = W("XY").circle(20).extrude(4).faces(">Z").workplane().circle(11).extrude(10)
    return body.faces(">Z").workplane().cboreHole(5.5, 9.5, 5).faces("<Z").edges().chamfer(0.5)


def tube_flange() -> W:
    body = W("XY").circle(50).extrude(8).faces(">Z").workplane().circle(26).extrude(40)
    body = body.faces(">Z").workplane().hole(42)
    return body.faces("<Z").workplane().polarArray(40, 22.5, 360, 8).hole(9)


def blind_flange() -> W:
    body = W("XY").circle(45).extrude(10).faces(">Z").workplane().circle(28).extrude(2)
    return body.faces("<Z").workplane().polarArray(36, 30, 360, 6).hole(6.6)


def square_flange() -> W:
    body = W("XY").rect(60, 60).extrude(8).edges("|Z").fillet(8)
    body = body.faces(">Z").workplane().circle(20).extrude(12).faces(">Z").workplane().hole(25)
    return body.faces("<Z").workplane().rect(44, 44, forConstruction=True).vertices().hole(6.6)


def stepped_bushing() -> W:
    profile = [(8, 0), (20, 0), (20, 5), (14, 5), (14, 30), (10, 30), (10, 12), (8, 12)]
    return W("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0))


def tapered_hub() -> W:
    profile = [(6, 0), (25, 0), (25, 8), (18, 8), (12, 30), (6, 30)]
    return W("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0))


def v_pulley() -> W:
    profile = [(0, 0), (30, 0), (30, 3), (22, 8), (22, 12), (30, 17), (30, 20), (0, 20)]
    body = W("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0)).faces(">Z").workplane().hole(12)
    return body.cut(W("XY").center(0, 6).rect(4, 4).extrude(20))


def crank_arm() -> W:
    body = W("XY").circle(15).extrude(12).union(W("XY").center(60, 0).circle(10).extrude(12))
    body = body.union(W("XY").box(60, 12, 8, centered=(False, True, False)))
    return body.cut(W("XY").circle(8).extrude(12)).cut(W("XY").center(60, 0).circle(4).extrude(12))


def lens_cell() -> W:
    body = W("XY").circle(20).extrude(15).faces(">Z").workplane().hole(30, 10)
    return body.faces("<Z").workplane().hole(26).faces(">Z").edges(">Z").chamfer(0.5)


def mirror_plate() -> W:
    body = W("XY").box(50, 50, 10, centered=(True, True, False))
    body = body.faces(">Z").workplane().pushPoints([(-18, -18), (18, -18), (-18, 18)]).hole(6.35, 7)
    return body.faces(">Z").workplane(origin=(0, 0, 10)).hole(25.4)


def optical_post() -> W:
    body = W("XY").circle(6.35).extrude(75)
    body = body.faces(">Z").workplane().hole(3.3, 8).faces("<Z").workplane().hole(5, 12)
    return body.cut(W("YZ").center(0, 70).circle(1.6).extrude(10, both=True))


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


def knob() -> W:
    body = W("XY").circle(15).extrude(12).faces(">Z").edges().fillet(3)
    return body.faces("<Z").workplane().circle(8).extrude(6).faces("<Z").workplane().hole(5, 12)


def eccentric() -> W:
    body = W("XY").circle(20).extrude(10).cut(W("XY").center(5, 0).circle(6).extrude(10))
    return body


def keyway_hub() -> W:
    body = W("XY").circle(30).extrude(12).union(W("XY").circle(18).extrude(30))
    body = body.cut(W("XY").circle(10).extrude(30))
    return body.cut(
        W("XY").rect(6, 12.8 * 2).extrude(30).intersect(W("XY").box(6, 40, 60, centered=(True, False, True)))
    )


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


def unified_stud() -> W:
    stud = W("XY").circle(25.4).extrude(30).faces(">Z").workplane().circle(12.7).extrude(50.8)
    stud = stud.cut(W("XY").workplane(offset=30).circle(13).circle(10.8).extrude(9.5)).faces(">Z").edges().chamfer(1.6)
    return stud.faces("<Z").workplane().polarArray(19.05, 45, 360, 4).hole(7.9375)


def wedge_block() -> W:
    block = W("XZ").polyline([(0, 0), (70, 0), (70, 12), (40, 42), (0, 42)]).close().extrude(-50)
    slope = W(cq.Plane(origin=(55, 25, 27), xDir=(0, 1, 0), normal=(1, 0, 1)))
    block = block.cut(slope.rect(30, 24, forConstruction=True).vertices().circle(2.1).extrude(-12))
    return block.cut(slope.circle(8).extrude(-10))


def crossed_pin() -> W:
    """Holes that end at the axis of the pin, and a flat in which one of them begins."""
    pin = W("YZ").circle(12).extrude(90).cut(W("XY").workplane(offset=8).center(65, 0).rect(20, 30).extrude(10))
    pin = pin.cut(W("XY").workplane(offset=-20).center(25, 0).circle(3).extrude(40))
    return pin.cut(W("XY").center(65, 0).circle(2.1).extrude(20)).cut(W("XZ").center(45, 0).circle(2).extrude(-20))


def seat_housing() -> W:
    """A bore that is wider at both ends, with a groove, and a hole that ends in it."""
    body = W("XY").circle(30).extrude(45).cut(W("XY").circle(18).extrude(12)).cut(W("XY").circle(12).extrude(45))
    body = body.cut(W("XY").workplane(offset=20).circle(20).extrude(25))
    body = body.cut(W("XY").workplane(offset=38).circle(21.5).extrude(1.8))
    return body.cut(W("XZ").center(0, 16).circle(3).extrude(40))


def nozzle() -> W:
    outline = [(3, 0), (15, 0), (15, 10), (8, 30), (8, 45), (5, 45), (3, 25)]
    return W("XZ").polyline(outline).close().revolve(360, (0, 0, 0), (0, 1, 0))


def sprayer() -> W:
    """Holes around a tube, at equal angles towards its axis."""
    tube = W("XY").circle(30).circle(22).extrude(50)
    for number in range(6):
        tube = tube.cut(W("XZ").circle(3).extrude(40).rotate((0, 0, 0), (0, 0, 1), 60 * number).translate((0, 0, 35)))
    return tube


def ball_stem() -> W:
    """A ball that is wider than the stem."""
    stem = W("YZ").circle(6).extrude(50).union(W("XY").sphere(9).translate((58, 0, 0)))
    return stem.cut(W("YZ").circle(2.1).extrude(14))


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


def sealed_flange() -> W:
    """A groove for a seal about the bore, and counterbores from behind."""
    disc = W("XY").circle(50).extrude(18).faces(">Z").workplane().hole(30)
    disc = disc.cut(W("XY").workplane(offset=15).circle(22).circle(18.5).extrude(10))
    return disc.faces("<Z").workplane().polarArray(38, 0, 360, 8).cboreHole(6.6, 11, 6.5)


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


def seal_cover() -> W:
    """A groove in the face below, its inner wall seen from there alone."""
    disc = W("XY").circle(40).extrude(5).faces(">Z").workplane().circle(25).extrude(9).faces(">Z").workplane().hole(12)
    groove = W("XY").circle(32).circle(28.6).extrude(1.8)
    return disc.cut(groove).cut(W("XY").circle(16).extrude(8))


def hexagon_adapter() -> W:
    """A collar whose flat ring no view but the section shows."""
    body = W("XY").polygon(6, 27.713).extrude(12).faces(">Z").workplane().circle(10.5).extrude(3)
    body = body.faces(">Z").workplane().circle(9).extrude(16).faces(">Z").workplane().hole(8)
    return body.faces("<Z").workplane().hole(14.5, 11)


def flanged_bush() -> W:
    """Three holes on a circle, one of them on the vertical centre line."""
    body = W("XY").circle(22).extrude(6).union(W("XY").circle(15).extrude(40)).cut(W("XY").circle(9).extrude(40))
    body = body.cut(W("XZ").center(0, 22).circle(2).extrude(-30))
    return body.cut(W("XY").polarArray(18.5, 90, 360, 3).circle(1.7).extrude(6))


def index_disc() -> W:
    """Slots that divide the rim."""
    body = W("XY").circle(35).extrude(8).cut(W("XY").circle(10).extrude(8))
    for number in range(6):
        body = body.cut(W("XY").transformed(rotate=(0, 0, 60 * number)).center(32, 0).rect(12, 5).extrude(8))
    return body


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


def three_flats() -> W:
    body = W("XY").circle(30).extrude(20)
    flat = W("XY").box(10, 60, 8, (False, True, False)).translate((27, 0, 12))
    for number in range(3):
        body = body.cut(flat.rotate((0, 0, 0), (0, 0, 1), 120 * number))
    return body


def hexagon_bolt() -> W:
    return W("YZ").polygon(6, 17 / math.cos(math.pi / 6)).extrude(7).faces(">X").workplane().circle(5).extrude(35)


def dovetail_table() -> W:
    """A dovetail between two slots of the form of a T."""
    body = W("XY").box(100, 70, 35, (True, True, False))
    body = body.cut(W("XZ").polyline([(-18, 35), (-24, 25), (24, 25), (18, 35)]).close().extrude(40, both=True))
    slot = W("XZ").polyline([(34, 35), (34, 28), (30, 28), (30, 23), (44, 23), (44, 28), (40, 28), (40, 35)]).close()
    slot = slot.extrude(40, both=True)
    return body.cut(slot).cut(slot.mirror("YZ"))


def clamp_collar() -> W:
    """A slit, and a screw across it whose counterbore begins in the round outside."""
    body = W("XY").circle(25).extrude(15).cut(W("XY").circle(10).extrude(15))
    body = body.cut(W("XY").box(40, 2, 15, (False, True, False)))
    body = body.cut(W("XZ").center(17.5, 7.5).circle(2.75).extrude(30))
    body = body.cut(W("XZ").center(17.5, 7.5).circle(2.25).extrude(-30))
    return body.cut(W("XZ").workplane(offset=8).center(17.5, 7.5).circle(5).extrude(30))


def two_keys() -> W:
    """A shaft with two keyways and two grooves for circlips."""
    body = W("YZ").circle(10).extrude(40).faces(">X").workplane().circle(15).extrude(50)
    body = body.faces(">X").workplane().circle(12.5).extrude(40)
    for at, radius in ((36.5, 10), (93, 12.5)):
        body = body.cut(W("YZ").workplane(offset=at).circle(radius + 1).circle(radius - 0.6).extrude(1.3))
    body = body.cut(W("XY").workplane(offset=6.5).center(17, 0).slot2D(22, 6).extrude(10))
    return body.cut(W("XY").workplane(offset=8.5).center(112, 0).slot2D(25, 8).extrude(10))


def spigot_flange() -> W:
    """Two dowel holes at 45 degrees."""
    body = W("XY").circle(50).extrude(12).faces(">Z").workplane().circle(30).extrude(4).faces(">Z").workplane().hole(40)
    body = body.cut(W("XY").polarArray(41, 22.5, 360, 8).circle(4.5).extrude(12))
    return body.cut(W("XY").polarArray(35.5, 45, 360, 2).circle(2.5).extrude(12))


PARTS: dict[str, Callable[[], W]] = {
    function.__name__: function
    for function in (
        plate, pillow_block, flange, hub, stepped_shaft, keyed_shaft, bushing, angle_bracket, slotted_plate,
        pocketed_block, v_block, dovetail, t_nut, countersunk_strip, hole_grid, link, manifold, hexagon_standoff,
        spacer_tube, cover, bearing_housing, yoke, stepped_block, gib, pulley, ball_stud, clamp_ring, triangle_gusset,
        bearing_block, motor_mount, rod_end_clevis, hexagon_nut, shoulder_screw_blank, grooved_pin, round_nut,
        spring_seat, tube_flange, blind_flange, square_flange, stepped_bushing, tapered_hub, v_pulley, crank_arm,
        lens_cell, mirror_plate, optical_post, rail, dowel_plate, t_slot_table, u_channel, ribbed_bracket, knob,
        eccentric, keyway_hub, slotted_angle, lofted_adapter, swept_handle, truncated_pyramid, hollow_box,
        two_way_block, angled_holes, ledged_housing, ball_socket, unified_stud, wedge_block, crossed_pin,
        seat_housing, nozzle, sprayer, ball_stem, curved_slots, hollow_block, sealed_flange, finned_base,
        fine_plate, tapered_lever, gusseted_angle, seal_cover, hexagon_adapter, flanged_bush, index_disc,
        heat_sink, rack, kinematic_plate, three_flats, hexagon_bolt, dovetail_table, clamp_collar, two_keys,
        spigot_flange,
    )
}  # fmt: skip
