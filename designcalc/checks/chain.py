"""A tolerance chain: the dimensions that add up to a functional distance, by worst case and statistically.

A chain is a sum of dimensions with signs, ``Y = sum(a_i x_i)``, each ``x_i`` within its deviations ``[l_i, u_i]``.
Worst case: ``Y`` is within ``sum(a_i l_i)`` to ``sum(a_i u_i)`` of its nominal value, the ends of a term exchanged
where ``a_i`` is negative. Statistically: each dimension is normal about the middle of its limits, these at three
standard deviations; then ``Y`` is within ``sqrt(sum((a_i (u_i - l_i)/2)^2))`` of its mean with a probability of
99.73 %.
Source: ISO/TR 16015; Bjorke, Computer-Aided Tolerancing, 2nd ed., chapters 3 and 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from stagecad.parameters.units import as_json


@dataclass(frozen=True)
class Link:
    """One dimension of a chain.

    Args:
        key: parameter; a geometrical tolerance by its own key.
        coefficient: change of the result per change of the dimension.
        nominal: m; 0 for a geometrical tolerance.
        low, high: limit deviations, m.
    """

    key: str
    coefficient: float
    nominal: float
    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and greatest contribution to the deviation of the result, m."""
        ends = self.coefficient * self.low, self.coefficient * self.high
        return min(ends), max(ends)


@dataclass(frozen=True)
class Chain:
    """A functional distance and the dimensions that it is the sum of.

    Args:
        name: of the distance.
        links: its dimensions.
        offset: constant part of the nominal value, m.
    """

    name: str
    links: tuple[Link, ...]
    offset: float = 0.0

    @property
    def nominal(self) -> float:
        """Value with all dimensions at their nominal sizes, m."""
        return self.offset + sum(link.coefficient * link.nominal for link in self.links)

    @property
    def worst_case(self) -> tuple[float, float]:
        """Smallest and greatest value, m."""
        return (
            self.nominal + sum(link.ends[0] for link in self.links),
            self.nominal + sum(link.ends[1] for link in self.links),
        )

    @property
    def statistical(self) -> tuple[float, float]:
        """Limits that hold with a probability of 99.73 %, m."""
        low, high = self.worst_case
        half = math.sqrt(sum(((link.ends[1] - link.ends[0]) / 2) ** 2 for link in self.links))
        return (low + high) / 2 - half, (low + high) / 2 + half

    def as_json(self) -> dict[str, Any]:
        """The chain as a JSON document, lengths in m."""
        return {
            "name": self.name,
            "nominal": as_json(self.nominal, "m"),
            "worst_case": [as_json(value, "m") for value in self.worst_case],
            "statistical": [as_json(value, "m") for value in self.statistical],
            "links": [
                {
                    "key": link.key,
                    "coefficient": link.coefficient,
                    "nominal": as_json(link.nominal, "m"),
                    "low": as_json(link.low, "m"),
                    "high": as_json(link.high, "m"),
                }
                for link in self.links
            ],
        }
