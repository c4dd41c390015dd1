"""The slow after-stretch of a piezo."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Effect, Parameter, Scan


def _signal(signal: Any, step: float, p: Any) -> Any:
    from sim.record_kernels import first_order_lag

    signal = np.ascontiguousarray(signal)
    out = np.array(signal)
    # A ladder of equal lags, four a decade, climbs like the logarithm between its first and its last time constant.
    for k in range(13):
        out += p.strength * (np.log(10.0) / 4.0) * (
            first_order_lag(signal, step, p.start * 10.0 ** (k / 4.0)) - signal[0]
        ) / np.log(10.0)
    return out


EFFECT = Effect(
    name="piezo_creep",
    meaning="after a step of voltage a piezo goes on stretching with the logarithm of time",
    equation="d(t) = d0 (1 + strength * log10(t / start)), made of lags from start to 1000 start",
    shows="after each step the residual creeps on, in seconds and more slowly each decade",
    source="Jung and Gweon, Rev. Sci. Instrum. 71 (2000) 1896; catalogues: 1-2 % per decade",
    acts_on="piezo",
    coordinates=("time", "contact_age"),
    parameters=(
        Parameter("strength", "1", 0.015, 0.0, 0.5, "stretch gained per decade of time", "1-2 % per decade"),
        Parameter("start", "s", 0.1, 1e-6, 1e4, "time from which it creeps", "0.1 s by convention",
                  role="shape", scan=Scan("time", 5e-4, 0.1, 5)),
    ),
    signal=_signal,
)
