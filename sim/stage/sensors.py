"""The thesis's sensors (filter, noise, quantisation, range), and what disturbs a loop; one reading a sample."""

import math

import numpy as np

from designcalc.errors.dynamic_budget import base_response
from designcalc.errors.sensors import filtered_noise
from sim.stage.machine import Piezo, Sensors, Surroundings


class Interferometer:
    """Position rounded to a count of 0.6 nm."""

    share = 1.0  # taken up of what it sees in a period

    def __init__(self, sensors: Sensors, period: float) -> None:
        self.count = sensors.interferometer_count

    def read(self, position: float) -> float:
        """m; `position` is the true one."""
        return round(position / self.count) * self.count


class Lvdt:
    """Position with the largest linearity error of its range added, rounded to its count."""

    share = 1.0

    def __init__(self, sensors: Sensors, period: float) -> None:
        self.count, self.error = sensors.lvdt_count, sensors.lvdt_linearity_error

    def read(self, position: float) -> float:
        """m; `position` is the true one."""
        return round((position + self.error) / self.count) * self.count


class FilteredProbe:
    """The capacitive probe about a target, behind its RC filter, gain and converter.

    The noise that the filter leaves is sigma sqrt(f_RC/f_probe) rms, of the white noise sigma in the probe's bandwidth;
    beyond its range, a 25th of the probe's own about `target`, m, the reading stays at its end. The `period` between
    readings, s, is short compared with the filter's time.
    """

    def __init__(self, sensors: Sensors, period: float, target: float, seed: int = 1) -> None:
        self.count = sensors.filtered_count
        self.range = sensors.filtered_range
        self.target = target
        self.share = 1.0 - math.exp(-2.0 * math.pi * sensors.filter_frequency * period)
        left = float(filtered_noise(sensors.probe_noise, sensors.probe_bandwidth, sensors.filter_frequency))
        # A first-order lag fed with independent readings of deviation s leaves s sqrt(share/(2 - share)).
        self.noise = left * math.sqrt((2.0 - self.share) / self.share)
        self.random = np.random.default_rng(seed)
        self.filtered: float | None = None

    def read(self, position: float) -> float:
        """m; `position` is the true one."""
        seen = position - self.target + self.noise * float(self.random.standard_normal())
        if self.filtered is None:
            self.filtered = seen
        self.filtered += self.share * (seen - self.filtered)
        half = 0.5 * self.range
        shown = min(max(self.filtered, -half), half)
        return self.target + round(shown / self.count) * self.count


LINES = 24
"""Sine waves in each band of the floor's velocity."""


class Disturbances:
    """Samples of all disturbances, one a `period` of the controller, s; no surroundings are a quiet place."""

    def __init__(
        self, surroundings: Surroundings | None, piezo: Piezo, period: float, step: float, seed: int = 2
    ) -> None:
        self.surroundings, self.period = surroundings, period
        self.random = np.random.default_rng(seed)
        self.index = 0.0
        self.deviation = 0.0
        if surroundings is None:
            return
        # A first-order lag fed with independent values of deviation s leaves s sqrt(share/(2 - share)).
        share = 1.0 - math.exp(-2.0 * math.pi * piezo.bandwidth * step)
        self.deviation = surroundings.amplifier_noise * math.sqrt((2.0 - share) / share)
        self.kept = math.exp(-period / surroundings.air_time)
        self.waves = self._waves(surroundings)

    def _waves(self, surroundings: Surroundings) -> np.ndarray:
        """Angular frequency (rad/s), amplitude (m) and phase of the waves of the stage against its base, (3, n)."""
        edges = [np.linspace(low, high, LINES + 1) for low, high in surroundings.floor_bands]
        frequency = np.concatenate([self.random.uniform(one[:-1], one[1:]) for one in edges])
        # Each wave has an equal share of the power of its band: v^2 = lines x amplitude^2/2.
        velocity = surroundings.floor_velocity * math.sqrt(2.0 / LINES)
        response = base_response(frequency, surroundings.held_resonance, surroundings.held_damping)
        amplitude = velocity / (2.0 * math.pi * frequency) * np.abs(response)
        phase = self.random.uniform(0.0, 2.0 * math.pi, frequency.size)
        return np.stack([2.0 * math.pi * frequency, amplitude, phase])

    def floor(self, time: np.ndarray) -> np.ndarray:
        """Motion of the held stage against its base by the floor, m, at times (n,), s."""
        if self.surroundings is None:
            return np.zeros_like(time)
        rate, amplitude, phase = self.waves
        return np.sin(time[:, None] * rate + phase) @ amplitude

    def air(self) -> float:
        """Error of the next reading of an interferometer, m: a first-order random process that begins at zero."""
        if self.surroundings is None:
            return 0.0
        fresh = self.surroundings.air_error * math.sqrt(1.0 - self.kept**2)
        self.index = self.kept * self.index + fresh * float(self.random.standard_normal())
        return self.index

    def disturbed(self, volts: np.ndarray) -> np.ndarray:
        """Voltages of each step with the noise that leaves its rms behind the amplifiers' bandwidth."""
        if self.deviation == 0.0:
            return volts
        return volts + self.deviation * self.random.standard_normal(volts.shape)
