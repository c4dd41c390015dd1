"""Parts as published projects have them: plates of extruders, brackets of motors and joints, clamps, levers."""

# The types of cadquery's fluent interface are not those that a checker can follow.
# pyright: basic

import math
from collections.abc import Callable

import cadquery as cq

W = cq.Workplane
C = (True, True, False)


def extruder_plate() -> W:
    """V-slot gantry plate: NEMA 17 motor, eccentric holes, slots for belt clamps."""
    p = W().box(88, 72, 6, centered=C).edges("|Z").fillet(6)
    p = p.faces(">Z").workplane(origin=(0, 0, 6)).pushPoints([(-30, 26), (30, 26), (-30, -26), (30, -26)]).hole(7.2)
    p = p.faces(">Z").workplane(origin=(0, 0, 6)).pushPoints([(0, 26)]).cboreHole(5.1, 9, 3)
    p = p.cut(W().center(0, -4).circle(11.25).extrude(6))
    for s in (-1, 1):
        for t in (-1, 1):
            p = p.cut(W().center(15.5 * s, -4 + 15.5 * t).circle(1.6).extrude(6))
    p = p.cut(W().center(-34, 0).slot2D(20, 4.2, 90).extrude(6)).cut(W().center(34, 0).slot2D(20, 4.2, 90).extrude(6))
    return p


def joint_bracket() -> W:
    """Robot joint bracket: U of sheet-like walls with bearing bore, servo horn pattern and weight reliefs."""
    b = W().box(60, 40, 50, centered=C).cut(W().box(48, 50, 50, centered=C).translate((0, 0, 6)))
    b = b.cut(W("YZ").workplane(offset=-40).center(0, 34).circle(8).extrude(30))
    b = b.cut(W("YZ").workplane(offset=10).center(0, 34).circle(5).extrude(40))
    for k in range(4):
        a = math.radians(45 + 90 * k)
        b = b.cut(W("YZ").workplane(offset=10).center(10 * math.cos(a), 34 + 10 * math.sin(a)).circle(1.25).extrude(40))
    b = b.edges("|X and >Z").fillet(12)
    b = b.faces("<Z").workplane(origin=(0, 0, 0)).rarray(30, 24, 2, 2).hole(4.5)
    return b


def nema_mount() -> W:
    """NEMA 17 angle bracket with slots in the foot."""
    b = W().box(50, 46, 5, centered=C).union(W().box(50, 5, 50, centered=C).translate((0, 20.5, 0)))
    b = b.cut(W("XZ").center(0, 27).circle(11.2).extrude(-40))
    for s in (-1, 1):
        for t in (-1, 1):
            b = b.cut(W("XZ").center(15.5 * s, 27 + 15.5 * t).circle(1.6).extrude(-40))
    for s in (-1, 1):
        b = b.cut(W().center(15 * s, -4).slot2D(18, 4.4, 90).extrude(5))
        g = (
            W("YZ")
            .workplane(offset=22 if s > 0 else -25)
            .moveTo(18, 5)
            .lineTo(18, 40)
            .lineTo(-15, 5)
            .close()
            .extrude(3)
        )
        b = b.union(g)
    return b


def standoff_plate() -> W:
    """Carrier of a circuit board: standoffs on a plate with a notch."""
    p = W().box(85, 56, 3, centered=False).edges("|Z").fillet(3)
    for x, y in ((3.5, 3.5), (61.5, 3.5), (3.5, 52.5), (61.5, 52.5)):
        p = p.union(W().workplane(offset=3).center(x, y).circle(3).extrude(5)).cut(
            W().center(x, y).circle(1.35).extrude(20)
        )
    return p.cut(W().box(14, 20, 10, centered=False).translate((71, 18, -2)))


def cable_clamp() -> W:
    """P-clamp half: saddle over a cable with two feet."""
    c = (
        W("XZ")
        .moveTo(-22, 0)
        .lineTo(22, 0)
        .lineTo(22, 4)
        .lineTo(10, 4)
        .threePointArc((0, 14), (-10, 4))
        .lineTo(-22, 4)
        .close()
        .extrude(12)
    )
    c = c.cut(W("XZ").circle(7).extrude(12))
    return c.faces(">Z").workplane(origin=(0, -6, 0)).pushPoints([(-16, 0), (16, 0)]).hole(4.4)


def keyed_pulley() -> W:
    """Timing belt pulley blank with hub, keyway and set screw."""
    p = (
        W()
        .circle(30)
        .extrude(3)
        .faces(">Z")
        .workplane()
        .circle(26)
        .extrude(16)
        .faces(">Z")
        .workplane()
        .circle(30)
        .extrude(3)
        .faces(">Z")
        .workplane()
        .circle(17)
        .extrude(12)
    )
    p = p.cut(W().circle(7).extrude(60)).cut(W().center(4.65, 0).rect(9.3, 5).extrude(60))
    return p.cut(W("XZ").center(0, 28).circle(2.1).extrude(40))


def cam_lever() -> W:
    """Clamp lever: hub with a square hole, arm at 30 degrees with a slot, stop lug."""
    lever = W().circle(15).extrude(18)
    a = math.radians(30)
    arm = W().transformed(rotate=(0, 0, 30)).center(35, 0).rect(70, 14).extrude(8)
    end = W().center(70 * math.cos(a), 70 * math.sin(a)).circle(9).extrude(8)
    lever = lever.union(arm).union(end).union(W().center(-18, 0).rect(20, 8).extrude(12))
    lever = lever.cut(W().rect(12, 12).extrude(40)).cut(
        W().center(70 * math.cos(a), 70 * math.sin(a)).circle(3).extrude(20)
    )
    return lever.cut(W().transformed(rotate=(0, 0, 30)).center(40, 0).slot2D(24, 6).extrude(20))


def split_bearing_block() -> W:
    """Bearing block with a split clamp, dowels, and a seat."""
    b = (
        W()
        .box(70, 30, 50, centered=C)
        .cut(W("XZ").center(0, 27).circle(13).extrude(30, both=True))
        .cut(W("XZ").workplane(offset=-15).center(0, 27).circle(16).extrude(9))
    )
    b = b.cut(W().box(2, 60, 30, centered=C).translate((0, 0, 30)))
    b = b.cut(W("YZ").workplane(offset=-40).center(0, 45).circle(2.1).extrude(80))
    b = (
        b.faces("<Z")
        .workplane(origin=(0, 0, 0))
        .rarray(54, 16, 2, 1)
        .hole(6.6)
        .faces("<Z")
        .workplane(origin=(0, 0, 0))
        .pushPoints([(20, 10), (-20, -10)])
        .hole(4, 8)
    )
    return b


PARTS: dict[str, Callable[[], W]] = {
    function.__name__: function
    for function in (
        extruder_plate,
        joint_bracket,
        nema_mount,
        standoff_plate,
        cable_clamp,
        keyed_pulley,
        cam_lever,
        split_bearing_block,
    )
}
