"""SI values of a design for its physical model, recorded as they are read, so that a check can list its inputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, SupportsFloat

from stagecad.parameters.units import format_quantity

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses


_SI = {"mm": "m", "deg": "rad"}
"""SI of the units that geometry is kept in; every other unit of a design is SI already."""


@dataclass(frozen=True)
class Input:
    """A number that a check or calculation reads."""

    value: float
    """SI"""
    unit: str
    origin: str
    """origin in the parameter file, or where else the number comes from"""

    def text(self) -> str:
        """The value with a suitable prefix."""
        return format_quantity(self.value, self.unit)


class DesignInputs:
    """Reads SI numbers of one design and records each, with its origin, until `take` is called.

    Args:
        design: the design.
        masses: of the solids; without them the masses are estimated from the stage's plain plate and the tip's limit,
            and the recorded inputs state it.
    """

    def __init__(self, design: Design, masses: BodyMasses | None = None) -> None:
        self.design = design
        self.masses = masses
        self.inputs: dict[str, Input] = {}

    def take(self) -> dict[str, Input]:
        """The inputs recorded since the last call."""
        inputs, self.inputs = self.inputs, {}
        return inputs

    def __call__(self, key: str) -> float:
        """SI value of a parameter."""
        entry = self.design.entry(key)
        value = self.design.si(key)
        self.inputs[key] = Input(value, _SI.get(entry.unit, entry.unit), entry.origin)
        return value

    def material(self, part: str, quantity: str) -> float:
        """SI value of a property of the material that a part is made of."""
        return self(f"materials.{self.design.value(f'{part}.material')}.{quantity}")

    def given(self, name: str, value: SupportsFloat, unit: str, origin: str) -> float:
        """Record a number that is not a parameter: from the solids, or calculated."""
        self.inputs[name] = Input(float(value), unit, origin)
        return float(value)

    def mass(self) -> float:
        """Mass of the moving body, kg."""
        if self.masses is not None:
            return self.given("moving body mass", self.masses.moving.mass, "kg", "measured from the solids")
        plate = self("stage.length") * self("stage.width") * self("stage.thickness")
        return self.given(
            "moving body mass",
            plate * self.material("stage", "density"),
            "kg",
            "estimated: the stage as a plain plate, since no solids were built",
        )

    def tip_mass(self) -> float:
        """Mass of one tip, kg."""
        if self.masses is not None:
            return self.given("tip mass", self.masses.tip.mass, "kg", "measured from the solids")
        return self("tip.mass_limit")

    def centre_of_mass(self) -> tuple[float, float]:
        """Centre of mass of the moving body in the plane of motion, from the middle of the stage, m."""
        if self.masses is None:
            return 0.0, 0.0
        x, y = self.masses.moving.centre_of_mass[:2]
        self.given("centre of mass along", x, "m", "measured from the solids")
        self.given("centre of mass across", y, "m", "measured from the solids")
        return x, y

    def centre_of_mass_height(self) -> float:
        """Height of the centre of mass of stage and payload above the stage's underside, m."""
        thickness, carried, above = self("stage.thickness"), self("payload.mass"), self("payload.height")
        mass = self.mass()
        if self.masses is None:
            own = thickness / 2
        else:
            sea = self("bearing_way.height") + self("pads.height")
            own = self.given(
                "centre of mass above the sea", self.masses.moving.centre_of_mass[2] - sea, "m", "measured"
            )
        return (mass * own + carried * (thickness + above)) / (mass + carried)

    def tilting_inertia(self) -> tuple[float, float]:
        """Moments of inertia of stage and payload about the axes along and across, through their centre, kg m^2."""
        mass, carried = self.mass(), self("payload.mass")
        length, width, thickness = self("stage.length"), self("stage.width"), self("stage.thickness")
        if self.masses is None:
            own = mass * (width**2 + thickness**2) / 12, mass * (length**2 + thickness**2) / 12
        else:
            inertia = self.masses.moving.inertia
            own = float(inertia[0][0]), float(inertia[1][1])
        apart = thickness / 2 + self("payload.height")
        steiner = mass * carried / (mass + carried) * apart**2 if mass + carried > 0 else 0.0
        along = self.given("inertia about the axis along", own[0] + steiner, "kg*m^2", "stage and a payload at a point")
        across = self.given(
            "inertia about the axis across", own[1] + steiner, "kg*m^2", "stage and a payload at a point"
        )
        return along, across
