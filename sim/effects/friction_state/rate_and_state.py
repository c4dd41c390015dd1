"""Rate-and-state friction of Dieterich and Ruina, on a contact of constant stiffness.

    friction = k z,    z' = v - w,    |friction| = g (1 + a ln(|w|/v_0))
    g = force (1 + b ln(1 + v_0 age/L)),    age' = 1 - |w| age/L    (ageing law; other effects change g further)

a is the direct effect: the force rises with the logarithm of the slip rate w. b is the evolution: the level rises with
the age of the contacts. In steady sliding below v_0 the force falls with the speed where b is larger than a, which is
the condition of stick-slip. The first line is regularised, w = 2 v_0 sinh(friction/(a g)) exp(-1/a): so w is zero
without force, and the contact creeps under any. At v_0 the friction is the level of age L/v_0, force (1 + b ln 2). The
age falls with the slip: a contact that only stretches ages on. Along a record the slip that ages the contacts is that
of the friction without other effects.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter
from sim.effects.friction.dwell_strengthening import MEMORY_LENGTH
from sim.effects.friction_state.lugre import FORCE, RELEASE, STIFFNESS, scale, stored
from sim.effects.friction_state_model import FrictionStateModel, Slopes
from sim.numerics.compilation import compiled
from sim.numerics.steps import age_step, rate_and_state_step

MOST = 30.0
"""Exponent beyond which the slip rate is continued linearly."""


def level(axis: Axis, p: Any) -> Any:
    return p.force * (1.0 + p.evolution * np.log(1.0 + p.velocity * axis.contact_age / p.memory_length))


def level_by_age(axis: Axis, p: Any) -> Any:
    return p.force * p.evolution * p.velocity / (p.memory_length + p.velocity * axis.contact_age)


@compiled
def _ages(
    dx: np.ndarray,
    dt: np.ndarray,
    force: float,
    stiffness: float,
    direct: float,
    evolution: float,
    velocity: float,
    memory_length: float,
) -> np.ndarray:
    out = np.zeros(dx.size + 1)
    held = 0.0
    for i in range(dx.size):
        g = force * (1.0 + evolution * math.log(1.0 + velocity * out[i] / memory_length))
        after, _ = rate_and_state_step(held, dx[i], dt[i], g, stiffness, direct, velocity)
        out[i + 1] = age_step(out[i], abs(dx[i] - (after - held) / stiffness), dt[i], memory_length)
        held = after
    return out


def memory(axis: Axis, p: Any) -> Axis:
    dx, dt = (np.diff(np.ascontiguousarray(a, dtype=float)) for a in (axis.position, axis.time))
    return axis._replace(contact_age=_ages(dx, dt, *map(float, p)))


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    force = p.stiffness * z
    if g <= 0.0:
        return -z / RELEASE, 0.0
    ahead, back = (force / g - 1.0) / p.direct, (-force / g - 1.0) / p.direct
    slip = math.exp(ahead) if ahead <= MOST else math.exp(MOST) * (1.0 + ahead - MOST)
    slip -= math.exp(back) if back <= MOST else math.exp(MOST) * (1.0 + back - MOST)
    return v - p.velocity * slip, force


def slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    force = p.stiffness * z
    ahead, back = (force / g - 1.0) / p.direct, (-force / g - 1.0) / p.direct
    steep = p.velocity * (math.exp(min(ahead, MOST)) + math.exp(min(back, MOST))) / (p.direct * g)
    return -steep * p.stiffness, 1.0, steep * force / g, p.stiffness, 0.0, 0.0


@compiled
def _forces(
    dx: np.ndarray, dt: np.ndarray, level: np.ndarray, stiffness: float, direct: float, v0: float
) -> np.ndarray:
    out = np.zeros(level.size)
    held = 0.0
    for i in range(level.size if level.size > 1 else 0):
        # The first row: take the first interval to have been going on before it.
        j = max(i - 1, 0)
        held, out[i] = rate_and_state_step(held, dx[j], dt[j], level[i], stiffness, direct, v0)
    return out


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    """Exact over each interval, of constant velocity and level, but for the slip at forces of a few A."""
    dx, dt = (np.diff(np.ascontiguousarray(a, dtype=float)) for a in (position, time))
    g = np.ascontiguousarray(level, dtype=float)
    return _forces(dx, dt, g, float(p.stiffness), float(p.direct), float(p.velocity))


def sliding(level: np.ndarray, speed: np.ndarray, p: Any) -> np.ndarray:
    """Friction in steady sliding, w = |v|: a g asinh(exp(1/a) |v|/(2 v_0)), N."""
    exponent = np.log(np.maximum(np.abs(speed), 1e-300) / (2.0 * p.velocity)) + 1.0 / p.direct
    return p.direct * level * np.logaddexp(exponent, 0.5 * np.logaddexp(2.0 * exponent, 0.0))


EFFECT = Effect(
    name="rate_and_state",
    meaning="friction that rises with the logarithm of the slip rate and with the age of the contacts (creep included)",
    equation="friction = k z,  z' = v - 2 velocity sinh(friction/(direct level)) exp(-1/direct);\n"
    "level = force (1 + evolution ln(1 + velocity age/memory_length)),  age' = 1 - |z' - v| age/memory_length",
    shows="after a step of the speed the force jumps up by direct ln(ratio), then decays by evolution ln(ratio) over "
    "the memory length; at rest the force relaxes with the logarithm of time",
    dissipation="Passive: the stiffness is constant, and the slip always has the direction of the force.",
    source="Dieterich, J. Geophys. Res. 84 (1979) 2161; Ruina, J. Geophys. Res. 88 (1983) 10359; regularised: Rice, "
    "Lapusta, Ranjith, J. Mech. Phys. Solids 49 (2001) 1865",
    parameters=(
        FORCE,
        STIFFNESS,
        Parameter(
            "direct",
            "1",
            0.01,
            1e-3,
            0.2,
            "a: rise of the force per e-fold of slip rate, over `force`",
            "Marone 1998: 0.005 to 0.015 of a friction coefficient of 0.6",
        ).shape(natural="both"),
        Parameter(
            *("evolution", "1", 0.015, 0.0, 0.5, "b: rise of the level per e-fold of age, over `force`"),
            source="Marone 1998: as a",
        ),
        Parameter(
            *("velocity", "m/s", 1e-3, 1e-9, 10.0, "v_0: slip rate at which the friction is the level"),
            source="chosen: a reference",
            role="reference",
            fixed=True,
        ),
        replace(MEMORY_LENGTH, meaning=f"L: {MEMORY_LENGTH.meaning}"),
    ),
    coordinates=("velocity", "contact_age", "distance_since_reversal"),
    level=level,
    slopes={"level.contact_age": level_by_age},
    memory=memory,
    friction_state=FrictionStateModel(
        "rate_and_state", law, slopes, along, scale, stored=stored, sliding=sliding, ages=True
    ),
    acts_on="friction",
)
