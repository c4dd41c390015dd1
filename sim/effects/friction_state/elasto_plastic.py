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
from sim.effects.friction_state_model import FrictionStateModel
from sim.numerics.compilation import compiled

SUBSTEP = 0.05
"""Largest displacement over z_s of one Runge-Kutta step along a record."""


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


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
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
def _slope(u: float, breakaway: float) -> float:
    """du/dxi of the stretch u over z_s along a displacement xi over z_s, in the direction of the motion."""
    if u >= 1.0:
        return 1.0 - u
    if u <= breakaway:
        return 1.0
    return 1.0 - u * (0.5 + 0.5 * math.sin(math.pi * (u - 0.5 * (1.0 + breakaway)) / (1.0 - breakaway)))


@compiled
def _stretches(dx: np.ndarray, level: np.ndarray, stiffness: float, breakaway: float) -> np.ndarray:
    out = np.zeros(level.size)
    z = 0.0
    for i in range(level.size):
        # The first row: take the first interval to have been going on before it.
        step = dx[max(i - 1, 0)] if level.size > 1 else 0.0
        reach = level[i] / stiffness
        if reach <= 0.0:
            z = 0.0
        elif step != 0.0:
            sign = 1.0 if step > 0.0 else -1.0
            u, left = sign * z / reach, abs(step) / reach
            elastic = min(max(breakaway - u, 0.0), left)
            u, left = u + elastic, left - elastic
            if left > 0.0 and u > 1.0:
                u, left = 1.0 + (u - 1.0) * math.exp(-left), 0.0
            while left > 0.0 and abs(1.0 - u) > 1e-12:
                h = min(SUBSTEP, left)
                one = _slope(u, breakaway)
                two = _slope(u + 0.5 * h * one, breakaway)
                three = _slope(u + 0.5 * h * two, breakaway)
                u += h / 6.0 * (one + 2.0 * two + 2.0 * three + _slope(u + h * three, breakaway))
                left -= h
            z = sign * u * reach
        out[i] = z
    return out


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    level = np.ascontiguousarray(level, dtype=float)
    z = _stretches(dx, level, float(p.stiffness), float(p.breakaway))
    u = p.stiffness * np.sign(velocity) * z / np.where(level > 0.0, level, 1.0)
    angle = np.pi * (np.clip(u, p.breakaway, 1.0) - 0.5 * (1.0 + p.breakaway)) / (1.0 - p.breakaway)
    rate = velocity * (1.0 - np.where(u > p.breakaway, 0.5 + 0.5 * np.sin(angle), 0.0) * u)
    return p.stiffness * z + p.damping * np.where(level > 0.0, rate, 0.0)


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
