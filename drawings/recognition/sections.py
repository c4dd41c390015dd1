"""The section that the front view is drawn as, where it shows what hidden lines and a straight section do not.

Blind and stepped holes, and bores on the axis of a turned part, need a section to be seen. Of the sections that show
most kinds of them the simplest is taken: a straight one; a half one of a turned part with features outside and inside;
an aligned one through holes around its axis; an offset one through holes on parallel planes (ISO 128-3).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise, product

from drawings.dimensions.levels import AXES, NEAR, along_of, is_mirrored
from drawings.dimensions.round_sections import Section
from drawings.recognition.features import Features, Hole
from drawings.recognition.visible import tidy
from drawings.views.view import PROJECTIONS, Cut, dot, section_cut
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import DimensionVerifier

FRONT = PROJECTIONS["front"]
MOST = 500
"""Choices of one hole of each kind that are tried."""


@dataclass(frozen=True)
class Inside:
    """What a section in the place of the front view has to show."""

    verifier: DimensionVerifier
    features: Features
    middle: bool  # whether a distance is declared in the middle plane

    @property
    def holes(self) -> list[Hole]:
        """Holes whose axis is parallel to the paper."""
        return [hole for hole in self.features.holes if abs(hole.into[1]) < NEAR]

    @property
    def deep(self) -> list[Hole]:
        """Those that need a section: blind and stepped ones, and bores on the axis of a round outline."""
        turned = {shaft.face.axis_key for shaft in self.features.shafts}
        return [h for h in self.holes if not h.through or len(h.steps) > 1 or h.faces[0].axis_key in turned]

    @property
    def facing(self) -> bool:
        """Whether there are holes in the front or back of the part."""
        return any(abs(hole.into[1]) > NEAR for hole in self.features.holes)

    @property
    def axis(self) -> Section | None:
        """The shaft about whose axis through the origin a part is turned."""
        shaft = max(self.features.shafts, key=lambda one: one.radius, default=None)
        name = along_of(shaft.axis) if shaft else None
        if shaft is None or name not in ("x", "z") or shaft.face.off_axis((0.0, 0.0, 0.0)) > NEAR:
            return None
        low, high = self.verifier.box
        sides = (abs(end[n]) for end in (low, high) for n in range(3) if n != "xyz".index(name))
        return shaft if shaft.whole and max(sides) < shaft.radius + NEAR else None


def sections(inside: Inside) -> Iterator[Cut]:
    """Sections in the place of the front view, the best one first."""
    surfaces, shaft = inside.verifier.surfaces, inside.axis
    mirrored = is_mirrored(surfaces, 1, 0.0)
    in_middle = [h for h in inside.deep if abs(h.mouth[1]) < NEAR]
    long = any(abs(one.face.axis[0]) > 0.5 and not inside.deep for one in inside.features.shafts)
    on_axis = [h for h in in_middle if shaft and h.faces[0].is_coaxial(shaft.face)]
    if shaft and on_axis and (inside.facing or not mirrored):
        number = "zyx".index(along_of(shaft.axis) or "z")
        if is_mirrored(surfaces, number, 0.0):
            yield section_cut("front", ((0.0, 0.0, 0.0), tuple(AXES.values())[number]), "", "half")
    if inside.facing or long:
        return
    straight = (inside.middle or bool(in_middle)) and mirrored
    shown = {hole.kind for hole in inside.holes if abs(hole.mouth[1]) < NEAR}
    if shaft and abs(shaft.axis[2]) > 0.5 and mirrored and in_middle:
        yield from _aligned(inside.holes, shown)
    deep = {hole.kind for hole in inside.deep}
    if not deep <= shown and len(deep) > 1:
        yield from _offset(inside.deep)
    if straight:
        yield section_cut("front", ((0.0, 0.0, 0.0),), "", "offset")


def _aligned(holes: Sequence[Hole], straight: set[tuple[object, ...]]) -> Iterator[Cut]:
    """Planes through the axis: to the left of it that of the paper, to the right one through a hole at an angle."""
    upright = [hole for hole in holes if abs(hole.into[2]) > 0.5]
    left = {h.kind for h in upright if abs(h.mouth[1]) < NEAR and h.mouth[0] < NEAR}
    found: list[tuple[int, float, Hole]] = []
    for hole in (h for h in upright if h.mouth[0] > NEAR and abs(h.mouth[1]) > NEAR):
        u, v = (a / math.hypot(*hole.mouth[:2]) for a in hole.mouth[:2])
        on = {h.kind for h in upright if abs(u * h.mouth[1] - v * h.mouth[0]) < NEAR and h.mouth[0] > NEAR}
        found.append((-len(on | left), abs(math.atan2(v, u)), hole))
    most, _, hole = min(found, key=lambda one: one[:2], default=(0, 0.0, None))
    if hole and -most > len(straight):
        x, y, _ = tidy(hole.mouth)
        # Beyond 45 degrees the planes would be taken for those of a section from the side.
        if abs(x) >= abs(y):
            yield section_cut("front", ((0.0, 0.0, 0.0), (x, y, 0.0)), "", "aligned")


def _offset(deep: Sequence[Hole]) -> Iterator[Cut]:
    """Parallel planes through one hole of each kind, of which the fewest are needed."""
    for into, way in ((AXES["z"], AXES["x"]), (AXES["x"], AXES["z"])):
        kinds: dict[tuple[object, ...], list[Hole]] = {}
        for hole in deep:
            kinds.setdefault(hole.kind, []).append(hole)
        if not all(abs(dot(hole.into, into)) > 0.5 for hole in deep):
            continue
        found: list[tuple[int, list[Point]]] = []
        for chosen in islice(product(*kinds.values()), MOST):
            row = sorted(chosen, key=lambda hole: dot(hole.mouth, way))
            legs: list[list[Hole]] = []
            for hole in row:
                same = legs and abs(hole.mouth[1] - legs[-1][0].mouth[1]) < NEAR
                legs = [*legs[:-1], [*legs[-1], hole]] if same else [*legs, [hole]]
            points = [_middle(leg, way) for leg in legs]
            changes = [(dot(a, way) + dot(b, way)) / 2 for a, b in pairwise(points)]
            radii = [(dot(hole.mouth, way), max(radius for radius, _ in hole.steps)) for hole in row]
            if all(abs(change - at) > radius + NEAR for change in changes for at, radius in radii) and all(
                dot(one[-1].mouth, way) < change < dot(other[0].mouth, way)
                for (one, other), change in zip(pairwise(legs), changes, strict=True)
            ):
                found.append((len(points), points))
        if found:
            yield section_cut("front", min(found, key=lambda one: one[0])[1], "", "offset")


def _middle(leg: Sequence[Hole], way: Point) -> Point:
    """The point half-way between the first and the last hole of a plane."""
    at = (dot(leg[0].mouth, way) + dot(leg[-1].mouth, way)) / 2
    return tidy((at * way[0], leg[0].mouth[1], at * way[2]))
