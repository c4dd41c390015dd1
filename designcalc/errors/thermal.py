"""Expansion of the structural loop, of unlike parts bolted together, and the floor's shake."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


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
        require(np.all(value > 0), f"thermal: {name}: must be above 0")
    m, n, h = t1 / t2, e1 / e2, t1 + t2
    share = 6 * (1 + m) ** 2 / (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n)))
    return np.abs(np.asarray(expansion_1, float) - np.asarray(expansion_2, float)) * share / h * L**2 / 8


THIRD_OCTAVES = 1000.0 * 2.0 ** (np.arange(-21, -10) / 3.0)
"""Middle frequencies of the third octaves of 8 to 80 Hz, in which the VC criteria limit the floor's velocity, Hz."""


def floor_motion(velocity: ArrayLike, resonance: ArrayLike, damping: ArrayLike) -> Array:
    """Relative motion across a loop by the floor's vibration in all third octaves of 8 to 80 Hz, m rms.

    The floor has the rms velocity v in each third octave, evenly spread over it, as a criterion VC permits. A loop with
    the resonance f_1 follows it with ``x_rel/x_floor = r^2/(1 - r^2 + 2 i zeta r)``, ``r = f/f_1``; ``x_floor = v/(2 pi
    f)``. Powers are integrated over each third octave and added.

    Args:
        velocity: v, rms in each third octave, m/s, >= 0.
        resonance: f_1, Hz, > 0.
        damping: zeta, 0 to below 1, > 0.

    Raises:
        InputError: outside the range.

    Source: Gordon, Generic vibration criteria, Proc. SPIE 1619 (1991) 71; single-degree-of-freedom transmissibility.
    """
    v, f_1, zeta = np.broadcast_arrays(*(np.asarray(a, float) for a in (velocity, resonance, damping)))
    if not (np.all(v >= 0) and np.all(f_1 > 0) and np.all((zeta > 0) & (zeta < 1))):
        raise InputError("thermal: the floor's velocity must be 0 or more, the resonance above 0, the damping 0 to 1")
    low, high = THIRD_OCTAVES * 2 ** (-1 / 6), THIRD_OCTAVES * 2 ** (1 / 6)

    def power(band: tuple[float, float]) -> Array:
        # |x_rel|^2 df = v^2/(width 4 pi^2 f^2) r^4/|...|^2 df; with s = r^2 the resonance is resolved by an arctangent.
        start, end = band[0] / f_1, band[1] / f_1
        return (_resonant_integral(end, zeta) - _resonant_integral(start, zeta)) / (end - start)

    total = sum(power(band) for band in zip(low, high, strict=True))
    return v / (2 * np.pi * f_1) * np.sqrt(total)


def _resonant_integral(r: Array, zeta: Array) -> Array:
    """Integral of ``r^2/[(1 - r^2)^2 + (2 zeta r)^2]`` over r from 0, in closed form.

    Partial fractions over the roots ``+-p``, ``+-conj(p)`` of the denominator, ``p = sqrt(1 - zeta^2) + i zeta``.
    """
    p = np.sqrt(1 - zeta**2) + 1j * zeta
    # 1/[(r^2 - p^2)(r^2 - conj(p)^2)] = Im[1/(r^2 - p^2)]/Im(p^2), and r^2/(r^2 - p^2) = 1 + p^2/(r^2 - p^2).
    inner = p / 2 * (np.log((p - r) / (p + r)))
    return np.imag(inner) / np.imag(p**2)
