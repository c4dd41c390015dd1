"""Temperatures of bodies that are connected by thermal conductances and heated in a duty cycle."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ThermalNetwork:
    """Bodies of one temperature each: ``C_i T_i' = P_i - sum_j G_ij (T_i - T_j) - G_i T_i``, over the surroundings.

    Raises:
        InputError: a capacity not above 0, a negative conductance, or none to the surroundings.
    """

    capacity: Array  # C of each body, J/K, shape (n,)
    between: Array  # G between each two, W/K, symmetric, shape (n, n)
    outside: Array  # G from each to the surroundings, W/K, shape (n,); one of them above 0

    def __post_init__(self) -> None:
        positive = np.all(self.capacity > 0) and np.all(self.between >= 0) and np.all(self.outside >= 0)
        if not (positive and np.any(self.outside > 0)):
            raise InputError("thermal network: capacities must be above 0, conductances 0 or more, one of them outside")

    @cached_property
    def _losses(self) -> Array:
        """Matrix L of ``C T' = P - L T``, W/K."""
        return np.diag(self.outside + self.between.sum(axis=1)) - self.between

    def steady(self, power: Array) -> Array:
        """Temperatures over the surroundings under a constant power (n,), W, after a long time, K."""
        return np.asarray(np.linalg.solve(self._losses, power), float)

    def after(self, start: Array, power: Array, time: float) -> Array:
        """Temperatures a time (s) after `start`, K, under a constant power, W; exact."""
        end = self.steady(power)
        return end + expm(-self._losses / self.capacity[:, None] * time) @ (start - end)

    def cycle(self, power: Array, heated: float, period: float) -> tuple[Array, Array]:
        """Temperatures over the surroundings at the end and at the beginning of the heated part of each period, once
        all periods are alike, K.

        Args:
            power: in the heated part, W, shape (n,).
            heated: its length, s.
            period: s, at least `heated`.
        """
        if not 0 < heated <= period:
            raise InputError("thermal network: the heated part must be above 0 s, and not longer than the period")
        rest, nothing, zero = period - heated, np.zeros_like(power), np.zeros_like(power)
        # From zero a period leads to `gained`, and each kelvin at its begin to a column of `kept`.
        gained = self.after(self.after(zero, power, heated), nothing, rest)
        kept = expm(-self._losses / self.capacity[:, None] * period)
        begin = np.asarray(np.linalg.solve(np.eye(power.size) - kept, gained), float)
        return self.after(begin, power, heated), begin
