"""A friction level that follows the normal load."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.sensitivity * (axis.load / p.reference - 1.0)


def _power(axis: Axis, p: Any) -> Any:
    return np.maximum(axis.load / p.reference, 0.0) ** p.exponent


_STRAIGHT = Effect(
    name="load_dependent_friction",
    meaning="the friction level follows the normal load (Amontons)",
    equation="level * (1 + sensitivity * (N / reference - 1));  sensitivity 1: proportional to the load",
    shows="the friction level rises and falls with the recorded normal load",
    source="Bowden and Tabor, The Friction and Lubrication of Solids (1950), ch. 5",
    acts_on="friction",
    coordinates=("normal_load",),
    needs=("load",),
    parameters=(
        Parameter(
            "sensitivity",
            "1",
            1.0,
            0.0,
            3.0,
            "relative change of level per relative change of load",
            "Amontons: 1; adhesion lowers it; friction does not fall with load",
        ),
        Parameter(
            "reference", "N", 1.0, 1e-12, 1e12, "load at which the factor is 1", "mean of the record", role="reference"
        ),
    ),
    factor=_factor,
)

_POWER = replace(
    _STRAIGHT,
    name="load_dependent_friction:power",
    meaning="the friction level follows a power of the normal load, as the area of an elastic contact does",
    equation="level * (N / reference)^exponent",
    source="Archard, Proc. R. Soc. A 243 (1957) 190: 2/3 for one smooth contact, towards 1 for many",
    parameters=(
        Parameter("exponent", "1", 2.0 / 3.0, 0.0, 2.0, "power of the load", "Hertz: 2/3; Amontons: 1", natural="both"),
        _STRAIGHT.parameters[1],
    ),
    factor=_power,
)

EFFECT = replace(_STRAIGHT, variants=(_POWER,))
