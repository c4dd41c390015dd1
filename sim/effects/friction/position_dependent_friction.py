"""A friction level that varies along the travel."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan

SECOND_HARMONIC = (
    Parameter(
        "second_sine", "1", 0.0, -0.3, 0.3, "sine part of the second harmonic, over the amplitude", "one wave"
    ).shape(natural="both"),
    Parameter(
        "second_cosine", "1", 0.0, -0.3, 0.3, "cosine part of the second harmonic, over the amplitude", "one wave"
    ).shape(natural="both"),
)
"""Parameters of a wave sin a + second_sine sin 2a + second_cosine cos 2a, a = 2 pi x / pitch + phase."""


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.amplitude * np.sin(2.0 * np.pi * axis.position / p.pitch + p.phase)


def wave_slope(axis: Axis, p: Any) -> Any:
    return p.amplitude * 2.0 * np.pi / p.pitch * np.cos(2.0 * np.pi * axis.position / p.pitch + p.phase)


def _gradient_factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.gradient * axis.position


def _gradient_factor_position(axis: Axis, p: Any) -> Any:
    return p.gradient + 0.0 * axis.position


def _two_harmonics_factor(axis: Axis, p: Any) -> Any:
    angle = 2.0 * np.pi * axis.position / p.pitch + p.phase
    overtone = p.second_sine * np.sin(2.0 * angle) + p.second_cosine * np.cos(2.0 * angle)
    return 1.0 + p.amplitude * (np.sin(angle) + overtone)


def two_harmonics_slope(axis: Axis, p: Any) -> Any:
    angle = 2.0 * np.pi * axis.position / p.pitch + p.phase
    overtone = 2.0 * (p.second_sine * np.cos(2.0 * angle) - p.second_cosine * np.sin(2.0 * angle))
    return p.amplitude * 2.0 * np.pi / p.pitch * (np.cos(angle) + overtone)


_SINE = Effect(
    name="position_dependent_friction",
    meaning="the friction level varies along the travel: lapping marks, waviness, uneven preload",
    equation="level * (1 + amplitude * sin(2 pi x / pitch + phase))",
    shows="the residual follows position with the sign of the velocity: mirrored between the two directions",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, sec. 2.3",
    acts_on="friction",
    coordinates=("position",),
    parameters=(
        Parameter("amplitude", "1", 0.1, 0.0, 0.95, "relative variation of the level", "level stays positive"),
        Parameter(
            "pitch", "m", 5e-3, 1e-9, 1e3, "length of one wave", "a pitch far longer than the travel acts as a gradient"
        ).shape(Scan("position", 0.02, 1.6, 112, "reciprocal", shortest=0.002)),
        Parameter("phase", "rad", 0.0, -50.0, 50.0, "angle at x = 0", "full circle", role="phase"),
    ),
    factor=_factor,
    slopes={"factor.position": wave_slope},
)

_GRADIENT = replace(
    _SINE,
    name="position_dependent_friction:gradient",
    meaning="the friction level changes linearly along the travel",
    equation="level * (1 + gradient * x)",
    parameters=(
        Parameter("gradient", "1/m", 1.0, -1e6, 1e6, "relative change of the level per length", "either sign"),
    ),
    factor=_gradient_factor,
    slopes={"factor.position": _gradient_factor_position},
)

_OVERTONE = replace(
    _SINE,
    name="position_dependent_friction:overtone",
    refinement=True,
    meaning="a periodic variation along the travel with a second harmonic",
    equation="level * (1 + amplitude * (sin a + second_sine sin 2a + second_cosine cos 2a)), a = 2 pi x/pitch + phase",
    parameters=(*(replace(p, high=0.6) if p.name == "amplitude" else p for p in _SINE.parameters), *SECOND_HARMONIC),
    factor=_two_harmonics_factor,
    slopes={"factor.position": two_harmonics_slope},
)

EFFECT = replace(_SINE, variants=(_GRADIENT, _OVERTONE))
