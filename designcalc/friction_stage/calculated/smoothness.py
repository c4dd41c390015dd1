"""Smoothness: response of the pads to a sampled profile of the way's surface."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from designcalc.checks.check import DesignInputs, Quantities
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pad_positions


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
