"""Presliding: a friction state model whose stretch the record resolves. Maxwell-slip unless a variant names another."""

from dataclasses import replace

from sim.effects.friction_state import dahl
from sim.effects.friction_state.lugre import CAUSAL, LUGRE
from sim.effects.friction_state.maxwell_slip import FREE_MAXWELL_SLIP, MAXWELL_SLIP

_DAHL = dahl.EFFECT
_FREE_EXPONENT = replace(
    _DAHL,
    name="dahl_free_exponent",
    meaning="bristles that deflect before they slip, with a free exponent of their yield curve",
    parameters=(*_DAHL.parameters[:2], replace(_DAHL.parameters[2], fixed=False)),
)

EFFECT = replace(
    MAXWELL_SLIP,
    name="presliding",
    variants=tuple(
        replace(effect, name=f"presliding:{effect.name}", refinement=effect in (MAXWELL_SLIP, _DAHL, CAUSAL))
        for effect in (MAXWELL_SLIP, FREE_MAXWELL_SLIP, _DAHL, _FREE_EXPONENT, LUGRE, CAUSAL)
    ),
)
