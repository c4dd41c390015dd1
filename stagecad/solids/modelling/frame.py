"""Rigid transformations, vectors, the mating of two datums, and shapes placed by them."""

from __future__ import annotations

from dataclasses import dataclass

from stagecad.parameters.dimension import Datum

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
Box = tuple[Vector, Vector]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """Rigid transformation from a part's coordinates to the assembly's: x -> rotation x + shift."""

    rotation: Matrix = IDENTITY  # three rows of three
    shift: Vector = (0.0, 0.0, 0.0)  # mm

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


Colour = tuple[float, float, float]

BY_MATERIAL: dict[str, Colour] = {
    "al6061": (0.74, 0.77, 0.80),
    "invar": (0.62, 0.62, 0.66),
    "sus416": (0.58, 0.60, 0.64),
    "sic": (0.27, 0.31, 0.37),
    "ptfe": (0.93, 0.92, 0.86),
    "steel": (0.40, 0.42, 0.45),
    "alloysteel": (0.30, 0.31, 0.34),
    "alumina": (0.90, 0.89, 0.85),
    "iron": (0.58, 0.48, 0.42),
    "ndfeb": (0.62, 0.22, 0.20),
    "pzt": (0.85, 0.68, 0.30),
}
"""Display colours (sRGB, 0 to 1) by the first letters of a material's name in the parameter file."""

OTHER: Colour = (0.60, 0.62, 0.60)


def colour_of(material: str) -> Colour:
    """Colour of `material` (its name in the parameter file): of the longest entry that its name begins with."""
    plain = material.lower().replace("-", "").replace("_", "")
    known = sorted((name for name in BY_MATERIAL if plain.startswith(name)), key=len)
    return BY_MATERIAL[known[-1]] if known else OTHER


@dataclass(frozen=True)
class PlacedShape:
    """A shape in an assembly."""

    name: str  # of this instance
    part: str  # name of the shape; equal to `name` for a single part
    colour: Colour  # sRGB, 0 to 1
    frame: Frame = UNMOVED  # position in the assembly
