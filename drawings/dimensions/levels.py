"""Levels of a part along one of its axes, tied together by the dimensions: what is located, what is given twice.

A level is the coordinate of a face or of an axis of a round face. Each dimension along the axis is a linear equation
between two levels; a level is located if the equations determine it, that is, if it is zero in every vector of their
null space. Where the middle plane of the axis is a plane of symmetry, a level and its mirror image are one unknown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.cluster.hierarchy import DisjointSet
from scipy.linalg import null_space

from drawings.views.view import dot
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.frame import add, scaled, subtract
from stagecad.solids.modelling.surface import Surface, meeting
from stagecad.solids.modelling.verification import DimensionVerifier

if TYPE_CHECKING:
    from drawings.dimensions.places import Part

NEAR = 2e-3
"""Levels closer than this are one, mm."""
SQUARE = 1e-6
BETWEEN = ("linear", "depth", "pitch")
"""Kinds of dimension that tie two levels together."""
Kind = bool | str | None
"""Of a level: whether it is that of a plane face, or else of what it is; None where this is not said."""
OUTLINE, CORNER, AXIS = "outline", "corner", "axis"
"""Kinds of the level of the outline of a round face, of a corner beside round faces, and of an axis, whose direction
follows (`axis_kind`) where it is said."""
HALVES = (1.0, 1.0, -2.0)
"""Coefficients of both ends of a distance and of its middle."""
REPEATS = 12
"""Most features in a row that are reached from a located one."""


class Levels:
    """Coordinates of faces and axes along one axis, and the dimensions between them.

    `strict`: with a datum no other level is a reference, a row of equal features ends where it is said, and a face and
    an axis at one level by chance have a dimension each."""

    def __init__(
        self,
        part: Part,
        axis: Point,  # unit vector
        dimensions: Sequence[Dimension],
        symmetric: bool,  # whether the middle plane of the axis is a plane of symmetry
        halved: Sequence[Dimension] = (),  # those whose middle is an axis, as the width of a slot
        *,
        datum: bool,  # whether the level 0 is a reference by itself: a middle plane, or a plane or axis of the part
        strict: bool,
    ) -> None:
        self._part, self._axis = part, axis
        self._datum, self._strict, self._own_kinds = datum, strict and datum, strict
        feature_at = partial(part.feature_at, axis)
        own = [d for d in dimensions if _is_along(d, axis)]
        walls = ((round(at, 6), way) for d in own for at, way in self._walls(d)) if strict else ()
        self._stated = [*dict.fromkeys(walls)]
        self._symmetric = symmetric
        self._levels: list[float] = []
        self._of_face: list[Kind] = []  # whether it is that of a plane face; None for of any feature
        self._private: set[int] = set()
        self._names: dict[int, str] = {}
        self._alike: list[tuple[Any, Any, str]] = []  # levels with their kinds, both ways
        self._at_middle = ""  # dimension that ends on a plane face at the level 0
        rows: list[dict[int, float]] = []
        for d in own:
            row: dict[int, float] = {}
            for place, (point, sign) in enumerate(zip(d.points[:2], (-1.0, 1.0), strict=True)):
                # The end of a drilled hole is at no level of another face, even if it is at the same height.
                drilled = place == 1 and d.kind == "depth" and bool(d.feature)
                private = drilled and (strict or not isinstance(feature_at(point), int))
                self._add(row, *self._end(point), sign, d.name, private=private)
                if abs(dot(point, axis)) < NEAR and not private and isinstance(feature_at(point), int):
                    self._at_middle = d.name
            rows.append(row)
        rows += self._outlines(own)
        for d in (d for d in halved if _is_along(d, axis)):
            kinds = [kind for _, kind in sorted(map(self._end, d.points[:2]), key=lambda end: end[0])]
            for low, high in (
                part.equal(axis, d) if strict and d.count > 1 else [sorted(dot(point, axis) for point in d.points[:2])]
            ):
                middle = (low + high) / 2
                rows.append({})
                for end, factor in zip(((low, kinds[0]), (high, kinds[1]), (middle, self._kind(middle, AXIS))), HALVES):
                    self._add(rows[-1], *end, factor, d.name)
        several = [d for d in own if d.count > 1 and not (d.kind == "depth" and d.feature)]
        rows += self._tied(several) if strict else self._equal_features([d.value for d in several if d.kind != "pitch"])
        self._located = self._determined(rows)
        rows_of_equal = [d for d in several if d.kind == "pitch"] if strict else []
        self._in_row = [
            (low + number * (high - low) / d.count, self._end(d.points[0])[1], d.name)
            for d in rows_of_equal
            for low, high in [(dot(d.points[0], axis), dot(d.points[1], axis))]
            for number in range(d.count + 1)
            if self._direct(low) and self._direct(high)
        ]
        several = [] if strict else [d for d in several if d not in rows_of_equal]
        self._steps = [(d.value, d.name, REPEATS if d.kind == "pitch" else 2) for d in several]
        # Others may repeat what follows: for reference, of a hole table, depths of holes, derived of packaged parts.
        repeats = [d for d in own if d.reference or d.table or d.kind == "depth" or (d.derived_from and not strict)]
        # Names of dimensions between faces that other dimensions tie together already.
        self.superfluous = _closing([d for d in own if d not in repeats], feature_at)

    def _kind(self, level: float, kind: Kind) -> Kind:
        return None if not self._own_kinds or self._part.meets(self._axis, level) else kind

    def _end(self, point: Point) -> tuple[float, Kind]:
        """Level of a point of a dimension and its kind."""
        level, feature = dot(point, self._axis), self._part.feature_at(self._axis, point)
        face = isinstance(feature, int)
        if self._own_kinds and isinstance(feature, tuple) and feature[0] in (OUTLINE, CORNER):
            return level, feature[0]
        if isinstance(feature, tuple) and feature[0] == AXIS:
            return level, self._kind(level, self._part.axis_kind(self._axis, level, feature[1]))
        return level, self._kind(level, True) if face else None

    def _walls(self, d: Dimension) -> Iterator[tuple[float, float]]:
        """Levels of faces that a dimension gives, with their normals along the axis: a width between two faces within
        the part is that of one wall or of one space, and of those equal to it; 0 where both normals are meant."""
        ends = sorted((dot(point, self._axis), self._part.side(self._axis, point)) for point in d.points[:2])
        inner = all(abs(at - dot(end, self._axis)) > NEAR for at, _ in ends for end in self._part.box)
        (low, side), (high, other) = ends
        is_width = d.kind == "linear" and inner and side * other < 0.0
        equal = self._part.equal(self._axis, d) if d.count > 1 else [(low, high)]
        yield from ((at, way if is_width else 0.0) for row in equal for at, way in zip(sorted(row), (side, other)))

    def _add(
        self, row: dict[int, float], level: float, face: Kind, sign: float, name: str, *, private: bool = False
    ) -> None:
        """Enter a level in the equation of a dimension."""
        number, side = self._unknown(level, face, private=private)
        row[number] = row.get(number, 0.0) + sign * side
        self._names.setdefault(number, name)

    def located_by(
        self, level: float, side: float | None = None, *, corner: bool = False, about: Point | None = None
    ) -> str:
        """Name of what locates a level, of a plane face with a normal along the axis, of an axis (0, or in a direction
        `about`), or of a corner beside round faces, if this is said; empty where nothing does, as for a plane face at a
        middle by chance."""
        face: Kind = CORNER if corner else None if side is None else True if side else AXIS
        if about and face == AXIS and self._own_kinds:
            face = self._part.axis_kind(self._axis, level, along_of(about) or "")
        at = [(known, way) for known, way in self._stated if abs(known - level) < NEAR]
        at += [(-known, -way) for known, way in self._stated if self._symmetric and abs(known + level) < NEAR]
        if side and at and not any(way * side >= 0.0 for _, way in at):
            return ""
        if abs(level) < NEAR and self._datum:
            return self._at_middle if face is True and self._strict else "middle, axis or datum plane"
        if name := self._direct(level, face) or self._repeated(level, face):
            return name
        for (here, own), (there, other), name in self._alike:
            known = self._direct(there, other) or self._repeated(there, other)
            if abs(here - level) < NEAR and _fits(own, face) and (known or (abs(there) < NEAR and self._datum)):
                return f"{name}, repeated"
        for step, name, most in self._steps:
            # A feature of the given width about a located middle, and features in a row.
            starts = [level - step / 2, level + step / 2]
            starts += [level + side * times * step for times in range(1, most) for side in (-1, 1)]
            if any((abs(start) < NEAR and self._datum) or self._direct(start) for start in starts):
                return f"{name}, repeated"
        return ""

    def locates_end(self, level: float) -> bool:
        """Whether a level is located, be it that of the end of one drilled hole only."""
        side = abs(level) if self._symmetric else level
        ends = [known for number, known in enumerate(self._levels) if number in self._located]
        return bool(self.located_by(level)) or any(abs(known - side) < NEAR for known in ends)

    def _direct(self, level: float, face: Kind = None) -> str:
        at = abs(level) if self._symmetric else level
        for number in sorted(self._located - self._private):
            if abs(self._levels[number] - at) < NEAR and _fits(self._of_face[number], face):
                return self._names[number]
        return ""

    def _repeated(self, level: float, face: Kind) -> str:
        rows = (name for at, own, name in self._in_row if abs(at - level) < NEAR and _fits(own, face))
        return next((f"{name}, repeated" for name in rows), "")

    def _unknown(self, level: float, face: Kind = None, *, private: bool = False) -> tuple[int, float]:
        """Number of the unknown of a level, and the sign of the level in it; a private one is no other's."""
        side = -1.0 if self._symmetric and level < 0.0 else 1.0
        for number, known in enumerate(self._levels):
            own = not private and number not in self._private and _fits(self._of_face[number], face)
            if own and abs(known - side * level) < NEAR:
                return number, side
        self._of_face.append(face)
        self._levels.append(side * level)
        if private:
            self._private.add(len(self._levels) - 1)
        return len(self._levels) - 1, side

    def _outlines(self, own: Sequence[Dimension]) -> list[dict[int, float]]:
        """The equations of round faces at whose outline, a radius off the axis, a distance ends: of a whole one however
        long this is, else on the face."""
        rows: list[dict[int, float]] = []
        axis = self._axis
        for surface in (s for s in self._part.rounds if abs(dot(s.axis, axis)) < SQUARE):
            centre = dot(surface.origin, axis)
            for d, end in [(one, end) for one in own for end in one.points]:
                near = abs(abs(dot(end, axis) - centre) - surface.radius) < NEAR
                on = near and abs(surface.off_axis(end) - surface.radius) < NEAR
                if on and (surface.span > WHOLE or surface.holds(end)):
                    rows.append({})
                    self._add(rows[-1], *self._end(end), 1.0, d.name)
                    about = self._part.axis_kind(axis, centre, along_of(surface.axis) or "")
                    self._add(rows[-1], centre, self._kind(centre, about), -1.0, d.name)
        return rows

    def _tied(self, several: Sequence[Dimension]) -> list[dict[int, float]]:
        """Equations of levels between which equal features are."""
        rows: list[dict[int, float]] = []
        for d in (d for d in several if d.kind != "pitch"):
            kinds = [kind for _, kind in sorted(map(self._end, d.points), key=lambda end: end[0])]
            for levels in self._part.equal(self._axis, d):
                low, high = zip(levels, kinds, strict=True)
                self._alike += [(low, high, d.name), (high, low, d.name)]
                rows.append({})
                self._add(rows[-1], *low, -1.0, d.name)
                self._add(rows[-1], *high, 1.0, d.name)
        return rows

    def _equal_features(self, sizes: Sequence[float]) -> list[dict[int, float]]:
        """Equations of equal features: levels as far apart as a dimension for several; or a level and its image."""
        apart = [
            {one: -1.0, other: 1.0}
            for size in sizes
            for one, low in enumerate(self._levels)
            for other, high in enumerate(self._levels)
            if abs(high - low - size) < NEAR and not {one, other} & self._private
        ]
        mirrored = [
            {one: 2.0}
            for size in sizes
            for one, level in enumerate(self._levels)
            if self._symmetric and abs(2.0 * level - size) < NEAR and one not in self._private
        ]
        return apart + mirrored

    def _determined(self, rows: Sequence[dict[int, float]]) -> set[int]:
        """Numbers of the unknowns that the equations determine, from the middle or a level of reference."""
        count = len(self._levels)
        # Equal features give many equal equations.
        unlike = dict.fromkeys(tuple(sorted(row.items())) for row in rows)
        matrix = np.zeros((max(len(unlike), 1), count))
        for index, row in enumerate(unlike):
            for number, coefficient in row:
                matrix[index, number] = coefficient
        null = null_space(matrix, rcond=1e-9) if count else matrix.T
        free = np.abs(null).max(axis=1, initial=0.0) < 1e-6
        shared = [number for number in range(count) if number not in self._private]
        zero = [number for number in shared if abs(self._levels[number]) < NEAR and self._datum]
        references = zero[:1] or ([] if self._symmetric or self._strict else list(range(count)))
        best = set(np.flatnonzero(free).tolist())
        for reference in references:
            # With the reference fixed, an unknown is determined if it is proportional to the reference in the space.
            row = null[reference]
            size = float(row @ row)
            along = null - np.outer(null @ row / size, row) if size > 1e-12 else null
            found = set(np.flatnonzero(np.abs(along).max(axis=1, initial=0.0) < 1e-6).tolist())
            best = max(best, found, key=self._reach)
        return best

    def _reach(self, numbers: set[int]) -> tuple[float, int]:
        """How far apart some levels are, and their number: of groups of levels the one that reaches farthest is the
        part, others are features without a place."""
        levels = [self._levels[number] for number in numbers]
        return max(levels, default=0.0) - min(levels, default=0.0), len(levels)


def _fits(kind: Kind, asked: Kind) -> bool:
    """Whether a kind of level is the one asked for, if one is."""
    both = (kind, asked)
    if None in both or kind == asked or (CORNER in both and OUTLINE not in both):
        return True
    return AXIS in both and all(isinstance(one, str) and one.startswith(AXIS) for one in both)


def axis_kind(verifier: DimensionVerifier, along: Point, level: float, name: str) -> str:
    """Kind of the level of an axis along a named axis of the part: with the name, since no view shows at one place that
    features in two directions are at one level; those that meet are alike."""

    def alike() -> dict[str, str]:
        across = (s for s in verifier.surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, along)) < SQUARE)
        at = [s for s in across if abs(dot(s.origin, along) - level) < NEAR]
        joined = DisjointSet([along_of(s.axis) or "" for s in at])
        for one, other in combinations(at, 2):
            if touch(one, other):
                joined.merge(along_of(one.axis) or "", along_of(other.axis) or "")
        return {name: min(subset) for subset in joined.subsets() for name in subset}

    return f"{AXIS} {verifier.kept(('alike', along, round(level, 3)), alike).get(name, name)}"


def _closing(dimensions: Sequence[Dimension], feature_at: Callable[[Point], Hashable]) -> list[str]:
    """Names of dimensions between two features that others tie together already."""
    tied = DisjointSet()
    found = []
    for d in dimensions:
        one, other = map(feature_at, d.points[:2])
        tied.add(one)
        tied.add(other)
        if not tied.merge(one, other):
            found.append(d.name)
    return found


def _is_along(d: Dimension, axis: Point) -> bool:
    along = d.direction is not None and abs(abs(dot(d.direction, axis)) - 1.0) < SQUARE
    return along and d.kind in BETWEEN and len(d.points) == 2


AXES: dict[str, Point] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
WHOLE, HALF = 1.5 * math.pi, 0.95 * math.pi
"""Angle about its axis from which on a face is a whole shaft, and up to which it may be a fillet."""
SIMPLE = ("PLANE", "CYLINDER", "CONE", "SPHERE", "TORUS")
"""Kinds of faces that are no free-form ones."""
LARGEST_CHAMFER = 0.2
"""Leg of a chamfer over the largest size of the part above which the face is a slope."""


def along_of(axis: Point) -> str | None:
    """Name of the axis of the part along which a direction is; None for a slanting one."""
    return next((name for name, unit in AXES.items() if abs(abs(dot(axis, unit)) - 1.0) < SQUARE), None)


def goes_around(faces: Sequence[Surface]) -> bool:
    """Whether faces about one axis are given by a diameter: of a hole, which may be cut open at its rim, those of more
    than half a turn (ISO 129-1); of any, those that are opposite each other. Those behind each other count once."""
    ways = [s.radial(s.middle[1]) for s in faces]
    if any(dot(one, other) < SQUARE - 1 for one in ways for other in ways):
        return True
    spans = {tuple(round(a, 4) + 0.0 for a in way): s.span for way, s in zip(ways, faces, strict=True)}
    return sum(spans.values()) > (WHOLE if faces[0].outward else 2 * math.pi - HALF)


def is_fillet(surface: Surface, surfaces: Sequence[Surface]) -> bool:
    """Whether a part of a cylinder is tangent to two faces that are not parallel, and so placed by them; not the nose
    between walls that a larger round face places with it."""
    if surface.span > HALF:
        return False
    sides, placed = 0, 0
    for edge in surface.face.Edges():
        ends = (edge.startPoint().toTuple(), edge.endPoint().toTuple())
        if edge.Length() - math.dist(*ends) > NEAR:
            continue
        point = edge.positionAt(0.5).toTuple()  # pyright: ignore[reportAttributeAccessIssue]
        out = surface.radial(point)
        for other in surfaces:
            if other.kind in ("PLANE", "CYLINDER") and not other.is_coaxial(surface) and other.holds(point):
                normal = other.axis if other.kind == "PLANE" else other.radial(point)
                if abs(abs(dot(normal, out)) - 1.0) < 1e-3:
                    sides += 1
                    placed += other.kind == "PLANE" and surface.outward and _touches_larger(other, surface, surfaces)
    return sides >= 2 > placed


def fillet_at(ball: Surface, surfaces: Sequence[Surface]) -> Surface | None:
    """The fillet that goes on in the ball of a corner, in which equal ones meet: it has its size, and places it."""
    near = (s for s in surfaces if s.kind == "TORUS" or (s.kind == "CYLINDER" and s.span <= HALF))
    alike = (s for s in near if abs(s.radius - ball.radius) < NEAR and s.outward == ball.outward)
    return next((s for s in alike if touch(s, ball) and any(map(s.holds, ball.vertices))), None)


def tube_of(torus: Surface, surfaces: Sequence[Surface]) -> Surface | None:
    """The tube that goes on in a torus, which has its size, and which a distance to its axis places."""
    tubes = (s for s in surfaces if s.is_round(torus.radius) and abs(dot(s.axis, torus.axis)) < SQUARE)
    return next((s for s in tubes if any(map(s.holds, torus.vertices)) and not is_fillet(s, surfaces)), None)


def is_usual_size(value: float) -> bool:
    """Whether a length is in tenths of a millimetre, as designers choose them."""
    return abs(value - round(value, 1)) < 1e-6


def corners_of(surface: Surface, verifier: DimensionVerifier) -> dict[Point, Point]:
    """Corners of a plane face by the theoretical ones: where a fillet is between it and another plane the one at which
    both would meet, and of a wall that ends in a round face, in the middle of this where that has a usual level."""
    return verifier.kept(("corners", id(surface)), lambda: _sharp_corners(surface, verifier))


def drawn_at(point: Point, verifier: DimensionVerifier) -> Point:
    """The corner beside a fillet that is drawn, for the theoretical one."""
    rows = verifier.kept("sharp", lambda: [s for s in verifier.surfaces if s.kind == "PLANE" and not along_of(s.axis)])
    found = (corners_of(s, verifier) for s in rows)
    return next((real for row in found for sharp, real in row.items() if math.dist(sharp, point) < NEAR), point)


def _sharp_corners(surface: Surface, verifier: DimensionVerifier) -> dict[Point, Point]:
    found: dict[Point, Point] = {}
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and abs(dot(s.axis, surface.axis)) < 1 - SQUARE]
    for corner in surface.corners:
        sharp = corner
        at = [s for s in verifier.surfaces if s.kind == "CYLINDER" and s.is_at(corner) and s.holds(corner)]
        hubs = (s for s in at if s.outward and s.span > HALF and abs(dot(s.axis, surface.axis)) < SQUARE)
        if hub := next(hubs, None):
            sharp = _beside_axis(surface, hub, corner)
        tangent = (s for s in at if abs(dot(s.radial(corner), surface.axis)) > 1 - SQUARE)
        for fillet in (s for s in tangent if is_fillet(s, verifier.surfaces)):
            beside = (s for s in planes if touch(s, fillet) and abs(dot(s.axis, fillet.axis)) < SQUARE)
            for s in beside:
                if any(s.is_level(v) and abs(dot(fillet.radial(v), s.axis)) > 1 - SQUARE for v in fillet.vertices):
                    x, y, z = meeting(surface, s, corner) or corner
                    sharp = (round(x, 9) + 0.0, round(y, 9) + 0.0, round(z, 9) + 0.0)
        found[sharp] = corner
    return found


def _beside_axis(wall: Surface, hub: Surface, corner: Point) -> Point:
    """The point of a slanting wall beside the axis of a round face, if it has a usual level and the corner has none."""
    number = max(range(3), key=lambda n: abs(wall.axis[n]))
    foot = list(add(hub.origin, scaled(hub.axis, dot(subtract(corner, hub.origin), hub.axis))))
    foot[number] += dot(subtract(wall.origin, (foot[0], foot[1], foot[2])), wall.axis) / wall.axis[number]
    usual = is_usual_size(foot[number]) and not is_usual_size(corner[number])
    x, y, z = (round(a, 9) + 0.0 for a in foot)
    return (x, y, z) if usual else corner


def _touches_larger(wall: Surface, nose: Surface, surfaces: Sequence[Surface]) -> bool:
    """Whether a wall is tangent to an outer round face of more than half a turn about another axis than a nose."""
    level = dot(wall.origin, wall.normal)
    large = (s for s in surfaces if s.kind == "CYLINDER" and s.outward and s.span > HALF and not s.is_coaxial(nose))
    tangent = (s for s in large if abs(dot(s.origin, wall.normal) + s.radius - level) < NEAR)
    return any(any(map(s.is_at, wall.vertices)) for s in tangent)


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
    own = surface.normal
    points = [edge.positionAt(0.5).toTuple() for edge in surface.face.Edges()]  # pyright: ignore[reportAttributeAccessIssue]
    beside = [s for s in surfaces if s is not surface and s.kind == "PLANE" and any(map(s.holds, points))]
    return all(any(s.normal[n] * own[n] > 0.7 for s in beside) for n in across)


def axes_about(plane: Surface, level: float, surfaces: Sequence[Surface]) -> list[Surface]:
    """Round faces along a plane whose axes are at a level along its axis."""
    along = (s for s in surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, plane.axis)) < SQUARE)
    return [s for s in along if abs(dot(s.origin, plane.axis) - level) < NEAR]


def axis_of_reference(surfaces: Sequence[Surface], along: Point) -> Surface | None:
    """The largest round face across a direction, an outer one before a bore, without an equal one about another axis,
    of a part that ends in no plane face square to the direction."""
    ends = [dot(end, along) for s in surfaces for end in (s.low, s.high)]
    flat = (dot(s.origin, along) for s in surfaces if s.kind == "PLANE" and abs(dot(s.axis, along)) > 1 - SQUARE)
    if any(min(abs(at - min(ends)), abs(at - max(ends))) < NEAR for at in flat):
        return None
    rounds = [s for s in surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, along)) < SQUARE]
    equal = {(s.outward, round(s.radius, 3)): {o.axis_key for o in rounds if o.is_round(s.radius)} for s in rounds}
    single = [s for s in rounds if len(equal[s.outward, round(s.radius, 3)]) == 1]
    return max(single, key=lambda s: (s.outward, s.radius), default=None)


def tangent_rounds(plane: Surface, surfaces: Sequence[Surface]) -> list[Surface]:
    """The round faces about two or more axes that a plane touches, and that so place it; else none. A fillet is placed
    by the plane, if no face of another radius is about its axis."""
    level = dot(plane.origin, plane.axis)
    radii = {s.radius for s in surfaces if s.kind == "CYLINDER"}
    near = [s for r in radii for side in (r, -r) for s in axes_about(plane, level + side, surfaces) if s.is_round(r)]
    met = [s for s in near if any(map(s.is_at, plane.vertices))]
    # Another wall may cut it off before it meets a second one.
    met += [s for s in near if met and s not in met and s.outward and abs(plane.off_plane(s.origin) - s.radius) < 1e-6]
    others = [s for s in surfaces if s.kind == "CYLINDER"]
    met = [
        s
        for s in met
        if any(o.is_coaxial(s) and not o.is_round(s.radius) for o in others) or not is_fillet(s, surfaces)
    ]
    return met if len({s.axis_key for s in met}) > 1 else []


def touch(one: Surface, other: Surface, but: int = -1) -> bool:
    """Whether the boxes of two faces meet, along all axes but one."""
    return all(one.low[n] - NEAR <= other.high[n] and other.low[n] - NEAR <= one.high[n] for n in range(3) if n != but)


def like_edges(verifier: DimensionVerifier, d: Dimension) -> dict[int, Hashable]:
    """Numbers of the faces of all fillets or chamfers of the size of a dimension, with what tells these apart."""
    found: dict[int, Hashable] = {}
    for number, surface in enumerate(verifier.surfaces):
        if d.kind == "radius" and surface.kind in ("CYLINDER", "SPHERE", "TORUS"):
            round_faces = (s for s in verifier.surfaces if s.is_round(surface.radius) and s.outward == surface.outward)
            like = [s for s in round_faces if s.is_coaxial(surface)]
            # Faces that go around their axis have a diameter.
            whole = like and goes_around(like)
            corner = surface.kind == "SPHERE" and fillet_at(surface, verifier.surfaces)
            if abs(surface.radius - d.value) < NEAR and not whole and not corner:
                found[number] = surface.axis_key if surface.kind == "CYLINDER" else number
        elif (
            d.kind == "chamfer"
            and surface.kind in ("PLANE", "CONE")
            and abs(_leg(surface) - d.value) < NEAR
            and is_chamfer(surface, verifier.surfaces)
        ):
            found[number] = key_of_chamfer(surface)
    return found


def key_of_chamfer(surface: Surface) -> Hashable:
    """Numbers that are equal for the faces into which a chamfer is divided: of cones about one axis
    with equal ends."""
    if surface.kind == "CONE":
        level, wide = sum(surface.extent(surface.axis)), max(map(surface.off_axis, surface.vertices))
        return (*surface.axis_key, round(abs(level), 2), round(wide, 2))
    return (*surface.axis_key, round(sum(surface.low), 2))


def _leg(chamfer: Surface) -> float:
    """Leg of a conical or plane chamfer at 45 degrees."""
    along = max(range(3), key=lambda n: abs(chamfer.axis[n]))
    return chamfer.high[along] - chamfer.low[along]


def ends_of_cones(surfaces: Sequence[Surface], radius: float) -> set[tuple[float, ...]]:
    """Axis and level of each end of a cone with a radius that no cylinder about the axis has."""
    round_faces = [s for s in surfaces if s.is_round(radius)]
    cones = [s for s in surfaces if s.kind == "CONE" and not any(map(s.is_coaxial, round_faces))]
    ends = ((s.axis_key, v) for s in cones for v in s.vertices if abs(s.off_axis(v) - radius) < NEAR)
    return {(*key, round(sum(a * b for a, b in zip(v, key[3:])), 2)) for key, v in ends}


def is_mirrored(surfaces: Sequence[Surface], number: int, middle: float) -> bool:
    """Whether the boxes of all faces are mirror images of each other about a middle plane; of free-form faces, which a
    seam may divide on one side, their common box and centre of area."""
    boxes = [(s.kind, s.low, s.high) for s in surfaces if s.kind in SIMPLE]
    free = [s for s in surfaces if s.kind not in SIMPLE]
    if abs(sum(s.area * (s.centre[number] - middle) for s in free)) > 0.02 * sum(s.area for s in free):
        return False
    corners = [
        tuple(pick(column) for column in zip(*ends))
        for pick, ends in ((min, [s.low for s in free]), (max, [s.high for s in free]))
    ]
    boxes += [("FREE", *corners)] if free else []

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
