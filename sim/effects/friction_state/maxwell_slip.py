"""Generalised Maxwell-slip: parallel elements of different stretches, each an ideal spring until it slips.

The friction level is shared: element k carries the part w_k of it. Its stiffness k_k = w_k force/u_k is constant, so at
the level `force` it slips at the stretch u_k, and at another level at another stretch.

`maxwell_slip`: the virgin curve of the force over the level is f(u) = 1 - (1 - u)^curvature, u the displacement over
the largest stretch. N elements slip at u_k = k/N; with the slopes m_k of f between the knots, element k carries the
part w_k = (m_k - m_(k+1)) u_k of the level, so f is met exactly at every knot, and the w_k sum to one.

`free_maxwell_slip`: the stretches are spread evenly on a logarithmic scale, from `stretch` down to `stretch` over
`span`; element k carries share_k over the sum of all shares. The force after a reversal follows any concave curve, as a
broken line with a knot at every stretch. Only ratios of the shares matter; one of them is held.

After a reversal at u_0 the force follows the same curve at twice its size: Masing's rule. Along a record the elements
yield ideally; in a simulation they yield smoothly (`sim/numerics/elasto_plastic.py`).
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan
from sim.effects.friction_state.lugre import level
from sim.effects.friction_state_model import parallel_elements
from sim.numerics.elasto_plastic import Elements, elements_along

ELEMENTS = 12
FREE_ELEMENTS = 10
HELD_SHARE = 5
"""Number of the share that is held at one, counted from one."""


@lru_cache(maxsize=64)
def _elements(p: Any) -> Elements:
    """Elements (12,) whose virgin curve meets 1 - (1 - u)^curvature at every knot."""
    knots = np.arange(1, ELEMENTS + 1) / ELEMENTS
    return elements_along(float(p.stretch) * knots, 1.0 - (1.0 - knots) ** float(p.curvature), float(p.force))


@lru_cache(maxsize=64)
def _free_elements(p: Any) -> Elements:
    """Elements (10,) with free shares."""
    shares = np.array([float(getattr(p, f"share_{k + 1}")) for k in range(FREE_ELEMENTS)])
    weights = shares / max(float(np.sum(shares)), 1e-300)
    return Elements(free_stretches(float(p.stretch), float(p.span)), weights, float(p.force))


def free_stretches(stretch: float, span: float) -> np.ndarray:
    """Stretches (10,) at which the elements of the free law slip, m."""
    return stretch * span ** (np.arange(FREE_ELEMENTS) / (FREE_ELEMENTS - 1.0) - 1.0)


_FORCE = Parameter("force", "N", 1.0, 0.0, math.inf, "friction force in steady sliding", "thesis Table 3", "level")
_STRETCH = Parameter(
    "stretch",
    "m",
    1e-5,
    1e-12,
    1e3,
    "displacement after which all elements slip, at the level `force`",
    "thesis: 2-5 um in steel",
).shape(Scan("position", 1e-5, 0.7, 15))

MAXWELL_SLIP = Effect(
    name="maxwell_slip",
    meaning="elastic contact before sliding: parallel elements that stretch, then slip one after another",
    equation="F = sum F_k;  stick: F_k' = (w_k force/u_k) v;  slip, from |F_k| = w_k level on: "
    "F_k' = sign(v) C (w_k - |F_k|/level), C large, |F_k'| <= (w_k force/u_k) |v|;  virgin curve at level = force: "
    "force (1 - (1 - x/stretch)^curvature)",
    shows="after each reversal the force rises along a curve over micrometres instead of a jump, the same at any speed",
    dissipation="Passive for any history of the level: the stiffnesses are constant, no force rises faster than its "
    "spring is stretched, and each element slips in the direction of its force.",
    source="Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 (2005) 1883; Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        _FORCE,
        _STRETCH,
        Parameter(
            "curvature",
            "1",
            2.0,
            1.0,
            12.0,
            "1: one spring; 2: uniformly distributed stretches; more: a long tail",
            "Hertz-Mindlin contacts: about 1.5",
        ).shape(Scan("one", 2.0, 8.0, 3), natural="both"),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=parallel_elements("maxwell_slip", _elements),
    acts_on="friction",
)

FREE_MAXWELL_SLIP = replace(
    MAXWELL_SLIP,
    name="free_maxwell_slip",
    needs=("imposed_motion",),  # so many shares take a motion that is known, not one that is measured
    meaning="elastic contact before sliding: parallel elements, each with its share of the level",
    equation="as maxwell_slip, with u_k from stretch/span to stretch, w_k = share_k / sum of the shares",
    shows="after each reversal the force rises along a concave curve over micrometres, the same at any speed",
    source="Lampaert, Al-Bender, Swevers, Proc. Control Applications (2003); Iwan, J. Appl. Mech. 33 (1966)",
    parameters=(
        _FORCE,
        _STRETCH,
        Parameter(
            "span", "1", 30.0, 2.0, 1e4, "longest stretch over the shortest", "a range of one to three decades"
        ).shape(natural="both"),
        *(
            Parameter(
                f"share_{k + 1}",
                "1",
                1.0,
                0.0,
                1e3,
                f"share of element {k + 1}, the shortest being 1",
                "only ratios matter",
            ).shape(fixed=k + 1 == HELD_SHARE, natural="both")
            for k in range(FREE_ELEMENTS)
        ),
    ),
    friction_state=replace(parallel_elements("free_maxwell_slip", _free_elements), free_shares=True),
)

EFFECTS = (MAXWELL_SLIP, FREE_MAXWELL_SLIP)
