"""A sensor whose zero drifts with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Effect, Parameter, Scan


def _signal(signal: Any, step: float, p: Any) -> Any:
    return signal + p.amplitude * -np.expm1(-step * np.arange(signal.size) / p.time_constant)


EFFECT = Effect(
    name="sensor_drift",
    meaning="the zero of a sensor drifts with time",
    equation="y = u + amplitude * (1 - exp(-t / time_constant)), t since the first row",
    shows="the residual grows with time alone, whatever the axis does",
    source="ISO 9283 and JCGM 200:2012, 4.21 instrumental drift",
    acts_on="sensor",
    coordinates=("time",),
    parameters=(
        Parameter("amplitude", "channel", 0.0, -1e9, 1e9, "how far the zero moves in the end", "either sign"),
        Parameter(
            "time_constant",
            "s",
            10.0,
            1e-6,
            1e9,
            "warm-up time; far beyond the record it is a steady drift",
            "warm-up of electronics and mounts",
            role="shape",
            scan=Scan("time", 0.05, 5.0, 7),
        ),
    ),
    signal=_signal,
)
