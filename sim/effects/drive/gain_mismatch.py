"""Two piezos that extend by different amounts for the same voltage."""

from typing import Any

from sim.effects.effect import Effect, Parameter


def _signal(signal: Any, step: float, p: Any) -> Any:
    return signal * (1.0 + p.mismatch)


EFFECT = Effect(
    name="gain_mismatch",
    meaning="piezo 2 extends more or less than piezo 1 for the same voltage",
    equation="d2 = (1 + mismatch) * gain * (voltage_2 - bias_voltage)",
    shows="each channel contains a part of the other's motion",
    source="piezo stacks are sold with 10-20 % tolerance of stroke (catalogues)",
    acts_on="piezo",
    piezo=1,
    coordinates=("input",),
    parameters=(
        Parameter(
            "mismatch", "1", 0.0, -0.8, 4.0, "relative excess of piezo 2's gain", "a weak or cracked stack at most"
        ),
    ),
    signal=_signal,
)
