"""A sensor whose zero drifts with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Effect, Parameter


def _signal(signal: Any, step: float, p: Any) -> Any:
    return signal + p.rate * step * np.arange(signal.size)


EFFECT = Effect(
    name="sensor_drift",
    meaning="the zero of a sensor drifts with time",
    equation="y = u + rate * t",
    shows="the residual grows with time alone, whatever the axis does",
    source="ISO 9283 and JCGM 200:2012, 4.21 instrumental drift",
    acts_on="sensor",
    coordinates=("time",),
    parameters=(Parameter("rate", "channel/s", 0.0, -1e9, 1e9, "change of the zero per second", "either sign"),),
    signal=_signal,
)
