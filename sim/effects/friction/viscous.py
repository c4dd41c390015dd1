"""Viscous friction: force proportional to velocity."""

import math
from typing import Any

from sim.effects.effect import Axis, Effect, Parameter


def force(axis: Axis, p: Any) -> Any:
    return p.coefficient * axis.velocity


def force_velocity(axis: Axis, p: Any) -> Any:
    return p.coefficient + 0.0 * axis.velocity


EFFECT = Effect(
    name="viscous",
    meaning="friction proportional to velocity, from a lubricant or the air",
    equation="force = coefficient * v",
    shows="Residual is proportional to velocity.",
    dissipation="Dissipates coefficient v^2.",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit 1994, Automatica 30(7), section 2.2; thesis (4.6)",
    parameters=(
        Parameter("coefficient", "N*s/m", 0.4, 0.0, math.inf, "drag per velocity", "thesis Table 3: alpha2 = 0.4"),
    ),
    coordinates=("velocity", "direction"),
    force=force,
    slopes={"force.velocity": force_velocity},
    acts_on="axis",
)
