"""Channels and known quantities of a base kind of rig, computed by the formulas of a declared kind."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from stagecad.parameters.formula import FUNCTIONS, Formula, Functions, Value
from stagecad.parameters.units import DIMENSIONLESS, Dimension, unit_dimension
from sysid.experiment.known import Known
from sysid.experiment.rig_kinds.declaration import default_value, unit_of
from sysid.experiment.rigs import RIGS, RigKind

_SECOND = unit_dimension("s")


def _elementwise(function: Callable[[Any], Any], result: Dimension, *allowed: Dimension) -> Callable[..., Value]:
    def apply(x: Value) -> Value:
        if x.dimension not in allowed:
            raise InputError("an angle or a number without unit is needed")
        return Value(function(x.si), result)

    return apply


_ANGLE = unit_dimension("rad")
ARRAY_FUNCTIONS: Functions = {
    **FUNCTIONS,
    **{
        name: (1, 1, _elementwise(function, DIMENSIONLESS, _ANGLE, DIMENSIONLESS))
        for name, function in (("sin", np.sin), ("cos", np.cos), ("tan", np.tan))
    },
    **{
        name: (1, 1, _elementwise(function, _ANGLE, DIMENSIONLESS))
        for name, function in (("asin", np.arcsin), ("acos", np.arccos), ("atan", np.arctan))
    },
}
"""Functions of formulas for arrays (n,)."""


@dataclass(frozen=True)
class Balance:
    """The formulas of a declared kind of rig with the SI values of its known quantities; `file` stands in messages."""

    kind: RigKind
    known: Mapping[str, float]
    rotary: bool
    file: str

    def channels(self, time: np.ndarray, recorded: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The base's channels (n,), SI: recorded ones, and those of the formulas."""
        base = RIGS[self.kind.base]
        found = {name: values for name, values in recorded.items() if name in base.channels}
        for channel, formula in self.kind.balance.items():
            known = {**recorded, **found}
            try:
                with np.errstate(all="ignore"):
                    value = formula.evaluate(lambda key: self._value(key, time, known), ARRAY_FUNCTIONS)  # noqa: B023
            except (InputError, ValueError, ArithmeticError) as error:
                raise InputError(f"{self._place(channel, formula)}: {error}") from None
            self._check(channel, formula, value.dimension)
            found[channel] = np.broadcast_to(np.asarray(value.si, dtype=float), time.shape).copy()
        return found

    def _check(self, channel: str, formula: Formula, dimension: Dimension) -> None:
        base = RIGS[self.kind.base]
        units = (base.declared(channel).si_unit(self.rotary), "N*m" if channel == "normal_load" else "")
        if not any(unit and dimension == unit_dimension(unit) for unit in units):
            axis = "rotary" if self.rotary else "linear"
            raise InputError(
                f"{self._place(channel, formula)} is no '{units[0]}', in which {channel} of a {axis} axis is"
            )

    def _place(self, channel: str, formula: Formula) -> str:
        return f"{self.file}: rig.kind = '{self.kind.name}': {channel} = '{formula.text}'"

    def _value(self, key: str, time: np.ndarray, channels: Mapping[str, np.ndarray]) -> Value:
        source, _, name = key.partition(".")
        if source == "known":
            quantity = {**RIGS[self.kind.base].known, **self.kind.known}[name]
            return Value(self.known[name], unit_dimension(quantity.rotary_unit if self.rotary else quantity.unit))
        dimension = unit_dimension(unit_of(name, self.kind, self.rotary))
        values: Any = channels.get(name)
        if values is None and name == "velocity":
            values = np.gradient(channels["position"], time)
        if values is None:
            values = default_value(self.kind, f"channel.{name}", unit_of(name, self.kind, self.rotary))
        for _ in range({"channel": 0, "rate": 1, "rate2": 2}[source]):
            values = np.gradient(values, time) if isinstance(values, np.ndarray) else 0.0
            dimension = tuple(a - b for a, b in zip(dimension, _SECOND, strict=True))
        return Value(values, dimension)


def balance_of(kind: RigKind, known: Mapping[str, Known], rotary: bool, file: str) -> tuple[Balance, dict[str, Known]]:
    """The balance of a declared kind, and the known quantities of its base."""
    base = RIGS[kind.base]
    values = {name: quantity.value for name, quantity in known.items()}
    for name, quantity in kind.known.items():
        unit = quantity.rotary_unit if rotary else quantity.unit
        default = default_value(kind, f"known.{name}", unit)
        if name not in values and default is not None:
            values[name] = default
    for formula in kind.balance.values():
        for key in formula.keys:
            source, _, name = key.partition(".")
            if source == "known" and name not in values:
                quantity = {**base.known, **kind.known}[name]
                unit = quantity.rotary_unit if rotary else quantity.unit
                raise InputError(
                    f"{file}: rig.known.{name} is missing, which '{kind.name}' needs; write it, like "
                    f'{name} = "1{f" {unit}" if unit else ""}"'
                )
    balance = Balance(kind, values, rotary, file)
    found = {name: quantity for name, quantity in known.items() if name in base.known}
    for name, formula in kind.constants.items():
        if all(key.partition(".")[2] in values for key in formula.keys):
            quantity = base.known[name]
            unit = quantity.rotary_unit if rotary else quantity.unit
            computed = formula.value(lambda key: balance._value(key, np.empty(0), {}), unit, f"{kind.name}: {name}")
            found[name] = Known(computed)
    return balance, found
