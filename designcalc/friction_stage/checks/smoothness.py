"""Smoothness: response of the pads to the way's surface, by formula and over a sampled profile."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from designcalc.checks.check import Check, CheckFunction, DesignInputs, FormulaCheck
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pad_positions
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_AVERAGING = "averaging of a random surface over the pads' contact"


def checks(design: Design) -> list[CheckFunction]:
    """Roughness under the film, smoothness of the way as drawn, as proposed, and with the waves that lapping leaves."""
    return [
        roughness_under_film,
        smoothness("way_roughness", "way as drawn", thesis=_PRINTED_RULE),
        smoothness("proposed_way_roughness", "way as proposed"),
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


# Not a length, so it depends on the unit.
_PRINTED_RULE = (
    "'smoothness in the order of sqrt(Ra^3)' is no length: worked in metres it reads "
    "{sqrt((bearing.way_roughness/1 m)^3)*1 m}, in millimetres {sqrt((bearing.way_roughness/1 mm)^3)*1 mm}; average "
    "the surface over the pad instead"
)


def smoothness(key: str, label: str, thesis: str = "") -> FormulaCheck:
    return stated(
        f"smoothness of the {label}",
        f"bearing.{key}*sqrt(pi/2)*sqrt(pi)*bearing.roughness_correlation"
        "/(radius.of_averaging*sqrt(8*pi/9*pads.count)) <= requirements.smoothness",
        (f"bearing.{key}", f"bearing.{key}*check.limit/check.value", False),
        source=_AVERAGING,
        proposal="a smoother way, or flatter pads",
        thesis=thesis,
        requirement="Table 1: smoothness",
    )


def ridden(r: DesignInputs) -> Check:
    """Height of the stage over profiles of roughness and waves; their bow belongs to the straightness."""
    rough, waves = _carried_rms(r, lapped_surface(r), spot(r), pad_positions(r))
    return stated(
        "smoothness over a lapped way with its waves",
        "sqrt(height.by_waves^2 + height.by_roughness^2) <= requirements.smoothness",
        (
            "bearing.way_waviness",
            "bearing.way_waviness*sqrt(max(check.limit^2 - height.by_roughness^2, 0 m^2))/height.by_waves",
            False,
        ),
        given={"height.by_waves": (waves, "m"), "height.by_roughness": (rough, "m")},
        source="profiles averaged over each pad's contact as its pressure weighs them; mean of the pads; rms over the "
        "travel",
        proposal="smaller waves, or pads that touch over several of their lengths: a convex pad averages roughness, "
        "not waves longer than its contact",
        requirement="Table 1: smoothness",
        note="contact {2*radius.of_pad} long",
    )(r)


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
