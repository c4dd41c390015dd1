"""Rings of equal holes around a shaft or tube, towards its axis."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.dimensions.levels import NEAR, along_of
from drawings.dimensions.round_sections import Section
from drawings.recognition.features import Hole
from drawings.recognition.visible import tidy
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import cross, subtract
from stagecad.solids.modelling.verification import moved


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
