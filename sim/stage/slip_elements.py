"""Presliding curves of pads and tip: tangential force over its limit as a function of the displacement.

A force on first loading, F = limit f(x/x_full), is followed by parallel elasto-plastic elements
(`sim/numerics/elasto_plastic.py`) along straight pieces between knots.

Source: Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327.
"""

import math
from collections.abc import Callable

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled
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


@compiled(forceinline=True, _nrt=False, fastmath=SUMS_IN_ANY_ORDER)
def slip(
    force: np.ndarray,
    stiffness: tuple[float, float],
    stored: float,
    cap: float,
    shares: tuple[np.ndarray, np.ndarray],
    way: tuple[float, float],
    lag: float,
) -> tuple[float, float, float, float]:
    """Move the elements of a contact; returns the force that resists (x, y), the heat and the stored energy.

    An element that sticks also damps: its force is k (z + tau z'). Slip begins when that exceeds the cap, and the force
    stays at the cap while z relaxes with tau: at speed nothing is left of the damping.

    `force` of the elements, N, (2, elements), is written in place; `stiffness` before and after the step, N/m; `stored`
    before it, J; `cap`, N; `shares` of both of each element; `way` in the step, m; `lag`: tau over the step.
    """
    tangent_before, tangent = stiffness
    stiffness_shares, cap_shares = shares
    dx, dy = way
    fx, fy, work, kept = 0.0, 0.0, 0.0, 0.0
    if tangent <= 0.0:
        for e in range(force.shape[1]):
            force[0, e], force[1, e] = 0.0, 0.0
        return fx, fy, stored, kept
    loss = 1.0
    if tangent < tangent_before:
        loss = tangent / tangent_before
    follow = 1.0 / (1.0 + lag)
    for e in range(force.shape[1]):
        spring = tangent * stiffness_shares[e]
        most = cap * cap_shares[e]
        x0, y0 = force[0, e], force[1, e]
        x, y = x0 * loss, y0 * loss
        damped_x = x + (1.0 + lag) * spring * dx
        damped_y = y + (1.0 + lag) * spring * dy
        size = math.sqrt(damped_x * damped_x + damped_y * damped_y)
        # An element that sticks keeps its damped force; `follow` times (1 + lag) is one.
        cut = most / size if size > most else 1.0
        damped_x, damped_y = damped_x * cut, damped_y * cut
        x += (damped_x - x) * follow
        y += (damped_y - y) * follow
        kept += (x * x + y * y) / stiffness_shares[e]
        work += (0.5 * (x0 + x) + damped_x - x) * dx + (0.5 * (y0 + y) + damped_y - y) * dy
        force[0, e], force[1, e] = x, y
        fx += damped_x
        fy += damped_y
    kept /= 2.0 * tangent
    return fx, fy, work - (kept - stored), kept
