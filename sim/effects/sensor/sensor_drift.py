"""A sensor whose zero drifts with time."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan


def _signal(signal: Any, step: float, p: Any) -> Any:
    return signal + p.amplitude * -np.expm1(-step * np.arange(signal.size) / p.time_constant)


def _power(signal: Any, step: float, p: Any) -> Any:
    return signal + p.amplitude * (step * np.arange(signal.size) / p.reference_time) ** p.exponent


_WARM_UP = Effect(
    name="sensor_drift",
    meaning="the zero of a sensor drifts with time",
    equation="y = u + amplitude * (1 - exp(-t / time_constant)), t since the first row",
    shows="the residual changes with time alone, independently of the motion",
    source="ISO 9283 and JCGM 200:2012, 4.21 instrumental drift",
    acts_on="sensor",
    added_to_output=True,
    coordinates=("time",),
    parameters=(
        Parameter("amplitude", "channel", 0.0, -1e9, 1e9, "final shift of the zero", "either sign"),
        Parameter(
            "time_constant",
            "s",
            10.0,
            1e-6,
            1e9,
            "time constant of the warm-up; if much longer than the record, the drift is linear in time",
            "warm-up of electronics and mounts",
        ).shape(Scan("time", 0.05, 5.0, 7), natural="high"),
    ),
    signal=_signal,
)

_POWER = replace(
    _WARM_UP,
    name="sensor_drift:power",
    meaning="the zero of a sensor drifts as a power of time: at a decreasing rate below 1, an increasing one above",
    equation="y = u + amplitude * (t / reference_time)^exponent, t since the first row",
    source="power law of ageing and creep, e.g. Findley, Lai and Onaran, Creep and Relaxation (1976), ch. 2",
    parameters=(
        Parameter("amplitude", "channel", 0.0, -1e9, 1e9, "shift of the zero at reference_time", "either sign"),
        Parameter("exponent", "1", 1.0, 0.2, 3.0, "power of time", "1: linear drift").shape(
            Scan("one", 0.4, 2.0, 5), natural="both"
        ),
        Parameter(
            "reference_time",
            "s",
            10.0,
            1e-9,
            1e9,
            "time at which the amplitude is reached",
            "a choice of scale",
            "reference",
        ),
    ),
    signal=_power,
)

EFFECT = replace(_WARM_UP, variants=(_POWER,))
