"""Spectra of disturbances through a position loop: amplitude spectral density and cumulative rms at the payload.

All spectra are one-sided. A disturbance of density ``a`` (m/sqrt(Hz)) that reaches the payload by the transfer function
``G`` has the density ``|G| a`` there; independent disturbances add as powers. The cumulative rms is the root of the
integral of the power from the lowest frequency upwards.

Source: Schmidt, Schitter, Rankers, The Design of High Performance Mechatronics (2020), section 8.2 (dynamic error
budgeting).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]
Response = NDArray[np.complex128]


def resonant_response(frequency: Array, resonance: Array | float, damping: Array | float) -> Response:
    """Mass on spring and damper driven through its spring: ``1/(1 - r^2 + 2 i zeta r)``, ``r = f/f_1``.

    The arguments are broadcast against each other.
    """
    r = frequency / resonance
    return 1 / (1 - r**2 + 2j * damping * r)


def base_response(frequency: Array, resonance: float, damping: float) -> Response:
    """Motion of the mass relative to its shaken base over that of the base: ``r^2/(1 - r^2 + 2 i zeta r)``."""
    return (frequency / resonance) ** 2 * resonant_response(frequency, resonance, damping)


def first_order_lag(frequency: Array, corner: float) -> Response:
    """``1/(1 + i f/f_c)``; `corner` f_c in Hz."""
    return np.asarray(1 / (1 + 1j * frequency / corner), np.complex128)


@dataclass(frozen=True)
class PositionLoop:
    """Integral controller of a mass that follows its actuator through a spring.

    The open loop is ``f_c/(i f) P(f) F(f) exp(-2 pi i f T)``: the plant P as a resonance with unit static gain, the
    sensor's filter F of first order, the delay T of one and a half samples.
    """

    crossover: float  # f_c, Hz
    resonance: float  # of the plant, Hz
    damping: float  # its ratio
    filter_corner: float  # Hz; infinite without a filter
    sample_rate: float  # Hz

    def __post_init__(self) -> None:
        values = (self.crossover, self.resonance, self.damping, self.filter_corner, self.sample_rate)
        require(all(value > 0 for value in values), "position loop: frequencies and damping must be above 0")

    def plant(self, frequency: Array) -> Response:
        """Position over position commanded, without the loop."""
        return resonant_response(frequency, self.resonance, self.damping)

    def sensor(self, frequency: Array) -> Response:
        """Filter of the sensor."""
        return first_order_lag(frequency, self.filter_corner)

    def open_loop(self, frequency: Array) -> Response:
        """Product of controller, delay, plant and filter."""
        delay = np.exp(-2j * np.pi * frequency * 1.5 / self.sample_rate)
        return self.crossover / (1j * frequency) * delay * self.plant(frequency) * self.sensor(frequency)

    def sensitivity(self, frequency: Array) -> Response:
        """``1/(1 + L)``: error over a disturbance of the position."""
        return 1 / (1 + self.open_loop(frequency))

    def stable(self) -> bool:
        """Nyquist's criterion: the open loop, whose only unstable pole is its integrator, does not encircle -1."""
        f = np.geomspace(1e-4 * self.crossover, 0.5 * self.sample_rate, 4001)
        f = np.unique(np.append(f, self.resonance * (1 + self.damping * np.linspace(-8, 8, 801))))
        f = f[(f > 0) & (f <= 0.5 * self.sample_rate)]
        turned = np.unwrap(np.angle(1 + self.open_loop(f)))
        # From -90 degrees at low frequencies 1 + L returns to 0 at high ones when -1 is not encircled.
        return bool(abs(turned[-1] - turned[0] - np.pi / 2) < np.pi / 2)


@dataclass(frozen=True)
class Disturbance:
    """A disturbance as it appears at the payload."""

    name: str  # of the disturbance
    source: str  # where its spectrum comes from
    density: Array  # one-sided amplitude spectral density at the payload, m/sqrt(Hz), shape (n,)


@dataclass(frozen=True)
class DynamicBudget:
    """Disturbances at the payload along one direction."""

    name: str  # direction and sensor
    frequency: Array  # Hz, rising, shape (n,)
    rows: tuple[Disturbance, ...]  # independent disturbances

    @property
    def total(self) -> Disturbance:
        """All of them together."""
        return Disturbance("total", "sum of the powers", np.sqrt(sum(row.density**2 for row in self.rows)))

    def cumulative(self, row: Disturbance) -> Array:
        """Rms from the lowest frequency up to each, m, shape (n,)."""
        power = row.density**2
        steps = 0.5 * (power[1:] + power[:-1]) * np.diff(self.frequency)
        return np.sqrt(np.concatenate([[0.0], np.cumsum(steps)]))

    def rms(self, row: Disturbance, lowest: float = 0.0) -> float:
        """Rms above a frequency, m; the rest is drift of a longer period."""
        run = self.cumulative(row)
        below = float(np.interp(lowest, self.frequency, run**2))
        return float(np.sqrt(max(run[-1] ** 2 - below, 0.0)))

    def largest_first(self, lowest: float = 0.0) -> list[tuple[Disturbance, float]]:
        """Disturbances with their rms above a frequency, the largest first."""
        return sorted(((row, self.rms(row, lowest)) for row in self.rows), key=lambda item: -item[1])


def band_density(rms: ArrayLike, bandwidth: float) -> Array:
    """Density of white noise whose rms behind a first-order lag of that bandwidth is `rms`: ``rms/sqrt(pi f_b/2)``."""
    if bandwidth <= 0:
        raise InputError("spectrum: bandwidth: must be above 0 Hz")
    return np.asarray(rms, float) / np.sqrt(np.pi / 2 * bandwidth)


def count_density(frequency: Array, count: float, sample_rate: float) -> Array:
    """Density of rounding to a count at a sampling rate: ``count/sqrt(12)`` rms, spread evenly to half the rate."""
    return np.where(frequency <= sample_rate / 2, count / np.sqrt(12) / np.sqrt(sample_rate / 2), 0.0)


def fluctuation_density(frequency: Array, rms: float, time_constant: float) -> Array:
    """Density of a first-order random process: ``2 rms sqrt(tau)/sqrt(1 + (2 pi f tau)^2)``; `time_constant` in s."""
    return 2 * rms * np.sqrt(time_constant) / np.sqrt(1 + (2 * np.pi * frequency * time_constant) ** 2)


def floor_density(frequency: Array, velocity: float, bands: Sequence[tuple[float, float]]) -> Array:
    """Density of the floor's displacement: velocity `velocity` (m/s rms) in each band (Hz), spread evenly over it."""
    power = np.zeros_like(frequency)
    for low, high in bands:
        power[(frequency >= low) & (frequency < high)] = velocity**2 / (high - low)
    return np.sqrt(power) / (2 * np.pi * frequency)


def frequencies(low: float, high: float, resonances: Sequence[tuple[float, float]], edges: Sequence[float]) -> Array:
    """Grid that resolves resonances, given with their damping ratios, and steps of a spectrum at `edges`, Hz."""
    grid = [np.geomspace(low, high, 3001)]
    for middle, damping in resonances:
        grid.append(middle * (1 + damping * np.sinh(np.linspace(-3, 3, 201))))
    grid += [np.array([edge * (1 - 1e-9), edge]) for edge in edges]
    joined = np.unique(np.concatenate(grid))
    return joined[(joined >= low) & (joined <= high)]
