"""A sensor that reports multiples of its resolution."""

from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter


def _signal(signal: Any, step: float, p: Any) -> Any:
    return p.step * np.round(signal / p.step)


EFFECT = Effect(
    name="sensor_quantisation",
    meaning="a sensor reports multiples of its resolution",
    equation="y = step * round(u / step); adds step / sqrt(12) to the noise floor",
    shows="the measured values lie on a grid, and are constant while the axis moves by less than one step",
    source="Widrow and Kollar, Quantization Noise (2008), ch. 4",
    acts_on="sensor",
    rounds=True,
    coordinates=("position",),
    parameters=(
        Parameter(
            "step",
            "channel",
            1e-6,
            0.0,
            1e9,
            "resolution: size of one step",
            "read off the record's values",
            "reference",
        ),
    ),
    signal=_signal,
)
