"""Cutters for round holes: drilled, reamed, counterbored and tapped, all turned from one profile.

A cutter is a solid of revolution that starts a little outside the surface and goes into the material, so that one
boolean takes all holes of a part at once. Threads are cosmetic: a tapped hole is cut at its tap drill, and its
declaration carries the thread. Lengths in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cadquery as cq


Point = tuple[float, float, float]

OVERRUN = 1.0
"""How far a cutter starts outside the surface, mm: no boolean has to decide about coinciding faces."""

DRILL_POINT = math.radians(118.0)
"""Included angle of a twist drill's point (ISO 5419 type N)."""


def stepped_hole(
    at: Point,
    into: Point,
    steps: Sequence[tuple[float, float]],
    *,
    mouth_chamfer: float = 0.0,
    drill_point: bool = False,
) -> cq.Solid:
    """Cutter of a hole whose diameter falls (or rises) in steps, turned about its axis.

    Arguments
        at: centre of the hole on the surface, part coordinates, mm.
        into: direction of the axis into the material, any length.
        steps: (diameter, depth from the surface) of each step, depths rising, mm.
        mouth_chamfer: 45 degree chamfer at the mouth, mm (deburred, and a lead for pin, screw or tap).
        drill_point: whether the last step ends in the drill's 118 degree cone, beyond its depth, rather than flat.
    Errors: ValueError where depths do not rise or a size is not positive.
    """
    depth = 0.0
    for diameter, end in steps:
        if diameter <= 0.0 or end <= depth:
            raise ValueError(f"hole steps must have positive diameters and rising depths: {list(steps)}")
        depth = end
    radius = steps[0][0] / 2
    outline = [(0.0, -OVERRUN)]
    if mouth_chamfer > 0.0:
        outline += [(radius + mouth_chamfer, -OVERRUN), (radius + mouth_chamfer, 0.0), (radius, mouth_chamfer)]
    else:
        outline += [(radius, -OVERRUN)]
    for index, (_, end) in enumerate(steps):
        outline.append((radius, end))
        if index + 1 < len(steps):
            radius = steps[index + 1][0] / 2
            outline.append((radius, end))
    outline.append((0.0, depth + radius / math.tan(DRILL_POINT / 2) if drill_point else depth))
    return turned(at, into, outline)


def turned(at: Point, axis: Point, outline: Sequence[tuple[float, float]]) -> cq.Solid:
    """Solid of revolution: `outline` holds (radius, distance along the axis) from `at`, closed by itself, mm."""
    import cadquery as cq

    plane = cq.Plane(origin=at, xDir=square_to(axis), normal=axis)
    # In the plane (local x radial, local z along the axis) the outline is in local x-z.
    points = [plane.toWorldCoords((radius, 0.0, along)) for radius, along in outline]
    wire = cq.Wire.makePolygon(points, close=True)
    start = plane.origin
    return cq.Solid.revolve(wire, [], 360.0, start, start + plane.zDir)


def square_to(axis: Point) -> Point:
    """Some unit direction at right angles to `axis`, the same one every time."""
    x, y, z = axis
    return (0.0, 0.0, 1.0) if abs(z) < 0.9 * math.sqrt(x * x + y * y + z * z) else (1.0, 0.0, 0.0)


def repeated(cutter: cq.Solid, offsets: Iterable[Point]) -> list[cq.Solid]:
    """Copies of a cutter moved by each offset, mm: a pattern costs one revolution, whatever its count."""
    import cadquery as cq

    return [cutter.moved(cq.Location(cq.Vector(*offset))) for offset in offsets]
