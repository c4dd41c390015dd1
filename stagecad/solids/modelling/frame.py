"""Rigid transformations, vectors, and the mating of two datums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stagecad.parameters.dimension import Datum

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
Box = tuple[Vector, Vector]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """Rigid transformation from a part's coordinates to the assembly's: x -> rotation x + shift.

    Attributes:
        rotation: three rows of three.
        shift: mm.
    """

    rotation: Matrix = IDENTITY
    shift: Vector = (0.0, 0.0, 0.0)

    def point(self, place: Vector) -> Vector:
        """A point of the part in coordinates of the assembly, mm."""
        return add(self.direction(place), self.shift)

    def direction(self, along: Vector) -> Vector:
        """A direction of the part in coordinates of the assembly."""
        return _triple([dot(row, along) for row in self.rotation])

    def shifted(self, by: Vector) -> Frame:
        """The transformation followed by a translation `by` in the assembly, mm."""
        return Frame(self.rotation, add(self.shift, by))


UNMOVED = Frame()


def mate(child: Datum, frame: Frame, parent: Datum) -> Frame:
    """Frame of the child's part such that origins coincide, normals are opposed and x directions are parallel."""
    own = (child.x_direction, cross(child.normal, child.x_direction), child.normal)
    x = frame.direction(parent.x_direction)
    normal = scaled(frame.direction(parent.normal), -1.0)
    there = (x, cross(normal, x), normal)
    # Sum over the three axes of (axis there) (axis of the part)^T.
    rotation = _rows([[_tidy(sum(there[k][i] * own[k][j] for k in range(3))) for j in range(3)] for i in range(3)])
    turned = Frame(rotation).direction(child.origin)
    return Frame(rotation, subtract(frame.point(parent.origin), turned))


def near(one: Box, two: Box, gap: float) -> bool:
    """Whether two boxes are closer than a gap, mm, along every axis."""
    return all(one[0][axis] - gap <= two[1][axis] and two[0][axis] - gap <= one[1][axis] for axis in range(3))


def transformed_box(frame: Frame, box: Box) -> Box:
    """Axis-parallel box that encloses the transformed `box` (lowest and highest corner)."""
    (x0, y0, z0), (x1, y1, z1) = box
    points = [frame.point((x, y, z)) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    low, high = ([function(point[axis] for point in points) for axis in range(3)] for function in (min, max))
    return _triple(low), _triple(high)


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a: Vector, by: float) -> Vector:
    return (a[0] * by, a[1] * by, a[2] * by)


def _tidy(value: float) -> float:
    # Exact zeros and ones, so that mated faces coincide exactly.
    return float(round(value)) if abs(value - round(value)) < 1e-12 else value


def _triple(values: list[float]) -> Vector:
    return (values[0], values[1], values[2])


def _rows(values: list[list[float]]) -> Matrix:
    return (_triple(values[0]), _triple(values[1]), _triple(values[2]))
