"""Features of a solid that nobody declared: holes and their patterns, slots, fillets, chamfers, bosses, slanted faces.

Recognised on the analytic surfaces of the faces (Han, Pratt, Regli, IEEE Trans. Robotics and Automation 16 (2000) 782):
round faces about one axis that follow each other are a hole if the material is outside; half cylinders in pairs are the
ends of a slot; other parts of cylinders are fillets. Millimetres, part coordinates.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from drawings.dimensions.small_edges import AXES, NEAR, SQUARE, WHOLE, along_of, is_chamfer
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import DimensionVerifier, Surface, moved

WIDEST_CHAMFER = 1.3
"""Diameter of a cone of 90 degrees at the mouth of a hole, over that of the hole, up to which it is a chamfer."""


@dataclass(frozen=True)
class Section:
    """Part of a hole or shaft with one radius, from one distance along its axis to another."""

    radius: float
    low: float
    high: float
    face: Surface = field(compare=False)


@dataclass(frozen=True)
class Hole:
    """A round hole.

    Args:
        mouth: point of its axis at its opening.
        into: unit vector into the material.
        steps: radius, and distance of its end from the mouth, from the mouth on.
        faces: of the steps.
        through: whether both ends are open.
        sink: diameter of a countersink at the mouth, and its whole angle, degrees; 0 without one.
    """

    mouth: Point
    into: Point
    steps: tuple[tuple[float, float], ...]
    faces: tuple[Surface, ...]
    through: bool
    sink: tuple[float, float] = (0.0, 0.0)

    @property
    def kind(self) -> tuple[object, ...]:
        """Equal for holes that one callout may describe."""
        level = round(dot(self.mouth, self.into), 2)
        steps = tuple(
            (round(r, 3), 0.0 if self.through and r == self.steps[-1][0] else round(d, 2)) for r, d in self.steps
        )
        return (tuple(round(a, 6) + 0.0 for a in self.into), level, steps, self.through, round(self.sink[0], 3))


@dataclass(frozen=True)
class Slot:
    """A slot with half cylinders at its ends."""

    centres: tuple[Point, Point]  # of both ends, at one level
    axis: Point  # across the plane of the slot
    radius: float  # of the ends
    ends: tuple[Surface, Surface]


@dataclass(frozen=True)
class Features:
    """What was recognised on a solid; all faces that are in no list are planes or of no simple shape."""

    holes: tuple[Hole, ...]
    slots: tuple[Slot, ...]
    shafts: tuple[Section, ...]
    fillets: tuple[Surface, ...]
    chamfers: tuple[Surface, ...]
    cones: tuple[Surface, ...]
    spheres: tuple[Surface, ...]
    slanted: tuple[Surface, ...]
    free: tuple[Surface, ...]


def features_of(verifier: DimensionVerifier) -> Features:
    """Features of a solid."""
    surfaces = verifier.surfaces
    round_faces, parts = _round_and_partial(surfaces)
    inner = [s for s in round_faces if not s.outward]
    holes = tuple(_holes(inner, [s for s in surfaces if s.kind == "CONE"], verifier))
    in_holes = {id(face) for hole in holes for face in hole.faces}
    slots = tuple(_slots(parts))
    in_slots = {id(end) for slot in slots for end in slot.ends}
    chamfers = tuple(s for s in surfaces if id(s) not in in_holes and is_chamfer(s, surfaces))
    taken = in_holes | {id(s) for s in chamfers}
    return Features(
        holes,
        slots,
        tuple(_sections(s for s in round_faces if s.outward)),
        tuple(s for s in surfaces if (s.kind == "TORUS" or any(s is part for part in parts)) and id(s) not in in_slots),
        chamfers,
        tuple(s for s in surfaces if s.kind == "CONE" and id(s) not in taken),
        tuple(s for s in surfaces if s.kind == "SPHERE"),
        tuple(s for s in surfaces if s.kind == "PLANE" and along_of(s.axis) is None and id(s) not in taken),
        tuple(s for s in surfaces if s.kind not in ("PLANE", "CYLINDER", "CONE", "SPHERE", "TORUS")),
    )


def is_usual(axis: Point) -> bool:
    """Whether a direction points towards the eye of the top, front or right view rather than of their opposites."""
    return axis[2] > SQUARE or (
        abs(axis[2]) <= SQUARE and (axis[0] > SQUARE or (abs(axis[0]) <= SQUARE and axis[1] < 0))
    )


def middle_of_face(surface: Surface) -> Point:
    """A point of a face in the middle of its parameters."""
    u0, u1, v0, v1 = surface.face._uvBounds()  # pyright: ignore[reportPrivateUsage]
    _, point = surface.face.normalAt((u0 + u1) / 2, (v0 + v1) / 2)
    return point.toTuple()


def _round_and_partial(surfaces: list[Surface]) -> tuple[list[Surface], list[Surface]]:
    """Cylinders that together go around their axis, and those that do not."""
    covered: dict[tuple[object, ...], float] = {}

    def key(surface: Surface) -> tuple[object, ...]:
        return (*surface.axis_key, round(surface.radius, 3), surface.outward)

    cylinders = [s for s in surfaces if s.kind == "CYLINDER"]
    for surface in cylinders:
        covered[key(surface)] = covered.get(key(surface), 0.0) + surface.span
    whole = [s for s in cylinders if covered[key(s)] >= WHOLE]
    return whole, [s for s in cylinders if covered[key(s)] < WHOLE]


def _sections(faces: Iterable[Surface]) -> Iterator[Section]:
    """Faces of one radius and axis that follow each other without a gap, as one section each."""
    rows: dict[tuple[object, ...], list[Surface]] = {}
    for face in faces:
        rows.setdefault((*face.axis_key, round(face.radius, 3)), []).append(face)
    for row in rows.values():
        axis = row[0].axis
        spans = sorted(((*_extent(face, axis), n, face) for n, face in enumerate(row)), key=lambda span: span[:3])
        low, high, _, first = spans[0]
        for start, end, _, face in spans[1:]:
            if start > high + NEAR:
                yield Section(first.radius, low, high, first)
                low, high, first = start, end, face
            high = max(high, end)
        yield Section(first.radius, low, high, first)


def _extent(face: Surface, axis: Point) -> tuple[float, float]:
    """Ends of a round face along its axis; of crossing bores by its box, as vertices are not at the ends."""
    low, high = face.extent(axis) if face.vertices else (0.0, 0.0)
    name = along_of(axis)
    if name is not None:
        number = list(AXES).index(name)
        sign = 1.0 if axis[number] > 0 else -1.0
        ends = sorted((sign * face.low[number], sign * face.high[number]))
        return min(low, ends[0]) if face.vertices else ends[0], max(high, ends[1]) if face.vertices else ends[1]
    return low, high


def _holes(inner: list[Surface], cones: list[Surface], verifier: DimensionVerifier) -> Iterator[Hole]:
    """Chains of sections about one axis that follow each other, with the cones between them and at their ends."""
    by_axis: dict[tuple[float, ...], list[Section]] = {}
    for section in _sections(inner):
        by_axis.setdefault(section.face.axis_key, []).append(section)
    for sections in by_axis.values():
        axis = sections[0].face.axis
        own = [s for s in cones if s.is_coaxial(sections[0].face) and not s.outward]
        sections = sorted(
            (replace_axis(section, axis) for section in sections), key=lambda section: (section.low, section.high)
        )
        chain: list[Section] = []
        for section in sections:
            gap = (chain[-1].high, section.low) if chain else (0.0, 0.0)
            cones_between = (_extent(cone, axis) for cone in own)
            bridged = any(abs(low - gap[0]) < NEAR and abs(high - gap[1]) < NEAR for low, high in cones_between)
            if gap[1] - gap[0] > NEAR and not bridged:
                yield _hole(chain, own, axis, verifier)
                chain = []
            chain.append(section)
        yield _hole(chain, own, axis, verifier)


def replace_axis(section: Section, axis: Point) -> Section:
    """A section with its ends along an axis that may be opposite to its own."""
    if dot(section.face.axis, axis) > 0:
        return section
    return Section(section.radius, -section.high, -section.low, section.face)


def _hole(chain: list[Section], cones: list[Surface], axis: Point, verifier: DimensionVerifier) -> Hole:
    """A hole from its sections in the order along the axis."""
    face = chain[0].face
    on_axis = moved(face.origin, axis, -dot(face.origin, axis))
    ends = [chain[0].low, chain[-1].high]
    tips = {}
    for side, end in ((-1.0, 0), (1.0, 1)):
        for cone in cones:
            low, high = _extent(cone, axis)
            near, far = (high, low) if side < 0 else (low, high)
            if abs(near - ends[end]) < NEAR:
                tips[end] = (cone, far)
    open_ends = []
    for end, side in ((0, -1.0), (1, 1.0)):
        reach = tips[end][1] if end in tips else ends[end]
        section = chain[0 if end == 0 else -1]
        around = moved(on_axis, axis, reach + side * 0.02)
        # The cone of a drill becomes narrower than the hole.
        drilled = end in tips and min(map(tips[end][0].off_axis, tips[end][0].vertices)) < section.radius - NEAR
        open_ends.append(not verifier.is_inside(around) and not drilled)
    # The mouth is the wider open end; of two equal ones that towards the eye of the top, front or right view.
    radii = [chain[0].radius, chain[-1].radius]
    upward = is_usual(axis)
    if all(open_ends):
        # A hole in a wall of a hollow part begins at its outside.
        reach = [verifier.size * part / 40 for part in range(1, 40)]
        free = [
            not any(verifier.is_inside(moved(on_axis, axis, ends[end] + side * by)) for by in reach)
            for end, side in ((0, -1.0), (1, 1.0))
        ]
        upward = free[1] if free[0] != free[1] else upward
    first = (
        1
        if open_ends[1] and (not open_ends[0] or radii[1] > radii[0] + NEAR or (radii[1] > radii[0] - NEAR and upward))
        else 0
    )
    side = 1.0 if first == 1 else -1.0
    into = (-side * axis[0] + 0.0, -side * axis[1] + 0.0, -side * axis[2] + 0.0)
    start = ends[first]
    sink = (0.0, 0.0)
    for end in [end for end in tips if open_ends[end]]:
        cone, far = tips[end]
        wide = max(cone.off_axis(vertex) for vertex in cone.vertices)
        start = far if end == first else start
        if wide <= WIDEST_CHAMFER * chain[-end].radius and abs(abs(cone.taper) - 1.0) < 1e-4:
            del tips[end]
        elif end == first:
            sink = (2 * wide, 2 * math.degrees(math.atan(abs(cone.taper))))
    ordered = chain if first == 0 else chain[::-1]
    if along_of(axis) is None:
        # Its mouth is an ellipse: it begins where the axis meets the face.
        corners = sorted(ordered[0].face.vertices, key=lambda vertex: dot(vertex, into))
        planes = [s for s in verifier.surfaces if s.kind == "PLANE" and any(map(s.holds, corners[:1]))]
        open_faces = [s for s in planes if abs(dot(s.axis, axis)) > 0.1]
        if open_faces:
            plane = open_faces[0]
            gap = [o - a for o, a in zip(plane.origin, on_axis, strict=True)]
            start = sum(g * n for g, n in zip(gap, plane.axis, strict=True)) / dot(axis, plane.axis)
    steps = tuple((s.radius, abs((s.high if first == 0 else s.low) - start)) for s in ordered)
    used = [s.face for s in ordered] + [tip[0] for tip in tips.values()]
    return Hole(moved(on_axis, axis, start), into, steps, tuple(used), all(open_ends), sink)


def _slots(parts: list[Surface]) -> Iterator[Slot]:
    """Pairs of half cylinders, nearest first, that face each other."""
    ends = [s for s in parts if not s.outward and abs(s.span - math.pi) < 0.02]
    used: set[int] = set()
    for one in ends:
        if id(one) in used:
            continue
        others = [
            other
            for other in ends
            if other is not one
            and id(other) not in used
            and abs(other.radius - one.radius) < NEAR
            and abs(abs(dot(one.axis, other.axis)) - 1.0) < SQUARE
            and not one.is_coaxial(other)
            and max(abs(a - b) for a, b in zip(_extent(one, one.axis), _extent(other, one.axis), strict=True)) < 0.05
        ]
        if not others:
            continue
        level = sum(_extent(one, one.axis)) / 2

        def centre(surface: Surface, level: float = level, axis: Point = one.axis) -> Point:
            return moved(surface.origin, axis, level - dot(surface.origin, axis))

        other = min(others, key=lambda end: math.dist(centre(one), centre(end)))
        used |= {id(one), id(other)}
        first, second = sorted((centre(one), centre(other)))
        yield Slot((first, second), one.axis, one.radius, (one, other))
