"""Free parameters of an optimisation: their ranges or choices, and points of the unit cube."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import DIMENSIONLESS, format_quantity, from_si, parse_quantity, to_si, unit_dimension

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

Array = NDArray[np.float64]

_WIDE = 20.0
"""A positive range whose ends differ by more than this factor is searched on a logarithmic scale."""


@dataclass(frozen=True)
class Free:
    """A parameter that may change."""

    key: str  # parameter
    unit: str  # of its attribute
    # low, high: ends of its range, in `unit`; equal for choices
    low: float
    high: float
    whole: bool  # whole numbers only
    choices: tuple[Any, ...]  # values instead of a range, in the order of the file
    start: Any  # present value
    weight: float = 1.0  # of its change in the distance

    @property
    def logarithmic(self) -> bool:
        """Whether the scale is logarithmic."""
        return self.low > 0 and self.high / self.low > _WIDE

    def value(self, place: float) -> Any:
        """Value at a place from 0 to 1."""
        place = min(max(place, 0.0), 1.0)
        if self.choices:
            return self.choices[min(int(place * len(self.choices)), len(self.choices) - 1)]
        if self.logarithmic:
            found = self.low * (self.high / self.low) ** place
        else:
            found = self.low + place * (self.high - self.low)
        found = min(max(found, self.low), self.high)
        return round(found) if self.whole else float(f"{found:.10g}")

    def place(self, value: Any) -> float:
        """Place of a value; a value outside of the range has that of the nearer end."""
        if self.choices:
            index = self.choices.index(value) if value in self.choices else 0
            return (index + 0.5) / len(self.choices)
        bounded = min(max(float(value), self.low), self.high)
        if self.logarithmic:
            return math.log(bounded / self.low) / math.log(self.high / self.low)
        return (bounded - self.low) / (self.high - self.low)

    def distance(self, value: Any) -> float:
        """Size of the change from the present value, in units of the range; 1 for another choice."""
        if self.choices:
            return float(value != self.start)
        if self.logarithmic:
            return abs(math.log(value / self.start)) / math.log(self.high / self.low) if value > 0 else 1.0
        return abs(value - self.start) / (self.high - self.low)

    def text(self, value: Any) -> str:
        """The value as it is written in a parameter file."""
        if isinstance(value, bool):
            return str(value).lower()
        if self.whole or isinstance(value, str):
            return str(value)
        return format_quantity(to_si(value, self.unit), self.unit, 10)


def free_parameters(design: Design, given: Sequence[str]) -> tuple[Free, ...]:
    """Parameters that are free: those marked in the file (`free = "8 mm..20 mm"`), and those of `--free`, texts
    `KEY=LOW:HIGH` or `KEY=A|B|C` for choices, which replace the marks of the same keys."""
    found = {
        entry.key: read_range(entry.key, entry.free, "..", design, "free") for entry in design.entries if entry.free
    }
    for text in given:
        key, equals, rest = (part.strip() for part in text.partition("="))
        if not equals or not rest:
            raise InputError(f"--free '{text}': write KEY=LOW:HIGH, like stage.thickness=8mm:20mm, or KEY=A|B")
        found[key] = read_range(key, rest, ":", design, "--free")
    if not found:
        raise InputError(
            f'{design.file}: no parameter is free; mark some (free = "8 mm..20 mm") or give --free KEY=LOW:HIGH'
        )
    return tuple(found.values())


def read_range(key: str, text: str, separator: str, design: Design, where: str) -> Free:
    """Read a range or choices of one parameter."""
    entry = design.entry(key)
    place = f"{where} {key}"
    words = [word.strip().strip("\"'").strip() for word in text.split("|")]
    number = isinstance(entry.value, int | float) and not isinstance(entry.value, bool)
    whole = number and isinstance(entry.value, int)
    unit = entry.unit
    wanted = unit if unit_dimension(unit) != DIMENSIONLESS else ""
    if len(words) > 1 or not number:
        choices = tuple(_choice(word, entry.value, wanted, unit, place) for word in words)
        if len(set(choices)) < 2:
            raise InputError(f"{place} = '{text}': at least two different choices are needed, like A|B")
        if entry.value not in choices:
            choices = (entry.value, *choices)
        return Free(key, unit, 0.0, 0.0, whole, choices, entry.value)
    ends = [part.strip().strip("\"'").strip() for part in text.split(separator)]
    if len(ends) != 2 or not all(ends):
        raise InputError(f"{place} = '{text}': write LOW{separator}HIGH, like '8 mm{separator}20 mm'")
    low, high = (from_si(parse_quantity(_bare(end, wanted), wanted, place), unit) for end in ends)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"{place} = '{text}': the lower end must be below the upper one, and both finite")
    return Free(key, unit, low, high, whole, (), entry.value)


def _bare(text: str, unit: str) -> Any:
    if unit:
        return text
    try:
        return float(text)
    except ValueError:
        return text


def _choice(word: str, present: Any, wanted: str, unit: str, place: str) -> Any:
    if isinstance(present, bool):
        if word not in ("true", "false"):
            raise InputError(f"{place}: '{word}' is neither true nor false")
        return word == "true"
    if isinstance(present, str):
        return word
    value = from_si(parse_quantity(_bare(word, wanted), wanted, place), unit)
    return round(value) if isinstance(present, int) else value


def values_at(free: Sequence[Free], point: Array) -> dict[str, Any]:
    """Values of all free parameters at a point of the unit cube, shape (n,)."""
    return {one.key: one.value(float(place)) for one, place in zip(free, point, strict=True)}


def start_point(free: Sequence[Free]) -> Array:
    """Point of the present values."""
    return np.array([one.place(one.start) for one in free])


def distance(free: Sequence[Free], values: Mapping[str, Any]) -> float:
    """Weighted sum of the changes in units of their ranges."""
    return math.fsum(one.weight * one.distance(values[one.key]) for one in free)
