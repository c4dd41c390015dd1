"""A sensor reports the measured quantity after a delay."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan
from sim.effects.sensor.sensor_lag import LONGEST, LONGEST_ROWS


def _signal(signal: Any, step: float, p: Any) -> Any:
    index = np.arange(signal.size)
    return np.interp(index - p.delay / step, index, signal)


def _signal_of_curves(signal: Any, step: float, p: Any) -> Any:
    from scipy.interpolate import PchipInterpolator

    index = np.arange(signal.size)
    return PchipInterpolator(index, signal)(np.clip(index - p.delay / step, 0.0, signal.size - 1.0))


def _inverse(signal: Any, step: float, p: Any) -> Any:
    return _signal(signal, step, p._replace(delay=-p.delay))


_STRAIGHT = Effect(
    name="sensor_delay",
    meaning="a sensor reports the measured quantity after a delay",
    equation="y(t) = u(t - delay), u linear between rows",
    shows="the residual grows with the rate of change of the signal, with one delay at all frequencies",
    source="pure transport delay, e.g. Ljung, System Identification (1999), sec. 4.2",
    acts_on="sensor",
    coordinates=("frequency", "input"),
    parameters=(
        Parameter("delay", "s", 1e-3, 0.0, 100.0, "delay of the signal", "sampling and transport").shape(
            Scan("sample", 0.1, LONGEST_ROWS / 1.5, 8, reach=LONGEST / 1.5), natural="low"
        ),
    ),
    signal=_signal,
    inverse=_inverse,
)

_OF_CURVES = replace(
    _STRAIGHT,
    name="sensor_delay:of_curves",
    between_rows=True,
    meaning="a sensor reports, after a delay, a quantity that is smooth between rows",
    equation="y(t) = u(t - delay), u a monotone cubic between rows (Fritsch and Carlson 1980)",
    signal=_signal_of_curves,
)

EFFECT = replace(_STRAIGHT, variants=(_OF_CURVES,))
