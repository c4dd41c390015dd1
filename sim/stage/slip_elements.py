"""Presliding curves of pads and tip: tangential force over its limit as a function of the displacement.

A force on first loading, F = limit f(x/x_full), is followed by parallel elasto-plastic elements
(`sim/numerics/elasto_plastic.py`) along straight pieces between knots.

Source: Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.numerics.elasto_plastic import Springs, elements_along, springs_of

KNOTS = np.array([0.06, 0.3, 0.65, 1.0])


def mindlin(u: np.ndarray) -> np.ndarray:
    """Force over limit of a Hertz contact in partial slip: 1 - (1 - u)^1.5; x_full = 1.5 limit / stiffness at rest."""
    return 1.0 - (1.0 - u) ** 1.5


def parabola(u: np.ndarray) -> np.ndarray:
    """Force over limit where all yield stretches from none to x_full are equally common: 1 - (1 - u)^2."""
    return 1.0 - (1.0 - u) ** 2


def slip_springs(curve: Callable[[np.ndarray], np.ndarray]) -> Springs:
    """Springs (4,) that follow a curve, for a limit and a displacement x_full of one: their stiffnesses sum to that at
    rest as a multiple of limit/x_full, and their limits to one."""
    return springs_of(elements_along(KNOTS, curve(KNOTS)))
