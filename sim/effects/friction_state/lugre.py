"""LuGre and its variants in the thesis: bristles with stiffness a0 and damping a1 that slip at a rate set by the level.

    lugre             z' = v - a0 |v| z/g                         force = a0 z + a1 z'
    lugre_undamped    the same                                    force = a0 z
    lugre_causal      z' = (v - a0 |v| z/g) / (1 + a1 |v|/g)      force = a0 z + a1 z'

In the causal model the slip element carries the whole bristle force, damping included, so that it has integral
causality in bond-graph terms: it is passive at any speed, and its force never exceeds the level. Past a reversal
(direction * v < 0, where only the trial stages of a step are) its divisor is continued so that it stays positive.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan
from sim.effects.friction_state_model import FrictionStateModel, Slopes
from sim.numerics.compilation import compiled
from sim.numerics.steps import relax

CANUDAS = "Canudas de Wit, Olsson, Astrom, Lischinsky 1995, IEEE Trans. Automatic Control 40(3), pp. 419-425"

FORCE = Parameter(
    "force", "N", 1.0, 0.0, math.inf, "friction force in slow steady sliding (Coulomb)", "thesis Table 3", "level"
)
STIFFNESS = Parameter("stiffness", "N/m", 1e5, 1.0, 1e12, "stiffness a0 of the bristles", "thesis Table 3").shape(
    Scan("one", 1e3, 1e8, 11)
)
RELEASE = 1e-5
"""s: time in which bristles relax where there is no friction level, as where the contact is lifted."""

DAMPING = Parameter("damping", "N*s/m", math.sqrt(1e5), 0.0, math.inf, "damping a1 of the bristles", "thesis Table 3")


def level(axis: Axis, p: Any) -> Any:
    return p.force + 0.0 * axis.velocity


def _law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    rate = v - p.stiffness * direction * v * z / g
    return rate, p.stiffness * z + p.damping * rate


def _slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    rate_z = -p.stiffness * direction * v / g
    rate_v = 1.0 - p.stiffness * direction * z / g
    rate_g = p.stiffness * direction * v * z / (g * g)
    return rate_z, rate_v, rate_g, p.stiffness + p.damping * rate_z, p.damping * rate_v, p.damping * rate_g


def _undamped_law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    return v - p.stiffness * direction * v * z / g, p.stiffness * z


def _undamped_slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    rate_v = 1.0 - p.stiffness * direction * z / g
    return -p.stiffness * direction * v / g, rate_v, p.stiffness * direction * v * z / (g * g), p.stiffness, 0.0, 0.0


def _causal_law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    # Multiplied through by g: one division.
    damped = p.damping * direction * v
    divisor = g + damped if damped >= 0.0 else g + damped + g * (damped / g) ** 4
    rate = v * (g - p.stiffness * direction * z) / divisor
    return rate, p.stiffness * z + p.damping * rate


def _causal_slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    q = p.damping * direction * v / g
    divisor = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    steep = (1.0 if q >= 0.0 else 1.0 + 4.0 * q**3) / divisor
    stressed = p.stiffness * z / g
    rate = v * (1.0 - direction * stressed) / divisor
    rate_z = -p.stiffness * direction * v / g / divisor
    rate_v = (1.0 - direction * stressed) / divisor - rate * steep * p.damping * direction / g
    rate_g = (direction * v * stressed / divisor + rate * steep * q) / g
    return rate_z, rate_v, rate_g, p.stiffness + p.damping * rate_z, p.damping * rate_v, p.damping * rate_g


@compiled
def _relax(dx: np.ndarray, dt: np.ndarray, level: np.ndarray, stiffness: float, damping: float) -> np.ndarray:
    n = level.size
    force = np.zeros(n)
    if n > 1 and level[0] > 0.0:
        # A record that begins in motion begins in slip: the first interval is taken to have preceded it.
        sliding = level[0] + damping * abs(dx[0]) / dt[0]
        force[0] = level[0] * np.sign(dx[0]) * -np.expm1(-stiffness * abs(dx[0]) / sliding)
    for k in range(1, n):
        force[k] = relax(force[k - 1], dx[k - 1], dt[k - 1], 0.5 * (level[k] + level[k - 1]), stiffness, damping)
    return force


def spring_force(
    position: np.ndarray, time: np.ndarray, level: np.ndarray, stiffness: float, damping: float = 0.0
) -> np.ndarray:
    """Spring force a0 z of the bristles along a measured motion, N, shape (n,).

    Solves z' = (v - a0 |v| z/g) / (1 + a1 |v|/g) exactly over each interval, of constant velocity and level g (N): a0 z
    tends to g sign(v) over the length (g + a1 |v|)/a0. So no interval is too long. `damping`: a1 in the rate (causal
    law only), N*s/m; no friction where the level is not positive.

    Source: Canudas de Wit et al. 1995, IEEE Trans. Automatic Control 40(3), eq. 1-2, solved for constant velocity.
    """
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    dt = np.diff(np.ascontiguousarray(time, dtype=float))
    return _relax(dx, dt, np.ascontiguousarray(level, dtype=float), float(stiffness), float(damping))


def _along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    spring = spring_force(position, time, level, p.stiffness)
    safe = np.where(level > 0.0, level, 1.0)
    rate = np.where(level > 0.0, velocity - np.abs(velocity) * spring / safe, 0.0)
    return spring + p.damping * rate


def _undamped_along(
    position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any
) -> np.ndarray:
    return spring_force(position, time, level, p.stiffness)


def _causal_along(
    position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any
) -> np.ndarray:
    spring = spring_force(position, time, level, p.stiffness, p.damping)
    divisor = np.where(level > 0.0, level + p.damping * np.abs(velocity), 1.0)
    rate = np.where(level > 0.0, (level * velocity - np.abs(velocity) * spring) / divisor, 0.0)
    return spring + p.damping * rate


def stored(k: int, z: Any, g: Any, p: Any) -> Any:
    return 0.5 * p.stiffness * z * z


def scale(p: Any) -> float:
    return max(p.force, 1e-9) / p.stiffness


LUGRE = Effect(
    name="lugre",
    meaning="bristles that deflect before they slip, with damping of their own",
    equation="z' = v - a0 |v| z/g,  friction = a0 z + a1 z'  (a0 stiffness, a1 damping, g the friction level)",
    shows="Presliding: a spring-like force over the first micrometres after a reversal, and loops that widen with "
    "frequency. Not passive above 4 g/a1: with a constant a1, the dissipated heat is negative in fast starts.",
    dissipation="Passive below the speed 4 g/a1 only; a falling level at a higher speed returns energy.",
    source=f"{CANUDAS}, eq. 1-3; thesis (4.4)-(4.5)",
    parameters=(FORCE, STIFFNESS, DAMPING),
    coordinates=("distance_since_reversal", "direction", "acceleration"),
    level=level,
    friction_state=FrictionStateModel("lugre", _law, _slopes, _along, scale, stored=stored),
    acts_on="friction",
)

UNDAMPED = replace(
    LUGRE,
    name="lugre_undamped",
    meaning="bristles that deflect before they slip, without damping of their own",
    equation="z' = v - a0 |v| z/g,  friction = a0 z",
    shows="As lugre, but at the onset of sticking the mass oscillates at the contact's frequency, sqrt(a0/mass).",
    dissipation="Passive: the stiffness is constant, and the slip always has the direction of the force.",
    source=f"{CANUDAS}, with a1 = 0; thesis (4.7)-(4.8)",
    parameters=(FORCE, STIFFNESS),
    coordinates=("distance_since_reversal", "direction"),
    friction_state=FrictionStateModel(
        "lugre_undamped", _undamped_law, _undamped_slopes, _undamped_along, scale, stored=stored
    ),
)

CAUSAL = replace(
    LUGRE,
    name="lugre_causal",
    meaning="bristles whose slip is driven by their total force, damping included: passive at any speed",
    equation="z' = (v - a0 |v| z/g) / (1 + a1 |v|/g),  friction = a0 z + a1 z'",
    shows="As lugre in presliding; in fast starts the force stays below the level, where lugre overshoots it.",
    dissipation="Passive at any speed and level: heat = a1 z'^2 + (|v|/g) friction^2.",
    source="thesis (3.7)-(3.8), (4.9)-(4.10) with the divisor's sign and level as derived there",
    friction_state=FrictionStateModel("lugre_causal", _causal_law, _causal_slopes, _causal_along, scale, stored=stored),
)

CAUSAL_AS_RUN = replace(
    CAUSAL,
    name="lugre_causal_as_run",
    meaning="the causal model with a1 = 0, as in the listings of the thesis: identical to lugre_undamped",
    equation="z' = v - a0 |v| z/g,  friction = a0 z  (the causal law at a1 = 0)",
    shows="As lugre_undamped: its oscillation is due to the missing damping, not to the causal law.",
    source="thesis Appendix, listings of the modified dynamics (alpha1 = 0)",
    parameters=(
        FORCE,
        STIFFNESS,
        replace(DAMPING, default=0.0, fixed=True, source="thesis Appendix (the listing's alpha1 = 0)"),
    ),
    coordinates=("distance_since_reversal", "direction"),
)

EFFECTS = (LUGRE, UNDAMPED, CAUSAL, CAUSAL_AS_RUN)
