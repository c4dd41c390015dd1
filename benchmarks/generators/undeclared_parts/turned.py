"""Parts that are mostly about one axis: shafts, flanges, pulleys, nuts."""

# The types of cadquery's fluent interface are not those that a checker can follow.
# pyright: basic

import math
from collections.abc import Callable

import cadquery as cq

W = cq.Workplane


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


def hexagon_standoff() -> W:
    return W("XY").polygon(6, 12).extrude(30).faces(">Z").workplane().hole(4.2)


def spacer_tube() -> W:
    return W("XY").circle(15).circle(10).extrude(40)


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


def lens_cell() -> W:
    body = W("XY").circle(20).extrude(15).faces(">Z").workplane().hole(30, 10)
    return body.faces("<Z").workplane().hole(26).faces(">Z").edges(">Z").chamfer(0.5)


def optical_post() -> W:
    body = W("XY").circle(6.35).extrude(75)
    body = body.faces(">Z").workplane().hole(3.3, 8).faces("<Z").workplane().hole(5, 12)
    return body.cut(W("YZ").center(0, 70).circle(1.6).extrude(10, both=True))


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


def unified_stud() -> W:
    stud = W("XY").circle(25.4).extrude(30).faces(">Z").workplane().circle(12.7).extrude(50.8)
    stud = stud.cut(W("XY").workplane(offset=30).circle(13).circle(10.8).extrude(9.5)).faces(">Z").edges().chamfer(1.6)
    return stud.faces("<Z").workplane().polarArray(19.05, 45, 360, 4).hole(7.9375)


def crossed_pin() -> W:
    """Holes that end at the axis of the pin, and a flat in which one of them begins."""
    pin = W("YZ").circle(12).extrude(90).cut(W("XY").workplane(offset=8).center(65, 0).rect(20, 30).extrude(10))
    pin = pin.cut(W("XY").workplane(offset=-20).center(25, 0).circle(3).extrude(40))
    return pin.cut(W("XY").center(65, 0).circle(2.1).extrude(20)).cut(W("XZ").center(45, 0).circle(2).extrude(-20))


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


def sealed_flange() -> W:
    """A groove for a seal about the bore, and counterbores from behind."""
    disc = W("XY").circle(50).extrude(18).faces(">Z").workplane().hole(30)
    disc = disc.cut(W("XY").workplane(offset=15).circle(22).circle(18.5).extrude(10))
    return disc.faces("<Z").workplane().polarArray(38, 0, 360, 8).cboreHole(6.6, 11, 6.5)


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


def three_flats() -> W:
    body = W("XY").circle(30).extrude(20)
    flat = W("XY").box(10, 60, 8, (False, True, False)).translate((27, 0, 12))
    for number in range(3):
        body = body.cut(flat.rotate((0, 0, 0), (0, 0, 1), 120 * number))
    return body


def hexagon_bolt() -> W:
    return W("YZ").polygon(6, 17 / math.cos(math.pi / 6)).extrude(7).faces(">X").workplane().circle(5).extrude(35)


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


def gear_shaft() -> W:
    """Nine diameters, three key seats, cross holes and rings of holes in both ends."""
    body, end = W("XY"), 0.0
    rows = ((20, 25), (24, 18), (30, 40), (36, 12), (45, 30), (36, 14), (30, 36), (25, 22), (20, 30))
    for diameter, length in rows:
        body, end = body.union(W("XY").workplane(offset=end).circle(diameter / 2).extrude(length)), end + length
    body = body.edges("%CIRCLE").chamfer(0.8)
    for start, length, width, diameter in ((4, 16, 6, 20), (50, 28, 8, 30), (150, 24, 8, 30)):
        seat = W("XZ").workplane(offset=-diameter / 2).center(0, start + length / 2).slot2D(length, width, 90)
        body = body.cut(seat.extrude(4))
    body = body.faces(">Z").workplane().polarArray(6, 0, 360, 6).hole(3, 12)
    body = body.faces("<Z").workplane().polarArray(6, 0, 360, 4).hole(3, 12)
    for at in (30, 110, 160):
        body = body.cut(W("XZ").workplane(offset=-40).center(0, at).circle(2).extrude(80))
    return body


PARTS: dict[str, Callable[[], W]] = {
    function.__name__: function
    for function in (
        flange, hub, stepped_shaft, keyed_shaft, bushing, hexagon_standoff, spacer_tube, pulley, ball_stud,
        clamp_ring, hexagon_nut, shoulder_screw_blank, grooved_pin, round_nut, spring_seat, tube_flange,
        blind_flange, stepped_bushing, tapered_hub, v_pulley, lens_cell, optical_post, knob, eccentric, keyway_hub,
        unified_stud, crossed_pin, nozzle, sprayer, ball_stem, sealed_flange, seal_cover, hexagon_adapter,
        flanged_bush, index_disc, three_flats, hexagon_bolt, clamp_collar, two_keys, spigot_flange, gear_shaft,
    )
}  # fmt: skip
