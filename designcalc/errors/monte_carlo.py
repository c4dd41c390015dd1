"""Monte Carlo samples of a design's uncertain parameters, and the distribution of a result over them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from stagecad.parameters.design import Design
from stagecad.parameters.units import si_of, to_si

SIGNIFICANCE = 0.01
"""Probability that the largest of the rank correlations with independent parameters exceeds the limit."""


@dataclass(frozen=True)
class UncertainParameter:
    """A parameter that is sampled: normally about its value with `std`, or uniformly within `half_width` either way."""

    key: str
    value: float
    unit: str
    std: float | None
    half_width: float

    def sample(self, random: np.random.Generator, count: int) -> np.ndarray:
        """Values in `unit`, shape (count,)."""
        if self.std is not None:
            return random.normal(self.value, self.std, count)
        return random.uniform(self.value - self.half_width, self.value + self.half_width, count)

    @property
    def text(self) -> str:
        """Value and distribution."""
        if self.std is not None:
            return f"{self.key} = {self.value:g} +- {self.std:g} {self.unit}".rstrip()
        return f"{self.key} = {self.value:g} {self.unit} within {self.half_width:g} {self.unit}"

    @property
    def si_unit(self) -> str:
        return si_of(self.unit) or "1"

    def as_json(self) -> dict[str, Any]:
        """Value and width of the distribution in SI."""
        width = ("plus_minus", self.half_width) if self.std is None else ("std", self.std)
        return {"value": to_si(self.value, self.unit), "unit": self.si_unit, width[0]: to_si(width[1], self.unit)}


def uncertain_parameters(design: Design, is_read: Callable[[str], bool]) -> tuple[UncertainParameter, ...]:
    """Parameters with a standard deviation (`+-`) and dimensions with a tolerance, of those whose key `is_read`."""
    found = []
    for entry in design.entries:
        if isinstance(entry.value, bool | str | int) or not is_read(entry.key):
            continue
        # A tolerance class in millimetres does not apply to an angle.
        half_width = design.plus_minus(entry.key) if entry.unit == "mm" else 0.0
        if entry.std or half_width > 0.0:
            found.append(UncertainParameter(entry.key, float(entry.value), entry.unit, entry.std or None, half_width))
    return tuple(found)


@dataclass(frozen=True)
class Distribution:
    """One result over the samples. SI."""

    nominal: float | None  # of the design itself; None where it has none (a mass that does not slip)
    values: np.ndarray  # of each sample, (samples,); NaN where it has none
    unit: str  # SI
    # the parameter with the largest rank correlation, and that correlation; an empty name where it is not significant
    strongest: tuple[str, float] = ("", 0.0)

    @property
    def finite(self) -> np.ndarray:
        """Values of the samples that have the result."""
        return self.values[np.isfinite(self.values)]

    @property
    def varies(self) -> bool:
        """Whether the samples differ by more than rounding errors."""
        finite = self.finite
        return finite.size > 1 and float(np.ptp(finite)) > 1e-12 * float(np.abs(finite).max())

    @property
    def strongest_text(self) -> str:
        """The parameter with the strongest rank correlation; empty where none is significant."""
        key, correlation = self.strongest
        return f"{key} ({correlation:+.2f})" if key else ""

    def as_json(self) -> dict[str, Any]:
        """Nominal value, mean and standard deviation over the samples, and their 95 % band."""
        finite = self.finite
        low, high = np.quantile(finite, [0.025, 0.975]) if finite.size else (np.nan, np.nan)
        key, correlation = self.strongest
        return {
            "value": self.nominal,
            "unit": self.unit,
            "mean": float(finite.mean()) if finite.size else None,
            "std": float(finite.std(ddof=1)) if finite.size > 1 else None,
            "low": float(low),
            "high": float(high),
            "draws": int(finite.size),
            "follows": {"key": key, "rank_correlation": correlation} if key else None,
        }


def strongest_correlation(keys: Sequence[str], samples: np.ndarray, values: np.ndarray) -> tuple[str, float]:
    """The parameter with the largest Spearman rank correlation, and that correlation; `("", 0.0)` if not significant.

    Args:
        keys: of the parameters.
        samples: (samples, parameters).
        values: of the result, (samples,); NaN where a sample has none.
    """
    finite = np.isfinite(values)
    y = _ranks(values[finite])
    found = [float(_ranks(x) @ y) for x in samples[finite].T]
    best = int(np.argmax(np.abs(found)))
    # Normal approximation of the rank correlation, two-sided, Bonferroni over the parameters.
    limit = NormalDist().inv_cdf(1.0 - 0.5 * SIGNIFICANCE / len(keys)) / np.sqrt(finite.sum() - 1)
    return (keys[best], found[best]) if abs(found[best]) > limit else ("", 0.0)


def _ranks(values: np.ndarray) -> np.ndarray:
    """Ranks, centred and of norm one."""
    ranks = np.argsort(np.argsort(values, kind="stable"), kind="stable").astype(float)
    ranks -= ranks.mean()
    return ranks / np.linalg.norm(ranks)
