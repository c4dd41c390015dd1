"""Limit cycles of stick-slip against speed and stiffness (thesis 3.1.3, Figures 20 to 22): a pin on a flat.

A mass on a spring, pulled at constant velocity, with static friction that rises with the dwell time by Kato's law. The
first break-away, after a long rest, is the highest; then a cycle repeats with the break-away force of its own dwell,
and becomes smaller as the speed rises, until the critical speed at which the mass slides steadily. Without viscous
friction and for a slide that renews the contacts the amplitude A of the spring force follows from the dwell 2A/(k v):

    A = (Fs - Fc) (1 - exp(-gamma (2 A/(k v))^m))

Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, section 2.3; Kato et al. (1972).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.effects.catalogue import Model, compose
from sim.experiments.friction_models import MOST_STEPS, Friction
from sim.integration import drive
from sim.integration.simulate import Simulation, simulate

STIFFNESSES = {"2N_m": 2.0, "20N_m": 20.0, "200N_m": 200.0}
"""Of the pulling spring, N/m; the thesis's is 2."""
SPEEDS = tuple(float(v) for v in np.geomspace(2e-3, 0.5, 8))
"""m/s."""
SHOWN = (SPEEDS[3], SPEEDS[5])
"""Of the two runs of Figure 21."""
MEMORY_LENGTH = 2e-4
"""m: far longer than the presliding displacement, which shall not renew the contacts, and shorter than a slip."""
CYCLES, DECAYS, ROWS = 12, 10.0, 8001
"""Cycles of a run, time constants of the viscous friction in which the start has decayed, and rows."""
STICKS = 0.02
"""Peak-to-peak spring force over 2 (Fs - Fc), below which the mass slides steadily."""
AT_REST = 0.1
"""Speed over that of the pull, below which the mass is at rest."""
HALVINGS = 7


@dataclass(frozen=True)
class Cycle:
    """A run at one speed."""

    simulation: Simulation  # the run
    first: float  # friction force at the first break-away, N
    top: float  # largest friction force in the limit cycle, N
    size: float  # peak to peak of the spring force in it, N
    dwell: float  # longest time at rest in it, s


@dataclass(frozen=True)
class LimitCycles:
    """Limit cycles over the speed with one spring."""

    stiffness: float  # N/m
    cycles: tuple[Cycle, ...]  # at `SPEEDS`
    critical: float | None  # speed above which the mass slides steadily, m/s; None where it sticks at all speeds

    @property
    def sizes(self) -> np.ndarray:
        """Peak to peak of the spring force, N, shape (speeds,)."""
        return np.array([cycle.size for cycle in self.cycles])

    def features(self) -> dict[str, tuple[float, str] | None]:
        return {
            "first_break_away": (self.cycles[0].first, "N"),
            "size_at_least_speed": (float(self.sizes[0]), "N"),
            "size_at_most_speed": (float(self.sizes[-1]), "N"),
            "critical_speed": None if self.critical is None else (self.critical, "m/s"),
        }


def ageing_model(friction: Friction, core: str) -> Model:
    """The friction model with strengthening at rest by Kato's law in place of the Stribeck curve."""
    model = friction.model(core)
    values = {key: value for key, value in model.parameters().items() if not key.startswith("stribeck.")}
    values["dwell_strengthening:kato.force"] = friction.breakaway - friction.coulomb
    values["dwell_strengthening:kato.memory_length"] = MEMORY_LENGTH
    return compose([core, "dwell_strengthening:kato", "viscous"], values)


def cycle(friction: Friction, core: str, speed: float, stiffness: float, mass: float, tolerance: float = 1e-8) -> Cycle:
    """A pull at one speed from rest, until the first break-away and some cycles later."""
    rise = friction.breakaway - friction.coulomb
    wind = 2.0 * friction.breakaway / (stiffness * speed)
    ends = wind + CYCLES * (2.0 * rise / (stiffness * speed) + 2.0 * np.pi * np.sqrt(mass / stiffness))
    if friction.viscous > 0.0:
        ends = max(ends, wind + DECAYS * 2.0 * mass / friction.viscous)
    time = np.linspace(0.0, ends, ROWS)
    pull = drive.pulled_spring([0.0, ends], [0.0, speed * ends], stiffness)
    options: dict[str, Any] = {"mass": mass, "tolerance": tolerance, "most_steps": MOST_STEPS}
    run = simulate(ageing_model(friction, core), pull, time, **options)
    late = time > 0.7 * ends
    moving = np.flatnonzero(run.velocity[late] >= AT_REST * speed)
    dwell = float(np.diff(moving).max(initial=1) - 1) * float(time[1] - time[0])
    return Cycle(run, float(run.friction.max()), float(run.friction[late].max()), float(np.ptp(run.drive[late])), dwell)


def limit_cycles(friction: Friction, core: str, stiffness: float, mass: float = 1.0) -> LimitCycles:
    """Limit cycles at each of `SPEEDS`, and the critical speed by bisection; stiffness in N/m, mass in kg."""
    cycles = tuple(cycle(friction, core, speed, stiffness, mass) for speed in SPEEDS)
    still = 2.0 * STICKS * (friction.breakaway - friction.coulomb)
    slides = [k for k, one in enumerate(cycles) if one.size < still]
    critical = None
    if slides and slides[0] > 0:
        low, high = SPEEDS[slides[0] - 1], SPEEDS[slides[0]]
        for _ in range(HALVINGS):
            middle = float(np.sqrt(low * high))
            low, high = (low, middle) if cycle(friction, core, middle, stiffness, mass).size < still else (middle, high)
        critical = float(np.sqrt(low * high))
    return LimitCycles(stiffness, cycles, critical)
