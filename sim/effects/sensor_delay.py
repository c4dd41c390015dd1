"""A sensor reports the measured quantity after a delay."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effect import Effect, Parameter, Scan


def _signal(signal: Any, step: float, p: Any) -> Any:
    from sim.record_kernels import delayed

    return delayed(np.ascontiguousarray(signal, dtype=float), p.delay / step)


def _signal_of_lines(signal: Any, step: float, p: Any) -> Any:
    index = np.arange(signal.size)
    return np.interp(index - p.delay / step, index, signal)


_SMOOTH = Effect(
    name="sensor_delay",
    meaning="a sensor reports the measured quantity after a delay",
    equation="y(t) = u(t - delay), between rows by a cubic that stays between them",
    shows="the residual grows with the rate of change of the signal, alike at all frequencies",
    source="pure transport delay, e.g. Ljung, System Identification (1999), sec. 4.2",
    acts_on="sensor",
    coordinates=("frequency", "input"),
    parameters=(
        Parameter(
            "delay",
            "s",
            1e-3,
            0.0,
            100.0,
            "time by which the signal comes late",
            "sampling and transport",
            role="shape",
            scan=Scan("sample", 0.3, 100.0, 8),
        ),
    ),
    signal=_signal,
)

_OF_LINES = replace(
    _SMOOTH,
    name="sensor_delay:of_lines",
    meaning="a sensor reports, after a delay, a quantity that goes straight from row to row",
    equation="y(t) = u(t - delay), u straight between rows",
    signal=_signal_of_lines,
)

EFFECT = replace(_SMOOTH, variants=(_OF_LINES,))
