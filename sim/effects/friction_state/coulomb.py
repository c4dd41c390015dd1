"""The Coulomb core: the level times the direction, through a bristle so stiff that its stretch stays below the
resolution. So the force is defined at rest: it holds its last value in a dwell.

The state is the bristle's force f itself. With the stretch s at the level and a relaxation time tau that damps the
oscillation after it, the bristle is the causal one of a0 = g/s, a1 = tau g/s:

    phi = (f + tau g v/s) / (1 + tau |v|/s),   f' = (g v - |v| phi)/s = (g v - |v| f)/(s + tau |v|),   friction = phi

|phi| never exceeds the level, and the core is passive at any speed. Past a reversal (direction * v < 0, where only the
trial stages of a step ever are) the divisor is continued so that it stays positive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.library.friction_state import FrictionStateModel
from sim.numerics.compilation import compiled

RELAXATION = 1e-4
"""tau, s: at the default stretch about critical damping for 1 kg under 1 N."""


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return 0.0, 0.0
    s = p.stretch
    w = RELAXATION / s
    q = w * direction * v
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    return (g * v - direction * v * z) / (s * below), (z + w * g * v) / below


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    if g <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s = p.stretch
    w = RELAXATION / s
    q = w * direction * v
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    steep = 1.0 if q >= 0.0 else 1.0 + 4.0 * q**3
    rate = (g * v - direction * v * z) / (s * below)
    force = (z + w * g * v) / below
    rate_v = (g - direction * z) / (s * below) - rate * steep * w * direction / below
    force_v = (w * g - force * steep * w * direction) / below
    return -direction * v / (s * below), rate_v, v / (s * below), 1.0 / below, force_v, w * v / below


@compiled
def _stop(dx: np.ndarray, level: np.ndarray, stretch: float) -> np.ndarray:
    n = level.size
    force = np.zeros(n)
    held = 0.0
    for k in range(n):
        # The first row: take the first interval to have been going on before it.
        step = dx[max(k - 1, 0)] if n > 1 else 0.0
        g = max(level[k], 0.0)
        held = min(max(held + g * step / stretch, -g), g)
        force[k] = held
    return force


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    """Coulomb force along a measured motion: a stop operator on the steps of the position.

    `p.stretch` should be a few times the noise of the position, so that noise in a dwell does not turn the force.
    """
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    return _stop(dx, np.ascontiguousarray(level, dtype=float), float(p.stretch))


def stored(k: int, z: Any, g: Any, p: Any) -> Any:
    return np.where(g > 0.0, 0.5 * z * z * p.stretch / np.where(g > 0.0, g, 1.0), 0.0)


def scale(p: Any) -> float:
    return max(p.force, 1e-9)


core = FrictionStateModel("coulomb", law, slopes, along, scale, state="force of the bristle, N", stored=stored)
