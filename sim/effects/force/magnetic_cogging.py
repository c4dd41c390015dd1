"""Magnetic cogging: a force that repeats with the pitch of teeth or magnets."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan
from sim.effects.friction.position_dependent_friction import SECOND_HARMONIC, two_harmonics_slope, wave_slope


def force(axis: Axis, p: Any) -> Any:
    return p.amplitude * np.sin(2.0 * np.pi * axis.position / p.pitch + p.phase)


def _two_harmonics_force(axis: Axis, p: Any) -> Any:
    angle = 2.0 * np.pi * axis.position / p.pitch + p.phase
    overtone = p.second_sine * np.sin(2.0 * angle) + p.second_cosine * np.cos(2.0 * angle)
    return p.amplitude * (np.sin(angle) + overtone)


_SINE = Effect(
    name="magnetic_cogging",
    meaning="teeth or magnets exert a force that is periodic in position",
    equation="force = amplitude * sin(2 pi x/pitch + phase)",
    shows="Residual is periodic in position, the same in both directions.",
    dissipation="Conservative: no work over a closed cycle of position.",
    source="Otten, de Vries, van Amerongen et al. 1997, IEEE/ASME Trans. Mechatronics 2(3): cogging of linear motors",
    parameters=(
        Parameter("amplitude", "N", 0.1, 0.0, np.inf, "peak force", "assumed: a tenth of the thesis's Coulomb force"),
        Parameter(
            "pitch", "m", 5e-3, 1e-9, 10.0, "distance over which the force repeats", "assumed: the design's tooth pitch"
        ).shape(Scan("position", 0.02, 0.5, 110, "reciprocal", shortest=0.002)),
        Parameter("phase", "rad", 0.0, -np.pi, np.pi, "phase at x = 0", "assumed: aligned at the origin", "phase"),
    ),
    coordinates=("position",),
    force=force,
    slopes={"force.position": wave_slope},
    acts_on="axis",
)

_OVERTONE = replace(
    _SINE,
    name="magnetic_cogging:overtone",
    refinement=True,
    meaning="a cogging force with a second harmonic: square teeth, saturated iron",
    equation="force = amplitude * (sin a + second_sine sin 2a + second_cosine cos 2a), a = 2 pi x/pitch + phase",
    # A second harmonic above the first would be found as a wave of half the pitch.
    parameters=(*_SINE.parameters, *(replace(part, low=-1.0, high=1.0) for part in SECOND_HARMONIC)),
    force=_two_harmonics_force,
    slopes={"force.position": two_harmonics_slope},
)

EFFECT = replace(_SINE, variants=(_OVERTONE,))
