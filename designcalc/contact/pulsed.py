"""Contact force of a tip that rises against a body and leaves it once a period."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root_scalar

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def pressed_force(depth: Array, rate: float, stiffness: float) -> Array:
    """Force of a Hertz contact in series with a spring, together pressed by a depth, N.

    ``depth = (F/K)^(2/3) + F/k``; no force without contact.

    Args:
        depth: m, any shape; negative: a gap.
        rate: K of the contact ``F = K delta^1.5``, N/m^1.5, > 0.
        stiffness: k of the spring behind the contact, N/m, > 0.
    """
    whole = np.maximum(np.asarray(depth, float), 0.0)
    # x + (K/k) x^1.5 = depth for the contact's part x: monotone and convex, so Newton from above descends to it.
    x = whole.copy()
    for _ in range(40):
        step = (x + rate / stiffness * x**1.5 - whole) / (1 + 1.5 * rate / stiffness * np.sqrt(x))
        x = np.maximum(x - step, 0.0)
        if np.all(np.abs(step) <= 1e-15 * x):
            break
    return rate * x**1.5


@lru_cache(maxsize=256)
def peak_of_mean(mean: float, rise: float, rate: float, stiffness: float) -> float:
    """Peak force of a tip that rises sinusoidally by `rise` each period and carries `mean` on average, N.

    The body stays where it is during a period (its inertia holds it, above the resonance of its supports), and the tip
    follows its command (below its own): ``F(t) = F(d - Y/2 (1 - cos wt))`` with the depth d at which the mean of F is
    the given one.

    Args:
        mean: N, > 0.
        rise: Y, peak to peak, m, >= 0.
        rate: K of the contact, N/m^1.5.
        stiffness: k of the tip's support, N/m.

    Raises:
        InputError: an argument out of its range.
    """
    depth = _depth_of_mean(mean, rise, rate, stiffness)
    return float(pressed_force(np.asarray(depth), rate, stiffness))


@lru_cache(maxsize=256)
def pulse_harmonics(mean: float, rise: float, rate: float, stiffness: float, count: int) -> tuple[float, ...]:
    """Amplitudes F_k of the force of such a tip, ``F(t) = N + sum_k F_k cos(k w t)``, t from its peak, N.

    Arguments and errors as of `peak_of_mean`; `count` of the harmonics.
    """
    contact, phase, force = _pulse(_depth_of_mean(mean, rise, rate, stiffness), rise, rate, stiffness)
    return tuple(float((_WEIGHTS * force) @ np.cos(k * phase)) * contact / np.pi for k in range(1, count + 1))


def _pulse(depth: float, rise: float, rate: float, stiffness: float) -> tuple[float, Array, Array]:
    """Half of the phase over which a tip touches, rad, and phases within it, shape (n,), with the force there, N."""
    contact = np.pi if depth >= rise else float(np.arccos(1 - 2 * depth / rise))
    phase = 0.5 * contact * (1 + _NODES)
    return contact, phase, pressed_force(depth - 0.5 * rise * (1 - np.cos(phase)), rate, stiffness)


@lru_cache(maxsize=256)
def _depth_of_mean(mean: float, rise: float, rate: float, stiffness: float) -> float:
    """Depth of the tip at its peak, m, with which the mean force is the given one; arguments as of `peak_of_mean`."""
    if not (mean > 0 and rise >= 0 and rate > 0 and stiffness > 0 and np.isfinite(mean + rise + rate)):
        raise InputError("tip force: mean, contact and stiffness must be above 0, the rise 0 or more")

    def average(depth: float) -> float:
        contact, _, force = _pulse(depth, rise, rate, stiffness)
        return float(_WEIGHTS @ force) * 0.5 * contact / np.pi

    static = float(mean / rate) ** (2 / 3) + mean / stiffness
    high = static + rise
    if rise > 0 and average(static) < mean < average(high):
        high = root_scalar(
            lambda depth: average(depth) / mean - 1, bracket=(static, high), xtol=1e-14 * static, rtol=1e-14
        ).root
    return float(high)
