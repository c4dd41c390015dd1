"""Sections of holes and shafts: round faces of one radius and axis that follow each other along it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from drawings.dimensions.levels import NEAR, WHOLE
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.surface import Surface


@dataclass(frozen=True)
class Section:
    """Part of a hole or shaft with one radius, from one distance along an axis to another."""

    radius: float
    low: float
    high: float
    axis: Point = field(compare=False)
    faces: tuple[Surface, ...] = field(compare=False)

    @property
    def face(self) -> Surface:
        return self.faces[0]

    @property
    def whole(self) -> bool:
        """Whether it goes around its axis, on the mean of its length."""
        spans = (face.span * (high - low) for face in self.faces for low, high in [face.extent(self.axis)])
        return sum(spans) > WHOLE * (self.high - self.low)

    def along(self, axis: Point) -> "Section":
        """The section with its ends along an axis that may be opposite to its own."""
        opposite = dot(self.axis, axis) <= 0
        return Section(self.radius, -self.high, -self.low, axis, self.faces) if opposite else self


def sections_of(faces: Iterable[Surface]) -> Iterator[Section]:
    """Faces of one radius and axis, all of shafts or all of holes, that follow each other without a gap, as one section
    each."""
    rows: dict[tuple[object, ...], list[Surface]] = {}
    for face in faces:
        rows.setdefault((*face.axis_key, round(face.radius, 3), face.outward), []).append(face)
    for row in rows.values():
        axis = row[0].axis
        spans = sorted(((*face.extent(axis), n, face) for n, face in enumerate(row)), key=lambda span: span[:3])
        low, high, _, first = spans[0]
        faces = [first]
        for start, end, _, face in spans[1:]:
            if start > high + NEAR:
                yield Section(first.radius, low, high, axis, tuple(faces))
                low, high, faces = start, end, list[Surface]()
            high = max(high, end)
            faces.append(face)
        yield Section(first.radius, low, high, axis, tuple(faces))
