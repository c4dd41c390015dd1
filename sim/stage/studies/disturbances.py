"""Disturbances of a position loop: vibration of the floor, noise of the amplifiers, refractive index of the air.

The floor moves the held stage against its base by the response of the small-signal suspension (tip and sticking pads),
which is added to the simulated position; voltage noise enters the amplifiers; the index of the air falsifies what an
interferometer reads.
"""

from __future__ import annotations

import math

import numpy as np

from designcalc.errors.dynamic_budget import base_response
from sim.stage.machine import Piezo, Surroundings

LINES = 24
"""Sine waves in each band of the floor's velocity."""


class Disturbances:
    """Samples of all disturbances, one a period of the controller.

    Args:
        surroundings: of the machine; None is a quiet place.
        piezo: whose amplifiers are noisy.
        period: of the controller, s.
        step: of the integration, s.
        seed: of the random numbers.
    """

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
