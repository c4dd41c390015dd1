"""Stick-slip: a mass on a spring pulled at constant velocity (thesis 4.2.3, Figures 39 to 42)."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from sim.effects.catalogue import Model
from sim.experiments.friction_models import MOST_STEPS, Friction
from sim.experiments.presliding import extremum
from sim.integration import drive
from sim.integration.simulate import Simulation, simulate

STIFFNESS = 2.0
PULL = 0.1
SHOWN = 20.0
HORIZON = 40.0
"""s: the thesis's figures end at 20 s, where only two slips have begun; periods are read from a longer run."""
SLIPPING = 0.02
STUCK = 0.002
"""m/s: a slip begins when the velocity passes the first, and the mass sticks again once it is below the second."""


@dataclass(frozen=True)
class StickSlip:
    """Times in s, position m, velocity m/s, forces N; None where the mass does not slip (again) within the horizon."""

    simulation: Simulation
    slips: np.ndarray
    period: float | None
    jump: float | None
    peak_velocity: float
    peak_force: float
    peak_spring_force: float

    def features(self) -> dict[str, tuple[float, str] | None]:
        first = (float(self.slips[0]), "s") if self.slips.size else None
        return {
            "first_slip": first,
            "period": None if self.period is None else (self.period, "s"),
            "jump": None if self.jump is None else (self.jump, "m"),
            "peak_velocity": (self.peak_velocity, "m/s"),
            "peak_force": (self.peak_force, "N"),
            "peak_spring_force": (self.peak_spring_force, "N"),
        }


def stick_slip(friction: Friction, core: str, mass: float = 1.0, tolerance: float = 1e-10) -> StickSlip:
    """A mass (kg) pulled through a spring of 2 N/m at 0.1 m/s, from rest, for 20 s (40 s where a period is read)."""
    time = np.linspace(0.0, HORIZON, 160001)
    pull = drive.pulled_spring([0.0, HORIZON], [0.0, PULL * HORIZON], STIFFNESS)
    model = friction.model(core)
    options: dict[str, Any] = {"mass": mass, "tolerance": tolerance, "energy": True, "most_steps": MOST_STEPS}
    run = _resolved(model, pull, time, options)
    slips = slip_times(run)
    shown = run.time <= SHOWN
    acceleration = (run.drive - run.friction) / mass
    t, v = run.time[shown], run.velocity[shown]
    return StickSlip(
        run,
        slips,
        period=float(np.mean(np.diff(slips[1:]))) if slips.size > 2 else None,
        jump=_jump(run, slips),
        peak_velocity=extremum(t, v, acceleration[shown], +1.0),
        peak_force=float(run.friction[shown].max()),
        peak_spring_force=float(run.drive[shown].max()),
    )


def _resolved(model: Model, pull: drive.Drive, time: np.ndarray, options: Any) -> Simulation:
    """A run with output that is dense enough to resolve its peaks and slips, for any mass."""
    run = simulate(model, pull, time, **options)
    for _ in range(8):
        at = [int(np.searchsorted(run.time, slip) - 1) for slip in slip_times(run)]
        coarse = [k for k in at if run.time[k + 1] - run.time[k] > 1e-3 * time[1]]
        for values in (run.velocity, run.friction, run.drive):
            k = int(np.argmax(np.where(run.time <= SHOWN, values, -np.inf)))
            neighbours = values[[max(k - 1, 0), min(k + 1, values.size - 1)]]
            if np.abs(values[k] - neighbours).max() > 1e-5 * abs(values[k]):
                coarse.append(k)
        if not coarse:
            break
        last = run.time.size - 1
        windows = [np.linspace(run.time[max(k - 1, 0)], run.time[min(k + 1, last)], 201) for k in coarse]
        run = simulate(model, pull, np.unique(np.concatenate([run.time, *windows])), **options)
    return run


def slip_times(run: Simulation) -> np.ndarray:
    """Times at which the velocity passes 0.02 m/s after a stick, s, shape (slips,)."""
    times = []
    stuck = True
    for k in np.flatnonzero((run.velocity[1:] >= SLIPPING) != (run.velocity[:-1] >= SLIPPING)):
        low, high = run.velocity[k], run.velocity[k + 1]
        if high >= SLIPPING and stuck:
            times.append(run.time[k] + (SLIPPING - low) / (high - low) * (run.time[k + 1] - run.time[k]))
            stuck = False
        elif high < SLIPPING:
            later = run.velocity[k + 1 :]
            back = np.flatnonzero(later >= SLIPPING)
            stuck = bool(np.any(np.abs(later[: back[0] if back.size else later.size]) < STUCK))
    return np.array(times)


def _jump(run: Simulation, slips: np.ndarray) -> float | None:
    """Position gained from one stick to the next: between the middles of the two sticks about the second slip."""
    if slips.size < 3:
        return None
    middle = [0.5 * (a + b) for a, b in pairwise(slips)]
    stuck = np.interp(middle, run.time, run.position)
    return float(np.mean(np.diff(stuck)))
