"""A stage driven through friction by a piezo tip: traction, tip-over, resonance.

The tip lifts the stage as well as pushing it: the load on the tip is taken off the pads.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]

GRAVITY = 9.80665
"""Standard gravity, m/s^2."""


def acceleration_limit(
    friction: ArrayLike,
    preload_ratio: ArrayLike,
    share: ArrayLike = 1.0,
    pad_friction: ArrayLike = 0.0,
    gravity: ArrayLike = GRAVITY,
) -> Array:
    """Largest acceleration of the stage without lifting it off its pads, m/s^2.

    The tip carries ``share`` of weight and preload, ``N = share (1+p) m g``; the pads carry the rest, with friction:
    ``a = g (1+p) [mu share - mu_pad (1 - share)]``. With share = 1 it is the absolute limit ``mu (1+p) g``.

    Args:
        friction: mu between tip and stage, >= 0.
        preload_ratio: p, preload over weight, >= 0.
        share: part of the load the tip takes, 0 to 1 (1: about to lift off; less where the stage would tip).
        pad_friction: mu of the pads.
        gravity: g, m/s^2.

    Returns:
        acceleration, m/s^2 (negative: the tip cannot even overcome the pads).
    """
    mu, p, s, mu_pad = (np.asarray(v, float) for v in (friction, preload_ratio, share, pad_friction))
    if not (np.all(mu >= 0) and np.all(p >= 0) and np.all((s >= 0) & (s <= 1))):
        raise InputError("friction drive: friction and preload ratio must be 0 or more, the share 0 to 1")
    return np.asarray(gravity, float) * (1 + p) * (mu * s - mu_pad * (1 - s))


def preload_ratio_for(acceleration: ArrayLike, friction: ArrayLike, gravity: ArrayLike = GRAVITY) -> Array:
    """Preload over weight needed for an acceleration (m/s^2) with the tip about to lift the stage: ``a/(mu g) - 1``."""
    a, mu = np.asarray(acceleration, float), np.asarray(friction, float)
    require(np.all(mu > 0), "friction drive: friction: must be above 0")
    return np.maximum(a / (mu * np.asarray(gravity, float)) - 1, 0.0)


def tip_force_limit(pads: ArrayLike, centre: ArrayLike, tip: ArrayLike) -> float:
    """Largest upward tip force over the load (weight and preload) before a pad lifts.

    The pads' reactions add up to load minus tip force, and act where the moment balance puts them; that point must stay
    inside the pads' polygon. With s the distance from the load's centre to the polygon's edge on the side away from the
    tip, and x the tip's distance from the centre: ``F/W = s/(s + x)``.

    Args:
        pads: pad centres in the plane of motion, m, shape (n, 2), n >= 3, in any order.
        centre: point where weight and preload act, m, shape (2,), inside the polygon.
        tip: point of contact of the tip, m, shape (2,).

    Returns:
        F/W, 0 (the stage tips by itself) to 1 (tip under the centre).
    """
    points, c, t = np.asarray(pads, float), np.asarray(centre, float), np.asarray(tip, float)
    if not all(np.all(np.isfinite(v)) for v in (points, c, t)):
        raise InputError("friction drive: the places of pads, load and tip must be finite")
    if points.ndim != 2 or points.shape[0] < 3:
        raise InputError("friction drive: at least three pads are needed to carry the stage")
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        raise InputError("friction drive: the pads lie on one line and cannot carry the stage") from None
    normals, offsets = hull.equations[:, :2], -hull.equations[:, 2]
    inside = offsets - normals @ c
    if np.any(inside < 0):
        return 0.0
    away = c - t
    distance = float(np.hypot(*away))
    if distance == 0:
        return 1.0
    slope = normals @ (away / distance)
    crossed = slope > 1e-12
    span = float(np.min(inside[crossed] / slope[crossed]))
    return span / (span + distance)


def resonance(stiffness: ArrayLike, mass: ArrayLike) -> Array:
    """``sqrt(k/m)/(2 pi)``, Hz, of a mass (kg) on a spring (N/m)."""
    k, m = np.asarray(stiffness, float), np.asarray(mass, float)
    require(np.all(k > 0) and np.all(m > 0), "friction drive: stiffness and mass must be above 0")
    return np.sqrt(k / m) / (2 * np.pi)
