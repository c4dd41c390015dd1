"""One design check: a value compared with a limit, with the formula, numbers and inputs behind both."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, SupportsFloat

from designcalc.checks.inputs import DesignInputs, Input
from stagecad.parameters.units import as_json, format_quantity

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
    text: str
    """value with its unit, as it is written in the parameter file"""
    result: str = ""
    """empty before the evaluation, and if the check then passes and no other one fails"""

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
    upper: bool
    """True: the value must not exceed the limit; False: it must reach it"""

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
    """The value must not exceed the limit."""
    return Comparison(_float(value), _float(limit), unit, upper=True)


def at_least(value: SupportsFloat | None, limit: SupportsFloat | None, unit: str) -> Comparison:
    """The value must reach the limit."""
    return Comparison(_float(value), _float(limit), unit, upper=False)


def _float(value: SupportsFloat | None) -> float | None:
    return None if value is None else float(value)


@dataclass(frozen=True)
class Check:
    """A value, its limit, and the verdict; `run_checks` adds subject and inputs."""

    name: str
    comparison: Comparison
    source: str = field(kw_only=True)
    formula: str = field(kw_only=True)
    substituted: str = ""
    """the formula with its numbers"""
    proposal: str = ""
    """the change that would pass, in words; empty when the check passes"""
    changes: tuple[Change, ...] = ()
    """proposed changes of one parameter each"""
    thesis: str = ""
    """statement of the thesis, if it is wrong or differs"""
    requirement: str = ""
    """entry of the thesis's Tables 1 and 2 that this check applies to"""
    note: str = ""
    trouble: Literal["", "out_of_range", "undecidable"] = ""
    """why there is no verdict: outside the formula's range, or a number is missing"""
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
        return {
            "name": self.name,
            "subject": self.subject,
            "value": None if self.value is None else as_json(self.value, self.unit),
            "limit": None if self.limit is None else as_json(self.limit, self.unit),
            "sense": "at most" if self.comparison.upper else "at least",
            "margin": self.margin,
            "verdict": self.verdict,
            "source": self.source,
            "formula": self.formula,
            "substituted": self.substituted,
            "inputs": {
                name: {**as_json(item.value, item.unit), "origin": item.origin} for name, item in self.inputs.items()
            },
            "proposal": self.proposal,
            "changes": [{"set": one.override, "result": one.result} for one in self.changes],
            "thesis": self.thesis,
            "requirement": self.requirement,
            "note": self.note,
        }


CheckFunction = Callable[[DesignInputs], Check]
"""Computes one check from the values it reads."""
