"""Sliding bearing: the crowns that would give the allowed pressure, pressure times speed, and the height that the pads
carry over the profile of the way."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root_scalar

from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from designcalc.checks.check import DesignInputs, Quantities
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pad_positions


def pressure(r: DesignInputs) -> Quantities:
    """The crown at which the peak pressure equals the allowed one."""
    crown = 0.0
    if r.advise:
        load, allowed = heaviest_pad(r), r("bearing.allowable_pressure")
        crown = _crown(r, lambda radius: float(film(r, load, radius).peak_pressure) / allowed)
    return {"crown.needed": (crown, "m")}


def pv(r: DesignInputs) -> Quantities:
    """The crown at which the mean pressure at full speed equals the allowed one."""
    speed, allowed, crown = r("requirements.speed"), r("bearing.allowable_pv"), r("pads.crown_radius")
    if r.advise:
        load, most = heaviest_pad(r), allowed / speed
        crown = _crown(r, lambda radius: load / (np.pi * float(film(r, load, radius).radius) ** 2) / most)
    sag = r("pads.length") ** 2 / (8 * crown)
    return {"crown.needed": (crown if sag > 0.1e-6 else 0.0, "m"), "crown.flatter": (crown, "m")}


def _crown(r: DesignInputs, share: Callable[[float], float]) -> float:
    """Crown radius at which a share, which falls with it, becomes one, m; the present one where it is below."""
    here = r("pads.crown_radius")

    def excess(logarithm: float) -> float:
        return share(math.exp(logarithm)) - 1

    low, high = math.log(here), math.log(1e9 * here)
    if excess(low) <= 0:
        return here
    return math.exp(float(root_scalar(excess, bracket=(low, high), xtol=1e-6).root))


def spot(r: DesignInputs) -> float:
    """Length along the travel over which a pad touches the way, m."""
    return 2 * float(film(r, heaviest_pad(r)).radius)


def lapped_surface(r: DesignInputs) -> Surface:
    """The way lapped as proposed."""
    return Surface(
        roughness=r("bearing.proposed_way_roughness"),
        correlation_length=r("bearing.roughness_correlation"),
        waviness=r("bearing.way_waviness"),
        wavelength=r("bearing.waviness_length"),
    )


def ridden(r: DesignInputs) -> Quantities:
    rough, waves = _carried_rms(r, lapped_surface(r), spot(r), pad_positions(r))
    return {"height.by_waves": (waves, "m"), "height.by_roughness": (rough, "m")}


def _carried_rms(r: DesignInputs, surface: Surface, side: float, places: NDArray[np.float64]) -> tuple[float, float]:
    """Rms heights of the stage over its travel by roughness and by waves, m. Pads in one line follow the same track one
    after another. The phase of the waves of the two ways is unknown: the worse of in phase and in antiphase is
    taken."""
    travel, spacing = r("stage.travel"), r("pads.spacing_along")
    tracks, track_of = np.unique(places[:, 1], return_inverse=True)
    profiles, step = synthetic_profiles(replace(surface, waviness=0.0), travel + spacing, side, len(tracks))
    count = int((travel + side) / step)
    starts = np.rint((places[:, 0] - places[:, 0].min()) / step).astype(int)
    heights = [profiles[track, start : start + count] for track, start in zip(track_of, starts, strict=True)]
    waves = [
        carried_waves(surface, starts, np.where(track_of > 0, phase, 0.0), step, count, side) for phase in (0.0, np.pi)
    ]
    return float(np.std(carried_height(heights, step, side))), max(waves)
