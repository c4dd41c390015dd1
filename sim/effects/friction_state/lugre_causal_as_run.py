"""The thesis's third model as its listings ran it: with a1 = 0, where the causal law is the undamped one."""

from __future__ import annotations

from dataclasses import replace

from sim.effects.friction_state import lugre_causal
from sim.effects.friction_state.lugre import DAMPING

EFFECT = replace(
    lugre_causal.EFFECT,
    name="lugre_causal_as_run",
    meaning="the causal model with a1 = 0, as the thesis ran it: the same as lugre_undamped",
    equation="z' = v - a0 |v| z/g,  core force = a0 z  (the causal law at a1 = 0)",
    shows="As lugre_undamped: what rings there is the missing damping, and says nothing of the causal law.",
    source="thesis Appendix, listings of the modified dynamics (alpha1 = 0)",
    parameters=(
        *lugre_causal.EFFECT.parameters[:2],
        replace(DAMPING, default=0.0, fixed=True, source="thesis Appendix (the listing's alpha1 = 0)"),
    ),
    coordinates=("distance_since_reversal", "direction"),
)
