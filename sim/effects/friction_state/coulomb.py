"""The Coulomb core: the level times the direction, through a bristle so stiff that its stretch stays below the
resolution. So the force is defined at rest: it holds its last value in a dwell.

The state is the bristle's force f itself. With its constant stiffness k and a relaxation time T that damps the
oscillation after it, the bristle is the causal one of a0 = k, a1 = T k:

    phi = g (f + T k v) / (g + T k |v|),   f' = k (g v - |v| f)/(g + T k |v|),   friction = phi

|phi| never exceeds the level, and the core is passive at any speed and level. Past a reversal (direction * v < 0, where
only the trial stages of a step ever are) the divisor is continued so that it stays positive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effects.friction_state_model import FrictionStateModel
from sim.numerics.compilation import compiled

RELAXATION = 1e-4
"""T, s: at the default stretch about critical damping for 1 kg under 1 N."""


def stiffness(p: Any) -> float:
    """k, N/m: the bristle stretches by `stretch` under `force`, or under 1 N where that is zero."""
    return (p.force if p.force > 0.0 else 1.0) / p.stretch


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return 0.0, 0.0
    stiff = (p.force if p.force > 0.0 else 1.0) / p.stretch
    q = RELAXATION * stiff * direction * v / g
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    return stiff * (v - direction * v * z / g) / below, (z + RELAXATION * stiff * v) / below


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    if g <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    stiff = (p.force if p.force > 0.0 else 1.0) / p.stretch
    q = RELAXATION * stiff * direction * v / g
    below = 1.0 + q if q >= 0.0 else 1.0 + q + q**4
    steep = (1.0 if q >= 0.0 else 1.0 + 4.0 * q**3) / below
    q_v = RELAXATION * stiff * direction / g
    rate = stiff * (v - direction * v * z / g) / below
    force = (z + RELAXATION * stiff * v) / below
    return (
        -stiff * direction * v / (g * below),
        stiff * (1.0 - direction * z / g) / below - rate * steep * q_v,
        stiff * direction * v * z / (g * g * below) + rate * steep * q / g,
        1.0 / below,
        RELAXATION * stiff / below - force * steep * q_v,
        force * steep * q / g,
    )


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
