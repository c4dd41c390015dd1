"""Friction that follows a change of the velocity, or of the speed, with a delay or a first-order lag."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, DelayedSpeed, Effect, Parameter, Scan
from sim.numerics.record_operators import first_order_lag


def _memory(axis: Axis, p: Any) -> Axis:
    speed = np.interp(axis.time - p.delay, axis.time, np.abs(axis.velocity))
    return axis._replace(velocity=axis.direction * speed)


def _film(axis: Axis, p: Any) -> Axis:
    step = float(axis.time[1] - axis.time[0]) if axis.time.size > 1 else 1.0
    return axis._replace(velocity=axis.direction * first_order_lag(np.abs(axis.velocity), step, p.time_constant))


def _relaxation(axis: Axis, p: Any) -> Axis:
    step = float(axis.time[1] - axis.time[0]) if axis.time.size > 1 else 1.0
    return axis._replace(velocity=first_order_lag(np.ascontiguousarray(axis.velocity), step, p.time_constant))


_PURE = Effect(
    name="frictional_lag",
    meaning="the velocity-dependent part of the friction level follows the speed after a pure delay",
    equation="level(v(t - delay))",
    shows="force against velocity opens into a loop at low speed, wider at higher acceleration",
    source="Hess and Soom, J. Tribology 112 (1990) 147: lag of 3-9 ms",
    acts_on="memory",
    coordinates=("velocity", "acceleration"),
    parameters=(
        Parameter(
            "delay", "s", 5e-3, 0.0, 10.0, "delay of the friction behind the speed", "Hess and Soom: 3-9 ms"
        ).shape(Scan("sample", 2.0, 150.0, 8), natural="low"),
    ),
    memory=_memory,
    time_domain=lambda p: DelayedSpeed(p.delay),
)

_RELAXATION = replace(
    _PURE,
    name="frictional_lag:relaxation",
    meaning="the velocity-dependent part of the friction level follows the velocity with a first-order lag",
    equation="level(w);  w' = (v - w) / time_constant",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, sec. 2.2 (frictional memory)",
    parameters=(
        Parameter(
            "time_constant",
            "s",
            5e-3,
            0.0,
            10.0,
            "time in which the friction follows the velocity",
            "as the pure lag: 3-9 ms",
        ).shape(Scan("sample", 2.0, 150.0, 8), natural="low"),
    ),
    memory=_relaxation,
    time_domain=None,
)

_FILM = replace(
    _RELAXATION,
    name="frictional_lag:film",
    meaning="the velocity-dependent part of the friction level follows the speed with a first-order lag, also through "
    "a reversal, as the thickness of a film does",
    equation="level(w);  w' = (|v| - w) / time_constant",
    source="Harnoy and Friedland, Tribol. Trans. 37 (1994) 608 (thickness of the film); Hess and Soom (1990)",
    memory=_film,
)

EFFECT = replace(_PURE, variants=(_RELAXATION, _FILM))
