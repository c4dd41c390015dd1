"""A tolerance chain: the dimensions that add up to a functional distance, by worst case and statistically.

A chain is a sum of dimensions with signs, ``Y = sum(a_i x_i)``, each ``x_i`` within its deviations ``[l_i, u_i]``.
Worst case: ``Y`` is within ``sum(a_i l_i)`` to ``sum(a_i u_i)`` of its nominal value, the ends of a term exchanged
where ``a_i`` is negative. Statistically: each dimension is uniform within its limits, as `stagecad check --tolerance`
draws it, since nothing is known of how parts are made; limits of ``Y`` that hold with a probability of 99.73 %, by
convolution. Source: ISO/TR 16015; Bjorke, Computer-Aided Tolerancing, 2nd ed., chapters 3 and 5.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from stagecad.parameters.design import Design
from stagecad.parameters.units import as_json, attributes


@dataclass(frozen=True)
class Link:
    """One dimension of a chain."""

    key: str  # parameter; a geometrical tolerance by its own key
    coefficient: float  # change of the result per change of the dimension
    nominal: float  # m; 0 for a geometrical tolerance
    # low, high: limit deviations, m
    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and greatest contribution to the deviation of the result, m."""
        ends = self.coefficient * self.low, self.coefficient * self.high
        return min(ends), max(ends)


def link_of(design: Design, key: str, coefficient: float) -> Link:
    """The link of a dimension, with the tolerance of its class."""
    low, high = design.deviations(key)
    return Link(key, coefficient, design.si(key), 1e-3 * low, 1e-3 * high)


PROBABILITY = 0.9973
"""Of three standard deviations of a normal distribution."""
CELLS = 2000
"""Of the density of a chain, over its worst case either way."""


@lru_cache(maxsize=64)
def _sum_of_uniforms(halves: tuple[float, ...]) -> float:
    """Distance from the mean within which a sum of numbers uniform within these half-widths is at 99.73 %."""
    worst = sum(halves)
    if worst == 0.0:
        return 0.0
    cell = 2 * worst / CELLS
    density = np.ones(1)
    for half in halves:
        # Cells within the width, and a part of one at either end.
        inner = int(half / cell - 0.5) if half > cell / 2 else 0
        edge = (half / cell - 0.5 - inner) if half > cell / 2 else 0.0
        density = np.convolve(density, np.concatenate([[edge], np.ones(2 * inner + 1), [edge]]))
    outside = 1.0 - np.cumsum(density) / density.sum()
    middle = (density.size - 1) / 2
    # The part beyond the far edge of each cell.
    return float(cell * (np.interp(-(1 - PROBABILITY) / 2, -outside, np.arange(density.size)) + 0.5 - middle))


@dataclass(frozen=True)
class Chain:
    """A functional distance and the dimensions that it is the sum of."""

    name: str  # of the distance
    links: tuple[Link, ...]  # its dimensions
    offset: float = 0.0  # constant part of the nominal value, m

    @property
    def nominal(self) -> float:
        """Value with all dimensions at their nominal sizes, m; zero where only the rounding of sizes is left."""
        total = sum(terms := [self.offset, *(link.coefficient * link.nominal for link in self.links)])
        return total if abs(total) > np.finfo(float).eps * sum(map(abs, terms)) else 0.0

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
        half = _sum_of_uniforms(tuple((link.ends[1] - link.ends[0]) / 2 for link in self.links))
        return (low + high) / 2 - half, (low + high) / 2 + half

    def as_json(self) -> dict[str, Any]:
        """The chain as a JSON document, lengths in m."""
        sizes = ("nominal", "low", "high")
        return {
            "name": self.name,
            "nominal": as_json(self.nominal, "m"),
            "worst_case": [as_json(value, "m") for value in self.worst_case],
            "statistical": [as_json(value, "m") for value in self.statistical],
            "links": [
                attributes(link, "key", "coefficient") | {name: as_json(getattr(link, name), "m") for name in sizes}
                for link in self.links
            ],
        }
