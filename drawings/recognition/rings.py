"""Equal features around an axis: holes towards it, slots, flats and grooves; thin webs between round notches."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Generic, TypeVar

from drawings.dimensions.levels import NEAR, SQUARE, along_of
from drawings.dimensions.round_sections import Section
from drawings.recognition.features import Hole, middle_of_face
from drawings.recognition.visible import tidy
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, features_of_faces, is_beside, moved, rejection, turned
from stagecad.solids.modelling.verification import DimensionVerifier

T = TypeVar("T")


@dataclass(frozen=True)
class Ring(Generic[T]):
    """Equal holes, or features of faces, at equal angles around an axis; distances place the first one."""

    features: tuple[T, ...]
    centre: Point
    start: Point  # unit vector from the centre towards the first feature
    neighbour: Point  # point of the next one


def rings_around(holes: Sequence[Hole], shafts: Sequence[Section]) -> Iterator[Ring[Hole]]:
    """Rings of three or more holes, not all along axes of the part, towards the axis of the largest shaft."""
    shaft = max(shafts, key=lambda one: one.radius, default=None)
    if shaft is None:
        return
    groups: dict[tuple[object, ...], list[Hole]] = defaultdict(list)
    for hole in holes:
        # Blind ones end at one distance from the axis.
        end = 0.0 if hole.through else shaft.face.off_axis(moved(hole.mouth, hole.into, hole.steps[-1][1]))
        if hole.faces[0].meets(shaft.face):
            level = round(dot(hole.mouth, shaft.axis), 3)
            groups[level, tuple(round(radius, 3) for radius, _ in hole.steps), round(end, 2), hole.way_out].append(hole)
    for group in groups.values():
        middles = [moved(hole.mouth, hole.into, 0.5 * hole.steps[-1][1]) for hole in group]
        outs = [rejection(subtract(middle, shaft.face.origin), shaft.axis) for middle in middles]
        along = [number for number, hole in enumerate(group) if along_of(hole.into)]
        if 0 < len(along) < len(group):
            first = along[0]
            yield from _in_turn(group, outs, first, (subtract(middles[first], outs[first]), outs[first]), shaft.axis)


def _in_turn(
    group: Sequence[T], outs: Sequence[Point], first: int, out: tuple[Point, Point], axis: Point
) -> Iterator[Ring[T]]:
    """The ring of three or more features, if they are at equal angles; `outs` are from the axis to the features, `out`
    is a point of the axis and the vector from it to one of the first one."""
    start, turn = outs[first], math.tau / len(group)
    angles = [math.atan2(dot(one, cross(axis, start)), dot(one, start)) / turn for one in outs]
    near = [round(angle) % len(group) for angle in angles]
    if len(group) > 2 and sorted(near) == [*range(len(group))] and max(abs(a - round(a)) for a in angles) < NEAR:
        centre, to = out
        others = (one for number, one in enumerate(group) if number != first)
        unit, neighbour = scaled(to, 1 / math.hypot(*to)), add(centre, turned(to, axis, turn))
        yield Ring((group[first], *others), tidy(centre), tidy(unit), tidy(neighbour))


def features_around(
    surfaces: Sequence[Surface], shaft: Section, taken: set[int]
) -> Iterator[Ring[tuple[Surface, ...]]]:
    """Three or more equal features around the axis of a shaft, of faces not taken."""
    origin, axis = shaft.face.origin, shaft.axis
    beside = [s for s in surfaces if id(s) not in taken and is_beside(s, origin, axis) and s.vertices]
    groups: dict[tuple[object, ...], list[tuple[Surface, ...]]] = defaultdict(list)
    for feature in (part for whole in features_of_faces(beside) for part in _periods(whole, origin, axis)):
        places = ((shaft.face.off_axis(s.centre), dot(s.centre, axis), s.area) for s in feature)
        groups[len(feature), *sorted(tuple(round(a, 2) for a in place) for place in places)].append(feature)
    for group in groups.values():
        outs = [_out(feature, origin, axis) for feature in group]
        rows = [[at for s in one for at in (middle_of_face(s), *s.vertices) if s.holds(tidy(at))] for one in group]
        ends = [[(at, rejection(subtract(at, origin), axis)) for at in row] for row in rows]
        # The first is along an axis of the part, or has a corner there.
        known = [(number, out) for number, out in enumerate(outs) if _along(out)]
        flats = len(known) == len(group) and len(group[0]) == 1  # which have their distance
        known += [(number, out) for number, row in enumerate(ends) for _, out in row if _along(out)]
        if known and not flats and min(math.hypot(*out) for out in outs) > 0.1:
            first, start = known[0]
            on, out = max(ends[first], key=lambda end: round(dot(end[1], start) / math.hypot(*end[1]), 6))
            yield from _in_turn(group, outs, first, (subtract(on, out), out), axis)


def _along(out: Point) -> bool:
    return along_of(scaled(out, 1 / max(math.hypot(*out), 1e-9))) is not None


def _periods(feature: list[Surface], origin: Point, axis: Point) -> Iterator[tuple[Surface, ...]]:
    """A feature, or the equal parts of one that goes around an axis, as the teeth of a ratchet."""
    out = rejection(subtract(feature[0].centre, origin), axis)

    def angle(surface: Surface) -> float:
        to = subtract(surface.centre, origin)
        return round(math.atan2(dot(to, cross(axis, out)), dot(to, out)) % math.tau, 6) % round(math.tau, 6)

    row = sorted(feature, key=angle)
    around = math.hypot(*_out(feature, origin, axis)) < NEAR
    for count in range(len(row) // 2, 2, -1) if around else ():
        size, rest = divmod(len(row), count)
        images = (add(origin, turned(subtract(s.centre, origin), axis, math.tau / count)) for s in row)
        if not rest and all(math.dist(at, s.centre) < NEAR for at, s in zip(images, row[size:])):
            yield from (tuple(row[number : number + size]) for number in range(0, len(row), size))
            return
    yield tuple(feature)


def _out(feature: Sequence[Surface], origin: Point, axis: Point) -> Point:
    """Vector from an axis to the centre of area of a feature."""
    x, y, z = (sum(s.area * s.centre[n] for s in feature) / sum(s.area for s in feature) for n in range(3))
    return rejection(subtract((x, y, z), origin), axis)


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
