"""SI values of a design for its physical model, recorded as they are read, so that a check can list its inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, SupportsFloat, TypeVar

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
        memory: results of `remembered` functions; shared by readers of the same design and masses.
        advise: whether a check that fails looks for a change that passes, where that takes long.
    """

    def __init__(
        self,
        design: Design,
        masses: BodyMasses | None = None,
        memory: dict[Any, Any] | None = None,
        advise: bool = True,
    ) -> None:
        self.design = design
        self.masses = masses
        self.inputs: dict[str, Input] = {}
        self.memory: dict[Any, Any] = {} if memory is None else memory
        self.advise = advise

    def take(self) -> dict[str, Input]:
        """The inputs recorded since the last call."""
        inputs, self.inputs = self.inputs, {}
        return inputs

    def __call__(self, key: str) -> float:
        """SI value of a parameter."""
        found = self.memory.get(key)
        if found is None:
            entry = self.design.entry(key)
            found = self.memory[key] = Input(self.design.si(key), _SI.get(entry.unit, entry.unit), entry.origin)
        self.inputs[key] = found
        return found.value

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


Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def remembered(
    function: Callable[Concatenate[DesignInputs, Arguments], Result],
) -> Callable[Concatenate[DesignInputs, Arguments], Result]:
    """Decorator: compute a quantity of a design once, and record its inputs each time as if it were computed.

    The arguments after the reader must be hashable; the result must not be changed.
    """

    @wraps(function)
    def reading(r: DesignInputs, *arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        key = (function, arguments, tuple(named.items()))
        if key not in r.memory:
            outer, r.inputs = r.inputs, {}
            try:
                result = function(r, *arguments, **named)
                r.memory[key] = (result, r.inputs)
            finally:
                r.inputs = {**outer, **r.inputs}
            return result
        result, inputs = r.memory[key]
        r.inputs.update(inputs)
        return result

    return reading
