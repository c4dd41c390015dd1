"""A friction level that follows the temperature."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.coefficient * (axis.temperature - p.reference)


def _exponential(axis: Axis, p: Any) -> Any:
    return np.exp(p.coefficient * (axis.temperature - p.reference))


def _thinner_drag(axis: Axis, p: Any) -> Any:
    return p.drag * axis.velocity * np.expm1(p.drag_coefficient * (axis.temperature - p.reference))


def _thinner_drag_velocity(axis: Axis, p: Any) -> Any:
    return p.drag * np.expm1(p.drag_coefficient * (axis.temperature - p.reference)) + 0.0 * axis.velocity


_REFERENCE = Parameter(
    "reference", "degC", 20.0, -273.0, 3000.0, "temperature at which the factor is 1", "mean of the record", "reference"
)
_DRAG = Parameter(
    "drag", "N*s/m", 1.0, 0.0, math.inf, "temperature-dependent viscous drag, at the reference", "drag dissipates: >= 0"
)
_DRAG_COEFFICIENT = Parameter(
    "drag_coefficient", "1/K", -0.05, -0.5, 0.5, "relative change of the drag per kelvin", "mineral oils: -0.03 to -0.1"
).shape(natural="both")

_LINEAR = Effect(
    name="temperature_dependent_friction",
    meaning="the friction level changes with temperature",
    equation="level * (1 + coefficient * (T - reference))",
    shows="the friction level follows the recorded temperature, in both directions of motion",
    source="Simoni, Beschi, Legnani, Visioli, Robotics and Computer-Integrated Manufacturing 36 (2015) 85",
    acts_on="friction",
    coordinates=("temperature", "time"),
    needs=("temperature",),
    parameters=(
        Parameter("coefficient", "1/K", -0.01, -0.5, 0.5, "relative change of the level per kelvin", "either sign"),
        _REFERENCE,
    ),
    factor=_factor,
)

_EXPONENTIAL = replace(
    _LINEAR,
    name="temperature_dependent_friction:exponential",
    meaning="the friction level changes exponentially with temperature, as the viscosity of a lubricant does",
    equation="level * exp(coefficient * (T - reference))",
    source="Reynolds, Phil. Trans. R. Soc. 177 (1886) 157: viscosity falls exponentially with temperature",
    factor=_exponential,
)

_LUBRICATED = replace(
    _EXPONENTIAL,
    name="temperature_dependent_friction:lubricated",
    refinement=True,
    meaning="level and viscous drag fall with temperature, each at its own rate",
    dissipation="Dissipates with viscous friction of at least `drag`, of which it is the change.",
    equation="level * exp(coefficient * dT) + drag * v * (exp(drag_coefficient * dT) - 1),  dT = T - reference",
    parameters=(
        *_EXPONENTIAL.parameters,
        _DRAG,
        _DRAG_COEFFICIENT,
    ),
    force=_thinner_drag,
    slopes={"force.velocity": _thinner_drag_velocity},
)

EFFECT = replace(_LINEAR, variants=(_EXPONENTIAL, _LUBRICATED))
