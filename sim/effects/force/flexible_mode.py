"""A resonance between the drive, the moving body and what is measured."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import AddedOscillator, Effect, Parameter, Scan
from sim.numerics.record_operators import resonance, resonance_of_steps


def _signal(signal: Any, step: float, p: Any) -> Any:
    return resonance(np.ascontiguousarray(signal), step, p.frequency, p.damping)


def _signal_of_steps(signal: Any, step: float, p: Any) -> Any:
    return resonance_of_steps(np.ascontiguousarray(signal), step, p.frequency, p.damping)


_SMOOTH = Effect(
    name="flexible_mode",
    meaning="a resonance of the structure between the drive and the sensor",
    equation=(
        "y'' + 2 damping w y' + w^2 y = w^2 u,  w = 2 pi frequency; "
        "on an axis, a part r of the mass oscillates; a tip moves by u + r (y - u)"
    ),
    shows="oscillation at one frequency after every fast change",
    dissipation="Dissipates in its own damper; passive.",
    source="Rankers, Machine Dynamics in Mechatronic Systems (1997)",
    acts_on="structure",
    coordinates=("frequency", "acceleration"),
    parameters=(
        Parameter("frequency", "Hz", 100.0, 1e-3, 1e6, "natural frequency", "below half the sampling frequency").shape(
            Scan("sample", 0.004, 0.4, 48)
        ),
        Parameter("damping", "1", 0.05, 1e-3, 0.35, "damping ratio", "bolted structures: 0.01-0.1").shape(
            natural="low"
        ),
        Parameter(
            "mass_ratio",
            "1",
            0.1,
            0.0,
            1.0,
            "part of the moving mass in the mode; of a tip, the part of its motion that passes through the mode",
            "0: none; 1: all",
            natural="high",
        ),
    ),
    signal=_signal,
    time_domain=lambda p: AddedOscillator(p.frequency, p.damping, p.mass_ratio),
)

_OF_STEPS = replace(
    _SMOOTH,
    name="flexible_mode:of_steps",
    between_rows=True,
    meaning="a resonance between a voltage that is held from row to row and what is measured",
    equation="as flexible_mode; u is held from each row to the next",
    signal=_signal_of_steps,
)

EFFECT = replace(_SMOOTH, variants=(_OF_STEPS,))
