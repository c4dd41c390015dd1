"""The elasto-plastic model of Dupont, Hayward, Armstrong and Altpeter: bristles that are purely elastic up to a
break-away stretch.

    z' = v (1 - alpha(z, v) a0 |z|/g),    friction = a0 z + a1 z',    z_s = g/a0

alpha = 0 where the motion unloads the bristles and up to |z| = breakaway z_s, 1 from z_s on, and between them half of
1 + sin. So a vibration below the break-away stretch moves nothing, where Dahl's and LuGre's models drift.
"""

import math
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter
from sim.effects.friction_state.lugre import DAMPING, FORCE, RELEASE, STIFFNESS, level, scale, stored
from sim.effects.friction_state_model import FrictionStateModel, Slopes
from sim.numerics.compilation import compiled
from sim.numerics.steps import elasto_plastic_step


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    u = p.stiffness * direction * z / g
    alpha = 0.0
    if u >= 1.0:
        alpha = 1.0
    elif u > p.breakaway:
        alpha = 0.5 + 0.5 * math.sin(math.pi * (u - 0.5 * (1.0 + p.breakaway)) / (1.0 - p.breakaway))
    rate = v * (1.0 - alpha * u)
    return rate, p.stiffness * z + p.damping * rate


def slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    u = p.stiffness * direction * z / g
    alpha, rise = 0.0, 0.0
    if u >= 1.0:
        alpha = 1.0
    elif u > p.breakaway:
        turn = math.pi / (1.0 - p.breakaway)
        angle = turn * (u - 0.5 * (1.0 + p.breakaway))
        alpha, rise = 0.5 + 0.5 * math.sin(angle), 0.5 * turn * math.cos(angle)
    rate_v = 1.0 - alpha * u
    by_u = -v * (alpha + rise * u)
    rate_z, rate_g = by_u * p.stiffness * direction / g, -by_u * u / g
    return rate_z, rate_v, rate_g, p.stiffness + p.damping * rate_z, p.damping * rate_v, p.damping * rate_g


@compiled
def _forces(
    dx: np.ndarray, velocity: np.ndarray, level: np.ndarray, stiffness: float, damping: float, breakaway: float
) -> np.ndarray:
    out = np.zeros(level.size)
    z = 0.0
    for i in range(level.size):
        # The first row: take the first interval to have been going on before it.
        step = dx[max(i - 1, 0)] if level.size > 1 else 0.0
        z, out[i] = elasto_plastic_step(z, step, velocity[i], level[i], stiffness, damping, breakaway)
    return out


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    motion = (np.ascontiguousarray(a, dtype=float) for a in (np.diff(position), velocity, level))
    return _forces(*motion, float(p.stiffness), float(p.damping), float(p.breakaway))


EFFECT = Effect(
    name="elasto_plastic",
    meaning="bristles that are purely elastic up to a break-away stretch, then slip along a smooth curve",
    equation="z' = v (1 - alpha a0 |z|/g),  friction = a0 z + a1 z';  alpha = 0 up to |z| = breakaway g/a0 and where "
    "the motion unloads, 1 from g/a0 on, (1 + sin)/2 between",
    shows="As lugre after a reversal, but small vibrations cause no drift: below break-away the bristles are elastic.",
    dissipation="Passive at any speed while the level is constant or rises; while it falls, below the speed 4 g/a1.",
    source="Dupont, Hayward, Armstrong, Altpeter, IEEE Trans. Automatic Control 47 (2002) 787, eq. 12-17",
    parameters=(
        FORCE,
        STIFFNESS,
        DAMPING,
        Parameter(
            "breakaway",
            "1",
            0.7,
            0.0,
            0.98,
            "break-away stretch over the stretch in steady sliding",
            "Dupont 2002: below one; about 0.7 in the examples",
        ).shape(natural="both"),
    ),
    coordinates=("distance_since_reversal", "direction", "acceleration"),
    level=level,
    friction_state=FrictionStateModel("elasto_plastic", law, slopes, along, scale, stored=stored),
    acts_on="friction",
)
