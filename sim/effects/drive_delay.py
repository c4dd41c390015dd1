"""The drive acts on its command only after a delay."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Effect, Parameter, Scan
from sim.in_time import DriveDelay


def _signal(signal: Any, step: float, p: Any) -> Any:
    index = np.arange(signal.size)
    return np.interp(index - p.delay / step, index, signal)


EFFECT = Effect(
    name="drive_delay",
    meaning="the drive acts on its command only after a delay",
    equation="y(t) = u(t - delay)",
    shows="the residual grows with the rate of change of the signal, alike at all frequencies",
    source="pure transport delay, e.g. Ljung, System Identification (1999), sec. 4.2",
    acts_on="drive",
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
    in_time=lambda p: DriveDelay(p.delay),
)
