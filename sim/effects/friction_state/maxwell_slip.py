"""Generalised Maxwell-slip: bristles of many lengths side by side, each an ideal spring until it slips.

The virgin curve of the force over the level is f(u) = 1 - (1 - u)^curvature, u the displacement over the largest
stretch. It is made of N elements that slip at u_k = k/N; with the slopes m_k of f between the knots, element k carries
the part w_k = (m_k - m_(k+1)) u_k of the level, so f is met exactly at every knot, and the w_k sum to one.
After a reversal at u_0 the force follows the same curve at twice its size: Masing's rule.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect, Parameter, Scan
from sim.library.friction_state import FrictionStateModel
from sim.numerics.compilation import compiled

ELEMENTS = 12

SHARPNESS = 8.0
"""How sharply an element yields in a simulation; along a record it is ideal."""


def level(axis: Axis, p: Any) -> Any:
    return p.force + 0.0 * axis.velocity


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    n = 12
    u = (k + 1) / n
    m = n * ((1.0 - k / n) ** p.curvature - (1.0 - u) ** p.curvature)
    after = n * ((1.0 - u) ** p.curvature - max(0.0, 1.0 - (k + 2) / n) ** p.curvature) if k < n - 1 else 0.0
    weight = (m - after) * u
    ratio = z / (u * p.stretch)
    force = max(g, 0.0) * weight * ratio
    if ratio * direction <= 0.0:
        return v, force
    return v * (1.0 - abs(ratio) ** 8.0), force


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    n = 12
    u = (k + 1) / n
    m = n * ((1.0 - k / n) ** p.curvature - (1.0 - u) ** p.curvature)
    after = n * ((1.0 - u) ** p.curvature - max(0.0, 1.0 - (k + 2) / n) ** p.curvature) if k < n - 1 else 0.0
    weight = (m - after) * u
    limit = u * p.stretch
    ratio = z / limit
    force_z = max(g, 0.0) * weight / limit
    force_g = weight * ratio if g > 0.0 else 0.0
    if ratio * direction <= 0.0:
        return 0.0, 1.0, 0.0, force_z, 0.0, force_g
    size = abs(ratio)
    return -v * 8.0 * size**7 * direction / limit, 1.0 - size**8, 0.0, force_z, 0.0, force_g


@compiled
def sum_of_stops(dx: np.ndarray, level: np.ndarray, stretches: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Level (n,) times a weighted sum of stop operators, N elements, along displacements (n - 1,)."""
    n, elements = level.size, stretches.size
    force = np.zeros(n)
    z = np.zeros(elements)
    for i in range(n):
        # A record that begins in motion begins in slip: the first interval has been going on before it.
        step = dx[i - 1] if i > 0 else np.sign(dx[0]) * 1e300
        total = 0.0
        for k in range(elements):
            u = min(1.0, max(-1.0, z[k] + step / stretches[k]))
            z[k] = u
            total += weights[k] * u
        force[i] = max(level[i], 0.0) * total
    return force


def elements_of(stretch: float, curvature: float) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (N,), m, at which the elements slip, and the parts (N,) of the level they carry."""
    knots = np.arange(ELEMENTS + 1) / ELEMENTS
    slope = ELEMENTS * np.diff(1.0 - (1.0 - knots) ** curvature)
    weights = (slope - np.append(slope[1:], 0.0)) * knots[1:]
    return stretch * knots[1:], weights


def along_springs(position: np.ndarray, level: np.ndarray, stretches: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Friction (n,) along a measured motion: the level times a weighted sum of stop operators, exact per step."""
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    return sum_of_stops(dx, np.ascontiguousarray(level, dtype=float), stretches, weights)


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    return along_springs(position, level, *springs(p))


def springs(p: Any) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (12,), m, at which the elements slip, and the parts (12,) of the level they carry."""
    return elements_of(float(p.stretch), float(p.curvature))


def scale(p: Any) -> float:
    return p.stretch / ELEMENTS


def _count(p: Any) -> int:
    return ELEMENTS


EFFECT = Effect(
    name="maxwell_slip",
    meaning="elastic contact before sliding: bristles of many lengths that stretch, then slip one after another",
    equation="F = level * sum_k w_k stop(x; u_k stretch);  virgin curve 1 - (1 - x/stretch)^curvature",
    shows="after each reversal the force climbs a curve over micrometres instead of jumping, the same at any speed",
    source="Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 (2005) 1883; Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        Parameter("force", "N", 1.0, 0.0, math.inf, "friction force in steady sliding", "thesis Table 3", "level"),
        Parameter("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which all slips", "thesis: 2-5 um in steel",
                  "shape", Scan("position", 1e-5, 0.3, 14)),
        Parameter("curvature", "1", 2.0, 1.0, 12.0, "1: one spring; 2: stretches spread evenly; more: a long tail",
                  "Hertz-Mindlin contacts: about 1.5", "shape", Scan("one", 2.0, 8.0, 3)),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel("maxwell_slip", law, slopes, along, scale, elements=_count, springs=springs),
    acts_on="friction",
)  # fmt: skip
