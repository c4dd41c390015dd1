"""Equal features around an axis: holes towards it, slots, flats and grooves; thin webs between round notches."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from drawings.dimensions.levels import NEAR, SQUARE, along_of
from drawings.dimensions.round_sections import Section
from drawings.recognition.features import Hole, middle_of_face
from drawings.recognition.visible import tidy
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, features_of_faces, is_beside, moved, turned
from stagecad.solids.modelling.verification import DimensionVerifier


@dataclass(frozen=True)
class Ring:
    """Equal holes towards one axis at equal angles, one of them, the first, along an axis of the part."""

    holes: tuple[Hole, ...]
    centre: Point  # where their axes meet
    start: Point  # unit vector from the centre towards the first hole
    neighbour: Point  # point on the axis of the next hole


def rings_around(holes: Sequence[Hole], shafts: Sequence[Section]) -> Iterator[Ring]:
    """Rings of three or more holes, not all along axes of the part, towards the axis of the largest shaft."""
    shaft = max(shafts, key=lambda one: one.radius, default=None)
    if shaft is None:
        return
    groups: dict[tuple[object, ...], list[Hole]] = defaultdict(list)
    for hole in holes:
        level = dot(hole.mouth, shaft.axis)
        centre = moved(shaft.face.origin, shaft.axis, level - dot(shaft.face.origin, shaft.axis))
        meets = hole.faces[0].off_axis(centre) < NEAR and abs(dot(hole.into, shaft.axis)) < NEAR
        # Blind ones end at one distance from the axis.
        end = 0.0 if hole.through else shaft.face.off_axis(moved(hole.mouth, hole.into, hole.steps[-1][1]))
        if meets:
            key = (round(level, 3), tuple(round(radius, 3) for radius, _ in hole.steps), round(end, 2), hole.way_out)
            groups[key].append(hole)
    for group in groups.values():
        first = next((hole for hole in group if along_of(hole.into)), None)
        if first is None or len(group) < 3 or all(along_of(hole.into) for hole in group):
            continue
        level = dot(first.mouth, shaft.axis)
        centre = tidy(moved(shaft.face.origin, shaft.axis, level - dot(shaft.face.origin, shaft.axis)))
        ways = [tidy(subtract(_middle(hole), centre)) for hole in group]
        start = towards(centre, _middle(first))
        side, turn = cross(shaft.axis, start), math.tau / len(group)
        angles = [math.atan2(dot(way, side), dot(way, start)) / turn for way in ways]
        numbers = {round(angle) % len(group): hole for angle, hole in zip(angles, group, strict=True)}
        if len(numbers) == len(group) and max(abs(angle - round(angle)) for angle in angles) < NEAR:
            others = (hole for hole in group if hole is not first)
            yield Ring((first, *others), centre, tidy(start), tidy(_middle(numbers[1])))


def _middle(hole: Hole) -> Point:
    return moved(hole.mouth, hole.into, 0.5 * hole.steps[-1][1])


@dataclass(frozen=True)
class Around:
    """Equal features at equal angles around an axis; the first is along an axis of the part."""

    features: tuple[tuple[Surface, ...], ...]
    centre: Point
    start: Point  # unit vector from the centre towards the first feature
    neighbour: Point  # point of a face of the next one


def features_around(surfaces: Sequence[Surface], shaft: Section, taken: set[int]) -> Iterator[Around]:
    """Three or more equal features around the axis of a shaft, of faces not taken."""
    origin, axis = shaft.face.origin, shaft.axis
    beside = [s for s in surfaces if id(s) not in taken and is_beside(s, origin, axis) and s.vertices]
    groups: dict[tuple[object, ...], list[list[Surface]]] = defaultdict(list)
    for group in features_of_faces(beside):
        places = ((shaft.face.off_axis(s.centre), dot(s.centre, axis), s.area) for s in group)
        groups[len(group), *sorted(tuple(round(a, 2) for a in place) for place in places)].append(group)
    for group in groups.values():
        ways = [_way(feature, origin, axis) for feature in group]
        first = next((number for number, way in enumerate(ways) if way and along_of(way)), None)
        # Flats along axes of the part have their distance.
        flats = all(along_of(way or axis) for way in ways) and len(group[0]) == 1
        if first is None or len(group) < 3 or not all(ways) or flats:
            continue
        start, turn = tidy(ways[first] or axis), math.tau / len(group)
        angles = [math.atan2(dot(way or axis, cross(axis, start)), dot(way or axis, start)) / turn for way in ways]
        near = [round(angle) % len(group) for angle in angles]
        if sorted(near) != [*range(len(group))] or max(abs(angle - round(angle)) for angle in angles) > NEAR:
            continue
        feature = group[first]
        ends = [point for s in feature for point in (middle_of_face(s), *s.vertices) if s.holds(tidy(point))]
        outward = [subtract(point, moved(origin, axis, dot(subtract(point, origin), axis))) for point in ends]
        pairs = zip(ends, outward, strict=True)
        on, out = max(pairs, key=lambda end: round(dot(end[1], start) / math.hypot(*end[1]), 6))
        centre, others = subtract(on, out), (tuple(one) for number, one in enumerate(group) if number != first)
        neighbour = tidy(add(centre, turned(out, axis, turn)))
        yield Around((tuple(feature), *others), tidy(centre), tidy(scaled(out, 1 / math.hypot(*out))), neighbour)


def _way(feature: Sequence[Surface], origin: Point, axis: Point) -> Point | None:
    """Direction from an axis to the middle of a feature; None for one about the axis."""
    whole = sum(s.area for s in feature)
    to = subtract(tuple(sum(s.area * s.centre[n] for s in feature) / whole for n in range(3)), origin)  # type: ignore[arg-type]
    out = subtract(to, scaled(axis, dot(to, axis)))
    return scaled(out, 1 / math.hypot(*out)) if math.hypot(*out) > 0.1 else None


def webs(verifier: DimensionVerifier) -> Iterator[tuple[Point, Point, Surface]]:
    """Ends of the least thickness of webs along an axis of the part, and one of the two notches that form each.

    A web thinner than the radius of its notches is a hinge (Paros, Weisbord, Machine Design 37 (1965) 151), whose
    stiffness follows from its thickness; between closed bores the distance of the axes is functional.
    """
    rounds = [s for s in verifier.surfaces if s.kind == "CYLINDER" and not s.outward]
    closed = {s.axis_key for s in rounds if sum(o.span for o in rounds if o.is_coaxial(s)) > math.tau - SQUARE}
    for one, other in combinations((s for s in rounds if s.axis_key not in closed), 2):
        low, high = (pick(ends) for pick, ends in zip((max, min), zip(one.extent(one.axis), other.extent(one.axis))))
        foot = moved(one.origin, one.axis, (low + high) / 2 - dot(one.origin, one.axis))
        step = subtract(other.origin, one.origin)
        step = subtract(step, scaled(one.axis, dot(step, one.axis)))
        apart = math.hypot(*step)
        gap = apart - one.radius - other.radius
        if low > high or not NEAR < gap < min(one.radius, other.radius) or along_of(scaled(step, 1 / apart)) is None:
            continue
        way = tidy(scaled(step, 1 / apart))
        near, far = (tidy(moved(foot, way, one.radius + by)) for by in (0.0, gap))
        if verifier.is_inside(scaled(add(near, far), 0.5)) and one.holds(near) and other.holds(far):
            yield (near, far, one)
