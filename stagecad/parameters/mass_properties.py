"""Mass properties in SI, passed from the geometry to checks and simulation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from stagecad.parameters.errors import InputError

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class MassProperties:
    """Mass properties of a part, or of several parts together."""

    volume: float  # m^3
    mass: float  # kg
    # m
    centre_of_mass: Any  # (3,)
    # tensor about the centre of mass, kg*m^2; products of inertia with their minus sign
    inertia: Any  # (3, 3)
    # lowest and highest corner, m
    bounding_box: Any  # (2, 3)

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_of_mass", tuple(float(value) for value in self.centre_of_mass))
        object.__setattr__(self, "inertia", tuple(tuple(float(value) for value in row) for row in self.inertia))
        object.__setattr__(self, "bounding_box", tuple(tuple(float(v) for v in row) for row in self.bounding_box))
        shape = len(self.centre_of_mass), [len(row) for row in self.inertia], [len(row) for row in self.bounding_box]
        if shape != (3, [3, 3, 3], [3, 3]):
            raise ValueError("mass properties need centre (3,), inertia (3, 3) and bounding box (2, 3)")

    def moved(self, shift: Vector) -> MassProperties:
        """The same body displaced by `shift`, m."""
        centre = tuple(a + b for a, b in zip(self.centre_of_mass, shift))
        box = tuple(tuple(a + b for a, b in zip(corner, shift)) for corner in self.bounding_box)
        return MassProperties(self.volume, self.mass, centre, self.inertia, box)

    def inertia_about(self, point: Vector) -> Matrix:
        """Inertia tensor about another point, kg*m^2: I = I_c + m (d^2 1 - d d^T), d from the centre to the point."""
        d = tuple(a - b for a, b in zip(point, self.centre_of_mass))
        square = sum(value * value for value in d)
        rows = tuple(
            tuple(self.inertia[i][j] + self.mass * ((square if i == j else 0.0) - d[i] * d[j]) for j in range(3))
            for i in range(3)
        )
        return rows  # type: ignore[return-value]

    def as_json(self) -> dict[str, Any]:
        """The entry in the document of `stagecad parts`: every number a quantity in SI."""
        return {
            "volume": {"value": self.volume, "unit": "m^3"},
            "mass": {"value": self.mass, "unit": "kg"},
            "centre_of_mass": {"value": list(self.centre_of_mass), "unit": "m"},
            "inertia": {"value": [list(row) for row in self.inertia], "unit": "kg*m^2"},
            "bounding_box": {"value": [list(row) for row in self.bounding_box], "unit": "m"},
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> MassProperties:
        """Read what `as_json` wrote."""
        try:
            fields = ("volume", "mass", "centre_of_mass", "inertia", "bounding_box")
            return cls(*(document[name]["value"] for name in fields))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"mass properties: {error} is missing or not a quantity") from None


@dataclass(frozen=True)
class BodyMasses:
    """Mass properties of the moving bodies, computed from their solids."""

    moving: MassProperties  # stage, irons and magnets, in the assembly's coordinates at mid-travel
    tip: MassProperties  # one tip, in its own coordinates (the piezos' ends at height zero)

    def as_json(self) -> dict[str, Any]:
        """Both as JSON documents."""
        return {"moving_body": self.moving.as_json(), "tip": self.tip.as_json()}


@dataclass(frozen=True)
class PartMasses:
    """Mass properties of each kind of part, in its own coordinates, and of the whole machine, by name."""

    parts: Mapping[str, MassProperties]

    def as_json(self) -> dict[str, Any]:
        """All of them as JSON documents."""
        return {"masses": {name: one.as_json() for name, one in self.parts.items()}}


Masses = BodyMasses | PartMasses
"""Mass properties that the checks of a machine read."""


def masses_from_json(document: Mapping[str, Any]) -> Masses:
    """Masses from a document that has those of their `as_json`."""
    if "masses" in document:
        return PartMasses({name: MassProperties.from_json(one) for name, one in document["masses"].items()})
    return BodyMasses(*(MassProperties.from_json(document[name]) for name in ("moving_body", "tip")))


def combined(bodies: Iterable[MassProperties]) -> MassProperties:
    """Several bodies as one: masses add, inertias add about the common centre (parallel-axis theorem)."""
    parts = tuple(bodies)
    mass = math.fsum(part.mass for part in parts)
    if not mass > 0.0:
        raise ValueError("no body with a mass to combine")
    x, y, z = (math.fsum(part.mass * part.centre_of_mass[axis] for part in parts) / mass for axis in range(3))
    centre = (x, y, z)
    tensors = [part.inertia_about(centre) for part in parts]
    inertia = tuple(tuple(math.fsum(tensor[i][j] for tensor in tensors) for j in range(3)) for i in range(3))
    low = tuple(min(part.bounding_box[0][axis] for part in parts) for axis in range(3))
    high = tuple(max(part.bounding_box[1][axis] for part in parts) for axis in range(3))
    return MassProperties(math.fsum(part.volume for part in parts), mass, centre, inertia, (low, high))
