"""A check that is one formula: the text that is shown is the one that is evaluated."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from designcalc.checks.check import Change, Check, DesignInputs, Input, at_least, at_most, change, show
from stagecad.parameters.formula import Value, parse_formula
from stagecad.parameters.units import unit_dimension

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
            return Input(float(number(r) if callable(number) else number), unit, "calculated")
        part, of_material, quantity = key.partition(".material.")
        if of_material:
            key = f"materials.{r.design.value(f'{part}.material')}.{quantity}"
        return Input(r(key), r.inputs[key].unit, "")

    def evaluate(
        self, r: DesignInputs, text: str, known: Mapping[str, tuple[float, str]] | None = None
    ) -> Value | None:
        """The value of a formula; None where it divides by zero."""

        def value(key: str) -> Value:
            si, unit = known[key] if known and key in known else (self._input(r, key).value, self._input(r, key).unit)
            return Value(si, unit_dimension(unit))

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
