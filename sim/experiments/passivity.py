"""Passivity of the friction models: motions in which a model returns more energy than it has received.

Heat is the work on the friction state model less the energy it stores: it never decreases in a passive model. Two
imposed motions:

- `start`: a start from near break-away, v = 0.2 m/s (1 - cos(2 pi 500 Hz t))/2 for half a cycle, bristles stretched to
  0.95 Fs. The level falls with the Stribeck curve faster than the bristles can relax.
- `tip`: a tip's motion, v = 0.2 m/s sin(2 pi 5 kHz t), ten cycles from unstressed bristles.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

from sim.effects.catalogue import Model
from sim.experiments.friction_models import MOST_STEPS, Friction
from sim.integration.drive import Drive
from sim.integration.simulate import Simulation, simulate

SPEED = 0.2
START_FREQUENCY = 2.0 * math.pi * 500.0
TIP_FREQUENCY = 2.0 * math.pi * 5000.0
SHARE = 0.95
MOTIONS = ("start", "tip")


@dataclass(frozen=True)
class Audit:
    """Heat and force of one imposed motion."""

    simulation: Simulation  # the run
    heat: np.ndarray  # heat since the start, J, shape (n,)
    least_heat: float  # its smallest value, J: negative where the model has returned energy
    peak_force: float  # largest friction force, N; in the last cycle for `tip`, by when the motion has settled
    # energy received by each element of the bond graph since the start, J, (n,): spring and damper of the bristles, and
    # the slip element, which takes what is left; one of them that falls, other than the spring, is not passive
    elements: dict[str, np.ndarray]

    def features(self) -> dict[str, tuple[float, str]]:
        return {
            "heat": (float(self.heat[-1]), "J"),
            "least_heat": (self.least_heat, "J"),
            "peak_force": (self.peak_force, "N"),
            "least_slip_heat": (float(self.elements["slip"].min()), "J"),
        }


def passive_below(friction: Friction) -> float:
    """Speed up to which model 1 is passive whatever its stretch, 4 a0 g/a1 at the Coulomb level (a0 g = Fc), m/s."""
    return 4.0 * friction.coulomb / friction.bristle_damping if friction.bristle_damping > 0.0 else math.inf


def audit(friction: Friction, core: str, motion: str, tolerance: float = 1e-10) -> Audit:
    """The audit of one model in the motion `start` or `tip`; see the head of this file."""
    model = friction.model(core)
    zero = np.zeros(1)
    if motion == "start":
        # v' = (V w/2) sin(w t), as a cosine.
        wave = (0.5 * SPEED * START_FREQUENCY, START_FREQUENCY, -0.5 * math.pi)
        end, bristle = math.pi / START_FREQUENCY, SHARE * friction.breakaway / friction.bristle_stiffness
    else:
        wave = (SPEED * TIP_FREQUENCY, TIP_FREQUENCY, 0.0)
        end, bristle = 10.0 * 2.0 * math.pi / TIP_FREQUENCY, 0.0
    imposed = Drive(zero, zero, zero, wave=wave, prescribes=True)
    time = np.linspace(0.0, end, 8001)
    options: dict[str, Any] = {"tolerance": tolerance, "energy": True, "most_steps": MOST_STEPS}
    run = simulate(model, imposed, time, bristle=[bristle], **options)
    heat = run.core_work - (run.stored - run.stored[0])
    judged = run.friction if motion == "start" else run.friction[time >= 0.9 * end]
    return Audit(run, heat, float(heat.min()), float(np.abs(judged).max()), _elements(run, model))


def _elements(run: Simulation, model: Model) -> dict[str, np.ndarray]:
    """The spring a0 z and the damper a1 z' of the bristles, and the rest of the work on the friction model, J."""
    damping = model.parameters().get(f"{model.names[0]}.damping", 0.0)
    rate = np.gradient(run.bristle[:, 0], run.time, edge_order=2)
    spring = run.stored - run.stored[0]
    damper = cumulative_trapezoid(damping * rate**2, run.time, initial=0.0)
    return {"spring": spring, "damper": damper, "slip": run.core_work - spring - damper}
