"""A sensor follows the measured quantity with a first-order lag."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan
from sim.numerics.record_operators import first_order_lag, first_order_lag_of_steps

LONGEST, LONGEST_ROWS = 0.05, 50.0
"""Longest plausible lag or delay of a logger, s, and in rows: filters of amplifiers and buses take milliseconds."""


def _signal(signal: Any, step: float, p: Any) -> Any:
    return first_order_lag(signal, step, p.time_constant)


def _signal_of_steps(signal: Any, step: float, p: Any) -> Any:
    return first_order_lag_of_steps(np.ascontiguousarray(signal), step, p.time_constant, p.early)


def _inverse(signal: Any, step: float, p: Any) -> Any:
    slope = np.gradient(signal)
    # Fourth order: a filter as narrow as one row passes frequencies at which second order is 16 % too low.
    slope[2:-2] = (8.0 * (signal[3:-1] - signal[1:-3]) - (signal[4:] - signal[:-4])) / 12.0
    return signal + p.time_constant / step * slope


_SMOOTH = Effect(
    name="sensor_lag",
    meaning="a sensor follows the measured quantity with a first-order lag",
    equation="y' = (u - y) / time_constant",
    shows="the residual grows with the rate of change of the signal: fast motion is delayed and attenuated",
    source="first-order system, e.g. Ljung, System Identification (1999), sec. 4.2",
    acts_on="sensor",
    coordinates=("frequency", "input"),
    parameters=(
        Parameter("time_constant", "s", 1e-3, 0.0, 100.0, "time to 63 % of a step", "filter in the electronics").shape(
            Scan("sample", 0.3, LONGEST_ROWS / 1.5, 8, reach=LONGEST / 1.5), natural="low"
        ),
    ),
    signal=_signal,
    inverse=_inverse,
)

_OF_STEPS = replace(
    _SMOOTH,
    name="sensor_lag:of_steps",
    between_rows=True,
    meaning="a digital first-order filter of the measured quantity, which is held from row to row",
    equation="as sensor_lag; u is held, and changes to a row's value the part `early` of a step before that row",
    source="Astrom and Wittenmark, Computer-Controlled Systems (1997), sec. 2.3 (delay of a part of a step)",
    parameters=(
        *_SMOOTH.parameters,
        Parameter(
            "early",
            "1",
            0.5,
            0.0,
            1.0,
            "time from the change of the input to the row with its value, over the step; 1 for a digital filter",
            "0 to 1",
        ).shape(Scan("one", 0.1, 0.9, 2, "linear"), natural="both"),
    ),
    signal=_signal_of_steps,
)

EFFECT = replace(_SMOOTH, variants=(_OF_STEPS,))
