"""Smoothness: response of the pads to the way's surface, by formula and over a sampled profile."""

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.sliding import averaged_roughness
from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_most, change, show
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pad_positions
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_AVERAGING = "averaging of a random surface over the pads' contact"


def checks(design: Design) -> list[CheckFunction]:
    """Roughness under the film, smoothness of the way as drawn, as proposed, and with the waves that lapping leaves."""
    return [
        roughness_under_film,
        partial(smoothness, key="way_roughness", label="way as drawn"),
        partial(smoothness, key="proposed_way_roughness", label="way as proposed"),
        ridden,
    ]


roughness_under_film = stated(
    "way roughness against the PTFE film",
    "4*bearing.way_roughness <= bearing.film_thickness/4",
    ("bearing.way_roughness", "bearing.proposed_way_roughness", False),
    source="Rz about 4 Ra; a quarter of the film, so that no peak cuts through",
    proposal="lap the way as Nanosurf 2's (nanometres)",
    thesis="Ra 1 um under a film of 1-2 um contradicts Nanosurf's way, lapped to nanometres",
    requirement="Table 1: smoothness",
)


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


def smoothness(r: DesignInputs, key: str, label: str) -> Check:
    side = spot(r)
    rough = r(f"bearing.{key}")
    number = int(r("pads.count"))
    left = float(averaged_roughness(rough, r("bearing.roughness_correlation"), side / 2, number))
    limit = r("requirements.smoothness")
    return Check(
        f"smoothness of the {label}",
        at_most(left, limit, "m"),
        source=_AVERAGING,
        formula="Ra sqrt(pi/2) sqrt(pi) l/(a sqrt(8 pi n/9)) <= 1 nm rms",
        substituted=f"Ra = {show(rough, 'm')}, contact {show(side, 'm')} wide, {number} pads: {show(left, 'm')}",
        proposal="a smoother way, or flatter pads",
        changes=change(f"bearing.{key}", rough * limit / left, "m", up=False),
        thesis=(_printed_rule(rough) if key == "way_roughness" else ""),
        requirement="Table 1: smoothness",
    )


def _printed_rule(roughness: float) -> str:
    """The printed 'smoothness in the order of sqrt(Ra^3)': not a length, so it depends on the unit."""
    in_metres, in_millimetres = np.sqrt(roughness**3), np.sqrt((roughness * 1e3) ** 3) * 1e-3
    return (
        f"'smoothness in the order of sqrt(Ra^3)' is no length: worked in metres it reads {show(in_metres, 'm')}, "
        f"in millimetres {show(in_millimetres, 'm')}; average the surface over the pad instead"
    )


def ridden(r: DesignInputs) -> Check:
    """Height of the stage over profiles of roughness and waves; their bow belongs to the straightness."""
    side, places = spot(r), pad_positions(r)
    surface = lapped_surface(r)
    rough, waves = _carried_rms(r, surface, side, places)
    both = float(np.hypot(rough, waves))
    limit = r("requirements.smoothness")
    may = surface.waviness * np.sqrt(max(limit**2 - rough**2, 0.0)) / waves if waves > 0 else np.inf
    return Check(
        "smoothness over a lapped way with its waves",
        at_most(both, limit, "m"),
        source="profiles averaged over each pad's contact as its pressure weighs them; mean of the pads; rms over the "
        "travel",
        formula="rms over x of mean over pads of the height averaged over 2a",
        substituted=f"contact {show(side, 'm')} long, {len(places)} pads, Ra {show(surface.roughness, 'm')}, waves of "
        f"{show(surface.waviness, 'm')} at {show(surface.wavelength, 'm')}: {show(waves, 'm')}, and "
        f"{show(rough, 'm')} of roughness",
        changes=change("bearing.way_waviness", may, "m", up=False),
        proposal="smaller waves, or pads that touch over several of their lengths: a convex pad "
        "averages roughness, not waves longer than its contact",
        requirement="Table 1: smoothness",
    )


def _carried_rms(r: DesignInputs, surface: Surface, side: float, places: NDArray[np.float64]) -> tuple[float, float]:
    """Rms heights of the stage over its travel by roughness and by waves, m.

    Pads in one line follow the same track one after another. The phase of the waves of the two ways is unknown: the
    worse of in phase and in antiphase is taken.
    """
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
