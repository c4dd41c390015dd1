"""Stribeck effect: friction falls from its static to its Coulomb value as the speed rises."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan


def level(axis: Axis, p: Any) -> Any:
    return p.force * np.exp(-(np.abs(axis.velocity / p.velocity) ** p.exponent))


def level_velocity(axis: Axis, p: Any) -> Any:
    ratio = np.abs(axis.velocity / p.velocity)
    # The small number keeps 0 ** (exponent - 1) finite at rest, where the slope is zero for exponents above one.
    steep = p.exponent * (ratio + 1e-300) ** (p.exponent - 1.0) * np.exp(-(ratio**p.exponent))
    return -p.force * steep * np.sign(axis.velocity) / p.velocity


def rational(axis: Axis, p: Any) -> Any:
    return p.force / (1.0 + np.abs(axis.velocity / p.velocity) ** p.exponent)


def rational_velocity(axis: Axis, p: Any) -> Any:
    ratio = np.abs(axis.velocity / p.velocity)
    steep = p.exponent * (ratio + 1e-300) ** (p.exponent - 1.0) / (1.0 + ratio**p.exponent) ** 2
    return -p.force * steep * np.sign(axis.velocity) / p.velocity


_GAUSSIAN = Effect(
    name="stribeck",
    meaning="friction falls with sliding speed: static friction above the Coulomb level, and stick-slip",
    equation="level += force * exp(-|v/velocity|^exponent)",
    shows="Residual peaks near zero velocity on both sides and decays within a few Stribeck velocities.",
    source="Stribeck 1902, Z. VDI 46; Tustin 1947 and Bo and Pavelescu 1982 for the curve; thesis (4.5): Gaussian",
    parameters=(
        Parameter(
            "force", "N", 0.5, 0.0, math.inf, "static friction above the Coulomb level, Fs - Fc", "thesis Table 3"
        ),
        Parameter(
            "velocity", "m/s", 1e-3, 1e-9, 1e3, "speed over which friction falls", "thesis Table 3: 1 mm/s"
        ).shape(Scan("velocity", 1e-3, 1.0, 13)),
        Parameter(
            "exponent",
            "1",
            2.0,
            0.5,
            4.0,
            "exponent of the curve: 1 Tustin, 2 Gaussian",
            "thesis (4.5): 2; Bo and Pavelescu 1982: 0.5 to 1",
        ).shape(Scan("one", 0.5, 4.0, 5, "linear"), fixed=True, natural="both"),
    ),
    coordinates=("velocity", "direction"),
    level=level,
    slopes={"level.velocity": level_velocity},
    acts_on="friction",
)

EFFECT = replace(
    _GAUSSIAN,
    variants=(
        replace(
            _GAUSSIAN,
            name="stribeck:free_exponent",
            meaning="the Stribeck effect with a free exponent of its curve",
            parameters=(*_GAUSSIAN.parameters[:2], replace(_GAUSSIAN.parameters[2], fixed=False)),
        ),
        replace(
            _GAUSSIAN,
            name="stribeck:rational",
            meaning="the Stribeck effect with a curve that decays as a power of the speed",
            equation="level += force / (1 + |v/velocity|^exponent)",
            source="Hess and Soom 1990, J. Tribology 112, 147, eq. 7: exponent 2",
            parameters=(*_GAUSSIAN.parameters[:2], replace(_GAUSSIAN.parameters[2], fixed=False)),
            level=rational,
            slopes={"level.velocity": rational_velocity},
        ),
    ),
)
