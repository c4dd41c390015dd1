"""A friction level that follows the temperature."""

from __future__ import annotations

from typing import Any

from sim.effect import Axis, Effect, Parameter


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.coefficient * (axis.temperature - p.reference)


EFFECT = Effect(
    name="temperature_dependent_friction",
    meaning="the friction level changes with temperature",
    equation="level * (1 + coefficient * (T - reference))",
    shows="the friction level drifts as the recorded temperature does, whichever way the axis moves",
    source="Simoni, Beschi, Legnani, Visioli, Robotics and Computer-Integrated Manufacturing 36 (2015) 85",
    acts_on="friction",
    coordinates=("temperature", "time"),
    needs=("temperature",),
    parameters=(
        Parameter("coefficient", "1/K", -0.01, -0.5, 0.5, "relative change of the level per kelvin", "either sign"),
        Parameter(
            "reference",
            "degC",
            20.0,
            -273.0,
            3000.0,
            "temperature at which the level holds",
            "mean of the record",
            role="reference",
        ),
    ),
    factor=_factor,
)
