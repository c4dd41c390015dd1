"""Sections of holes and shafts: round faces of one radius and axis that follow each other along it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from drawings.dimensions.levels import AXES, NEAR, along_of
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import Surface


@dataclass(frozen=True)
class Section:
    """Part of a hole or shaft with one radius, from one distance along its axis to another."""

    radius: float
    low: float
    high: float
    faces: tuple[Surface, ...] = field(compare=False)

    @property
    def face(self) -> Surface:
        return self.faces[0]


def sections_of(faces: Iterable[Surface]) -> Iterator[Section]:
    """Faces of one radius and axis, all of shafts or all of holes, that follow each other without a gap, as one section
    each."""
    rows: dict[tuple[object, ...], list[Surface]] = {}
    for face in faces:
        rows.setdefault((*face.axis_key, round(face.radius, 3), face.outward), []).append(face)
    for row in rows.values():
        axis = row[0].axis
        spans = sorted(((*extent(face, axis), n, face) for n, face in enumerate(row)), key=lambda span: span[:3])
        low, high, _, first = spans[0]
        faces = [first]
        for start, end, _, face in spans[1:]:
            if start > high + NEAR:
                yield Section(first.radius, low, high, tuple(faces))
                low, high, faces = start, end, list[Surface]()
            high = max(high, end)
            faces.append(face)
        yield Section(first.radius, low, high, tuple(faces))


def extent(face: Surface, axis: Point) -> tuple[float, float]:
    """Ends of a round face along its axis; of crossing bores by its box, as vertices are not at the ends."""
    low, high = face.extent(axis) if face.vertices else (0.0, 0.0)
    name = along_of(axis)
    if name is not None:
        number = list(AXES).index(name)
        sign = 1.0 if axis[number] > 0 else -1.0
        ends = sorted((sign * face.low[number], sign * face.high[number]))
        return min(low, ends[0]) if face.vertices else ends[0], max(high, ends[1]) if face.vertices else ends[1]
    return low, high
