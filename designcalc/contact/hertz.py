"""Hertzian contact of elastic bodies: elliptic (point) contact and line contact.

Point contact, semi-axes ``a >= b``, ``k = b/a``, relative curvatures ``A <= B`` (Johnson 1985, 4.25 to 4.31):

    A = p0 b / (E* a^2) (K - E)/e^2        B = p0 b / (E* a^2) (E/k^2 - K)/e^2        e^2 = 1 - k^2
    F = 2/3 pi a b p0                      delta = p0 b K / E*

The differences of complete elliptic integrals cancel when the contact is nearly circular or very slender. Carlson's
symmetric integrals are the same numbers without a difference: ``(K - E)/e^2 = R_D(0, k^2, 1)/3`` and
``(E/k^2 - K)/e^2 = R_D(0, 1, k^2)/3`` (DLMF 19.25.1), so no case needs a special branch.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import elliprd, elliprf

from stagecad.parameters.errors import require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointContact:
    """Result of `point_contact`; every field is an array of the common shape of the arguments, in SI units."""

    load: Array  # normal force F, N
    semi_axis_major: Array  # a, m
    semi_axis_minor: Array  # b, m
    peak_pressure: Array  # p0, Pa
    approach: Array  # delta, approach of distant points of the two bodies, m
    stiffness: Array  # tangent stiffness dF/ddelta = 1.5 F/delta, N/m
    secant_stiffness: Array  # F/delta, N/m


@dataclass(frozen=True)
class LineContact:
    """Result of `line_contact`; arrays in SI units.

    There is no approach: in two dimensions it grows without bound with the distance of the point it is measured to.
    """

    half_width: Array  # b, m
    peak_pressure: Array  # p0, Pa


def contact_modulus(modulus_1: ArrayLike, poisson_1: ArrayLike, modulus_2: ArrayLike, poisson_2: ArrayLike) -> Array:
    """Contact modulus ``E* = 1/[(1-nu1^2)/E1 + (1-nu2^2)/E2]``.

    Args:
        modulus_1, modulus_2: Young's moduli, Pa, > 0 (``inf`` for a rigid body).
        poisson_1, poisson_2: Poisson's ratios, 0 to 0.5.

    Returns:
        E*, Pa.

    Raises:
        InputError: outside the range, or both bodies rigid.

    Source: Johnson, Contact Mechanics (1985), eq. 4.20.
    """
    e1, n1, e2, n2 = (np.asarray(v, float) for v in (modulus_1, poisson_1, modulus_2, poisson_2))
    require(np.all(e1 > 0) and np.all(e2 > 0), "hertz: modulus: must be above 0 Pa")
    for nu in (n1, n2):
        require(np.all((nu >= 0) & (nu <= 0.5)), "hertz: poisson: must lie in 0 to 0.5")
    compliance = (1 - n1**2) / e1 + (1 - n2**2) / e2
    require(np.all(compliance > 0), "hertz: modulus: both bodies are rigid: one modulus must be finite")
    return 1 / compliance


def ellipse_ratio(curvature_ratio: ArrayLike) -> Array:
    """Axis ratio ``k = b/a`` of the contact ellipse from the ratio of relative curvatures ``A/B``.

    Solves ``R_D(0, k^2, 1) / R_D(0, 1, k^2) = A/B``, monotone in k, by bisection in ln k.

    Args:
        curvature_ratio: smaller over larger relative curvature A/B, in (0, 1], any shape; down to 1e-200.

    Returns:
        b/a in (0, 1].

    Raises:
        InputError: outside (0, 1].

    Source: Johnson (1985), eq. 4.28, in Carlson's form (DLMF 19.25.1).
    """
    ratio = np.asarray(curvature_ratio, float)
    require(np.all((ratio >= 1e-200) & (ratio <= 1)), "hertz: curvature ratio: must lie in 1e-200 to 1")
    if np.all(ratio == 1.0):
        return np.ones(ratio.shape)
    target = np.log(ratio)
    low = np.full(ratio.shape, -345.0)  # exp(-345)^2 is still a normal number
    high = np.zeros(ratio.shape)
    for _ in range(64):
        middle = 0.5 * (low + high)
        square = np.exp(2 * middle)
        above = np.log(elliprd(0.0, square, 1.0)) - np.log(elliprd(0.0, 1.0, square)) > target
        high = np.where(above, middle, high)
        low = np.where(above, low, middle)
    return np.exp(0.5 * (low + high))


def relative_curvatures(
    radius_1: ArrayLike, radius_1_minor: ArrayLike, radius_2: ArrayLike, radius_2_minor: ArrayLike
) -> tuple[Array, Array]:
    """Relative curvatures ``A <= B`` with gap ``z = A x^2 + B y^2``, both bodies' principal planes coinciding.

    In one plane the curvatures are ``(1/R1 + 1/R2)/2``, in the other ``(1/R1' + 1/R2')/2``.

    Args:
        radius_1, radius_2: radii in the first plane, m; ``inf`` for a flat, negative for a hollow surface.
        radius_1_minor, radius_2_minor: radii in the second plane, m.

    Returns:
        A and B, 1/m.

    Raises:
        InputError: a radius of zero, or surfaces that conform or interlock in a plane (sum of curvatures < 0).

    Source: Johnson (1985), eq. 4.3.
    """
    radii = [np.asarray(r, float) for r in (radius_1, radius_1_minor, radius_2, radius_2_minor)]
    for r in radii:
        require(np.all(r != 0) and not np.any(np.isnan(r)), "hertz: radius: must not be zero")
    first = 0.5 * (1 / radii[0] + 1 / radii[2])
    second = 0.5 * (1 / radii[1] + 1 / radii[3])
    small, large = np.minimum(first, second), np.maximum(first, second)
    require(
        np.all(small >= 0) and np.all(large > 0),
        "hertz: radius: the surfaces do not touch: the curvatures of each plane must add up to 0 or more, of one to "
        "above 0",
    )
    return small, large


def point_contact(
    load: ArrayLike,
    radius_1: ArrayLike,
    radius_2: ArrayLike,
    modulus: ArrayLike,
    radius_1_minor: ArrayLike | None = None,
    radius_2_minor: ArrayLike | None = None,
) -> PointContact:
    """Elliptic Hertz contact of two bodies.

    ``a^3 = 3 F R_D(0,1,k^2) / (6 pi E* B)``, ``p0 = 3F/(2 pi a b)``, ``delta = 3 F K/(2 pi a E*)``, ``F ~ delta^1.5``.

    Args:
        load: normal force F, N, > 0.
        radius_1, radius_2: radii of curvature in one plane, m; ``inf`` for a flat, negative for a hollow surface.
        modulus: contact modulus E*, Pa (`contact_modulus`).
        radius_1_minor, radius_2_minor: radii in the other plane, m; equal to the first when left out.

    Returns:
        `PointContact` of the broadcast shape. Valid for a contact small compared with the radii, elastic, frictionless.

    Raises:
        InputError: load or modulus not above zero or not finite, a plane without curvature (that is a line contact), or
            a contact whose minor semi-axis exceeds the smallest radius.

    Source: Johnson, Contact Mechanics (1985), section 4.2(c).
    """
    force, e_star = np.asarray(load, float), np.asarray(modulus, float)
    require(np.all(force > 0) and np.all(np.isfinite(force)), "hertz: load: must be above 0 N, and finite")
    require(np.all(e_star > 0) and np.all(np.isfinite(e_star)), "hertz: modulus: must be above 0 Pa, and finite")
    radii = (
        radius_1,
        radius_1 if radius_1_minor is None else radius_1_minor,
        radius_2,
        radius_2 if radius_2_minor is None else radius_2_minor,
    )
    small, large = relative_curvatures(*radii)
    require(
        np.all(small > 0), "hertz: radius: both bodies are straight in one plane: a line contact, which needs a length"
    )
    k = ellipse_ratio(small / large)
    square = k**2
    a = np.cbrt(force * elliprd(0.0, 1.0, square) / (2 * np.pi * e_star * large))
    b = k * a
    approach = 3 * force * elliprf(0.0, square, 1.0) / (2 * np.pi * a * e_star)
    sharpest = np.min(np.broadcast_arrays(*(np.abs(np.asarray(radius, float)) for radius in radii)), axis=0)
    wide = "presses the bodies over a contact that is not small compared with their radii: larger than the smallest"
    require(np.all(b <= sharpest), f"hertz: load: {wide}")
    return PointContact(
        load=force * np.ones_like(a),
        semi_axis_major=a,
        semi_axis_minor=b,
        peak_pressure=3 * force / (2 * np.pi * a * b),
        approach=approach,
        stiffness=1.5 * force / approach,
        secant_stiffness=force / approach,
    )


def tangential_stiffness(
    contact: PointContact, modulus_1: ArrayLike, poisson_1: ArrayLike, modulus_2: ArrayLike, poisson_2: ArrayLike
) -> Array:
    """Stiffness of a contact against a force along the surface, before any of it slips, N/m.

    ``k_t = 8 a G*``, ``1/G* = (2 - nu1)/G1 + (2 - nu2)/G2``, ``G = E/(2 (1 + nu))``: of a circle. For an ellipse the
    radius of the circle of the same area serves; between the two directions that errs by a few percent up to a/b = 2.

    Args:
        modulus_1, modulus_2: Young's moduli, Pa.
        poisson_1, poisson_2: Poisson's ratios.

    Returns:
        k_t of the contact's shape; an upper bound, since the edge slips under any tangential force.

    Source: Mindlin (1949); Johnson (1985), eq. 7.43.
    """
    e1, n1, e2, n2 = (np.asarray(v, float) for v in (modulus_1, poisson_1, modulus_2, poisson_2))
    require(np.all(e1 > 0) and np.all(e2 > 0), "hertz: modulus: must be above 0 Pa")
    shear = 2 * (1 + n1) * (2 - n1) / e1 + 2 * (1 + n2) * (2 - n2) / e2
    return 8 * np.sqrt(contact.semi_axis_major * contact.semi_axis_minor) / shear


def line_contact(
    load: ArrayLike, length: ArrayLike, radius_1: ArrayLike, radius_2: ArrayLike, modulus: ArrayLike
) -> LineContact:
    """Hertz contact of two parallel cylinders: ``b^2 = 4 F R/(pi L E*)``, ``p0 = 2F/(pi b L)``, ``1/R = 1/R1 + 1/R2``.

    Args:
        load: normal force F, N, > 0.
        length: length of the contact L, m, > 0.
        radius_1, radius_2: radii across the line, m; ``inf`` for a flat, negative for a groove.
        modulus: contact modulus E*, Pa.

    Returns:
        `LineContact` of the broadcast shape.

    Raises:
        InputError: load, length or modulus not above zero, or surfaces that do not touch along a line.

    Source: Johnson (1985), eq. 4.43 to 4.45.
    """
    force, span, e_star = (np.asarray(v, float) for v in (load, length, modulus))
    require(np.all(force > 0) and np.all(np.isfinite(force)), "hertz: load: must be above 0 N, and finite")
    require(np.all(span > 0), "hertz: length: must be above 0 m")
    require(np.all(e_star > 0), "hertz: modulus: must be above 0 Pa")
    curvature = 1 / np.asarray(radius_1, float) + 1 / np.asarray(radius_2, float)
    require(np.all(curvature > 0), "hertz: radius: 1/R1 + 1/R2 must be above 0: the surfaces do not touch along a line")
    per_length = force / span
    half_width = np.sqrt(4 * per_length / (np.pi * e_star * curvature))
    return LineContact(half_width=half_width, peak_pressure=2 * per_length / (np.pi * half_width))


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
        poisson: Poisson's ratio of the body looked at, 0 to 0.5.

    Returns:
        `ShearPeak` of the contact's shape, Pa and m.

    Source: Johnson (1985), section 4.2(c) and table 4.1.
    """
    shear, depth = np.vectorize(_peak_shear, otypes=[float, float])(
        contact.semi_axis_minor / contact.semi_axis_major, poisson
    )
    return ShearPeak(shear=shear * contact.peak_pressure, depth=depth * contact.semi_axis_minor)


@lru_cache(maxsize=256)
def _peak_shear(k: float, nu: float) -> tuple[float, float]:
    """Peak of ``(sigma_y - sigma_z)/2`` over the peak pressure, and its depth over the minor semi-axis."""

    def shear(depth: float) -> Array:
        _, sigma_y, sigma_z = axis_stresses(depth, k, nu)
        return 0.5 * (sigma_y - sigma_z)

    best = _golden_maximum(shear)
    return float(shear(best)), best


def line_shear_peak(contact: LineContact) -> ShearPeak:
    """Peak shear below a line contact, across the line: ``tau = p0 (u - u^2/sqrt(1 + u^2))``, ``u = z/b``.

    Its maximum is 0.30028 p0 at z = 0.78615 b.

    Returns:
        `ShearPeak` of the contact's shape, Pa and m.

    Source: Johnson (1985), eq. 4.47.
    """
    # d/du [u - u^2/sqrt(1+u^2)] = 0  <=>  (1+u^2)^3 = u^2 (2+u^2)^2  <=>  u^4 + u^2 - 1 = 0
    u = np.sqrt((np.sqrt(5.0) - 1) / 2)
    return ShearPeak(shear=contact.peak_pressure * (u - u**2 / np.sqrt(1 + u**2)), depth=contact.half_width * u)


def peak_mises(ratio: ArrayLike, poisson: ArrayLike) -> Array:
    """Largest von Mises stress on the axis over the peak pressure, for an elliptic contact.

    Yield begins at ``p0 = yield strength / peak_mises``: 1.61 times the yield strength for a circle with nu = 0.3.

    Args:
        ratio: b/a in (0, 1].
        poisson: Poisson's ratio, 0 to 0.5.

    Source: Johnson (1985), section 6.1, on the stresses of eq. 4.46.
    """
    return np.asarray(np.vectorize(_peak_mises, otypes=[float])(ratio, poisson))


@lru_cache(maxsize=256)
def _peak_mises(k: float, nu: float) -> float:
    def mises(depth: float) -> Array:
        x, y, z = axis_stresses(depth, k, nu)
        return np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2))

    return float(max(mises(_golden_maximum(mises)), mises(0.0)))


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


def _golden_maximum(function: Callable[[float], Array]) -> float:
    """Depth of the maximum of a function with one peak between depths of 0.02 and 2."""
    golden, low, high = (np.sqrt(5.0) - 1) / 2, 0.02, 2.0
    for _ in range(60):
        step = golden * (high - low)
        left, right = high - step, low + step
        low, high = (left, high) if function(left) < function(right) else (low, right)
    return float(0.5 * (low + high))
