"""LuGre: bristles with stiffness and damping, slipping at a rate set by the level (the thesis's first model)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.effects.friction_state.relaxation import spring_force
from sim.library.effect import Axis, Effect, Parameter, Scan
from sim.library.friction_state import FrictionStateModel

CANUDAS = "Canudas de Wit, Olsson, Astrom, Lischinsky 1995, IEEE Trans. Automatic Control 40(3), pp. 419-425"

FORCE = Parameter(
    "force", "N", 1.0, 0.0, math.inf, "friction force in slow steady sliding (Coulomb)", "thesis Table 3", "level"
)
STIFFNESS = Parameter(
    "stiffness",
    "N/m",
    1e5,
    1.0,
    1e12,
    "stiffness a0 of the bristles",
    "thesis Table 3",
    "shape",
    Scan("one", 1e3, 1e8, 11),
)
DAMPING = Parameter("damping", "N*s/m", math.sqrt(1e5), 0.0, math.inf, "damping a1 of the bristles", "thesis Table 3")


def level(axis: Axis, p: Any) -> Any:
    return p.force + 0.0 * axis.velocity


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return v, 0.0
    rate = v - p.stiffness * direction * v * z / g
    return rate, p.stiffness * z + p.damping * rate


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    if g <= 0.0:
        return 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    rate_z = -p.stiffness * direction * v / g
    rate_v = 1.0 - p.stiffness * direction * z / g
    rate_g = p.stiffness * direction * v * z / (g * g)
    return rate_z, rate_v, rate_g, p.stiffness + p.damping * rate_z, p.damping * rate_v, p.damping * rate_g


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    spring = spring_force(position, time, level, p.stiffness)
    safe = np.where(level > 0.0, level, 1.0)
    rate = np.where(level > 0.0, velocity - np.abs(velocity) * spring / safe, 0.0)
    return spring + p.damping * rate


def stored(k: int, z: Any, g: Any, p: Any) -> Any:
    return 0.5 * p.stiffness * z * z


def scale(p: Any) -> float:
    return max(p.force, 1e-9) / p.stiffness


EFFECT = Effect(
    name="lugre",
    meaning="bristles that bend before they slip, with damping of their own",
    equation="z' = v - a0 |v| z/g,  core force = a0 z + a1 z'  (a0 stiffness, a1 damping, g the friction level)",
    shows="Presliding: a spring-like force over the first micrometres after a reversal, and loops that widen with "
    "frequency. Not passive above 4 g/a1: at a constant a1 fast starts give negative heat.",
    source=f"{CANUDAS}, eq. 1-3; thesis (4.4)-(4.5)",
    parameters=(FORCE, STIFFNESS, DAMPING),
    coordinates=("distance_since_reversal", "direction", "acceleration"),
    level=level,
    friction_state=FrictionStateModel("lugre", law, slopes, along, scale, stored=stored),
    acts_on="friction",
)
