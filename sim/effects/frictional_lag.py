"""Friction that follows a change of velocity only after a while."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Axis, Effect, Parameter, Scan
from sim.in_time import LaggedSpeed


def _memory(axis: Axis, p: Any) -> Axis:
    speed = np.interp(axis.time - p.delay, axis.time, np.abs(axis.velocity))
    return axis._replace(velocity=axis.direction * speed)


EFFECT = Effect(
    name="frictional_lag",
    meaning="the velocity-dependent part of the friction level follows the speed after a pure lag",
    equation="level(v(t - delay))",
    shows="force against velocity opens into a loop at low speed, wider at higher acceleration",
    source="Hess and Soom, J. Tribology 112 (1990) 147: lag of 3-9 ms",
    acts_on="memory",
    coordinates=("velocity", "acceleration"),
    parameters=(
        Parameter(
            "delay",
            "s",
            5e-3,
            0.0,
            10.0,
            "lag of the friction behind the speed",
            "Hess and Soom: 3-9 ms",
            role="shape",
            scan=Scan("sample", 2.0, 60.0, 7),
        ),
    ),
    memory=_memory,
    in_time=lambda p: LaggedSpeed(p.delay),
)
