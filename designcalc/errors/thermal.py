"""Expansion of the structural loop, of unlike parts bolted together, and the floor's shake."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


def loop_drift(lengths: ArrayLike, expansions: ArrayLike) -> float:
    """Opening of a loop of members per kelvin: ``sum(alpha_i L_i)``, m/K.

    Args:
        lengths: signed lengths along the sensitive direction, m, shape (n,): positive where growth opens the gap.
        expansions: coefficients of expansion, 1/K, shape (n,).
    """
    return float(np.dot(np.asarray(lengths, float), np.asarray(expansions, float)))


def differential_growth(length: ArrayLike, expansion_1: ArrayLike, expansion_2: ArrayLike) -> Array:
    """Difference of the growth of two bodies of one length, ``|alpha_1 - alpha_2| L``, m/K."""
    return np.abs(np.asarray(expansion_1, float) - np.asarray(expansion_2, float)) * np.asarray(length, float)


def bow_of_layers(
    length: ArrayLike,
    thickness_1: ArrayLike,
    modulus_1: ArrayLike,
    expansion_1: ArrayLike,
    thickness_2: ArrayLike,
    modulus_2: ArrayLike,
    expansion_2: ArrayLike,
) -> Array:
    """Sagitta per kelvin of two layers that cannot slide on each other, m/K.

    ``curvature = 6 dalpha (1+m)^2 / [h (3(1+m)^2 + (1+mn)(m^2 + 1/(mn)))]``, m = t1/t2, n = E1/E2, h = t1 + t2;
    sagitta = curvature L^2/8. Layers free to slip at their joint bow less.

    Args:
        length: L, m.
        thickness_1, thickness_2: m.
        modulus_1, modulus_2: Pa.
        expansion_1, expansion_2: 1/K.

    Source: Timoshenko, Analysis of bi-metal thermostats, J. Opt. Soc. Am. 11 (1925) 233.
    """
    L, t1, t2, e1, e2 = (np.asarray(v, float) for v in (length, thickness_1, thickness_2, modulus_1, modulus_2))
    for name, value in (("length", L), ("thickness", t1), ("thickness", t2), ("modulus", e1), ("modulus", e2)):
        if not np.all(value > 0):
            raise InputError(f"thermal: {name}: must be above 0")
    m, n, h = t1 / t2, e1 / e2, t1 + t2
    share = 6 * (1 + m) ** 2 / (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n)))
    return np.abs(np.asarray(expansion_1, float) - np.asarray(expansion_2, float)) * share / h * L**2 / 8


def preload_change(
    grip: ArrayLike,
    bolt_expansion: ArrayLike,
    clamped_expansion: ArrayLike,
    bolt_stiffness: ArrayLike,
    clamped_stiffness: ArrayLike,
) -> Array:
    """Change of a bolt's preload per kelvin, N/K; negative when the bolt outgrows what it clamps.

    ``dF/dT = (alpha_clamped - alpha_bolt) grip / (1/k_bolt + 1/k_clamped)``.

    Args:
        grip: clamped length, m.
        bolt_expansion, clamped_expansion: 1/K.
        bolt_stiffness, clamped_stiffness: N/m.
    """
    t, bolt, clamped = (np.asarray(v, float) for v in (grip, bolt_stiffness, clamped_stiffness))
    if not (np.all(t > 0) and np.all(bolt > 0) and np.all(clamped > 0)):
        raise InputError("thermal: grip and stiffnesses must be above 0")
    apart = np.asarray(clamped_expansion, float) - np.asarray(bolt_expansion, float)
    return apart * t / (1 / bolt + 1 / clamped)


def vibration_at_tip(floor_acceleration: ArrayLike, resonance: ArrayLike) -> Array:
    """Relative motion across a loop by shaking its base well below its resonance: ``a/(2 pi f)^2``, m.

    Args:
        floor_acceleration: amplitude or rms, m/s^2, >= 0.
        resonance: first resonance f of the loop, Hz, > 0; the shaking must lie well below it.

    Raises:
        InputError: outside the range.
    """
    shake, f = np.asarray(floor_acceleration, float), np.asarray(resonance, float)
    if not (np.all(shake >= 0) and np.all(f > 0)):
        raise InputError("thermal: the floor's acceleration must be 0 or more, the resonance above 0")
    return shake / (2 * np.pi * f) ** 2
