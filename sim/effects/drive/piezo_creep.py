"""Creep of a piezo after a step of voltage."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan
from sim.numerics.record_operators import first_order_lag


def _lags(signal: Any, step: float, parts: list[tuple[float, float]]) -> Any:
    """The signal (n,) with parts of it that lag behind, each with its time constant, s.

    The lags start at rest on the first row: the piezo has been at that voltage for a long time.
    """
    out = np.array(signal := np.ascontiguousarray(signal))
    for part, time_constant in parts:
        out += part * first_order_lag(signal, step, time_constant)
    return out


def _logarithmic(signal: Any, step: float, p: Any) -> Any:
    # The sum of equal lags with logarithmically spaced time constants rises with log t between the first and the last.
    parts = [(p.decades / 12.0 * p.strength, p.start * 10.0 ** (k * p.decades / 12.0)) for k in range(13)]
    return _lags(signal, step, parts)


def _exponential(signal: Any, step: float, p: Any) -> Any:
    return _lags(signal, step, [(p.strength, p.time_constant), (p.slow_strength, p.time_constant * p.ratio)])


def _three_exponentials(signal: Any, step: float, p: Any) -> Any:
    parts = (p.quick, p.middle, p.slow)
    return _lags(signal, step, [(part, p.time_constant * p.ratio**k) for k, part in enumerate(parts)])


_LOGARITHMIC = Effect(
    name="piezo_creep",
    meaning="after a step of voltage a piezo continues to extend with the logarithm of time",
    equation="d(t) = d0 (1 + strength * log10(t / start)), approximated by lags from start to start * 10^decades",
    shows="after each step the residual continues to drift for seconds, at a decreasing rate",
    source="Jung and Gweon, Rev. Sci. Instrum. 71 (2000) 1896; catalogues: 1-2 % per decade",
    acts_on="piezo",
    coordinates=("time", "contact_age"),
    parameters=(
        Parameter("strength", "1", 0.015, 0.0, 0.5, "extension gained per decade of time", "1-2 % per decade"),
        Parameter("start", "s", 0.1, 1e-6, 1e4, "time at which creep begins", "0.1 s by convention").shape(
            Scan("time", 5e-4, 0.1, 5), natural="both"
        ),
        Parameter(
            "decades", "1", 3.0, 1.0, 5.0, "decades of time over which it continues", "longer drift exceeds the record"
        ).shape(fixed=True),
    ),
    signal=_logarithmic,
)

_EXPONENTIAL = replace(
    _LOGARITHMIC,
    name="piezo_creep:exponential",
    meaning="after a step of voltage a piezo continues to extend, by a fast and a slow exponential",
    equation="d = u + strength * lag(u; time_constant) + slow_strength * lag(u; ratio * time_constant)",
    source="Croft, Shed, Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35: springs and dampers in series",
    parameters=(
        Parameter("strength", "1", 0.01, 0.0, 0.5, "part that creeps quickly", "1-2 % per decade"),
        Parameter("slow_strength", "1", 0.01, 0.0, 0.5, "part that creeps slowly", "1-2 % per decade"),
        Parameter("time_constant", "s", 0.5, 1e-6, 1e4, "time constant of the quick part", "0.1-10 s").shape(
            Scan("time", 2e-3, 0.3, 6), natural="high"
        ),
        Parameter("ratio", "1", 10.0, 2.0, 100.0, "slow time constant over the quick one", "a decade").shape(
            natural="both"
        ),
    ),
    signal=_exponential,
)

_THREE = replace(
    _LOGARITHMIC,
    name="piezo_creep:three_exponentials",
    meaning="after a step of voltage a piezo continues to extend, by three exponentials",
    equation="d = u + quick * lag(u; T) + middle * lag(u; ratio T) + slow * lag(u; ratio^2 T),  T = time_constant",
    source="Croft, Shed, Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35: three springs and dampers in series",
    parameters=(
        Parameter("quick", "1", 0.01, 0.0, 1.0, "part with the shortest time constant", "1-2 % per decade"),
        Parameter("middle", "1", 0.01, 0.0, 1.0, "part with the middle time constant", "1-2 % per decade"),
        Parameter("slow", "1", 0.01, 0.0, 1.0, "part with the longest time constant", "1-2 % per decade"),
        Parameter("time_constant", "s", 0.1, 1e-6, 1e4, "shortest time constant", "0.1-10 s").shape(
            Scan("time", 2e-3, 0.1, 5), natural="high"
        ),
        Parameter(
            "ratio", "1", 5.0, 2.0, 30.0, "each time constant over the next shorter one", "half a decade or more"
        ).shape(natural="both"),
    ),
    signal=_three_exponentials,
)

EFFECT = replace(_LOGARITHMIC, variants=(_EXPONENTIAL, _THREE))
