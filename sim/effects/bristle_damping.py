"""Damping of the bristles while they stretch."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.cores.core import Core
from sim.effect import Axis, Effect, Parameter, Scan


def _force(axis: Axis, p: Any) -> Any:
    return _along(axis.position, axis.velocity, axis.time, axis.velocity, p)


def _law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    """In time the bristle yields along a steep curve instead of all at once, as those of Maxwell-slip do."""
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
    from sim.record_kernels import stop

    return p.damping * velocity * (np.abs(stop(np.ascontiguousarray(position), p.stretch)) < 1.0)


EFFECT = Effect(
    name="bristle_damping",
    meaning="the contact resists the rate of its stretch, before it slides (the a1 of LuGre)",
    equation="F = damping * v while a bristle of +-stretch has not slipped; 0 once it slides",
    shows="just after a reversal the force is higher the faster the axis turns round",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419",
    acts_on="friction",
    coordinates=("distance_since_reversal", "velocity"),
    parameters=(
        Parameter("damping", "N*s/m", 10.0, 0.0, 1e9, "force per rate of stretch", "damping dissipates: >= 0"),
        Parameter("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which it slides", "thesis: 2-5 um in steel",
                  role="shape", scan=Scan("position", 1e-4, 0.1, 6)),
    ),
    force=_force,
    element=Core("bristle_damping", _law, _slopes, _along, lambda p: p.stretch),
)  # fmt: skip
