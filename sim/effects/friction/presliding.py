"""Presliding: a core whose stretch the record can see. Maxwell-slip unless a variant names another."""

from __future__ import annotations

from dataclasses import replace

from sim.effects.friction_state import dahl, free_maxwell_slip, lugre, lugre_causal, maxwell_slip

EFFECT = replace(
    maxwell_slip.EFFECT,
    name="presliding",
    variants=tuple(
        replace(core, name=f"presliding:{core.name}")
        for core in (maxwell_slip.EFFECT, free_maxwell_slip.EFFECT, dahl.EFFECT, lugre.EFFECT, lugre_causal.EFFECT)
    ),
)
