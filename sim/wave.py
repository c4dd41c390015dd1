"""A wave along the travel with its overtone: what lapping marks, teeth and magnets leave is seldom a pure sine.

w = sin a + second_sine sin 2a + second_cosine cos 2a,    a = 2 pi x / pitch + phase
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Axis, Parameter

SECOND = (
    Parameter("second_sine", "1", 0.0, -0.3, 0.3, "half the length, of the wave: leaning flanks", "one wave", "shape"),
    Parameter("second_cosine", "1", 0.0, -0.3, 0.3, "half the length, of the wave: broad crests", "one wave", "shape"),
)
"""Parameters of the overtone."""


def wave(axis: Axis, p: Any) -> Any:
    """The wave at the axis's position; no unit, at most 1.6."""
    angle = 2.0 * np.pi * axis.position / p.pitch + p.phase
    return np.sin(angle) + p.second_sine * np.sin(2.0 * angle) + p.second_cosine * np.cos(2.0 * angle)


def wave_position(axis: Axis, p: Any) -> Any:
    """Its slope over the position, 1/m."""
    angle = 2.0 * np.pi * axis.position / p.pitch + p.phase
    overtone = p.second_sine * np.cos(2.0 * angle) - p.second_cosine * np.sin(2.0 * angle)
    return 2.0 * np.pi / p.pitch * (np.cos(angle) + 2.0 * overtone)
