"""Plates, boxes and turned solids, and cutters for round holes: drilled, reamed, counterbored and tapped, all turned
from one profile.

A cutter is a solid of revolution that starts a little outside the surface and goes into the material, so that one
boolean takes all holes of a part at once. Threads are cosmetic: a tapped hole is cut at its tap drill, and its
declaration carries the thread. Lengths in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

from stagecad.solids.modelling.kernel import cq

Point = tuple[float, float, float]


def plate(centre: Point, length: float, width: float, height: float, *, corner_radius: float = 0.0) -> cq.Solid:
    """Prism of length (x) by width (y), rising by height (z) from `centre`, the middle of its lower face.

    corner_radius rounds the four upright edges (the cutter's radius in a pocket, a handling radius on a plate);
    it must stay below half the shorter side. A negative height makes it hang below `centre`.
    """
    x, y, z = centre
    low = min(z, z + height)
    block = cq.Solid.makeBox(length, width, abs(height), cq.Vector(x - length / 2, y - width / 2, low))
    if corner_radius > 0.0:
        block = block.fillet(corner_radius, upright_edges(block))
    return _solid(block)


def upright_edges(shape: cq.Shape) -> list[cq.Edge]:
    """The straight edges of a shape that run along z."""
    return [e for e in shape.Edges() if e.geomType() == "LINE" and abs(e.tangentAt(0.5).z) > 0.999]


def edges_where(shape: cq.Shape, keep: Callable[[cq.Vector], bool]) -> list[cq.Edge]:
    """The edges whose mid-point satisfies `keep`: selection by position."""
    return [e for e in shape.Edges() if keep(e.positionAt(0.5))]


def cut_all(body: cq.Shape, cutters: Iterable[cq.Shape]) -> cq.Solid:
    """The body with every cutter taken away in one boolean; the result must be one solid."""
    return _solid(body.cut(*cutters).clean())


def joined(body: cq.Shape, others: Iterable[cq.Shape]) -> cq.Solid:
    """The body and others as one solid, faces that continue each other merged."""
    return _solid(body.fuse(*others).clean())


def revolved(profile: cq.Workplane) -> cq.Solid:
    """A closed profile drawn in the XZ plane, turned about z."""
    return _solid(cast("cq.Shape", profile.revolve(360, (0, 0), (0, 1)).val()))


def _solid(shape: cq.Shape) -> cq.Solid:
    """The one solid a boolean left. More than one, or none, means that the dimensions cut the part apart."""
    solids = shape.Solids()
    if len(solids) != 1:
        raise ValueError(f"the dimensions leave {len(solids)} separate bodies where one part is meant")
    return solids[0]


OVERRUN = 1.0
"""How far a cutter starts outside the surface, mm: no boolean has to decide about coinciding faces."""

DRILL_POINT = math.radians(118.0)
"""Included angle of a twist drill's point (ISO 5419 type N)."""
Step = tuple[float, float]
"""Diameter of a part of a hole, and depth of its end, mm."""


def stepped_hole(at: Point, into: Point, *steps: Step, chamfer: float = 0.0, point: bool = False) -> cq.Solid:
    """Cutter of a hole whose diameter falls (or rises) in steps, turned about its axis.

    Arguments
        at: centre of the hole on the surface, part coordinates, mm.
        into: direction of the axis into the material, any length.
        steps: (diameter, depth from the surface) of each step, depths rising, mm.
        chamfer: 45 degree chamfer at the mouth, mm (deburred, and a lead for pin, screw or tap).
        point: whether the last step ends in the drill's 118 degree cone, beyond its depth, rather than flat.
    Errors: ValueError where depths do not rise or a size is not positive.
    """
    depth = 0.0
    for diameter, end in steps:
        if diameter <= 0.0 or end <= depth:
            raise ValueError(f"hole steps must have positive diameters and rising depths: {list(steps)}")
        depth = end
    radius = steps[0][0] / 2
    outline = [(0.0, -OVERRUN)]
    if chamfer > 0.0:
        outline += [(radius + chamfer, -OVERRUN), (radius + chamfer, 0.0), (radius, chamfer)]
    else:
        outline += [(radius, -OVERRUN)]
    for index, (_, end) in enumerate(steps):
        outline.append((radius, end))
        if index + 1 < len(steps):
            radius = steps[index + 1][0] / 2
            outline.append((radius, end))
    outline.append((0.0, depth + radius / math.tan(DRILL_POINT / 2) if point else depth))
    return turned(at, into, outline)


def turned(at: Point, axis: Point, outline: Sequence[tuple[float, float]]) -> cq.Solid:
    """Solid of revolution: `outline` holds (radius, distance along the axis) from `at`, closed by itself, mm."""
    # Some direction at right angles to the axis, the same one every time.
    square = (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 * math.hypot(*axis) else (1.0, 0.0, 0.0)
    plane = cq.Plane(origin=at, xDir=square, normal=axis)
    # In the plane (local x radial, local z along the axis) the outline is in local x-z.
    wire = cq.Wire.makePolygon([plane.toWorldCoords((radius, 0.0, along)) for radius, along in outline], close=True)
    start = plane.origin
    return cq.Solid.revolve(wire, [], 360.0, start, start + plane.zDir)


def drilled(
    places: Iterable[tuple[float, float]], z: float, *steps: Step, up: bool = False, **mouth: Any
) -> list[cq.Solid]:
    """The same `stepped_hole` at places (x, y), downwards from a face at the height `z` or upwards, mm."""
    hole = stepped_hole((0.0, 0.0, z), (0.0, 0.0, 1.0 if up else -1.0), *steps, **mouth)
    return repeated(hole, [(x, y, 0.0) for x, y in places])


def repeated(cutter: cq.Solid, offsets: Iterable[Point]) -> list[cq.Solid]:
    """Copies of a cutter moved by each offset, mm: a pattern costs one revolution, whatever its count."""
    return [cutter.moved(cq.Location(cq.Vector(*offset))) for offset in offsets]
