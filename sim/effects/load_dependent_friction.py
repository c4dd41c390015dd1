"""A friction level that follows the normal load."""

from __future__ import annotations

from typing import Any

from sim.effect import Axis, Effect, Parameter


def _factor(axis: Axis, p: Any) -> Any:
    return 1.0 + p.sensitivity * (axis.load / p.reference - 1.0)


EFFECT = Effect(
    name="load_dependent_friction",
    meaning="the friction level follows the normal load (Amontons)",
    equation="level * (1 + sensitivity * (N / reference - 1));  sensitivity 1: proportional to the load",
    shows="the friction level rises and falls with the recorded normal load",
    source="Bowden and Tabor, The Friction and Lubrication of Solids (1950), ch. 5",
    acts_on="friction",
    coordinates=("normal_load",),
    needs=("load",),
    parameters=(
        Parameter(
            "sensitivity",
            "1",
            1.0,
            0.0,
            3.0,
            "relative change of level per relative change of load",
            "Amontons: 1; adhesion lowers it; friction does not fall with load",
        ),
        Parameter(
            "reference", "N", 1.0, 1e-12, 1e12, "load at which the level holds", "mean of the record", role="reference"
        ),
    ),
    factor=_factor,
)
