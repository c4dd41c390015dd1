"""Masses and forces of the design: weight, preload, and the load on the tip."""

from __future__ import annotations

from designcalc.drive.friction_drive import GRAVITY
from designcalc.machine.inputs import DesignInputs


def moved_mass(r: DesignInputs) -> float:
    """Mass the drive accelerates: stage and payload, kg."""
    return r.mass() + r("payload.mass")


def weight(r: DesignInputs) -> float:
    """Weight of stage and payload, N: the load of the bearing without preload."""
    return moved_mass(r) * GRAVITY


def preload_ratio(r: DesignInputs) -> float:
    """Preload over weight."""
    return r("preload.force") / weight(r)


def tip_load(r: DesignInputs) -> float:
    """Largest normal force on the tip, N: weight and preload, when the stage is about to lift off its pads."""
    return r.given("tip load at lift-off", weight(r) + r("preload.force"), "N", "weight and preload")
