"""A presliding curve as elements that stick and slip (Iwan, generalised Maxwell-slip).

A contact's tangential force on first loading is F = cap f(s/s_full), f concave from 0 to 1. Elements in parallel, each
a spring that slips at its own share of the cap, follow f along straight pieces between knots, and give Masing's rule
on every reversal by themselves.

Source: Iwan, J. Appl. Mech. 33 (1966) 893; Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

KNOTS = np.array([0.06, 0.3, 0.65, 1.0])


def mindlin(u: np.ndarray) -> np.ndarray:
    """Force over cap of a Hertz contact in partial slip: 1 - (1 - u)^1.5, s_full = 1.5 cap / (tangential stiffness)."""
    return 1.0 - (1.0 - u) ** 1.5


def parabola(u: np.ndarray) -> np.ndarray:
    """Force over cap where all thresholds from none to s_full are equally common: 1 - (1 - u)^2."""
    return 1.0 - (1.0 - u) ** 2


def slip_elements(curve: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray, float]:
    """Elements that follow a curve.

    Returns:
        shares of the stiffness (4,), shares of the cap (4,), each summing to 1, and the stiffness at rest as a multiple
        of cap/s_full.
    """
    u = np.concatenate([[0.0], KNOTS])
    slopes = np.append(np.diff(curve(u)) / np.diff(u), 0.0)
    stiffness = slopes[:-1] - slopes[1:]
    caps = stiffness * KNOTS
    return stiffness / stiffness.sum(), caps / caps.sum(), float(slopes[0])
