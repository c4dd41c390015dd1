"""Coulomb and viscous friction that differ between the two directions of motion."""

from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.coulomb * axis.direction


def _force(axis: Axis, p: Any) -> Any:
    return p.viscous * np.abs(axis.velocity)


def _force_velocity(axis: Axis, p: Any) -> Any:
    return p.viscous * np.sign(axis.velocity)


EFFECT = Effect(
    name="direction_asymmetry",
    meaning="Coulomb and viscous friction differ between the two directions",
    equation="level * (1 + coulomb * sign v);  F = viscous * |v|",
    shows="the two branches of force against velocity lie at different heights and have different slopes",
    dissipation="Dissipates with viscous friction of at least |viscous|; alone, it returns energy in one direction.",
    source="Janot, Gautier, Brunot, Data Set and Reference Models of EMPS (2019): asymmetric ball-screw friction",
    acts_on="friction",
    coordinates=("direction", "velocity"),
    parameters=(
        Parameter("coulomb", "1", 0.05, -0.9, 0.9, "relative difference of the friction level", "level stays positive"),
        Parameter("viscous", "N*s/m", 0.0, -1e6, 1e6, "half the difference of the viscous coefficients", "either sign"),
    ),
    factor=_factor,
    force=_force,
    slopes={"force.velocity": _force_velocity},
)
