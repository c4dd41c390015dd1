"""The Coulomb core: the level times the direction, through a bristle so stiff that its stretch stays below the
resolution. So the force is defined at rest: it holds its last value in a dwell.

The state is the bristle's force f itself; k is its stiffness, T a relaxation time that damps the oscillation after it:

    phi = g (f + T k v)/(g + T k |v|),   f' = k (v - alpha |v| phi/g),   friction = phi

alpha = 0 up to 95 % of the level, then a cubic to 1 at the level: a load that stays below moves the bristle elastically
and does not creep, whatever it does. |phi| never exceeds the level, and the core is passive at any speed and level:
phi v - f f'/k >= 0. Past a reversal (direction * v < 0, where only the trial stages of a step ever are) the divisor is
continued so that it stays positive.
"""

from typing import Any

import numpy as np

from sim.effects.friction_state_model import FrictionStateModel, Slopes
from sim.numerics.compilation import compiled
from sim.numerics.steps import coulomb_step

RELAXATION = 1e-4
"""T, s: at the default stretch about critical damping for 1 kg under 1 N."""
ELASTIC = 0.95
"""Part of the level below which the bristle is elastic."""


def stiffness(p: Any) -> float:
    """k, N/m: the bristle stretches by `stretch` under `force`, or under 1 N where that is zero."""
    return (p.force if p.force > 0.0 else 1.0) / p.stretch


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return 0.0, 0.0
    stiff = (p.force if p.force > 0.0 else 1.0) / p.stretch
    q = RELAXATION * stiff * direction * v / g
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    u = (direction * z / g + q) / below
    part = min(max((u - ELASTIC) / (1.0 - ELASTIC), 0.0), 1.0)
    return stiff * v * (1.0 - part * part * (3.0 - 2.0 * part) * u), direction * g * u


def slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    stiff = (p.force if p.force > 0.0 else 1.0) / p.stretch
    q = RELAXATION * stiff * direction * v / g
    below, steep = 1.0 + q, 1.0
    if q < 0.0:
        below, steep = below + q**4, 1.0 + 4.0 * q**3
    u = (direction * z / g + q) / below
    part = min(max((u - ELASTIC) / (1.0 - ELASTIC), 0.0), 1.0)
    alpha, rise = part * part * (3.0 - 2.0 * part), 6.0 * part * (1.0 - part) / (1.0 - ELASTIC)
    u_z, u_q = direction / (g * below), (1.0 - u * steep) / below
    u_v, u_g = u_q * RELAXATION * stiff * direction / g, -z * u_z / g - u_q * q / g
    rate_u = -stiff * v * (alpha + rise * u)
    return (
        rate_u * u_z,
        stiff * (1.0 - alpha * u) + rate_u * u_v,
        rate_u * u_g,
        1.0 / below,
        direction * g * u_v,
        direction * (u + g * u_g),
    )


@compiled
def _stop(dx: np.ndarray, level: np.ndarray, stretch: float) -> np.ndarray:
    n = level.size
    force = np.zeros(n)
    held = 0.0
    for k in range(n):
        # The first row: take the first interval to have been going on before it.
        step = dx[max(k - 1, 0)] if n > 1 else 0.0
        held, force[k] = coulomb_step(held, step, level[k], stretch)
    return force


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    """Coulomb force along a measured motion: a stop operator on the steps of the position.

    `p.stretch` should be a few times the noise of the position, so that noise in a dwell does not turn the force: it is
    the resolution of the record, not a spring. So the bristle stretches by it under the level of each row, whatever
    that of other rows: a part of a record has the force of the whole.
    """
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    return _stop(dx, np.ascontiguousarray(level, dtype=float), float(p.stretch))


def stored(k: int, z: Any, g: Any, p: Any) -> Any:
    return 0.5 * z * z / stiffness(p)


def scale(p: Any) -> float:
    return max(p.force, 1e-9)


core = FrictionStateModel(
    *("coulomb", law, slopes, along, scale), state="force of the bristle, N", stored=stored, rigid=True
)
