"""LuGre without bristle damping: the thesis's second model."""

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
    return v - p.stiffness * direction * v * z / g, p.stiffness * z


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    if g <= 0.0:
        return 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    rate_v = 1.0 - p.stiffness * direction * z / g
    return -p.stiffness * direction * v / g, rate_v, p.stiffness * direction * v * z / (g * g), p.stiffness, 0.0, 0.0


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    return spring_force(position, time, level, p.stiffness)


EFFECT = Effect(
    name="lugre_undamped",
    meaning="bristles that bend before they slip, without damping of their own",
    equation="z' = v - a0 |v| z/g,  core force = a0 z",
    shows="As lugre, but a landing rings on at the contact's own frequency, sqrt(a0/mass).",
    source=f"{lugre.CANUDAS}, with a1 = 0; thesis (4.7)-(4.8)",
    parameters=(lugre.FORCE, lugre.STIFFNESS),
    coordinates=("distance_since_reversal", "direction"),
    level=lugre.level,
    friction_state=FrictionStateModel("lugre_undamped", law, slopes, along, lugre.scale, stored=lugre.stored),
    acts_on="friction",
)
