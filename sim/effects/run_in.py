"""A friction level that settles as the surfaces run in."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Axis, Effect, Parameter, Scan


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.excess * np.exp(-axis.travelled / p.distance)


def _factor_travelled(axis: Axis, p: Any) -> Any:
    return -p.excess / p.distance * np.exp(-axis.travelled / p.distance)


EFFECT = Effect(
    name="run_in",
    meaning="the friction level settles with the distance slid",
    equation="level * (1 + excess * exp(-s / distance)), s the distance travelled since the first row",
    shows="the friction level decays with the distance travelled, and stands still while the axis rests",
    source="Blau, Tribology International 38 (2005) 1007: running-in of friction",
    acts_on="friction",
    coordinates=("distance_travelled", "time"),
    parameters=(
        Parameter("excess", "1", 0.2, -0.9, 10.0, "relative excess of the level at the start", "level stays positive"),
        Parameter(
            "distance",
            "m",
            1.0,
            1e-9,
            1e6,
            "distance over which it decays",
            "bounded by the distance slid",
            role="shape",
            scan=Scan("travelled", 0.03, 2.0, 9),
        ),
    ),
    factor=_factor,
    slopes={"factor.travelled": _factor_travelled},
)
