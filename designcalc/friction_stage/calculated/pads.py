"""Sliding bearing: the crowns that would give the allowed pressure, and pressure times speed."""

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import DesignInputs, Quantities
from designcalc.friction_stage.physics.pads import film, heaviest_pad


def pressure(r: DesignInputs) -> Quantities:
    crown = crown_for(r, heaviest_pad(r), r("bearing.allowable_pressure")) if r.advise else 0.0
    return {"crown.needed": (crown, "m")}


def pv(r: DesignInputs) -> Quantities:
    speed, allowed, here = r("requirements.speed"), r("bearing.allowable_pv"), r("pads.crown_radius")
    crown = crown_for_mean(r, heaviest_pad(r), allowed / speed) if r.advise else here
    sag = r("pads.length") ** 2 / (8 * crown)
    return {"crown.needed": (crown if sag > 0.1e-6 else 0.0, "m"), "crown.flatter": (crown, "m")}


def crown_for(r: DesignInputs, load: float, allowed: float) -> float:
    """Crown radius at which the peak pressure equals the allowed one, m; the present one where it is below."""
    here = r("pads.crown_radius")

    def excess(logarithm: float) -> float:
        return float(film(r, load, math.exp(logarithm)).peak_pressure) / allowed - 1

    return _crown(excess, here)


def crown_for_mean(r: DesignInputs, load: float, allowed: float) -> float:
    """Crown radius at which the mean pressure equals the allowed one, m; the present one where it is below."""

    def excess(logarithm: float) -> float:
        return load / (np.pi * float(film(r, load, math.exp(logarithm)).radius) ** 2) / allowed - 1

    return _crown(excess, r("pads.crown_radius"))


def _crown(excess: Callable[[float], float], here: float) -> float:
    low, high = math.log(here), math.log(1e9 * here)
    if excess(low) <= 0:
        return here
    return math.exp(float(root_scalar(excess, bracket=(low, high), xtol=1e-6).root))
