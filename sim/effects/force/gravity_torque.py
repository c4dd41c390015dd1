"""The torque of an unbalanced weight on a rotary axis."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect, Parameter


def _force(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.sin(axis.position)


def _force_position(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.cos(axis.position)


EFFECT = Effect(
    name="gravity_torque",
    meaning="torque of an unbalanced weight, proportional to the sine of the angle (rotary axis)",
    equation="F = amplitude * sin(x)",
    shows="the residual follows the sine of the angle, the same in both directions",
    source="statics: m g r sin(angle)",
    acts_on="axis",
    coordinates=("position",),
    needs=("rotary",),
    parameters=(Parameter("amplitude", "N", 0.1, -1e9, 1e9, "largest torque", "either sign"),),
    force=_force,
    slopes={"force.position": _force_position},
)
