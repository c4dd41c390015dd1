"""The thesis's "modified dynamics": the slip element carries the whole bristle force, damping included, so that the
model has integral causality in bond-graph terms. It is passive at any speed, and its force never exceeds the level.
Past a reversal (direction * v < 0, where only the trial stages of a step ever are) the divisor is continued so that it
stays positive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effects.friction_state import lugre
from sim.effects.friction_state.relaxation import spring_force
from sim.library.effect import Effect
from sim.library.friction_state import FrictionStateModel


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return v, 0.0
    # Multiplied through by g: one division.
    damped = p.damping * direction * v
    below = g + damped if damped >= 0.0 else g + damped + g * (damped / g) ** 4
    rate = v * (g - p.stiffness * direction * z) / below
    return rate, p.stiffness * z + p.damping * rate


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    if g <= 0.0:
        return 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    q = p.damping * direction * v / g
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    steep = (1.0 if q >= 0.0 else 1.0 + 4.0 * q**3) / below
    stressed = p.stiffness * z / g
    rate = v * (1.0 - direction * stressed) / below
    rate_z = -p.stiffness * direction * v / g / below
    rate_v = (1.0 - direction * stressed) / below - rate * steep * p.damping * direction / g
    rate_g = (direction * v * stressed / below + rate * steep * q) / g
    return rate_z, rate_v, rate_g, p.stiffness + p.damping * rate_z, p.damping * rate_v, p.damping * rate_g


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    spring = spring_force(position, time, level, p.stiffness, p.damping)
    below = np.where(level > 0.0, level + p.damping * np.abs(velocity), 1.0)
    rate = np.where(level > 0.0, (level * velocity - np.abs(velocity) * spring) / below, 0.0)
    return spring + p.damping * rate


EFFECT = Effect(
    name="lugre_causal",
    meaning="bristles whose slip is driven by their whole force, damping included: passive at any speed",
    equation="z' = (v - a0 |v| z/g) / (1 + a1 |v|/g),  core force = a0 z + a1 z'",
    shows="As lugre in presliding; in fast starts the force stays below the level, where lugre overshoots it.",
    source="thesis (3.7)-(3.8), (4.9)-(4.10) with the divisor's sign and level as derived there",
    parameters=(lugre.FORCE, lugre.STIFFNESS, lugre.DAMPING),
    coordinates=("distance_since_reversal", "direction", "acceleration"),
    level=lugre.level,
    friction_state=FrictionStateModel("lugre_causal", law, slopes, along, lugre.scale, stored=lugre.stored),
    acts_on="friction",
)
