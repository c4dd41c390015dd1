"""The thesis's sensors: filter, noise, quantisation, range. One reading a sample."""

from __future__ import annotations

import math

import numpy as np

from designcalc.errors.sensors import filtered_noise
from sim.stage.machine import Sensors


class Interferometer:
    """Position rounded to a count of 0.6 nm."""

    def __init__(self, sensors: Sensors, period: float) -> None:
        self.count = sensors.interferometer_count

    def read(self, position: float) -> float:
        """m; `position` is the true one."""
        return round(position / self.count) * self.count


class Lvdt:
    """Position with the largest linearity error of its range added, rounded to its count."""

    def __init__(self, sensors: Sensors, period: float) -> None:
        self.count, self.error = sensors.lvdt_count, sensors.lvdt_linearity_error

    def read(self, position: float) -> float:
        """m; `position` is the true one."""
        return round((position + self.error) / self.count) * self.count


class FilteredProbe:
    """The capacitive probe about a target, behind its RC filter, gain and converter.

    The noise that the filter leaves is sigma sqrt(f_RC/f_probe) rms, of the white noise sigma in the probe's bandwidth;
    beyond its range, a 25th of the probe's own, the reading stays at its end.

    Args:
        sensors: the design's.
        period: between readings, s, short compared with the filter's time.
        target: middle of its range, m.
        seed: of the noise.
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
