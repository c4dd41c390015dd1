"""Which faces and edges of a solid a declared dimension stands on, so that it can be attached to them in a STEP file.

A declaration says where to look; `stagecad.solids.modelling.verification` reads the number there, and this finds what
it was read from, in the same order of preference: the face at the point, the round feature whose axis passes it, the
end of a bore, the outermost faces whose middle it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.verification import NEAR, DimensionVerifier, Surface

if TYPE_CHECKING:
    import cadquery as cq

SQUARE = 1e-9

Side = Literal["centre", "inner", "outer"]
"""Where on a round feature a distance ends: on its axis or centre, on the side nearer the other end, or the far one."""


@dataclass(frozen=True)
class Attachment:
    """What a dimension stands on.

    Args:
        first: faces, or the edge where a bore or chamfer ends; all like features where `alike` counts them.
        second: of a dimension between two places; empty for a size.
        sides: which side of a round feature either end means; its centre, and a flat face, are `centre`.
        oriented: whether its direction does not follow from what it stands on and has to be told.
        alike: how many like features `first` holds.
        from_middle: whether `first` are two faces and the dimension starts half-way between them.
    """

    first: tuple[cq.Shape, ...]
    second: tuple[cq.Shape, ...] = ()
    sides: tuple[Side, Side] = ("centre", "centre")
    oriented: bool = False
    alike: int = 1
    from_middle: bool = False


@dataclass(frozen=True)
class _End:
    """One end of a distance."""

    shapes: tuple[cq.Shape, ...]
    square: bool
    """Whether it is a plane at right angles to the dimension, or an edge in one: then the direction is clear."""
    round: Surface | None = None
    touched: bool = False
    """Whether the round face itself is meant, rather than its axis."""
    middle: bool = False


def attachment(gauge: DimensionVerifier, dimension: Dimension) -> Attachment:
    """Faces and edges of the gauged solid that a dimension stands on.

    Raises:
        LookupError: the declaration points at nothing, or its kind (count, callout, thread depth) stands on no face.
    """
    points, along = dimension.points, dimension.direction
    if along is None or not points:
        raise LookupError(f"dimension '{dimension.name}' says not where on the part it is")
    match dimension.kind:
        case "linear" | "depth":
            return _distance(gauge, dimension, along)
        case "diameter" | "tap_drill" | "thread":
            return _pattern(gauge, _round(gauge, points, along), dimension.count)
        case "radius":
            face = _on(gauge, points[0], "CYLINDER", "SPHERE", "TORUS")
            return _pattern(gauge, face, dimension.count)
        case "chamfer":
            return _chamfer(_on(gauge, points[0], "PLANE", "CONE"), along)
        case "slope":
            return Attachment((_on(gauge, points[0], "PLANE").face,), (_reference(gauge, along).face,))
        case "angle":
            ends = [_axis(gauge, point, (1.0, 0.0, 0.0)) for point in points[:2]]
            if ends[0] is None or ends[1] is None:
                raise LookupError(f"dimension '{dimension.name}': no upright axis at {points[0]} or {points[1]}")
            return Attachment(ends[0].shapes, ends[1].shapes)
        case _:
            raise LookupError(f"dimension '{dimension.name}': a {dimension.kind} stands on no face")


def faces_at(gauge: DimensionVerifier, points: Iterable[Point], normal: Point) -> tuple[cq.Face, ...]:
    """The faces a datum or a geometrical tolerance speaks of, one by point.

    Args:
        points: on the faces, or on the axis beside a round one.
        normal: of a flat face; along the axis of a round one.

    Raises:
        LookupError: no such face.
    """
    return tuple(_face_at(gauge, point, normal).face for point in points)


def _face_at(gauge: DimensionVerifier, point: Point, normal: Point) -> Surface:
    for surface in gauge.surfaces:
        if surface.holds(point) and (surface.kind != "PLANE" or _parallel(surface, normal)):
            return surface
    return _round(gauge, (point,), normal)


def _distance(gauge: DimensionVerifier, dimension: Dimension, along: Point) -> Attachment:
    find = _place if dimension.kind == "linear" else _level
    points = dimension.points[:2]
    first, second = (find(gauge, point, along) for point in points)
    if second.middle:
        # The middle comes first, so that one flag tells it.
        first, second, points = second, first, points[::-1]
    return Attachment(
        first.shapes,
        second.shapes,
        (_side(first, points[0], points[1], along), _side(second, points[1], points[0], along)),
        oriented=not (first.square or second.square or _abreast(first.round, second.round, along)),
        from_middle=first.middle,
    )


def _side(end: _End, point: Point, other: Point, along: Point) -> Side:
    """Which side of a round face a distance to the other end starts from."""
    if not (end.touched and end.round):
        return "centre"
    here, opposite = _dot(point, along), 2 * _dot(end.round.origin, along) - _dot(point, along)
    there = _dot(other, along)
    return "inner" if abs(here - there) < abs(opposite - there) else "outer"


def _abreast(first: Surface | None, second: Surface | None, along: Point) -> bool:
    """Whether two axes are parallel, apart, and the shortest way from one to the other runs along the direction."""
    if first is None or second is None or not _parallel(first, second.axis) or "SPHERE" in (first.kind, second.kind):
        return False
    apart = second.off_axis(first.origin)
    return apart > NEAR and abs(abs(_dot(_minus(second.origin, first.origin), along)) - apart) < NEAR


def _place(gauge: DimensionVerifier, point: Point, along: Point) -> _End:
    for surface in gauge.surfaces:
        if surface.place(point, along) is not None and surface.holds(point):
            if surface.kind == "PLANE":
                return _End((surface.face,), _parallel(surface, along))
            return _End((surface.face,), False, surface, touched=True)
    return _axis(gauge, point, along) or _level(gauge, point, along)


def _axis(gauge: DimensionVerifier, point: Point, along: Point) -> _End | None:
    """The round feature whose axis passes the point, all faces of it; or the crown whose middle it is."""
    found = [
        s
        for kind in ("CYLINDER", "CONE")
        for s in gauge.surfaces
        if s.kind == kind and abs(_dot(s.axis, along)) < SQUARE and s.off_axis(point) < NEAR
    ]
    if found:
        first = min(found, key=lambda s: (s.kind == "CONE", _beyond(s, point)))
        same = [s for s in found if s.kind == first.kind and abs(s.radius - first.radius) < NEAR]
        return _End(tuple(s.face for s in same if _beyond(s, point) <= _beyond(first, point) + NEAR), False, first)
    for surface in gauge.surfaces:
        if surface.kind == "SPHERE" and surface.holds(point):
            return _End((surface.face,), False, surface)
    return None


def _beyond(surface: Surface, point: Point) -> float:
    """How far the point lies beyond the ends of a round face, along its axis, mm."""
    low, high = surface.extent(surface.axis)
    at = _dot(point, surface.axis)
    return max(low - at, at - high, 0.0)


def _level(gauge: DimensionVerifier, point: Point, along: Point) -> _End:
    """The plane at the point's level, the nearest one; else the edge at which a bore ends; else the outermost faces."""
    at = _dot(point, along)
    planes = [s for s in gauge.surfaces if s.kind == "PLANE" and _parallel(s, along)]
    here = [s for s in planes if abs(_dot(s.origin, along) - at) < NEAR]
    reach = max((s.radius for s in gauge.surfaces if s.kind == "CYLINDER" and s.off_axis(point) < NEAR), default=0.0)
    gap, plane = min(((_gap(s, point), s) for s in here), key=lambda pair: pair[0], default=(math.inf, None))
    if plane and gap < 2 * reach + NEAR:
        return _End((plane.face,), True)
    for s in gauge.surfaces:
        if s.kind == "CYLINDER" and _parallel(s, along) and s.off_axis(point) < NEAR:
            ends = _edges_at(s, along, at)
            if ends:
                return _End((ends[0],), True)
    if plane:
        return _End((plane.face,), True)
    levels = sorted(planes, key=lambda s: _dot(s.origin, along))
    if levels and abs((_dot(levels[0].origin, along) + _dot(levels[-1].origin, along)) / 2 - at) < NEAR:
        return _End((levels[0].face, levels[-1].face), True, middle=True)
    raise LookupError(f"nothing of the solid ends at {point} along {along}")


def _gap(surface: Surface, point: Point) -> float:
    import cadquery as cq

    return surface.face.distance(cq.Vertex.makeVertex(*point))


def _edges_at(surface: Surface, along: Point, level: float) -> list[cq.Edge]:
    """The face's edges that lie in the plane at a level."""
    edges = []
    for edge in surface.face.Edges():
        ends = [vertex.toTuple() for vertex in edge.Vertices()]
        middle = edge.positionAt(0.5).toTuple()  # pyright: ignore[reportAttributeAccessIssue]
        if all(abs(_dot(point, along) - level) < NEAR for point in (*ends, middle)):
            edges.append(edge)
    return edges


def _chamfer(surface: Surface, along: Point) -> Attachment:
    low, high = surface.extent(along)
    ends = [_edges_at(surface, along, level) for level in (low, high)]
    if not all(ends):
        return Attachment((surface.face,))
    return Attachment(tuple(ends[0][:1]), tuple(ends[1][:1]), oriented=True)


def _round(gauge: DimensionVerifier, points: Sequence[Point], axis: Point) -> Surface:
    point, touch = points[0], points[1] if len(points) > 1 else None
    for kind in ("CYLINDER", "CONE"):
        for s in gauge.surfaces:
            if s.kind != kind or not _parallel(s, axis) or s.off_axis(point) > NEAR:
                continue
            if kind == "CYLINDER":
                met = _beyond(s, point) < NEAR and (not touch or s.holds(touch))
            else:
                radius = s.radius + s.taper * _dot(_minus(point, s.origin), s.axis)
                met = not touch or abs(s.off_axis(touch) - radius) < NEAR
            if met:
                return s
    raise LookupError(f"no round face about {axis} through {point}")


def _on(gauge: DimensionVerifier, point: Point, *kinds: str) -> Surface:
    for surface in gauge.surfaces:
        if surface.kind in kinds and surface.holds(point):
            return surface
    raise LookupError(f"no {' or '.join(kinds).lower()} face at {point}")


def _reference(gauge: DimensionVerifier, along: Point) -> Surface:
    """The round face along a direction that a slope is told against, or the plane nearest to it."""
    cylinders = [s for s in gauge.surfaces if s.kind == "CYLINDER"]
    for surface in sorted(cylinders, key=lambda s: -s.radius):
        if abs(abs(_dot(surface.axis, along)) - 1) < SQUARE or abs(_dot(surface.axis, along)) < SQUARE:
            return surface
    raise LookupError(f"no round face that a slope along {along} could be told against")


def _pattern(gauge: DimensionVerifier, first: Surface, count: int) -> Attachment:
    """The face with all that are like it, where these are as many features as the dimension stands for."""
    like = [s for s in gauge.surfaces if s.kind == first.kind and abs(s.radius - first.radius) < NEAR]
    # A bore may be cut into several faces about one axis, and two holes may share an axis.
    for group in (lambda: like, lambda: _of_size(like, first)):
        faces = group()
        for features in (_features(faces), [[s] for s in faces]):
            if len(features) == count and any(first in feature for feature in features):
                return Attachment(tuple(s.face for feature in features for s in feature), alike=count)
    own = next(feature for feature in _features(like) if first in feature)
    return Attachment(tuple(s.face for s in own))


def _of_size(surfaces: Iterable[Surface], first: Surface) -> list[Surface]:
    size = first.face.Area()
    return [s for s in surfaces if abs(s.face.Area() - size) < 1e-4 * size]


def _features(surfaces: Iterable[Surface]) -> list[list[Surface]]:
    """Faces gathered by feature: those about one axis (of a sphere or torus: about one centre)."""
    features: list[list[Surface]] = []
    for surface in surfaces:
        for feature in features:
            if _one_feature(feature[0], surface):
                feature.append(surface)
                break
        else:
            features.append([surface])
    return features


def _one_feature(one: Surface, other: Surface) -> bool:
    if one.kind in ("SPHERE", "TORUS"):
        return math.dist(one.origin, other.origin) < NEAR
    return abs(abs(_dot(one.axis, other.axis)) - 1) < SQUARE and one.off_axis(other.origin) < NEAR


def _parallel(surface: Surface, along: Point) -> bool:
    return abs(abs(_dot(surface.axis, along)) - 1) < SQUARE


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _minus(a: Point, b: Point) -> Point:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
