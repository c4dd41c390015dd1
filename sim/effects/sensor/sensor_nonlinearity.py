"""A sensor whose scale changes over its range."""

from typing import Any

from sim.effects.effect import Effect, Parameter


def _signal(signal: Any, step: float, p: Any) -> Any:
    ratio = signal / p.full_scale
    return signal + p.full_scale * (p.second_order + p.third_order * ratio) * ratio * ratio


EFFECT = Effect(
    name="sensor_nonlinearity",
    meaning="the scale of a sensor changes over its range",
    equation="y = u + full_scale * (second_order * (u/full_scale)^2 + third_order * (u/full_scale)^3)",
    shows="the residual of a channel is a curve of that channel alone",
    source="JCGM 200:2012, 4.31 calibration curve; LVDT and capacitive probe data sheets quote it per full scale",
    acts_on="sensor",
    coordinates=("position", "input"),
    parameters=(
        Parameter("second_order", "1", 0.0, -1.5, 1.5, "quadratic part, of full scale", "either sign"),
        Parameter("third_order", "1", 0.0, -1.5, 1.5, "cubic part, of full scale", "either sign"),
        Parameter(
            "full_scale", "channel", 1.0, 1e-15, 1e15, "range of the sensor", "largest value of the record", "reference"
        ),
    ),
    signal=_signal,
)
