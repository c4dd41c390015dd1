"""Presliding: a force that stays below break-away moves the mass by micrometres (thesis 4.2.1, Figures 35 to 37)."""

from dataclasses import dataclass

import numpy as np

from sim.experiments.friction_models import MOST_STEPS, Friction
from sim.integration import drive
from sim.integration.simulate import Simulation, simulate

SHARE = 0.95
"""Peak of the force, as a share of the static friction (thesis: 1.425 N of 1.5 N)."""


@dataclass(frozen=True)
class Presliding:
    """Positions in m."""

    simulation: Simulation
    position_max: float
    position_min: float
    position_end: float

    def features(self) -> dict[str, tuple[float, str]]:
        return {
            "position_max": (self.position_max, "m"),
            "position_min": (self.position_min, "m"),
            "position_end": (self.position_end, "m"),
        }


def presliding(friction: Friction, core: str, mass: float = 1.0, tolerance: float = 1e-10) -> Presliding:
    """Force 0 -> 0.95 Fs at 1 s -> -0.95 Fs at 3 s -> 0 at 4 s, from rest; mass in kg."""
    peak = SHARE * friction.breakaway
    time = np.linspace(0.0, 4.0, 8001)
    push = drive.force([0.0, 1.0, 3.0, 4.0], [0.0, peak, -peak, 0.0])
    model = friction.model(core)
    run = simulate(model, push, time, mass=mass, tolerance=tolerance, energy=True, most_steps=MOST_STEPS)
    return Presliding(
        run,
        position_max=extremum(run.time, run.position, run.velocity, +1.0),
        position_min=extremum(run.time, run.position, run.velocity, -1.0),
        position_end=float(run.position[-1]),
    )


def extremum(time: np.ndarray, value: np.ndarray, rate: np.ndarray, sign: float) -> float:
    """Largest (sign +1) or smallest (-1) value between samples, by cubic Hermite interpolation with the known rate."""
    from scipy.interpolate import CubicHermiteSpline

    at = int(np.argmax(sign * value))
    near, best = slice(max(at - 1, 0), at + 2), float(value[at])
    spline = CubicHermiteSpline(time[near], value[near], rate[near])
    for place in spline.derivative().roots(extrapolate=False):
        there = float(spline(place))
        rise = abs(np.diff(value[near]))[np.searchsorted(time[near], place) - 1]
        # Where the samples are too far apart for the rates to mean anything, the sample itself is kept.
        if 0.0 < sign * (there - best) <= rise:
            best = there
    return best
