"""Parts that nobody declared: shapes of the kind that CadQuery's public examples and tests show, written anew.

Each function gives a workplane without dimensions, for the proposal of dimensions (`benchmarks.part_sheets`).
"""

# The types of cadquery's fluent interface are not those that a checker can follow.
# pyright: basic

from __future__ import annotations

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
    ring = ring.cut(W("XY").box(40, 3, 15).translate((40, 0, 7.5)))
    return ring.faces(">Y").workplane(origin=(37, 0, 7.5)).hole(5.5)


def triangle_gusset() -> W:
    return W("XZ").polyline([(0, 0), (60, 0), (0, 45)]).close().extrude(-8)


PARTS: dict[str, Callable[[], W]] = {
    function.__name__: function
    for function in (
        plate, pillow_block, flange, hub, stepped_shaft, keyed_shaft, bushing, angle_bracket, slotted_plate,
        pocketed_block, v_block, dovetail, t_nut, countersunk_strip, hole_grid, link, manifold, hexagon_standoff,
        spacer_tube, cover, bearing_housing, yoke, stepped_block, gib, pulley, ball_stud, clamp_ring, triangle_gusset,
    )
}  # fmt: skip
