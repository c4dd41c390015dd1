"""Faces whose shape no dimensions give but the model: free-form ones, and outlines of marks such as engraved text.

A mark is a row of small flat recesses or raised areas of one depth on a plane face, at least one of them slender and
with a free-form wall.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.dimensions.levels import AXES, NEAR, SIMPLE, along_of, touch
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier

SLENDER = 30.0
"""Square of the outline of an area over the area from which on it is made of strokes: a rectangle of 5 to 1 has 29."""
FREE, OUTLINE_OF_MARK = "free-form face, by the model", "outline of a mark, by the model"


@dataclass(frozen=True)
class Mark:
    """Areas of a mark and the walls that end at them; the level of the areas along the axis, and of their mouths."""

    axis: str
    areas: tuple[Surface, ...]
    walls: tuple[Surface, ...]
    level: float
    mouth: float

    @property
    def is_recess(self) -> bool:
        return self.areas[0].normal[list(AXES).index(self.axis)] * (self.mouth - self.level) > 0


def marks_of(verifier: DimensionVerifier) -> tuple[Mark, ...]:
    """Marks of a solid."""
    return verifier.kept("marks", lambda: tuple(_marks(verifier)))


def by_model(surface: Surface, verifier: DimensionVerifier) -> str:
    """What a face is of which the model gives the shape; empty for any other."""
    walls = verifier.kept("walls of marks", lambda: {id(wall) for mark in marks_of(verifier) for wall in mark.walls})
    return OUTLINE_OF_MARK if id(surface) in walls else FREE if surface.kind not in SIMPLE else ""


def _marks(verifier: DimensionVerifier) -> Iterator[Mark]:
    """Rows of islands that begin with a slender one."""
    islands = [one for s in verifier.surfaces if s.kind == "PLANE" and (one := _island(s, verifier.surfaces))]
    while first := next(filter(_is_stroke, islands), None):
        row = [first]
        for one in row:
            row += [other for other in islands if other not in row and _is_in_row(one, other)]
        islands = [one for one in islands if one not in row]
        areas, walls = tuple(one.areas[0] for one in row), {id(wall): wall for one in row for wall in one.walls}
        yield Mark(first.axis, areas, tuple(walls.values()), first.level, first.mouth)


def _island(area: Surface, surfaces: Sequence[Surface]) -> Mark | None:
    """A plane area with walls square to it all around, from it to one level within the part."""
    axis = along_of(area.axis)
    if axis is None:
        return None
    number = list(AXES).index(axis)
    level = area.origin[number]
    corners = {tuple(round(a, 3) for a in corner) for corner in area.vertices}
    beside = [s for s in surfaces if s is not area and touch(s, area)]
    walls = [s for s in beside if any(tuple(round(a, 3) for a in corner) in corners for corner in s.vertices)]
    ends = {round(s.high[number] + s.low[number] - level, 2) for s in walls}
    if len(ends) != 1 or not all(_is_square(s, AXES[axis]) for s in walls) or len(corners) < 2:
        return None
    (mouth,) = ends
    low, high = (pick(end[number] for s in surfaces for end in (s.low, s.high)) for pick in (min, max))
    through = abs(abs(mouth - level) - (high - low)) < NEAR
    return None if through else Mark(axis, (area,), tuple(walls), level, mouth)


def _is_square(wall: Surface, axis: Point) -> bool:
    """Whether a face is along an axis everywhere."""
    if wall.kind in ("PLANE", "CYLINDER"):
        return abs(abs(dot(wall.axis, axis)) - (wall.kind == "CYLINDER")) < NEAR
    normals = (wall.face.normalAt(edge.positionAt(0.5)).toTuple() for edge in wall.face.Edges())  # pyright: ignore
    return all(abs(dot(normal, axis)) < NEAR for normal in normals)


def _is_stroke(island: Mark) -> bool:
    """Whether an area is slender, and a wall of it free-form."""
    face = island.areas[0].face
    length = sum(edge.Length() for edge in face.Edges())
    return length**2 / face.Area() > SLENDER and any(s.kind not in SIMPLE for s in island.walls)


def _is_in_row(one: Mark, other: Mark) -> bool:
    """Whether areas at one level are nearer to each other than the larger one is long, and this at most twice the
    other."""
    if one.axis != other.axis or math.dist((one.level, one.mouth), (other.level, other.mouth)) > NEAR:
        return False
    (low, high), (start, end) = ((s.low, s.high) for s in (one.areas[0], other.areas[0]))
    size = math.dist(low, high)
    gap = math.hypot(*(max(a - d, c - b, 0.0) for a, b, c, d in zip(low, high, start, end, strict=True)))
    return gap < size and math.dist(start, end) < 2 * size
