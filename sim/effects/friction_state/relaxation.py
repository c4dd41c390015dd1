"""Exact steps of a bristle's stretch along a measured motion: between two rows the velocity and level are taken as
constant, for which the first-order bristle law has a closed solution. No explicit integration, so no step is too long.
"""

from __future__ import annotations

import math

import numpy as np

from sim.numerics.compilation import compiled


@compiled
def _relax(dx: np.ndarray, dt: np.ndarray, level: np.ndarray, stiffness: float, damping: float) -> np.ndarray:
    n = level.size
    force = np.zeros(n)
    if n == 0:
        return force
    held = 0.0
    if n > 1 and level[0] > 0.0:
        # A record that begins in motion begins in slip: take the first interval to have been going on before it.
        yielding = level[0] + damping * abs(dx[0]) / dt[0]
        held = level[0] * np.sign(dx[0]) * -np.expm1(-stiffness * abs(dx[0]) / yielding)
    force[0] = held
    for k in range(1, n):
        g = 0.5 * (level[k] + level[k - 1])
        step = dx[k - 1]
        if g <= 0.0:
            held = 0.0
        elif step != 0.0:
            end = g if step > 0.0 else -g
            held = end + (held - end) * math.exp(-stiffness * abs(step) / (g + damping * abs(step) / dt[k - 1]))
        force[k] = held
    return force


def spring_force(
    position: np.ndarray, time: np.ndarray, level: np.ndarray, stiffness: float, damping: float = 0.0
) -> np.ndarray:
    """Spring force of bristles along a measured motion.

    Solves z' = (v - a0 |v| z/g) / (1 + a1 |v|/g) exactly over each interval: a0 z tends to g sign(v) over the length
    (g + a1 |v|)/a0. With a1 = 0 this is the LuGre and Dahl bristle.

    Args:
        position: m, shape (n,).
        time: s, shape (n,), increasing.
        level: friction level g, N, shape (n,); no friction where it is not positive.
        stiffness: a0, N/m.
        damping: a1 in the rate (causal law only), N*s/m.

    Returns:
        a0 z, N, shape (n,).

    Source: Canudas de Wit et al. 1995, IEEE Trans. Automatic Control 40(3), eq. 1-2, solved for constant velocity.
    """
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    dt = np.diff(np.ascontiguousarray(time, dtype=float))
    return _relax(dx, dt, np.ascontiguousarray(level, dtype=float), float(stiffness), float(damping))
