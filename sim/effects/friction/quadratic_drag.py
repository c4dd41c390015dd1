"""Drag proportional to the square of the speed."""

from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter


def _force(axis: Axis, p: Any) -> Any:
    return p.coefficient * axis.velocity * np.abs(axis.velocity)


def _force_velocity(axis: Axis, p: Any) -> Any:
    return 2.0 * p.coefficient * np.abs(axis.velocity)


EFFECT = Effect(
    name="quadratic_drag",
    meaning="drag proportional to the square of the speed: air, or stirred oil",
    equation="F = coefficient * v |v|",
    shows="force against velocity deviates from a straight line at high speed, in both directions",
    dissipation="Dissipates coefficient |v|^3.",
    source="Hoerner, Fluid-Dynamic Drag (1965), ch. 1",
    acts_on="axis",
    coordinates=("velocity",),
    parameters=(
        Parameter("coefficient", "N*s^2/m^2", 1.0, 0.0, 1e9, "force over speed squared", "drag dissipates: >= 0"),
    ),
    force=_force,
    slopes={"force.velocity": _force_velocity},
)
