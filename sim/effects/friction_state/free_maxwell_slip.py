"""Generalised Maxwell-slip with free shares: each bristle carries a part of the level of its own.

The stretches at which the elements slip are spread evenly on a logarithmic scale, from `stretch` down to `stretch` over
`span`; element k carries share_k over the sum of all shares. The curve of the force after a reversal is any that bends
one way: broken lines with a knot at every stretch. Shares matter by their ratios only; one of them is held.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.effects.friction_state.maxwell_slip import along_springs, level
from sim.library.effect import Effect, Parameter, Scan
from sim.library.friction_state import FrictionStateModel

ELEMENTS = 10
HELD = 5
"""Number of the share that is held at one, counted from one."""


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    share = (
        p.share_1 if k == 0 else p.share_2 if k == 1 else p.share_3 if k == 2 else p.share_4 if k == 3
        else p.share_5 if k == 4 else p.share_6 if k == 5 else p.share_7 if k == 6 else p.share_8 if k == 7
        else p.share_9 if k == 8 else p.share_10
    )  # fmt: skip
    total = (p.share_1 + p.share_2 + p.share_3 + p.share_4 + p.share_5 + p.share_6 + p.share_7 + p.share_8 + p.share_9
             + p.share_10)  # fmt: skip
    ratio = z / (p.stretch * p.span ** ((k - 9.0) / 9.0))
    force = max(g, 0.0) * share / total * ratio
    if ratio * direction <= 0.0:
        return v, force
    return v * (1.0 - abs(ratio) ** 8.0), force


def slopes(
    k: int, z: float, v: float, direction: float, g: float, p: Any
) -> tuple[float, float, float, float, float, float]:
    share = (
        p.share_1 if k == 0 else p.share_2 if k == 1 else p.share_3 if k == 2 else p.share_4 if k == 3
        else p.share_5 if k == 4 else p.share_6 if k == 5 else p.share_7 if k == 6 else p.share_8 if k == 7
        else p.share_9 if k == 8 else p.share_10
    )  # fmt: skip
    total = (p.share_1 + p.share_2 + p.share_3 + p.share_4 + p.share_5 + p.share_6 + p.share_7 + p.share_8 + p.share_9
             + p.share_10)  # fmt: skip
    weight = share / total
    limit = p.stretch * p.span ** ((k - 9.0) / 9.0)
    ratio = z / limit
    force_z = max(g, 0.0) * weight / limit
    force_g = weight * ratio if g > 0.0 else 0.0
    if ratio * direction <= 0.0:
        return 0.0, 1.0, 0.0, force_z, 0.0, force_g
    size = abs(ratio)
    return -v * 8.0 * size**7 * direction / limit, 1.0 - size**8, 0.0, force_z, 0.0, force_g


def springs(p: Any) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (10,), m, at which the elements slip, and the parts (10,) of the level they carry."""
    shares = np.array([float(getattr(p, f"share_{k + 1}")) for k in range(ELEMENTS)])
    return stretches_of(float(p.stretch), float(p.span)), shares / max(float(np.sum(shares)), 1e-300)


def stretches_of(stretch: float, span: float) -> np.ndarray:
    """Stretches (10,) at which the elements slip, m."""
    return stretch * span ** (np.arange(ELEMENTS) / (ELEMENTS - 1.0) - 1.0)


def shares_of(stretches: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Parts (10,) of the level with which a fresh contact's force meets `curve` (10,), over the level, at the knots."""
    slope = np.diff(np.concatenate([[0.0], curve])) / np.diff(np.concatenate([[0.0], stretches]))
    return np.maximum((slope - np.append(slope[1:], 0.0)) * stretches, 0.0)


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    return along_springs(position, level, *springs(p))


def scale(p: Any) -> float:
    return p.stretch / p.span


def _count(p: Any) -> int:
    return ELEMENTS


EFFECT = Effect(
    name="free_maxwell_slip",
    meaning="elastic contact before sliding: bristles of many lengths, each with a share of its own",
    equation="F = level * sum_k w_k stop(x; u_k);  u_k from stretch/span to stretch, w_k = share_k / sum of the shares",
    shows="after each reversal the force climbs a curve over micrometres, of whatever shape, the same at any speed",
    source="Lampaert, Al-Bender, Swevers, Proc. Control Applications (2003); Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        Parameter("force", "N", 1.0, 0.0, math.inf, "friction force in steady sliding", "thesis Table 3", "level"),
        Parameter("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which all slips", "thesis: 2-5 um in steel",
                  "shape", Scan("position", 1e-5, 0.3, 14)),
        Parameter("span", "1", 30.0, 2.0, 1e4, "longest stretch over the shortest", "a range of one to three decades",
                  "shape"),
        *(
            Parameter(f"share_{k + 1}", "1", 1.0, 0.0, 1e3, f"share of element {k + 1}, the shortest being 1",
                      "ratios matter only", "shape", fixed=k + 1 == HELD)
            for k in range(ELEMENTS)
        ),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel("free_maxwell_slip", law, slopes, along, scale, elements=_count, springs=springs),
    acts_on="friction",
)  # fmt: skip
