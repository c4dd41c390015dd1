"""Fillets and chamfers of a solid: faces that are placed by the faces that they join."""

import math
from collections.abc import Hashable, Sequence

from drawings.dimensions.levels import NEAR, SQUARE
from drawings.views.view import dot
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.verification import DimensionVerifier, Surface

AXES: dict[str, Point] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
WHOLE, HALF = 1.5 * math.pi, 0.95 * math.pi
"""Angle about its axis from which on a face is a whole hole or shaft, and up to which it may be a fillet."""
LARGEST_CHAMFER = 0.2
"""Leg of a chamfer over the largest size of the part above which the face is a slope."""


def along_of(axis: Point) -> str | None:
    """Name of the axis of the part along which a direction is; None for a slanting one."""
    return next((name for name, unit in AXES.items() if abs(abs(dot(axis, unit)) - 1.0) < SQUARE), None)


def is_fillet(surface: Surface, surfaces: Sequence[Surface]) -> bool:
    """Whether a part of a cylinder is tangent to two faces that are not parallel, and so placed by them."""
    if surface.span > HALF:
        return False
    sides = 0
    for edge in surface.face.Edges():
        if edge.geomType() != "LINE":
            continue
        point = edge.positionAt(0.5).toTuple()  # pyright: ignore[reportAttributeAccessIssue]
        out = surface.radial(point)
        for other in surfaces:
            if other is not surface and other.kind in ("PLANE", "CYLINDER") and other.holds(point):
                normal = other.axis if other.kind == "PLANE" else other.radial(point)
                sides += abs(abs(dot(normal, out)) - 1.0) < 1e-3
    return sides >= 2


def is_chamfer(surface: Surface, surfaces: Sequence[Surface]) -> bool:
    """A small plane at 45 degrees between two planes, or a cone between a cylinder and an end face, that breaks an edge
    of the part."""
    along = along_of(surface.axis)
    size = max(s.high[n] - s.low[n] for s in surfaces for n in range(3))
    if surface.kind == "CONE":
        if along is None or abs(abs(surface.taper) - 1.0) > 1e-4 or _leg(surface) > LARGEST_CHAMFER * size:
            return False
        coaxial = [s for s in surfaces if s.kind == "CYLINDER" and s.is_coaxial(surface)]
        ends = [s for s in surfaces if s.kind == "PLANE" and along_of(s.axis) == along]
        rims = {round(surface.off_axis(v), 4): dot(v, AXES[along]) for v in surface.vertices}
        return any(
            any(abs(s.radius - radius) < NEAR for s in coaxial)
            and any(
                abs(dot(s.origin, AXES[along]) - level) < NEAR for s in ends for level in rims.values() if level != own
            )
            for radius, own in rims.items()
        )
    across = [n for n in range(3) if abs(abs(surface.axis[n]) - math.sqrt(0.5)) < 1e-4]
    legs = [surface.high[n] - surface.low[n] for n in across]
    if surface.kind != "PLANE" or len(across) != 2 or abs(legs[0] - legs[1]) > NEAR or legs[0] > LARGEST_CHAMFER * size:
        return False
    own = outward_normal(surface)
    points = [edge.positionAt(0.5).toTuple() for edge in surface.face.Edges()]  # pyright: ignore[reportAttributeAccessIssue]
    beside = [s for s in surfaces if s is not surface and s.kind == "PLANE" and any(map(s.holds, points))]
    return all(any(outward_normal(s)[n] * own[n] > 0.7 for s in beside) for n in across)


def outward_normal(surface: Surface) -> Point:
    """Normal of a plane face out of the material."""
    sign = math.copysign(1.0, dot(surface.face.normalAt(surface.face.Center()).toTuple(), surface.axis))
    x, y, z = (round(sign * a, 15) + 0.0 for a in surface.axis)
    return (x, y, z)


def corners(surface: Surface) -> list[Point]:
    """Corners of the outline of a plane face, without those of holes in it."""
    return [vertex.toTuple() for vertex in surface.face.outerWire().Vertices()]


def like_edges(verifier: DimensionVerifier, d: Dimension) -> dict[int, Hashable]:
    """Numbers of the faces of all fillets or chamfers of the size of a dimension, with what tells these apart."""
    found: dict[int, Hashable] = {}
    for number, surface in enumerate(verifier.surfaces):
        if d.kind == "radius" and surface.kind in ("CYLINDER", "SPHERE", "TORUS"):
            like = [s for s in verifier.surfaces if s.is_round(surface.radius) and s.is_coaxial(surface)]
            # Faces that go around their axis have a diameter.
            whole = sum(s.span for s in like if s.outward == surface.outward) > WHOLE
            if abs(surface.radius - d.value) < NEAR and not (surface.kind == "CYLINDER" and whole):
                found[number] = surface.axis_key if surface.kind == "CYLINDER" else number
        elif (
            d.kind == "chamfer"
            and surface.kind in ("PLANE", "CONE")
            and abs(_leg(surface) - d.value) < NEAR
            and is_chamfer(surface, verifier.surfaces)
        ):
            found[number] = (*surface.axis_key, round(surface.low[0] + surface.low[1] + surface.low[2], 2))
    return found


def _leg(chamfer: Surface) -> float:
    """Leg of a conical or plane chamfer at 45 degrees."""
    along = max(range(3), key=lambda n: abs(chamfer.axis[n]))
    return chamfer.high[along] - chamfer.low[along]


def is_mirrored(surfaces: Sequence[Surface], number: int, middle: float) -> bool:
    """Whether the boxes of all faces are mirror images of each other about a middle plane."""
    boxes = [(s.kind, s.low, s.high) for s in surfaces]

    def mirrored(low: tuple[float, ...], high: tuple[float, ...]) -> list[tuple[float, ...]]:
        return [
            tuple(2 * middle - other[n] if n == number else own[n] for n in range(3))
            for own, other in ((low, high), (high, low))
        ]

    for kind, low, high in boxes:
        one, other = mirrored(low, high)
        if not any(k == kind and math.dist(a, one) < 0.02 and math.dist(b, other) < 0.02 for k, a, b in boxes):
            return False
    return True
