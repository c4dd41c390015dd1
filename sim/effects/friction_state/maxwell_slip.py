"""Generalised Maxwell-slip: parallel elements of different stretches, each an ideal spring until it slips.

`maxwell_slip`: the virgin curve of the force over the level is f(u) = 1 - (1 - u)^curvature, u the displacement over
the largest stretch. N elements slip at u_k = k/N; with the slopes m_k of f between the knots, element k carries the
part w_k = (m_k - m_(k+1)) u_k of the level, so f is met exactly at every knot, and the w_k sum to one.

`free_maxwell_slip`: the stretches are spread evenly on a logarithmic scale, from `stretch` down to `stretch` over
`span`; element k carries share_k over the sum of all shares. The force after a reversal follows any concave curve, as a
broken line with a knot at every stretch. Only ratios of the shares matter; one of them is held.

After a reversal at u_0 the force follows the same curve at twice its size: Masing's rule. Along a record the elements
yield ideally; in a simulation their rate falls with the eighth power of the stretch.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect, Parameter, Scan
from sim.library.friction_state import FrictionStateModel
from sim.numerics.compilation import compiled

ELEMENTS = 12
FREE_ELEMENTS = 10
FIRST_SHARE = 3
"""Index of the first share among the parameters of the free law."""
HELD_SHARE = 5
"""Number of the share that is held at one, counted from one."""


def level(axis: Axis, p: Any) -> Any:
    return p.force + 0.0 * axis.velocity


def _law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    n = ELEMENTS
    u = (k + 1) / n
    m = n * ((1.0 - k / n) ** p.curvature - (1.0 - u) ** p.curvature)
    after = n * ((1.0 - u) ** p.curvature - max(0.0, 1.0 - (k + 2) / n) ** p.curvature) if k < n - 1 else 0.0
    weight = (m - after) * u
    ratio = z / (u * p.stretch)
    force = max(g, 0.0) * weight * ratio
    if ratio * direction <= 0.0:
        return v, force
    return v * (1.0 - abs(ratio) ** 8.0), force


def _slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    n = ELEMENTS
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


def _free_law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    total = 0.0
    for i in range(FREE_ELEMENTS):
        total += p[FIRST_SHARE + i]
    ratio = z / (p.stretch * p.span ** ((k - 9.0) / 9.0))
    force = max(g, 0.0) * p[FIRST_SHARE + k] / total * ratio
    if ratio * direction <= 0.0:
        return v, force
    return v * (1.0 - abs(ratio) ** 8.0), force


def _free_slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    total = 0.0
    for i in range(FREE_ELEMENTS):
        total += p[FIRST_SHARE + i]
    weight = p[FIRST_SHARE + k] / total
    limit = p.stretch * p.span ** ((k - 9.0) / 9.0)
    ratio = z / limit
    force_z = max(g, 0.0) * weight / limit
    force_g = weight * ratio if g > 0.0 else 0.0
    if ratio * direction <= 0.0:
        return 0.0, 1.0, 0.0, force_z, 0.0, force_g
    size = abs(ratio)
    return -v * 8.0 * size**7 * direction / limit, 1.0 - size**8, 0.0, force_z, 0.0, force_g


@compiled
def _sum_of_stops(dx: np.ndarray, level: np.ndarray, stretches: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Level (n,) times a weighted sum of stop operators, N elements, along displacements (n - 1,)."""
    n, elements = level.size, stretches.size
    force = np.zeros(n)
    z = np.zeros(elements)
    for i in range(n):
        # A record that begins in motion begins in slip: the first interval is taken to have preceded it.
        step = dx[i - 1] if i > 0 else np.sign(dx[0]) * 1e300
        total = 0.0
        for k in range(elements):
            u = min(1.0, max(-1.0, z[k] + step / stretches[k]))
            z[k] = u
            total += weights[k] * u
        force[i] = max(level[i], 0.0) * total
    return force


def _along_springs(position: np.ndarray, level: np.ndarray, springs: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    dx = np.diff(np.ascontiguousarray(position, dtype=float))
    return _sum_of_stops(dx, np.ascontiguousarray(level, dtype=float), *springs)


def _along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    return _along_springs(position, level, _springs(p))


def _free_along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    return _along_springs(position, level, _free_springs(p))


def _springs(p: Any) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (12,), m, at which the elements slip, and the parts (12,) of the level they carry."""
    knots = np.arange(ELEMENTS + 1) / ELEMENTS
    slope = ELEMENTS * np.diff(1.0 - (1.0 - knots) ** float(p.curvature))
    weights = (slope - np.append(slope[1:], 0.0)) * knots[1:]
    return float(p.stretch) * knots[1:], weights


def _free_springs(p: Any) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (10,), m, at which the elements slip, and the parts (10,) of the level they carry."""
    shares = np.array([float(getattr(p, f"share_{k + 1}")) for k in range(FREE_ELEMENTS)])
    return free_stretches(float(p.stretch), float(p.span)), shares / max(float(np.sum(shares)), 1e-300)


def free_stretches(stretch: float, span: float) -> np.ndarray:
    """Stretches (10,) at which the elements of the free law slip, m."""
    return stretch * span ** (np.arange(FREE_ELEMENTS) / (FREE_ELEMENTS - 1.0) - 1.0)


def free_shares(stretches: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Parts (10,) of the level with which a fresh contact's force meets `curve` (10,), over the level, at the knots."""
    slope = np.diff(np.concatenate([[0.0], curve])) / np.diff(np.concatenate([[0.0], stretches]))
    return np.maximum((slope - np.append(slope[1:], 0.0)) * stretches, 0.0)


_FORCE = Parameter("force", "N", 1.0, 0.0, math.inf, "friction force in steady sliding", "thesis Table 3", "level")
_STRETCH = Parameter(
    *("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which all elements slip", "thesis: 2-5 um in steel"),
    role="shape",
    scan=Scan("position", 1e-5, 0.3, 14),
)

MAXWELL_SLIP = Effect(
    name="maxwell_slip",
    meaning="elastic contact before sliding: parallel elements that stretch, then slip one after another",
    equation="F = level * sum_k w_k stop(x; u_k stretch);  virgin curve 1 - (1 - x/stretch)^curvature",
    shows="after each reversal the force rises along a curve over micrometres instead of a jump, the same at any speed",
    source="Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 (2005) 1883; Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        _FORCE,
        _STRETCH,
        Parameter(
            *("curvature", "1", 2.0, 1.0, 12.0, "1: one spring; 2: stretches spread evenly; more: a long tail"),
            source="Hertz-Mindlin contacts: about 1.5",
            role="shape",
            scan=Scan("one", 2.0, 8.0, 3),
            natural="both",
        ),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel(
        *("maxwell_slip", _law, _slopes, _along),
        scale=lambda p: p.stretch / ELEMENTS,
        elements=lambda p: ELEMENTS,
        springs=_springs,
    ),
    acts_on="friction",
)

FREE_MAXWELL_SLIP = Effect(
    name="free_maxwell_slip",
    meaning="elastic contact before sliding: parallel elements, each with its share of the level",
    equation="F = level * sum_k w_k stop(x; u_k);  u_k from stretch/span to stretch, w_k = share_k / sum of the shares",
    shows="after each reversal the force rises along a concave curve over micrometres, the same at any speed",
    source="Lampaert, Al-Bender, Swevers, Proc. Control Applications (2003); Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        _FORCE,
        _STRETCH,
        Parameter(
            *("span", "1", 30.0, 2.0, 1e4, "longest stretch over the shortest", "a range of one to three decades"),
            role="shape",
            natural="both",
        ),
        *(
            Parameter(
                *(f"share_{k + 1}", "1", 1.0, 0.0, 1e3, f"share of element {k + 1}, the shortest being 1"),
                source="only ratios matter",
                role="shape",
                fixed=k + 1 == HELD_SHARE,
            )
            for k in range(FREE_ELEMENTS)
        ),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel(
        *("free_maxwell_slip", _free_law, _free_slopes, _free_along),
        scale=lambda p: p.stretch / p.span,
        elements=lambda p: FREE_ELEMENTS,
        springs=_free_springs,
    ),
    acts_on="friction",
)

EFFECTS = (MAXWELL_SLIP, FREE_MAXWELL_SLIP)
