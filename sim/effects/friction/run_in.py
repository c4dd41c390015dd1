"""A friction level that settles as the surfaces run in."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.excess * np.exp(-axis.travelled / p.distance)


def _factor_travelled(axis: Axis, p: Any) -> Any:
    return -p.excess / p.distance * np.exp(-axis.travelled / p.distance)


def _stages_factor(axis: Axis, p: Any) -> Any:
    first = np.exp(-axis.travelled / p.distance)
    second = np.exp(-axis.travelled / (p.later * p.distance))
    return 1.0 + p.excess * first + p.late_excess * second


def _stages_factor_travelled(axis: Axis, p: Any) -> Any:
    far = p.later * p.distance
    first = p.excess / p.distance * np.exp(-axis.travelled / p.distance)
    return -first - p.late_excess / far * np.exp(-axis.travelled / far)


_EXPONENTIAL = Effect(
    name="run_in",
    meaning="the friction level settles with the distance slid",
    equation="level * (1 + excess * exp(-s / distance)), s the distance travelled since the first row",
    shows="the friction level decays with the distance travelled, and is constant while the axis rests",
    source="Blau, Tribology International 38 (2005) 1007: running-in of friction",
    acts_on="friction",
    coordinates=("distance_travelled", "time"),
    parameters=(
        Parameter("excess", "1", 0.2, -0.9, 10.0, "relative excess of the level at the start", "level stays positive"),
        Parameter(
            "distance", "m", 1.0, 1e-9, 1e6, "distance over which it decays", "bounded by the distance slid"
        ).shape(Scan("travelled", 0.03, 2.0, 9)),
    ),
    factor=_factor,
    slopes={"factor.travelled": _factor_travelled},
)

_EXCESS, _DISTANCE = _EXPONENTIAL.parameters

EFFECT = replace(
    _EXPONENTIAL,
    variants=(
        replace(
            _EXPONENTIAL,
            name="run_in:two_stages",
            meaning="the friction level settles with the distance slid, first quickly, then slowly",
            equation="level * (1 + excess * exp(-s / distance) + late_excess * exp(-s / (later * distance)))",
            source="Blau, Tribology International 38 (2005) 1007: asperities wear first, the form of surfaces later",
            parameters=(
                _EXCESS,
                replace(_DISTANCE, scan=Scan("travelled", 0.02, 0.5, 5)),
                Parameter(
                    "late_excess", "1", 0.1, -0.9, 10.0, "relative excess of the second stage", "level stays positive"
                ),
                Parameter(
                    "later",
                    "1",
                    8.0,
                    2.0,
                    100.0,
                    "distance of the second stage over that of the first",
                    "two exponentials closer than a factor of two are hard to distinguish",
                ).shape(Scan("one", 4.0, 16.0, 2), fixed=True, natural="both"),
            ),
            factor=_stages_factor,
            slopes={"factor.travelled": _stages_factor_travelled},
        ),
    ),
)
