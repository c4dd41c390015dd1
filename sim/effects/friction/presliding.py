"""Presliding: a friction state model whose stretch the record resolves. Maxwell-slip unless a variant names another."""

from dataclasses import replace

from sim.effects.friction_state import dahl
from sim.effects.friction_state.lugre import CAUSAL, LUGRE
from sim.effects.friction_state.maxwell_slip import FREE_MAXWELL_SLIP, MAXWELL_SLIP

EFFECT = replace(
    MAXWELL_SLIP,
    name="presliding",
    variants=tuple(
        replace(effect, name=f"presliding:{effect.name}", refinement=effect in (MAXWELL_SLIP, CAUSAL))
        for effect in (MAXWELL_SLIP, FREE_MAXWELL_SLIP, dahl.EFFECT, LUGRE, CAUSAL)
    ),
)
