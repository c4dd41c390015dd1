"""SI values of a design for its physical model, recorded as they are read, so that a check can list its inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, SupportsFloat, TypeVar

from stagecad.parameters.mass_properties import Masses, PartMasses
from stagecad.parameters.units import format_quantity

if TYPE_CHECKING:
    from stagecad.parameters.design import Design


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
        masses: of the solids, as the machine has them; None without solids.
        memory: results of `remembered` functions; shared by readers of the same design and masses.
        advise: whether a check that fails looks for a change that passes, where that takes long.
    """

    def __init__(
        self,
        design: Design,
        masses: Masses | None = None,
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
        """SI value of a parameter, or of `PART.mass` of a part that was built."""
        part, _, last = key.rpartition(".")
        if last == "mass" and isinstance(self.masses, PartMasses) and part in self.masses.parts:
            return self.given(key, self.masses.parts[part].mass, "kg", "measured from the solids")
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
