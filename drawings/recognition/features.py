"""Features of a solid that nobody declared: holes and their patterns, slots, fillets, chamfers, bosses, slanted faces.

Recognised on the analytic surfaces of the faces (Han, Pratt, Regli, IEEE Trans. Robotics and Automation 16 (2000) 782):
round faces about one axis that follow each other are a hole if the material is outside; parts of cylinders that are no
ends of a slot are fillets. Millimetres, part coordinates.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from drawings.dimensions.levels import (
    AXES,
    NEAR,
    SQUARE,
    along_of,
    fillet_at,
    goes_around,
    is_chamfer,
    is_usual_size,
    tube_of,
)
from drawings.dimensions.round_sections import Section, sections_of
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.parameters.threads import threads
from stagecad.solids.modelling.frame import cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, moved
from stagecad.solids.modelling.verification import DimensionVerifier

WIDEST_CHAMFER = 1.3
"""Diameter of a cone of 90 degrees at the mouth of a hole, over that of the hole, up to which it is a chamfer."""
NARROWEST_SINK = 50.0
"""Whole angle of a countersink, degrees; a narrower cone is a taper."""


@dataclass(frozen=True)
class Hole:
    """A round hole."""

    mouth: Point  # of its axis at its opening
    into: Point  # unit vector into the material
    steps: tuple[tuple[float, float], ...]  # radius, and distance of its end from the mouth, from the mouth on
    faces: tuple[Surface, ...]  # of the steps
    way_out: str  # where its end is open: `through`, `to bore`, or `one wall` of several; empty for a blind hole
    sink: tuple[float, float] = (0.0, 0.0)  # diameter of a countersink at the mouth, and its whole angle, degrees; or 0

    @property
    def through(self) -> bool:
        return bool(self.way_out)

    @property
    def kind(self) -> tuple[object, ...]:
        """Equal for holes that one callout may describe; plain ones through the part may begin at different levels."""
        plain = self.through and len(self.steps) == 1 and not self.sink[0]
        level = 0.0 if plain else round(dot(self.mouth, self.into), 2)
        steps = tuple(
            (round(r, 3), 0.0 if self.through and r == self.steps[-1][0] else round(d, 2)) for r, d in self.steps
        )
        return (tuple(round(a, 6) + 0.0 for a in self.into), level, steps, self.way_out, round(self.sink[0], 3))


@dataclass(frozen=True)
class Features:
    """What was recognised on a solid; all faces that are in no list are planes or of no simple shape."""

    holes: tuple[Hole, ...]
    shafts: tuple[Section, ...]
    fillets: tuple[Surface, ...]
    chamfers: tuple[Surface, ...]
    grooves: tuple[Section, ...]  # within a hole, wider than what is in front of them
    cones: tuple[Surface, ...]
    spheres: tuple[Surface, ...]
    slanted: tuple[Surface, ...]


def features_of(verifier: DimensionVerifier) -> Features:
    """Features of a solid."""
    surfaces = verifier.surfaces
    round_faces, parts = _round_and_partial(surfaces)
    inner = [s for s in round_faces if not s.outward]
    grooves: list[Section] = []
    holes = tuple(_as_equals([*_holes(inner, [s for s in surfaces if s.kind == "CONE"], verifier, grooves)]))
    in_holes = {id(face) for hole in holes for face in hole.faces}
    in_slots = {id(end) for prism in verifier.prisms for end in prism.ends}
    chamfers = tuple(s for s in surfaces if id(s) not in in_holes and is_chamfer(s, surfaces))
    taken = in_holes | {id(s) for s in chamfers}
    return Features(
        holes,
        tuple(sections_of(s for s in round_faces if s.outward)),
        tuple(s for s in surfaces if (s.kind == "TORUS" or any(s is part for part in parts)) and id(s) not in in_slots),
        chamfers,
        tuple(grooves),
        tuple(s for s in surfaces if s.kind == "CONE" and id(s) not in taken),
        tuple(s for s in surfaces if s.kind == "SPHERE" and not fillet_at(s, surfaces)),
        tuple(s for s in surfaces if s.kind == "PLANE" and along_of(s.axis) is None and id(s) not in taken),
    )


def is_usual(axis: Point) -> bool:
    """Whether a direction points towards the eye of the top, front or right view rather than of their opposites."""
    return axis[2] > SQUARE or (
        abs(axis[2]) <= SQUARE and (axis[0] > SQUARE or (abs(axis[0]) <= SQUARE and axis[1] < 0))
    )


def decimals(value: float) -> int:
    """Number of decimals of a length or angle, at most 4."""
    return next((n for n in range(4) if abs(value - round(value, n)) < 1e-6), 4)


def middle_of_face(surface: Surface) -> Point:
    """A point of a face in the middle of its parameters, or if this is cut out, off the middle."""
    u0, u1, v0, v1 = surface.face._uvBounds()  # pyright: ignore[reportPrivateUsage]
    parts = (0.5, 0.25, 0.75, 0.05, 0.95)
    found = [surface.face.normalAt(u0 + part * (u1 - u0), (v0 + v1) / 2)[1].toTuple() for part in parts]
    return next((point for point in found if surface.holds(point)), found[0])


def _round_and_partial(surfaces: list[Surface]) -> tuple[list[Surface], list[Surface]]:
    """Cylinders that together go around their axis, and those that do not."""
    groups: dict[tuple[object, ...], list[Surface]] = defaultdict(list)
    for surface in (s for s in surfaces if s.kind == "CYLINDER"):
        groups[*surface.axis_key, round(surface.radius, 3), surface.outward].append(surface)
    whole = {id(s) for group in groups.values() if goes_around(group) for s in group}
    cylinders = [s for s in surfaces if s.kind == "CYLINDER"]
    return [s for s in cylinders if id(s) in whole], [s for s in cylinders if id(s) not in whole]


def _holes(
    inner: list[Surface], cones: list[Surface], verifier: DimensionVerifier, grooves: list[Section]
) -> Iterator[Hole]:
    """Chains of sections about one axis that follow each other, with the cones between them and at their ends."""
    by_axis: dict[tuple[float, ...], list[Section]] = {}
    for section in sections_of(inner):
        by_axis.setdefault(section.face.axis_key, []).append(section)
    for sections in by_axis.values():
        axis = sections[0].face.axis
        own = [s for s in cones if s.is_coaxial(sections[0].face) and not s.outward]
        sections = sorted((section.along(axis) for section in sections), key=lambda one: (one.low, one.high))
        # About a shoulder or core that the bore goes into there is a groove in an end face, or a recess.
        inside = [
            s
            for s in sections
            if any(i.radius < s.radius and max(i.low, s.low) < min(i.high, s.high) - NEAR for i in sections)
        ]
        grooves += inside
        chain: list[Section] = []
        for section in (one for one in sections if one not in inside):
            gap = (chain[-1].high, section.low) if chain else (0.0, 0.0)
            cones_between = (cone.extent(axis) for cone in own)
            bridged = any(abs(low - gap[0]) < NEAR and abs(high - gap[1]) < NEAR for low, high in cones_between)
            if gap[1] - gap[0] > NEAR and not bridged:
                yield from _holes_of(_from_mouth(chain, own, axis, verifier), verifier, grooves)
                chain = []
            chain.append(section)
        yield from _holes_of(_from_mouth(chain, own, axis, verifier), verifier, grooves)


def _as_equals(holes: Sequence[Hole]) -> Iterator[Hole]:
    """Holes; those equal to one in front of further material are holes through one wall from its side, too."""
    covered = [one for one in holes if one.way_out == "one wall"]
    for hole in holes:
        (radius, depth), *more = hole.steps
        for one in (one for one in covered if hole.through and not more and len(one.steps) == 1):
            like = (
                abs(one.steps[0][0] - radius) + abs(one.steps[0][1] - depth) < NEAR and not one.sink[0] + hole.sink[0]
            )
            ends = (hole.mouth, moved(hole.mouth, hole.into, depth))
            mouth = next((end for end in ends if abs(dot(subtract(end, one.mouth), one.into)) < NEAR), None)
            both = like and mouth and abs(dot(hole.into, one.into)) > 1 - SQUARE
            if both and any(other.way_out == "through" and other.kind[2] == one.kind[2] for other in holes):
                hole = replace(hole, mouth=mouth, into=one.into, way_out="through")
        yield hole


@dataclass(frozen=True)
class _Chain:
    """Sections about one axis that follow each other, from the mouth on, and what is at both ends."""

    sections: list[Section]
    axis: Point  # from the mouth into the material
    tips: dict[int, tuple[Surface, float]]  # cone at the mouth (0) and at the end (1), and how far it reaches
    is_open: list[bool]
    is_free: list[bool]  # whether no material is beyond the end

    def turned(self) -> "_Chain":
        """The chain from its other end on."""
        x, y, z = self.axis
        back = (-x + 0.0, -y + 0.0, -z + 0.0)
        tips = {1 - end: (cone, -far) for end, (cone, far) in self.tips.items()}
        return _Chain([s.along(back) for s in self.sections[::-1]], back, tips, self.is_open[::-1], self.is_free[::-1])


def _from_mouth(sections: list[Section], cones: list[Surface], axis: Point, verifier: DimensionVerifier) -> _Chain:
    """A chain from its wider open end; of two equal ones from that at the outside of a hollow part, or else from that
    towards the eye of the top, front or right view."""
    chain = _Chain(sections, axis, {}, [], [])
    on_axis = moved(sections[0].face.origin, axis, -dot(sections[0].face.origin, axis))
    for end, side, level in ((0, -1.0, sections[0].low), (1, 1.0, sections[-1].high)):
        for cone in cones:
            near, far = cone.extent(axis)[:: -1 if end == 0 else 1]
            if abs(near - level) < NEAR:
                chain.tips[end] = (cone, far)
        cone, far = chain.tips.get(end, (None, level))
        # The cone of a drill becomes narrower than the hole.
        narrow = cone is not None and min(map(cone.off_axis, cone.vertices)) < sections[-end].radius - NEAR
        is_open = not verifier.is_inside(moved(on_axis, axis, far + side * 0.02)) and not narrow
        chain.is_open.append(is_open and not verifier.has_floor(sections[-end].face, axis, far))
        # Beyond a slit the hole may go on with another diameter.
        across = next(unit for unit in AXES.values() if abs(dot(unit, axis)) < 0.9)
        beside = moved(on_axis, cross(axis, across), 0.9 * sections[-end].radius / math.hypot(*cross(axis, across)))
        chain.is_free.append(not verifier.is_covered(moved(beside, axis, level), scaled(axis, side)))
    upward = chain.is_free[1] if chain.is_free[0] != chain.is_free[1] else is_usual(axis)
    wider = sections[-1].radius - sections[0].radius
    turn = chain.is_open[1] and (not chain.is_open[0] or wider > NEAR or (wider > -NEAR and upward))
    return chain.turned() if turn else chain


def _holes_of(chain: _Chain, verifier: DimensionVerifier, grooves: list[Section]) -> Iterator[Hole]:
    """The hole of a chain as long as it does not become wider, and the one from its other end."""
    main, rest = chain.sections[:1], list[Section]()
    for number, section in enumerate(chain.sections[1:], start=1):
        narrower = [later for later in chain.sections[number + 1 :] if later.radius <= main[-1].radius + NEAR]
        if abs(section.radius - main[-1].radius) < NEAR:
            main[-1] = replace(main[-1], high=section.high)
        elif section.radius < main[-1].radius:
            main.append(section)
        elif narrower or not all(chain.is_open):
            grooves.append(section)
        else:
            rest = chain.sections[number:]
            break
    way_out = ""
    if all(chain.is_open):
        beyond = moved(
            main[0].face.origin, chain.axis, chain.sections[-1].high + 0.02 - dot(main[0].face.origin, chain.axis)
        )
        bores = (s for s in verifier.surfaces if s.kind == "CYLINDER" and not s.outward)
        to_bore = any(s.off_axis(beyond) < s.radius for s in bores if not s.is_coaxial(main[0].face))
        ends = chain.sections[-1].face
        bent = any(tube_of(s, [ends]) for s in verifier.surfaces if s.kind == "TORUS" and s.vertices)
        way_out = "through" if chain.is_free[1] or bent else "to bore" if to_bore else "one wall"
    yield _hole(main, chain, verifier, way_out)
    other = chain.turned()
    if rest or _sink(other)[0]:
        yield _hole(other.sections[: len(rest)] or other.sections, other, verifier, "" if rest else way_out)


def _sink(chain: _Chain) -> tuple[float, float]:
    """Diameter and whole angle, degrees, of the countersink at the mouth of a chain; 0 for a chamfer or taper."""
    cone = chain.tips[0][0] if 0 in chain.tips and chain.is_open[0] else None
    if cone is None:
        return (0.0, 0.0)
    wide, angle = max(map(cone.off_axis, cone.vertices)), 2 * math.degrees(math.atan(abs(cone.taper)))
    chamfer = wide <= WIDEST_CHAMFER * chain.sections[0].radius and abs(abs(cone.taper) - 1.0) < 1e-4
    return (0.0, 0.0) if chamfer or angle < NARROWEST_SINK else (2 * wide, angle)


def _hole(sections: list[Section], chain: _Chain, verifier: DimensionVerifier, way_out: str) -> Hole:
    """A hole of the sections at the mouth of a chain."""
    face, into, sink = sections[0].face, chain.axis, _sink(chain)
    on_axis = moved(face.origin, into, -dot(face.origin, into))
    start = chain.tips[0][1] if 0 in chain.tips else sections[0].low
    if along_of(into) is None:
        # Its mouth is an ellipse: it begins where the axis meets the face.
        corners = sorted(face.vertices, key=lambda vertex: dot(vertex, into))
        planes = [s for s in verifier.surfaces if s.kind == "PLANE" and any(map(s.holds, corners[:1]))]
        for plane in [s for s in planes if abs(dot(s.axis, into)) > 0.1][:1]:
            start = dot(subtract(plane.origin, on_axis), plane.axis) / dot(into, plane.axis)
        # Or a round face around an axis that it meets.
        rounds = [s for s in verifier.surfaces if s.kind == "CYLINDER" and s.outward and any(map(s.is_at, corners[:1]))]
        for shaft in [s for s in rounds if face.meets(s)][:1]:
            start = dot(subtract(shaft.origin, on_axis), into) - shaft.radius
    steps = tuple((s.radius, s.high - start) for s in sections)
    # The cone of a drill, and a countersink.
    cones = [cone for end, (cone, _) in chain.tips.items() if not chain.is_open[end] or (end == 0 and sink[0])]
    return Hole(moved(on_axis, into, start), into, steps, (*(s.face for s in sections), *cones), way_out, sink)


def tap_drill_of(drill: float) -> str:
    """Designation of the metric coarse thread with a tap drill, for a drill in inches of the unified one; or empty.

    Of the sizes of second choice (ISO 261) those alone whose drill is not in whole millimetres, as plain holes are.
    """
    inches, whole = abs(10 * drill - round(10 * drill)) > 1e-3, abs(drill - round(drill)) < 1e-3
    metric = [one for one in threads().values() if "coarse" in one.source and not (whole and "second" in one.source)]
    usual = (*metric, *(one for one in threads().values() if inches and one.name.startswith("unc")))
    return next((one.designation for one in usual if abs(one.tap_drill - drill) < (0.1 if inches else 0.01)), "")


FACE, AXIS, MOUTH = "face", "axis", "mouth"
"""Kinds of level: of a face, of the axis of a round feature, of the mouth of a slanting hole, seen in one view only."""


@dataclass(frozen=True)
class Level:
    """A coordinate that must be given: points of the part at which it can be measured, and equal features there."""

    at: float
    points: tuple[Point, ...]
    view: str = ""
    kind: str = FACE
    of: frozenset[str] = frozenset()
    seen: frozenset[tuple[str, Point]] = frozenset()  # views of several features there, with points of them
    side: float = 0.0  # normal along the axis of the plane faces there; 0 for other features
    about: str = ""  # kind of an axis (`drawings.dimensions.levels.axis_kind`)


def rows_of_equal_steps(rows: list[Level]) -> list[list[Level]]:
    """Rows of three or more equally spaced levels of equal features, the longest first."""
    found: list[list[Level]] = []
    for feature in sorted({one for row in rows for one in row.of}):
        equal = [row for row in rows if feature in row.of and not feature.endswith((" around", "concave"))]
        steps = [b.at - a.at for a, b in pairwise(equal)]
        if len(equal) > 2 and max(steps) - min(steps) < NEAR and equal not in found:
            found.append(equal)
    return sorted(found, key=lambda row: -len(row))


def rows_of_equal_faces(surfaces: Sequence[Surface]) -> dict[tuple[str, int], frozenset[str]]:
    """Names of rows of three or more plane faces that differ by their places along an axis only, by the name of the
    axis and the identity of the face."""
    found: dict[tuple[str, int], frozenset[str]] = defaultdict(frozenset)
    for number, name in enumerate(AXES):
        groups: dict[tuple[float, ...], list[Surface]] = defaultdict(list)
        for s in surfaces:
            if s.kind == "PLANE" and abs(s.axis[number]) > SQUARE:
                across = [value for n in range(3) if n != number for value in (s.low[n], s.high[n])]
                key = (*s.normal, *across, s.high[number] - s.low[number])
                groups[tuple(round(value, 2) + 0.0 for value in key)].append(s)
        for count, group in enumerate(group for group in groups.values() if len(group) > 2):
            found.update({(name, id(s)): frozenset((f"row {count}",)) for s in group})
    return found


def centre_of_circle(group: Sequence[Hole], shafts: Iterable[Section]) -> Point | None:
    """Centre of the circle on which equal holes are equally spaced, about the axis of another round feature."""
    count = len(group)
    if count < 2:
        return None
    centre: Point = tuple(sum(hole.mouth[n] for hole in group) / count for n in range(3))  # type: ignore[assignment]
    radii = [math.dist(hole.mouth, centre) for hole in group]
    if max(radii) - min(radii) > NEAR:
        return None
    gaps = sorted(math.dist(group[0].mouth, hole.mouth) for hole in group)
    expected = sorted(2 * radii[0] * math.sin(math.pi * number / count) for number in range(count))
    if max(abs(a - b) for a, b in zip(gaps, expected, strict=True)) > NEAR:
        return None
    corners = {tuple(round(hole.mouth[n] - centre[n], 2) for n in range(3)) for hole in group}
    # Two on an axis of the part are dimensioned by their distance.
    if count == 2 and sum(abs(a - b) > NEAR for a, b in zip(group[0].mouth, group[1].mouth, strict=True)) < 2:
        return None
    square = count in (2, 4) and all(len({abs(corner[n]) for corner in corners}) == 1 for n in range(3))
    axis_key = group[0].faces[0].axis_key
    # Corners of a rectangle are dimensioned as such, except within a round outline, or if only the diameter of the
    # circle is in tenths.
    around = any(
        one.face.off_axis(centre) < NEAR and one.face.axis_key[3:] == axis_key[3:] and one.radius > max(radii)
        for one in shafts
    )
    tenths = [*map(is_usual_size, (2 * radii[0], gaps[1]))]
    return centre if around or not square or tenths == [True, False] else None
