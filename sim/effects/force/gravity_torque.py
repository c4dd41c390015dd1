"""The torque of an unbalanced weight on a rotary axis."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter


def _force(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.sin(axis.position)


def _force_position(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.cos(axis.position)


def _offset_force(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.sin(axis.position + p.phase)


def _offset_force_position(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.cos(axis.position + p.phase)


_VERTICAL = Effect(
    name="gravity_torque",
    meaning="torque of an unbalanced weight, proportional to the sine of the angle (rotary axis)",
    equation="force = amplitude * sin(x)",
    shows="the residual follows the sine of the angle, the same in both directions",
    dissipation="Conservative: no work over a closed cycle of position.",
    source="statics: m g r sin(angle)",
    acts_on="axis",
    coordinates=("position",),
    needs=("rotary",),
    parameters=(Parameter("amplitude", "N", 0.1, -1e9, 1e9, "largest torque", "either sign"),),
    force=_force,
    slopes={"force.position": _force_position},
)

_OFFSET = replace(
    _VERTICAL,
    name="gravity_torque:offset",
    meaning="torque of an unbalanced weight on a rotary axis whose zero angle is not the vertical",
    equation="force = amplitude * sin(x + phase)",
    parameters=(
        replace(_VERTICAL.parameters[0], low=0.0, source="assumed: a tenth of the thesis's Coulomb force"),
        Parameter("phase", "rad", 0.0, -math.pi, math.pi, "angle from the vertical at x = 0", "assumed: zero", "phase"),
    ),
    force=_offset_force,
    slopes={"force.position": _offset_force_position},
)

EFFECT = replace(_VERTICAL, variants=(_OFFSET,))
