"""Association of dimensions with faces and edges of a solid, for product and manufacturing information (PMI) in STEP.

A point of a declaration is associated in the order of `stagecad.solids.modelling.verification`: with the face at the
point, the round feature whose axis contains it, the end of a bore, the two outermost faces whose middle it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from drawings.dimensions.consistency import parallel
from drawings.views.view import dot
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.kernel import cq
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import NEAR, DimensionVerifier

SQUARE = 1e-9
"""Greatest cosine, or 1 minus cosine, of the angle between perpendicular or parallel directions."""

Side = Literal["centre", "inner", "outer"]
"""End of a distance on a round feature: axis or centre, near side, or far side."""


@dataclass(frozen=True)
class FaceAssociation:
    """The faces and edges of a dimension."""

    first: tuple[cq.Shape, ...]  # faces, or the edge at the end of a bore or chamfer; of all features of a pattern
    second: tuple[cq.Shape, ...] = ()  # at the other end of a distance; empty for a size
    sides: tuple[Side, Side] = ("centre", "centre")  # side of a round feature at either end; `centre` for a plane face
    oriented: bool = False  # whether the direction does not follow from the faces and must be given
    count: int = 1  # number of features in `first`
    from_middle: bool = False  # whether the dimension starts half-way between the two faces of `first`


@dataclass(frozen=True)
class _End:
    """One end of a distance."""

    shapes: tuple[cq.Shape, ...]  # faces or edges
    normal: bool  # whether they are in a plane normal to the dimension, which determines its direction
    round: Surface | None = None  # surface of a round feature
    on_surface: bool = False  # whether the distance ends on the round surface, not on its axis
    middle: bool = False  # whether it ends half-way between two faces


def face_association(verifier: DimensionVerifier, dimension: Dimension) -> FaceAssociation:
    """Faces and edges of the solid with which a dimension is associated."""
    points, along = dimension.points, dimension.direction
    if along is None or not points:
        raise LookupError(f"dimension '{dimension.name}' has no points and direction")
    match dimension.kind:
        case "linear" | "depth":
            return _distance(verifier, dimension, along)
        case "diameter" | "tap_drill" | "thread":
            return _pattern(verifier, verifier.round_about(points, along)[0], dimension.count)
        case "radius":
            return _pattern(verifier, verifier.face_on(points[0], "CYLINDER", "SPHERE", "TORUS"), dimension.count)
        case "chamfer":
            surface = verifier.face_on(points[0], "PLANE", "CONE")
            low, high = (_edges_at(surface, along, level)[:1] for level in surface.extent(along))
            if not (low and high):
                return FaceAssociation((surface.face,))
            return FaceAssociation(tuple(low), tuple(high), oriented=True)
        case "slope":
            return FaceAssociation((verifier.face_on(points[0], "PLANE").face,), (_reference(verifier, along).face,))
        case "angle":
            ends = [_axis(verifier, point, (1.0, 0.0, 0.0)) for point in points[:2]]
            if ends[0] is None or ends[1] is None:
                raise LookupError(f"dimension '{dimension.name}': no upright axis at {points[0]} or {points[1]}")
            return FaceAssociation(ends[0].shapes, ends[1].shapes)
        case _:
            raise LookupError(f"dimension '{dimension.name}': a {dimension.kind} has no faces")


def faces_at(verifier: DimensionVerifier, points: Iterable[Point], normal: Point) -> tuple[cq.Face, ...]:
    """The faces of a datum or a geometrical tolerance, one for each point."""

    def at(point: Point) -> Surface:
        on = (s for s in verifier.surfaces if s.holds(point) and (s.kind != "PLANE" or parallel(s, normal)))
        return next(on, None) or verifier.round_about((point,), normal)[0]

    return tuple(at(point).face for point in points)


def _distance(verifier: DimensionVerifier, dimension: Dimension, along: Point) -> FaceAssociation:
    find = _place if dimension.kind == "linear" else _level
    points = dimension.points[:2]
    first, second = (find(verifier, point, along) for point in points)
    if second.middle:
        # The middle is the first end, so that one flag is enough.
        first, second, points = second, first, points[::-1]
    return FaceAssociation(
        first.shapes,
        second.shapes,
        (_side(first, points[0], points[1], along), _side(second, points[1], points[0], along)),
        oriented=not (first.normal or second.normal or _distance_is_along(first.round, second.round, along)),
        from_middle=first.middle,
    )


def _side(end: _End, point: Point, other: Point, along: Point) -> Side:
    """Side of a round face at which a distance to another point ends."""
    if not (end.on_surface and end.round):
        return "centre"
    here, opposite = dot(point, along), 2 * dot(end.round.origin, along) - dot(point, along)
    there = dot(other, along)
    return "inner" if abs(here - there) < abs(opposite - there) else "outer"


def _distance_is_along(first: Surface | None, second: Surface | None, along: Point) -> bool:
    """Whether two axes are parallel and their shortest distance is along a direction."""
    if first is None or second is None or not parallel(first, second.axis) or "SPHERE" in (first.kind, second.kind):
        return False
    apart = second.off_axis(first.origin)
    return apart > NEAR and abs(abs(dot(second.origin, along) - dot(first.origin, along)) - apart) < NEAR


def _place(verifier: DimensionVerifier, point: Point, along: Point) -> _End:
    for surface in verifier.surfaces:
        if surface.place(point, along) is not None and surface.holds(point):
            if surface.kind == "PLANE":
                return _End((surface.face,), parallel(surface, along))
            return _End((surface.face,), False, surface, on_surface=True)
    return _axis(verifier, point, along) or _level(verifier, point, along)


def _axis(verifier: DimensionVerifier, point: Point, along: Point) -> _End | None:
    """All faces of the round feature whose axis contains a point, or the crown with the point as its middle."""
    found = [
        s
        for kind in ("CYLINDER", "CONE")
        for s in verifier.surfaces
        if s.kind == kind and abs(dot(s.axis, along)) < SQUARE and s.off_axis(point) < NEAR
    ]
    if found:
        first = min(found, key=lambda s: (s.kind == "CONE", _beyond(s, point)))
        same = [s for s in found if s.kind == first.kind and abs(s.radius - first.radius) < NEAR]
        return _End(tuple(s.face for s in same if _beyond(s, point) <= _beyond(first, point) + NEAR), False, first)
    for surface in verifier.surfaces:
        if surface.kind == "SPHERE" and surface.holds(point):
            return _End((surface.face,), False, surface)
    return None


def _beyond(surface: Surface, point: Point) -> float:
    """Distance of a point beyond the ends of a round face, along its axis, mm."""
    low, high = surface.extent(surface.axis)
    at = dot(point, surface.axis)
    return max(low - at, at - high, 0.0)


def _level(verifier: DimensionVerifier, point: Point, along: Point) -> _End:
    """The nearest plane face through a point; else the edge at the end of a bore; else the two outermost faces."""
    at = dot(point, along)
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and parallel(s, along)]
    here = [s for s in planes if abs(dot(s.origin, along) - at) < NEAR]
    reach = max((s.radius for s in verifier.surfaces if s.kind == "CYLINDER" and s.off_axis(point) < NEAR), default=0.0)
    gaps = [(s.face.distance(cq.Vertex.makeVertex(*point)), s) for s in here]
    gap, plane = min(gaps, key=lambda pair: pair[0], default=(math.inf, None))
    if plane and gap < 2 * reach + NEAR:
        return _End((plane.face,), True)
    for s in verifier.surfaces:
        if s.kind == "CYLINDER" and parallel(s, along) and s.off_axis(point) < NEAR:
            ends = _edges_at(s, along, at)
            if ends:
                return _End((ends[0],), True)
    if plane:
        return _End((plane.face,), True)
    levels = sorted(planes, key=lambda s: dot(s.origin, along))
    if levels and abs((dot(levels[0].origin, along) + dot(levels[-1].origin, along)) / 2 - at) < NEAR:
        return _End((levels[0].face, levels[-1].face), True, middle=True)
    for edge in verifier.solid.Edges():
        corners = [vertex.toTuple() for vertex in edge.Vertices()]
        level = all(abs(dot(corner, along) - at) < NEAR for corner in corners)
        if level and any(math.dist(corner, point) < NEAR for corner in corners):
            return _End((edge,), True)
    raise LookupError(f"no face of the solid at {point} along {along}")


def _edges_at(surface: Surface, along: Point, level: float) -> list[cq.Edge]:
    """Edges of a face in the plane at a coordinate along a direction."""
    edges = []
    for edge in surface.face.Edges():
        ends = [vertex.toTuple() for vertex in edge.Vertices()]
        middle = edge.positionAt(0.5).toTuple()  # pyright: ignore[reportAttributeAccessIssue]
        if all(abs(dot(point, along) - level) < NEAR for point in (*ends, middle)):
            edges.append(edge)
    return edges


def _reference(verifier: DimensionVerifier, along: Point) -> Surface:
    """The largest round face parallel or normal to a direction, as the reference of a slope."""
    cylinders = [s for s in verifier.surfaces if s.kind == "CYLINDER"]
    for surface in sorted(cylinders, key=lambda s: -s.radius):
        if abs(abs(dot(surface.axis, along)) - 1) < SQUARE or abs(dot(surface.axis, along)) < SQUARE:
            return surface
    raise LookupError(f"no round face as reference of a slope along {along}")


def _pattern(verifier: DimensionVerifier, first: Surface, count: int) -> FaceAssociation:
    """The faces of a pattern of equal features, if there are as many as the dimension counts; else of one feature."""
    like = [s for s in verifier.surfaces if s.kind == first.kind and abs(s.radius - first.radius) < NEAR]
    # A bore may be cut into several faces about one axis, and two holes may share an axis.
    size = first.face.Area()
    alike = [s for s in like if abs(s.face.Area() - size) < 1e-4 * size]
    for faces in (like, alike, [s for s in alike if s.kind != "CYLINDER" or parallel(s, first.axis)]):
        for features in (_features(faces), [[s] for s in faces]):
            if len(features) == count and any(first in feature for feature in features):
                return FaceAssociation(tuple(s.face for feature in features for s in feature), count=count)
    single = next(feature for feature in _features(like) if first in feature)
    return FaceAssociation(tuple(s.face for s in single))


def _features(surfaces: Iterable[Surface]) -> list[list[Surface]]:
    """Faces by feature: those with a common axis, or for a sphere or torus a common centre."""
    features: list[list[Surface]] = []
    for surface in surfaces:
        at, axis = surface.origin, surface.axis
        for feature in features:
            one = feature[0]
            coaxial = abs(abs(dot(one.axis, axis)) - 1) < SQUARE and one.off_axis(at) < NEAR
            if math.dist(one.origin, at) < NEAR if one.kind in ("SPHERE", "TORUS") else coaxial:
                feature.append(surface)
                break
        else:
            features.append([surface])
    return features
