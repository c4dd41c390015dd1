"""Damping of the elastic deflection of a contact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect, Parameter, Scan
from sim.library.friction_state import FrictionStateModel


def _force(axis: Axis, p: Any) -> Any:
    return _along(axis.position, axis.velocity, axis.time, axis.velocity, p)


def _law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    """In time the bristle yields along a steep curve instead of abruptly, as those of Maxwell-slip do."""
    size = direction * z / p.stretch
    rate = v * (1.0 - size**8) if size > 0.0 else v
    return rate, p.damping * rate


def _slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    size = direction * z / p.stretch
    if size <= 0.0:
        return 0.0, 1.0, 0.0, 0.0, p.damping, 0.0
    rate_z, rate_v = -v * 8.0 * size**7 * direction / p.stretch, 1.0 - size**8
    return rate_z, rate_v, 0.0, p.damping * rate_z, p.damping * rate_v, 0.0


def _along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    from sim.numerics.record_operators import sticking_fraction

    return p.damping * velocity * sticking_fraction(np.ascontiguousarray(position), p.stretch)


SPREAD = 8
"""Bristles of the law with many lengths."""


def _spread_force(axis: Axis, p: Any) -> Any:
    return _spread_along(axis.position, axis.velocity, axis.time, axis.velocity, p)


def _spread_law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    size = direction * z / (p.stretch * p.span ** ((k - 7.0) / 7.0))
    rate = v * (1.0 - size**8) if size > 0.0 else v
    return rate, p.damping / 8.0 * rate


def _spread_slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    limit = p.stretch * p.span ** ((k - 7.0) / 7.0)
    size = direction * z / limit
    part = p.damping / 8.0
    if size <= 0.0:
        return 0.0, 1.0, 0.0, 0.0, part, 0.0
    rate_z, rate_v = -v * 8.0 * size**7 * direction / limit, 1.0 - size**8
    return rate_z, rate_v, 0.0, part * rate_z, part * rate_v, 0.0


def _spread_along(
    position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any
) -> np.ndarray:
    from sim.numerics.record_operators import sticking_fraction

    position = np.ascontiguousarray(position)
    stretches = p.stretch * p.span ** ((np.arange(SPREAD) - 7.0) / 7.0)
    return p.damping / SPREAD * velocity * sum(sticking_fraction(position, stretch) for stretch in stretches)


_ONE = Effect(
    name="bristle_damping",
    meaning="viscous damping of the contact's elastic deflection before it slides (a1 of LuGre)",
    equation="F = damping * v while a bristle of +-stretch has not slipped; 0 once it slides",
    shows="the faster the reversal, the higher the force just after it",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419",
    acts_on="friction",
    coordinates=("distance_since_reversal", "velocity"),
    parameters=(
        Parameter("damping", "N*s/m", 10.0, 0.0, 1e9, "force per rate of stretch", "damping dissipates: >= 0"),
        Parameter(
            *("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which it slides", "thesis: 2-5 um in steel"),
            role="shape",
            scan=Scan("position", 1e-4, 0.1, 10),
        ),
    ),
    force=_force,
    parallel_element=FrictionStateModel("bristle_damping", _law, _slopes, _along, lambda p: p.stretch),
)

_SPREAD = replace(
    _ONE,
    name="bristle_damping:spread",
    meaning="viscous damping of the deflection, which decreases as elements of different stretches slip",
    equation="F = damping * v * (part of the bristles not slipped);  8 stretches from stretch/span to stretch",
    source="Lampaert, Al-Bender, Swevers, Proc. Control Applications (2003): a damping to each element",
    parameters=(
        *_ONE.parameters,
        Parameter(
            "span",
            "1",
            20.0,
            1.0,
            1e3,
            "longest stretch over the shortest",
            "one to two decades",
            role="shape",
            natural="both",
        ),
    ),
    force=_spread_force,
    parallel_element=FrictionStateModel(
        "bristle_damping",
        _spread_law,
        _spread_slopes,
        _spread_along,
        lambda p: p.stretch / p.span,
        elements=lambda p: SPREAD,
    ),
)

EFFECT = replace(_ONE, variants=(_SPREAD,))
