"""Stresses below and around a Hertzian contact: peak shear, first yield, cracking at the edge."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import elliprd

from designcalc.contact.hertz import LineContact, PointContact

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ShearPeak:
    """Largest principal shear stress below the middle of a contact, and where it is."""

    shear: Array  # Pa
    depth: Array  # m


def axis_stresses(depth: ArrayLike, ratio: ArrayLike, poisson: ArrayLike) -> tuple[Array, Array, Array]:
    """Stresses on the axis below the middle of an elliptic contact, over the peak pressure.

    The closed form of Thomas and Hoersch as given by Johnson, with the incomplete elliptic integrals in Carlson's form
    and the common factor 1/e^2 divided out, so that a circle is an ordinary case.

    Args:
        depth: depth over the minor semi-axis, z/b, >= 0.
        ratio: b/a of the contact ellipse, in (0, 1].
        poisson: Poisson's ratio of the body.

    Returns:
        sigma_x (along the major axis), sigma_y (the minor one), sigma_z (normal), each over p0, tension positive.

    Source: Johnson (1985), eq. 4.46; Thomas and Hoersch, Univ. Illinois Eng. Exp. Sta. Bull. 212 (1930).
    """
    k, nu = np.asarray(ratio, float), np.asarray(poisson, float)
    zeta = np.asarray(depth, float) * k
    c = 1 + zeta**2
    T = np.sqrt((k**2 + zeta**2) / c)
    # zeta (F - E)/e^2 and zeta (E/k^2 - F)/e^2 of Johnson's formulas; at the surface both vanish (R_D is infinite).
    inside = np.where(zeta > 0, zeta, 1.0)
    first = np.where(zeta > 0, inside * elliprd(inside**2, inside**2 + k**2, 1 + inside**2) / 3, 0.0)
    second = np.where(zeta > 0, inside * elliprd(inside**2, 1 + inside**2, inside**2 + k**2) / 3, 0.0)
    second = second + zeta**2 / (k**2 * c * T)
    shrink = 1 / (c * (1 + T))  # (1 - T)/e^2
    bend = -(zeta**2 + c * T) / (c * (1 + T) * k**2)  # (1 - T/k^2)/e^2
    omega_x = -0.5 * shrink + first
    omega_x_nu = bend + second
    omega_y = bend + 0.5 * shrink / T + second
    omega_y_nu = -shrink + first
    sigma_x = 2 * k * (omega_x + nu * omega_x_nu)
    sigma_y = 2 * k * (omega_y + nu * omega_y_nu)
    sigma_z = -k / (c * T)
    return sigma_x, sigma_y, sigma_z


def point_shear_peak(contact: PointContact, poisson: ArrayLike) -> ShearPeak:
    """Peak of ``(sigma_y - sigma_z)/2`` below the middle of an elliptic contact, and its depth.

    For a circle with nu = 0.3 it is 0.310 p0 at 0.48 a, for a slender ellipse 0.300 p0 at 0.79 b.

    Args:
        contact: the contact.
        poisson: Poisson's ratio of the body looked at, 0 to 0.5.

    Returns:
        `ShearPeak` of the contact's shape, Pa and m.

    Source: Johnson (1985), section 4.2(c) and table 4.1.
    """
    k, nu = np.broadcast_arrays(contact.semi_axis_minor / contact.semi_axis_major, np.asarray(poisson, float))
    if k.shape:
        pairs = [_peak_shear(*pair) for pair in zip(k.ravel().tolist(), nu.ravel().tolist(), strict=True)]
        shear, depth = np.array(pairs).reshape(*k.shape, 2).transpose(-1, *range(k.ndim))
    else:
        shear, depth = _peak_shear(float(k), float(nu))
    return ShearPeak(shear=shear * contact.peak_pressure, depth=depth * contact.semi_axis_minor)


@lru_cache(maxsize=256)
def _peak_shear(k: float, nu: float) -> tuple[float, float]:
    """Peak of ``(sigma_y - sigma_z)/2`` over the peak pressure, and its depth over the minor semi-axis."""

    def shear(depth: Array) -> Array:
        _, sigma_y, sigma_z = axis_stresses(depth, k, nu)
        return 0.5 * (sigma_y - sigma_z)

    best = _golden_maximum(shear, np.array(0.02), np.array(2.0))
    return float(shear(best)), float(best)


def line_shear_peak(contact: LineContact) -> ShearPeak:
    """Peak shear below a line contact, across the line: ``tau = p0 (u - u^2/sqrt(1 + u^2))``, ``u = z/b``.

    Its maximum is 0.30028 p0 at z = 0.78615 b.

    Args:
        contact: the contact.

    Returns:
        `ShearPeak` of the contact's shape, Pa and m.

    Source: Johnson (1985), eq. 4.47.
    """
    # d/du [u - u^2/sqrt(1+u^2)] = 0  <=>  (1+u^2)^3 = u^2 (2+u^2)^2  <=>  u^4 + u^2 - 1 = 0
    u = np.sqrt((np.sqrt(5.0) - 1) / 2)
    return ShearPeak(
        shear=contact.peak_pressure * (u - u**2 / np.sqrt(1 + u**2)),
        depth=contact.half_width * u,
    )


def peak_mises(ratio: ArrayLike, poisson: ArrayLike) -> Array:
    """Largest von Mises stress on the axis over the peak pressure, for an elliptic contact.

    Yield begins at ``p0 = yield strength / peak_mises``: 1.61 times the yield strength for a circle with nu = 0.3.

    Args:
        ratio: b/a in (0, 1].
        poisson: Poisson's ratio, 0 to 0.5.

    Source: Johnson (1985), section 6.1, on the stresses of eq. 4.46.
    """
    k, nu = np.broadcast_arrays(np.asarray(ratio, float), np.asarray(poisson, float))
    if not k.shape:
        return np.asarray(_peak_mises(float(k), float(nu)))
    return np.array([_peak_mises(*pair) for pair in zip(k.ravel().tolist(), nu.ravel().tolist(), strict=True)]).reshape(
        k.shape
    )


@lru_cache(maxsize=256)
def _peak_mises(k: float, nu: float) -> float:
    def mises(depth: Array) -> Array:
        x, y, z = axis_stresses(depth, k, nu)
        return np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2))

    inner = mises(_golden_maximum(mises, np.array(0.02), np.array(2.0)))
    return float(max(inner, mises(np.array(0.0))))


def edge_tension(peak_pressure: ArrayLike, poisson: ArrayLike, friction: ArrayLike = 0.0) -> Array:
    """Largest tensile stress of a circular contact that slides, at its trailing edge on the surface, Pa.

    ``p0 [(1 - 2 nu)/3 + mu pi (4 + nu)/8]``: the contact's own radial tension, and that of the traction mu p over it.
    It cracks a brittle body or coating. In a thin coating on a body the stress is this times the ratio of
    ``E/(1 - nu^2)`` of coating and body.

    Args:
        peak_pressure: p0, Pa.
        poisson: Poisson's ratio, 0 to 0.5.
        friction: mu of the sliding contact, >= 0; 0 without traction.

    Source: Johnson (1985), eq. 3.44 and section 4.2(b); Hamilton, Goodman, J. Appl. Mech. 33 (1966) 371.
    """
    nu, mu = np.asarray(poisson, float), np.asarray(friction, float)
    return np.asarray(peak_pressure, float) * ((1 - 2 * nu) / 3 + mu * np.pi * (4 + nu) / 8)


def _golden_maximum(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Place of the maximum of a function with one peak between `low` and `high`, element by element."""
    golden = (np.sqrt(5.0) - 1) / 2
    for _ in range(60):
        step = golden * (high - low)
        left, right = high - step, low + step
        rises = function(left) < function(right)
        low = np.where(rises, left, low)
        high = np.where(rises, high, right)
    return 0.5 * (low + high)
