"""Cable spring: a cable, hose or flexure pulls the axis towards a rest position."""

import math
from typing import Any

from sim.effects.effect import Axis, Effect, Parameter


def force(axis: Axis, p: Any) -> Any:
    return p.stiffness * (axis.position - p.rest_position)


def force_position(axis: Axis, p: Any) -> Any:
    return p.stiffness + 0.0 * axis.position


EFFECT = Effect(
    name="cable_spring",
    meaning="a cable, hose or flexure pulls the axis towards a rest position",
    equation="force = stiffness * (x - rest_position)",
    shows="Residual is linear in position, the same in both directions.",
    dissipation="Conservative: no work over a closed cycle of position.",
    source="Hooke; cable-carrier disturbance in precision stages: Slocum 1992, Precision Machine Design, ch. 7",
    parameters=(
        Parameter("stiffness", "N/m", 10.0, 0.0, math.inf, "stiffness of the cable", "assumed: a sensor cable"),
        Parameter(
            "rest_position", "m", 0.0, -math.inf, math.inf, "position where it does not pull", "assumed: mid-travel"
        ),
    ),
    coordinates=("position",),
    force=force,
    slopes={"force.position": force_position},
    acts_on="axis",
)
