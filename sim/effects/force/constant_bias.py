"""Constant bias: a steady force on the axis."""

import math
from typing import Any

from sim.effects.effect import Axis, Effect, Parameter


def force(axis: Axis, p: Any) -> Any:
    return p.force + 0.0 * axis.velocity


EFFECT = Effect(
    name="constant_bias",
    meaning="a steady force on the axis: a tilt under gravity, a drive's or a load cell's offset",
    equation="force = force",
    shows="Residual has a constant offset, the same in both directions.",
    dissipation="Conservative: no work over a closed cycle of position.",
    source="statics; Swevers et al. 1997, IEEE Control Systems 17(5): offset as a separate parameter",
    parameters=(
        Parameter("force", "N", 0.1, -math.inf, math.inf, "force against positive motion", "assumed: order of a cable"),
    ),
    coordinates=(),
    force=force,
    acts_on="axis",
)
