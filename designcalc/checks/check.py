"""One design check: a value compared with a limit, with the formula, numbers and inputs behind both."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, Concatenate, Literal, ParamSpec, SupportsFloat, TypeVar

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.formula import Value, parse_formula
from stagecad.parameters.mass_properties import Masses, PartMasses
from stagecad.parameters.units import as_json, attributes, format_quantity, si_of, si_unit, to_si, unit_dimension


@dataclass(frozen=True)
class Input:
    """A number that a check or calculation reads."""

    value: float  # SI
    unit: str
    origin: str  # origin in the parameter file, or where else the number comes from

    def text(self) -> str:
        """The value with a suitable prefix."""
        return format_quantity(self.value, self.unit)


class MissingNumberError(InputError):
    """A number that a check reads is not known: the check is undecidable."""


class DesignInputs:
    """Reads SI numbers of one design and records each, with its origin.

    `masses` are those of the solids, None without; `memory` has the results of `remembered` functions, and is shared by
    readers of the same design and masses; without `advise` a check has no texts and looks for no change that passes.
    """

    def __init__(
        self, design: Design, masses: Masses | None = None, memory: dict[Any, Any] | None = None, advise: bool = True
    ) -> None:
        self.design = design
        self.masses = masses
        self.inputs: dict[str, Input] = {}
        self.memory: dict[Any, Any] = {} if memory is None else memory
        self.advise = advise

    def __call__(self, key: str) -> float:
        """SI value of a parameter, or of `PART.mass` of a part that was built."""
        part, _, last = key.rpartition(".")
        if last == "mass" and isinstance(self.masses, PartMasses) and part in self.masses.parts:
            return self.given(key, self.masses.parts[part].mass, "kg", "measured from the solids")
        declaration = self.design.machine.declaration
        if last == "mass" and self.masses is None and declaration is not None and declaration.has(part):
            raise MissingNumberError(f"'{key}' is measured from the solids, which are left out here (--no-solids)")
        found = self.memory.get(key)
        if found is None:
            try:
                entry = self.design.entry(key)
            except InputError as error:
                # No range of a calculator, but a slip in the code that asks for it: it is named with its line.
                raise LookupError(str(error)) from None
            found = self.memory[key] = Input(self.design.si(key), si_of(entry.unit), entry.origin)
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


Verdict = Literal["passes", "fails", "out_of_range", "undecidable"]


def show(value: SupportsFloat, unit: str = "") -> str:
    """A number for a formula with numbers put in."""
    return format_quantity(float(value), unit, 4)


def ratio(value: SupportsFloat, divisor: SupportsFloat) -> float:
    """`value/divisor`, infinite for a divisor of zero."""
    return float(value) / float(divisor) if float(divisor) != 0 else math.inf


@dataclass(frozen=True)
class Change:
    """A proposed change of one parameter, and the result of its evaluation."""

    key: str
    text: str  # value with its unit, as it is written in the parameter file
    result: str = ""  # empty before the evaluation, and if the check then passes and no other one fails

    @property
    def override(self) -> str:
        """The change as `--set` takes it."""
        return f"{self.key}={self.text}"


def change(key: str, value: SupportsFloat, unit: str, *, up: bool) -> tuple[Change, ...]:
    """The proposal to set a parameter to a value, rounded up or down to three digits; none for no finite value."""
    number = float(value)
    if not (math.isfinite(number) and number > 0):
        return ()
    scale = 10.0 ** (math.floor(math.log10(number)) - 2)
    rounded = (math.ceil if up else math.floor)(number / scale * (1 + (-1e-9 if up else 1e-9))) * scale
    return (Change(key, show(float(f"{rounded:.3g}"), unit)),)


@dataclass(frozen=True)
class Comparison:
    """A value and the limit that it must not exceed, or must reach; None where a number is missing."""

    value: float | None
    limit: float | None
    unit: str
    upper: bool  # True: the value must not exceed the limit; False: it must reach it

    @property
    def margin(self) -> float | None:
        """``(limit - value)/|limit|`` for an upper limit, with the other sign for a lower one; negative beyond it.

        With a limit of zero it is the distance itself, in the unit of the value. None without a value.
        """
        if self.value is None or self.limit is None or math.isnan(self.value) or math.isinf(self.limit):
            return None
        room = self.limit - self.value if self.upper else self.value - self.limit
        return room / abs(self.limit) if self.limit != 0 else room


def at_most(value: SupportsFloat | None, limit: SupportsFloat | None, unit: str) -> Comparison:
    """The value must not exceed the limit; both are numbers of `unit`, and are kept in SI."""
    return _compared(value, limit, unit, upper=True)


def at_least(value: SupportsFloat | None, limit: SupportsFloat | None, unit: str) -> Comparison:
    """The value must reach the limit; both are numbers of `unit`, and are kept in SI."""
    return _compared(value, limit, unit, upper=False)


def _compared(value: SupportsFloat | None, limit: SupportsFloat | None, unit: str, upper: bool) -> Comparison:
    first, second = (None if one is None else to_si(float(one), unit) for one in (value, limit))
    return Comparison(first, second, unit if to_si(1.0, unit) == 1.0 else si_unit(unit_dimension(unit)), upper)


@dataclass(frozen=True)
class Check:
    """A value, its limit, and the verdict; `run_checks` adds subject and inputs."""

    name: str
    comparison: Comparison
    source: str = field(kw_only=True)
    formula: str = field(kw_only=True)
    substituted: str = ""  # the formula with its numbers
    proposal: str = ""  # the change that would pass, in words; empty when the check passes
    changes: tuple[Change, ...] = ()  # proposed changes of one parameter each
    thesis: str = ""  # statement of the thesis, if it is wrong or differs
    requirement: str = ""  # entry of the thesis's Tables 1 and 2 that this check applies to
    note: str = ""
    # why there is no verdict: outside the formula's range, or a number is missing
    trouble: Literal["", "out_of_range", "undecidable"] = ""
    subject: str = ""
    inputs: dict[str, Input] = field(default_factory=dict)

    @property
    def value(self) -> float | None:
        return self.comparison.value

    @property
    def limit(self) -> float | None:
        return self.comparison.limit

    @property
    def unit(self) -> str:
        return self.comparison.unit

    @property
    def sense(self) -> str:
        return "at most" if self.comparison.upper else "at least"

    @property
    def margin(self) -> float | None:
        """Part of the limit left, negative when the check fails; None without a value."""
        return self.comparison.margin

    @property
    def verdict(self) -> Verdict:
        """Passes on the limit itself; rounding errors (1e-9 of the limit) do not fail a design."""
        if self.trouble:
            return self.trouble
        margin = self.margin
        if margin is None:
            return "undecidable"
        return "passes" if margin >= -1e-9 else "fails"

    def as_json(self) -> dict[str, Any]:
        """The check as a JSON document."""
        both = {"value": self.value, "limit": self.limit}
        inputs = {name: {**as_json(one.value, one.unit), "origin": one.origin} for name, one in self.inputs.items()}
        return {
            **attributes(self, "name", "subject"),
            **{name: number if number is None else as_json(number, self.unit) for name, number in both.items()},
            **attributes(self, "sense", "margin", "verdict", "source", "formula", "substituted"),
            "inputs": inputs,
            "proposal": self.proposal,
            "changes": [{"set": one.override, "result": one.result} for one in self.changes],
            **attributes(self, "thesis", "requirement", "note"),
        }


CheckFunction = Callable[[DesignInputs], Check]
"""Computes one check from the values it reads."""


Quantities = Mapping[str, tuple[Callable[[DesignInputs], float] | float, str]]
"""Calculated numbers that formulas may name as they name parameters: SI value, or its function, and unit."""

_SYMBOL = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+")
_SHOWN = (
    *("", "s", "m", "m/s", "m/s^2", "m^2", "m^2/N", "N", "Pa", "N/m", "N*m", "kg", "Hz", "W", "W/m^2", "A", "T", "K"),
    *("1/K", "m/K"),
)
_UNITS = {unit_dimension(unit): unit for unit in (*_SHOWN, "rad")}
"""Unit in which a result is shown, by its dimension."""


@dataclass(frozen=True)
class FormulaCheck:
    """A check ``LEFT <= RIGHT`` or ``LEFT >= RIGHT`` of two formulas as in a parameter file.

    They name parameters, properties of the material of a part (``tip.material.expansion``), and `quantities`. What is
    divided by zero is infinite. In the texts ``{FORMULA}`` stands for its value, ``{FORMULA: J}`` for that in joule;
    there, and in the formulas of changes, ``check.value`` and ``check.limit`` are known too.
    """

    name: str
    formula: str
    texts: Mapping[str, str]  # source, proposal, thesis, requirement, note
    quantities: Quantities
    changes: Sequence[tuple[str, str, bool]] = ()  # key, formula of the value that passes, whether to round it up

    def __call__(self, r: DesignInputs) -> Check:
        left, sign, right = re.split(r" (<=|>=) ", self.formula)
        value, limit = self.evaluate(r, left), self.evaluate(r, right)
        unit = _UNITS[(value or limit or Value(0.0, unit_dimension(""))).dimension]
        compare = at_most if sign == "<=" else at_least
        comparison = compare(math.inf if value is None else value.si, math.inf if limit is None else limit.si, unit)
        if not r.advise:
            return Check(self.name, comparison, source="", formula=self.formula)
        known = {"check.value": (comparison.value or 0.0, unit), "check.limit": (comparison.limit or 0.0, unit)}

        def filled(text: str) -> str:
            return re.sub(r"\{([^}]*)\}", lambda match: self._shown(r, match[1], known), text)

        changes: tuple[Change, ...] = ()
        for key, formula, up in self.changes:
            wanted = self.evaluate(r, formula, known)
            if wanted is not None:
                changes += change(key, wanted.si, _UNITS[wanted.dimension], up=up)
        return Check(
            self.name,
            comparison,
            formula=self.formula,
            substituted=f"{self._with_numbers(r, left)} {sign} {self._with_numbers(r, right)}",
            changes=changes,
            **{name: filled(text) for name, text in self.texts.items()},  # type: ignore[arg-type]
        )

    def _input(self, r: DesignInputs, key: str) -> Input:
        if key in self.quantities:
            number, unit = self.quantities[key]
            return Input(float(remembered(number)(r) if callable(number) else number), unit, "calculated")
        part, of_material, quantity = key.partition(".material.")
        if of_material:
            key = f"materials.{r.design.value(f'{part}.material')}.{quantity}"
        return Input(r(key), r.inputs[key].unit, "")

    def evaluate(
        self, r: DesignInputs, text: str, known: Mapping[str, tuple[float, str]] | None = None
    ) -> Value | None:
        """The value of a formula; None where it divides by zero."""

        def value(key: str) -> Value:
            found = Input(*known[key], "") if known and key in known else self._input(r, key)
            return Value(found.value, unit_dimension(found.unit))

        try:
            return parse_formula(text).evaluate(value)
        except ZeroDivisionError:
            return None

    def _shown(self, r: DesignInputs, text: str, known: Mapping[str, tuple[float, str]]) -> str:
        formula, _, unit = text.partition(": ")
        found = self.evaluate(r, formula, known)
        return "inf" if found is None else show(found.si, unit or _UNITS[found.dimension])

    def _with_numbers(self, r: DesignInputs, text: str) -> str:
        def number(match: re.Match[str]) -> str:
            shown = self._input(r, match[0]).text()
            return f"({shown})" if text[match.end() :].startswith("^") else shown

        return _SYMBOL.sub(number, text)
