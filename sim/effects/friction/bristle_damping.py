"""Damping of the elastic deflection of a contact."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan
from sim.effects.friction_state_model import parallel_elements
from sim.numerics.elasto_plastic import Elements

SPREAD = 8
"""Bristles of the law with many lengths."""


def _one(p: Any) -> Elements:
    return Elements(np.array([p.stretch]), np.ones(1))


def _spread(p: Any) -> Elements:
    """Eight bristles (8,), their stretches spread evenly on a logarithmic scale, down to `stretch` over `span`."""
    return Elements(p.stretch * p.span ** (np.arange(SPREAD) / (SPREAD - 1.0) - 1.0), np.full(SPREAD, 1.0 / SPREAD))


def _law(elements: Callable[[Any], Elements]) -> dict[str, Any]:
    """The force along a record, and the internal states in a simulation."""
    model = parallel_elements("bristle_damping", elements, damping=lambda p: p.damping)

    def force(axis: Axis, p: Any) -> Any:
        return model.along_record(axis.position, axis.velocity, axis.time, axis.velocity, p)

    return {"force": force, "parallel_element": model}


_ONE = Effect(
    name="bristle_damping",
    meaning="viscous damping of the contact's elastic deflection before it slides (a1 of LuGre)",
    equation="F = damping * v while a bristle of +-stretch has not slipped; 0 once it slides",
    shows="the faster the reversal, the higher the force just after it",
    dissipation="Dissipates damping v^2 while the bristles stick.",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419",
    acts_on="friction",
    coordinates=("distance_since_reversal", "velocity"),
    parameters=(
        Parameter("damping", "N*s/m", 10.0, 0.0, 1e9, "force per rate of stretch", "damping dissipates: >= 0"),
        Parameter(
            "stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which it slides", "thesis: 2-5 um in steel"
        ).shape(Scan("position", 1e-4, 0.1, 10)),
    ),
    **_law(_one),
)

_SPREAD = replace(
    _ONE,
    name="bristle_damping:spread",
    meaning="viscous damping of the deflection, which decreases as elements of different stretches slip",
    equation="F = damping * v * (part of the bristles not slipped);  8 stretches from stretch/span to stretch",
    source="Lampaert, Al-Bender, Swevers, Proc. Control Applications (2003): a damping to each element",
    parameters=(
        *_ONE.parameters,
        Parameter("span", "1", 20.0, 1.0, 1e3, "longest stretch over the shortest", "one to two decades").shape(
            natural="both"
        ),
    ),
    **_law(_spread),
)

EFFECT = replace(_ONE, variants=(_SPREAD,))
