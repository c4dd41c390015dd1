"""Dahl: bristles that yield along a smooth curve, without rate effects."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter
from sim.effects.friction_state.lugre import FORCE, RELEASE, STIFFNESS, level, scale, stored
from sim.effects.friction_state_model import FrictionStateModel, Slopes
from sim.numerics.compilation import compiled
from sim.numerics.steps import dahl_step


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    left = 1.0 - p.stiffness * direction * z / g
    if left <= 0.0:
        # Only where the level has just fallen below the stress held: slip back onto it.
        return v * left, p.stiffness * z
    return v * left**p.exponent, p.stiffness * z


def slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    left = 1.0 - p.stiffness * direction * z / g
    if left <= 0.0:
        power, steep = left, 1.0
    else:
        power, steep = left**p.exponent, p.exponent * left ** (p.exponent - 1.0)
    rate_z = -v * steep * p.stiffness * direction / g
    rate_g = v * steep * p.stiffness * direction * z / (g * g)
    return rate_z, power, rate_g, p.stiffness, 0.0, 0.0


@compiled
def _forces(dx: np.ndarray, level: np.ndarray, stiffness: float, exponent: float) -> np.ndarray:
    force = np.zeros(level.size)
    held = 0.0
    for k in range(level.size):
        # The first row: take the first interval to have been going on before it.
        before = max(k - 1, 0)
        step = dx[before] if level.size > 1 else 0.0
        held, force[k] = dahl_step(held, step, level[before], level[k], stiffness, exponent)
    return force


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    return _forces(dx, np.ascontiguousarray(level, dtype=float), float(p.stiffness), float(p.exponent))


EFFECT = Effect(
    name="dahl",
    meaning="bristles that deflect before they slip; the force depends on the path alone, not on the speed",
    equation="z' = v (1 - a0 z sign(v)/g)^i,  friction = a0 z",
    shows="A spring-like force over the first micrometres after a reversal, in loops that do not change with speed.",
    dissipation="Passive: the stiffness is constant, and the slip always has the direction of the force.",
    source="Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1; thesis 3.2.2",
    parameters=(
        replace(FORCE, meaning="friction force in steady sliding"),
        STIFFNESS,
        Parameter(
            "exponent", "1", 1.0, 0.5, 4.0, "shape i of the yield curve", "Dahl 1968: 1 for most", "shape", fixed=True
        ),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel("dahl", law, slopes, along, scale, stored=stored),
    acts_on="friction",
)
