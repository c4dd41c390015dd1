"""Hysteresis: friction force against an imposed sinusoidal velocity (thesis 4.2.2, Figure 38).

v = v0 + 1 mm/s sin(w t), from an unstressed bristle, for two periods; features are evaluated in the second.
"""

import math
from dataclasses import dataclass

import numpy as np

from sim.experiments.friction_models import MOST_STEPS, Friction
from sim.integration import drive
from sim.integration.simulate import Simulation, simulate

AMPLITUDE = 1e-3
LEVEL = 1e-3
"""Velocity at which the loop's width is read, m/s."""
CASES = {f"w{w}_v0_{name}": (float(w), mean) for w in (25, 10, 1) for name, mean in (("1.5mm_s", 1.5e-3), ("0", 0.0))}
"""Case name -> frequency, rad/s, and mean velocity, m/s."""


@dataclass(frozen=True)
class Hysteresis:
    """Peak force, N, and width of the loop at 1 mm/s, N (None where that velocity is not crossed)."""

    simulation: Simulation
    frequency: float
    peak_force: float
    width_at_1mm_s: float | None

    def features(self) -> dict[str, tuple[float, str] | None]:
        width = None if self.width_at_1mm_s is None else (self.width_at_1mm_s, "N")
        return {"peak_force": (self.peak_force, "N"), "width_at_1mm_s": width}


def hysteresis(friction: Friction, core: str, case: str, tolerance: float = 1e-10) -> Hysteresis:
    """The loop of one case of `CASES`; the motion is imposed, so there is no mass in it."""
    frequency, mean = CASES[case]
    period = 2.0 * math.pi / frequency
    time = np.linspace(0.0, 2.0 * period, 16001)
    crossings = _crossings(frequency, mean)
    time = np.unique(np.concatenate([time, crossings]))
    motion = drive.sinusoidal_velocity(AMPLITUDE, frequency, mean)
    run = simulate(friction.model(core), motion, time, tolerance=tolerance, energy=True, most_steps=MOST_STEPS)
    last = run.time >= period
    width = None
    if crossings.size == 2:
        down, up = run.friction[np.searchsorted(run.time, crossings)]
        width = float(abs(down - up))
    return Hysteresis(run, frequency, float(_peak(run.friction[last])), width)


def _crossings(frequency: float, mean: float) -> np.ndarray:
    """The two instants of the second period at which the velocity is `LEVEL`: falling, then rising."""
    sine = (LEVEL - mean) / AMPLITUDE
    if not -1.0 < sine < 1.0:
        return np.empty(0)
    rising = math.asin(sine) % (2.0 * math.pi)
    falling = (math.pi - math.asin(sine)) % (2.0 * math.pi)
    return np.sort((2.0 * math.pi + np.array([falling, rising])) / frequency)


def _peak(values: np.ndarray) -> float:
    """Largest value, by the parabola through the largest sample and its neighbours."""
    at = int(np.argmax(values))
    if not 0 < at < values.size - 1:
        return float(values[at])
    before, here, after = values[at - 1 : at + 2]
    bend = before - 2.0 * here + after
    return float(here if bend >= 0.0 else here - (after - before) ** 2 / (8.0 * bend))
