"""Sliding bearing: loads, pressure, pv, friction, stiffness."""

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.friction_stage.checks.preload import share_of_load
from designcalc.friction_stage.physics.pads import film, heaviest_pad
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_FILM = "Johnson (1985), sections 4.2 and 5.8: crown and film in series"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the sliding bearing."""
    return [
        lightest_pad,
        pressure,
        pv,
        indentation,
        proportions,
        stiction,
        share_of_load,
        normal,
        pitch,
        *([yaw] if design.teeth.fitted else []),
    ]


lightest_pad = stated(
    "lightest pad load over the mean",
    "load.lightest_pad/(load.whole/pads.count) >= 0.5",
    source="statics of the plate on its pads",
    proposal="pads nearer to equal shares of the load",
    note="heaviest pad load {load.heaviest_pad}",
)


def pressure(r: DesignInputs) -> Check:
    crown = crown_for(r, heaviest_pad(r), r("bearing.allowable_pressure")) if r.advise else 0.0
    return stated(
        "pad pressure",
        "pressure.of_pad <= bearing.allowable_pressure",
        ("pads.crown_radius", "crown.needed", True),
        given={"crown.needed": (crown, "m")},
        source=_FILM,
        proposal="a flatter crown, or a lighter pad load",
        note="{load.heaviest_pad} on a spot of radius {radius.of_pad}",
    )(r)


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


def pv(r: DesignInputs) -> Check:
    speed, allowed, here = r("requirements.speed"), r("bearing.allowable_pv"), r("pads.crown_radius")
    crown = crown_for_mean(r, heaviest_pad(r), allowed / speed) if r.advise else here
    sag = r("pads.length") ** 2 / (8 * crown)
    return stated(
        "PTFE pressure times speed",
        "load.heaviest_pad/(pi*radius.of_pad^2)*requirements.speed <= bearing.allowable_pv",
        ("pads.crown_radius", "crown.needed", True),
        given={"crown.needed": (crown if sag > 0.1e-6 else 0.0, "m"), "crown.flatter": (crown, "m")},
        source="pv limit of the film",
        proposal="a flatter crown ({crown.flatter}, {pads.length^2/(8*crown.flatter)} of sag over the pad), or full "
        "speed for {100*check.limit/check.value} % of the time",
        requirement="Table 1: speed",
    )(r)


indentation = stated(
    "indentation of the PTFE film",
    "depth.film <= bearing.film_thickness/4",
    source=_FILM + ": p0 t/M",
    proposal="a larger crown radius",
    note="also the range of the film's formula",
)


proportions = stated(
    "pads twice as long as wide",
    "abs(pads.length/pads.width - 2) <= 0.1",
    source="thesis 2.3.2, rule of Slocum (1992)",
    proposal="length of {2*pads.width}",
)


stiction = stated(
    "jump of the stage as it breaks away",
    "2*max(bearing.static_friction - bearing.dynamic_friction, 0)*load.whole/stiffness.along <= ellipse.along/2",
    source="undamped slip of a mass pulled slowly through a spring; the tip's lean must bring the stage back",
    proposal="run in for some thousand cycles; a filled PTFE grade whose static and dynamic friction are alike",
    thesis="thesis 2.3.2: PTFE with static within 10-20 % of dynamic friction",
    requirement="Table 1: resolution",
)


normal = stated(
    "deflection of the pads under a tenth of the payload",
    "0.1*payload.mass*environment.gravity/stiffness.pads <= requirements.resolution_coarse",
    source=_FILM,
    proposal="more preload, or a larger crown radius",
    requirement="Table 1: smoothness",
)


pitch = stated(
    "pitch of the stage under its drive force",
    "load.whole*drive.friction*height.centre_of_mass/stiffness.pitch*stage.travel/2 <= requirements.smoothness",
    ("pads.spacing_along", "pads.spacing_along*sqrt(check.value/check.limit)", True),
    source="pads as springs; the tip pushes below the centre of mass of stage and payload; height error mid-base",
    proposal="pads farther apart along the travel (stiffness grows as the square), or measure with no drive",
    requirement="Table 1: smoothness",
    note="pads {stiffness.pads} in all, {stiffness.roll} in roll",
)


yaw = stated(
    "yaw held by the teeth",
    "0.1 rad*bearing.dynamic_friction*load.whole*pads.spacing_across/2/(stiffness.teeth_across*tooth_iron.length^2/12)"
    " <= 1 rad*requirements.straightness/(stage.length/2)",
    ("tooth_iron.length", "tooth_iron.length*(check.value/check.limit)^(1/3)", True),
    source="lateral stiffness of the teeth spread along the irons, against friction that differs by a tenth across",
    proposal="longer irons and magnets (both stiffness and lever grow), a guide, or a tip that pushes through the "
    "middle of friction",
    thesis="magnets are stated to align the stage about its axis of motion; this is their stiffness",
)
