"""A round porous air bearing: load and stiffness over its gap, from supply pressure and one permeance.

Air seeps through the porous face everywhere and leaves at the rim. With ``P = p^2`` the film obeys

    (1/r) d/dr(r dP/dr) = (lambda/R)^2 (P - Ps),   lambda^2 = 12 c R^2/h^3,

isothermal and viscous, with ``c`` the permeability of the pad over its thickness; so
``P = Ps - (Ps - Pa) I0(lambda r/R)/I0(lambda)`` and the load is ``2 pi`` times the integral of ``(p - pa) r``.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import root_scalar
from scipy.special import i0e, i1e

from stagecad.parameters.errors import require

Array = NDArray[np.float64]

ATMOSPHERE = 101325.0
"""Standard atmosphere, Pa."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(80)
_RADII = 0.5 * (_NODES + 1)
_AREAS = _RADII * _WEIGHTS  # of the integral 2 x dx over 0 to 1


def load_of_feed(feed: ArrayLike, diameter: float, supply: float) -> Array:
    """Load of the bearing, N.

    Args:
        feed: lambda, > 0, any shape; small starves the film, large brings the supply's pressure everywhere.
        diameter: of the porous face, m, > 0.
        supply: pressure above the atmosphere, Pa, > 0.

    Returns:
        load of the shape of `feed`, between 0 and supply times area.
    """
    lam = np.asarray(feed, float)[..., None]
    require(np.all(lam > 0) and diameter > 0 and supply > 0, "air bearing: feed, diameter and supply must be above 0")
    pressure, _ = _film(lam, supply)
    return np.pi / 4 * diameter**2 * ((pressure - ATMOSPHERE) @ _AREAS)


def _film(lam: Array, supply: float) -> tuple[Array, Array]:
    """Absolute pressure over the radii (..., n), Pa, and its slope over lambda, for lambda (..., 1)."""
    source, outside = (ATMOSPHERE + supply) ** 2, ATMOSPHERE**2
    # i0e(x) = exp(-x) I0(x): the ratio stays finite however large lambda is.
    within, rim = i0e(lam * _RADII), i0e(lam)
    fall = (source - outside) * within / rim * np.exp(-lam * (1 - _RADII))
    pressure = np.sqrt(source - fall)
    # I0' = I1, so the logarithm of I0(lambda x)/I0(lambda) has the slope x I1/I0 there, less I1/I0 at the rim.
    slope = fall * (i1e(lam) / rim - _RADII * i1e(lam * _RADII) / within) / (2.0 * pressure)
    return pressure, slope


def feed_for(load: float, diameter: float, supply: float) -> float:
    """The lambda with which a bearing carries a load: one point of a catalogue fixes it.

    Raises:
        InputError: a load outside the range of any feed: not between 0 and supply times area.
    """
    most = float(load_of_feed(1e3, diameter, supply))
    require(0 < load < most, f"air bearing: load: {load:g} N must be above 0 and below {most:.4g} N, supply times area")

    def excess(logarithm: float) -> float:
        return float(load_of_feed(math.exp(logarithm), diameter, supply)) / load - 1

    return math.exp(root_scalar(excess, bracket=(-9.0, math.log(1e3))).root)


def load_of_gap(gap: ArrayLike, known_gap: float, known_load: float, diameter: float, supply: float) -> Array:
    """Load over gap of the bearing that carries `known_load` (N) at `known_gap` (m): ``lambda ~ h^(-3/2)``, N."""
    h = np.asarray(gap, float)
    require(np.all(h > 0) and known_gap > 0, "air bearing: gap: must be above 0")
    return load_of_feed(feed_for(known_load, diameter, supply) * (known_gap / h) ** 1.5, diameter, supply)


def stiffness_of_gap(gap: ArrayLike, known_gap: float, known_load: float, diameter: float, supply: float) -> Array:
    """Stiffness ``-dW/dh`` over gap, N/m; arguments as `load_of_gap`.

    The supply is taken as undisturbed by the flow; slow motions, no squeeze film.
    """
    h = np.asarray(gap, float)
    feed = feed_for(known_load, diameter, supply) * (known_gap / h) ** 1.5
    _, slope = _film(feed[..., None], supply)
    return 1.5 * feed / h * np.pi / 4 * diameter**2 * (slope @ _AREAS)
