"""The drive follows its command with a first-order lag."""

from __future__ import annotations

from typing import Any

from sim.effect import Effect, Parameter, Scan
from sim.in_time import DriveLag


def _signal(signal: Any, step: float, p: Any) -> Any:
    from sim.record_kernels import first_order_lag

    return first_order_lag(signal, step, p.time_constant)


EFFECT = Effect(
    name="drive_lag",
    meaning="the drive follows its command with a first-order lag",
    equation="y' = (u - y) / time_constant",
    shows="the residual grows with the rate of change of the signal: fast motion comes late and rounded",
    source="first-order system, e.g. Ljung, System Identification (1999), sec. 4.2",
    acts_on="drive",
    coordinates=("frequency", "input"),
    parameters=(
        Parameter(
            "time_constant",
            "s",
            1e-3,
            0.0,
            100.0,
            "time to 63 % of a step",
            "amplifier or piezo charging lag",
            role="shape",
            scan=Scan("sample", 0.3, 300.0, 10),
        ),
    ),
    signal=_signal,
    in_time=lambda p: DriveLag(p.time_constant),
)
