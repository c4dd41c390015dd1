"""Faces in a view: the line as which a face is seen from the side, and the centre of a round one."""

import math
from collections.abc import Iterator

from drawings.views.view import Point2, View, degrees_of, distance_along, dot
from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Point,
    SurfaceTexture,
)
from stagecad.solids.modelling.kernel import occ
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier

SQUARE = 1e-6
"""Sine of the greatest angle by which perpendicular or parallel directions may differ."""

NEARLY_SQUARE = 0.1
"""Cosine of the angle to the direction of sight below which a face is seen as a line."""

LONGEST = 40.0
"""Greatest length of the line on either side of the declared point, mm on the paper."""

CLEAR_OF_END = 2.5
"""Distance from the ends of the line of a face within which a leader is ambiguous, mm on the paper."""
MOST_CHOICES = 3
"""Most equal holes, besides the declared one, at which a callout may be."""
_PLACES = (0.5, 0.3, 0.7, 0.15, 0.85, 0.4, 0.6, 0.05, 0.95, 0.22, 0.78)

EdgeOfFace = tuple[Point2, Point2, float, float]
"""Both ends of the line in view coordinates, the direction out of the material, degrees, and the part of the line at
which the declared point is."""


def edge_of_face(view: View, requirement: FaceRequirement, gauge: DimensionVerifier) -> EdgeOfFace | None:
    """The line as which a face is seen in a view; None where it is not seen as a line."""
    eye = view.projection.towards_eye
    point = next((p for p in requirement.points if view.cut and view.cut.holds(p)), requirement.points[0])
    if not isinstance(requirement, SurfaceTexture) and requirement.round:
        return _outline(view, requirement, gauge)
    if abs(dot(requirement.normal, eye)) > SQUARE:
        return None
    for surface in gauge.surfaces:
        # A point on an edge is on the neighbouring face too.
        square = surface.kind != "PLANE" or abs(dot(surface.axis, requirement.normal)) > 1 - SQUARE
        if square and surface.holds(point):
            u, v = view.projection.to_view(requirement.normal)
            at, side = view.projection.to_view(point), (-v, u)
            reach = [distance_along(corner, at, side) for corner in map(view.projection.to_view, _corners(surface))]
            low, high = max(min(reach), -LONGEST / view.scale), min(max(reach), LONGEST / view.scale)
            ends = [(at[0] + r * side[0], at[1] + r * side[1]) for r in (low, high)]
            return ends[0], ends[1], degrees_of((u, v)), -low / (high - low) if high > low else 0.5
    return None


def outward_at(view: View, point: Point, gauge: DimensionVerifier) -> float | None:
    """Direction out of the material at a point of a flat or crowned face that a view shows from the side, degrees.

    None for a face seen from the front, and where no such face is.
    """
    for surface in gauge.surfaces:
        if surface.kind in ("PLANE", "SPHERE") and surface.holds(point):
            normal = surface.face.normalAt(surface.face.Center()).toTuple()
            if abs(dot(normal, view.projection.towards_eye)) < NEARLY_SQUARE:
                return degrees_of(view.projection.to_view(normal))
    return None


def rim_of_chamfer(view: View, chamfer: Dimension, gauge: DimensionVerifier) -> tuple[Point2, float] | None:
    """Centre and radius of the circle as which a view shows a conical chamfer; None for any other."""
    point, eye = chamfer.points[0], view.projection.towards_eye
    for surface in gauge.surfaces:
        if surface.kind == "CONE" and abs(abs(dot(surface.axis, eye)) - 1) < SQUARE and surface.holds(point):
            return view.projection.to_view(surface.origin), surface.off_axis(point)
    return None


def equal_holes(view: View, hole: Dimension, gauge: DimensionVerifier) -> tuple[Point2, ...]:
    """Centres of the other holes to which a callout applies, those nearest to the declared one first."""
    at = view.projection.to_view(hole.points[0])
    try:
        centres = {view.projection.to_view(surface.origin) for surface in gauge.holes(hole)}
    except LookupError:
        return ()
    others = sorted((math.dist(at, centre), centre) for centre in centres)
    return tuple(centre for away, centre in others if away > 1e-3)[:MOST_CHOICES]


def places_of_texture(
    view: View, texture: SurfaceTexture, line: EdgeOfFace, gauge: DimensionVerifier
) -> tuple[Point2, ...]:
    """Points of a face at which the leader of a texture may end: on the face and not at its ends, the best first."""
    first, second, _, declared = line
    point = next((p for p in texture.points if view.cut and view.cut.holds(p)), texture.points[0])
    faces = [surface for surface in gauge.surfaces if surface.holds(point)]
    right, up = view.projection.right, view.projection.up

    def on_face(at: float) -> bool:
        u, v = ((at - declared) * (b - a) for a, b in zip(first, second, strict=True))
        x, y, z = (p + u * r + v * w for p, r, w in zip(point, right, up, strict=True))
        return any(surface.holds((x, y, z)) for surface in faces)

    length = math.dist(first, second) * view.scale
    parts = places_along(declared, length)
    for wanted in (lambda t: not near_end(t, length), on_face):
        parts = tuple(filter(wanted, parts)) or parts
    return tuple((first[0] + t * (second[0] - first[0]), first[1] + t * (second[1] - first[1])) for t in parts)


def centre_of_round(surface: Surface, on: Point) -> Point:
    """Centre of the circle of a fillet, corner or crown through a point of it."""
    if surface.kind == "SPHERE":
        return surface.origin
    to = (on[0] - surface.origin[0], on[1] - surface.origin[1], on[2] - surface.origin[2])
    along = dot(to, surface.axis)
    on_axis = tuple(o + along * a for o, a in zip(surface.origin, surface.axis, strict=True))
    if surface.kind == "CYLINDER":
        return (on_axis[0], on_axis[1], on_axis[2])
    major = occ.BRepAdaptor_Surface(surface.face.wrapped).Torus().MajorRadius()
    away = tuple(p - o for p, o in zip(on, on_axis, strict=True))
    size = math.hypot(*away)
    x, y, z = (o + major * a / size for o, a in zip(surface.origin, away, strict=True))
    return (x, y, z)


def _outline(view: View, requirement: DatumFeature | GeometricTolerance, gauge: DimensionVerifier) -> EdgeOfFace | None:
    """The outline, at the right or above, of a round face seen from the side."""
    axis = requirement.normal
    if abs(dot(axis, view.projection.towards_eye)) > SQUARE:
        return None
    for surface in gauge.surfaces:
        touched = requirement.points[1:2]
        if surface.kind == "CYLINDER" and surface.off_axis(requirement.points[0]) < 1e-6:
            if touched and not surface.holds(touched[0]):
                continue
            low, high = surface.extent(axis)
            at = dot(requirement.points[0], axis)
            if not low - 1e-6 <= at <= high + 1e-6:
                continue
            u, v = view.projection.to_view(axis)
            middle = view.projection.to_view(requirement.points[0])
            corners = [view.projection.to_view(corner) for corner in _corners(surface)]
            for square in ((v, -u), (-v, u)):
                # On one side a flat may have removed the outline.
                if max(distance_along(corner, middle, square) for corner in corners) > surface.radius - 1e-6:
                    break
            rim = (middle[0] + surface.radius * square[0], middle[1] + surface.radius * square[1])
            ends = [(rim[0] + (end - at) * u, rim[1] + (end - at) * v) for end in (low, high)]
            return ends[0], ends[1], degrees_of(square), 0.5
    return None


def _corners(surface: Surface) -> Iterator[Point]:
    (x0, y0, z0), (x1, y1, z1) = surface.low, surface.high
    return ((x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1))


def places_along(at: float, length: float) -> tuple[float, ...]:
    """Parts of the line of a face, mm long on the paper, at which a leader may end: the best, `at`, first; those near
    its ends last."""
    places = [at, *(t for t in _PLACES if abs(t - at) > 0.02)]
    return tuple(sorted(places, key=lambda t: (near_end(t, length), round(abs(t - at), 6))))


def near_end(at: float, length: float) -> bool:
    """Whether a leader ends near an end of the line of a face, which it shares with a neighbouring face."""
    return min(at, 1 - at) * length < min(CLEAR_OF_END, 0.2 * length)
