"""Motion of the tip on its piezos: ellipse, moved mass, resonances, and stiffness along the travel."""

from __future__ import annotations

import numpy as np

from designcalc.drive.friction_drive import TipEllipse, piezo_stiffness, resonance, tip_ellipse
from designcalc.drive.piezo_stack import rocking_stiffness, tip_inertia
from designcalc.machine.inputs import DesignInputs
from designcalc.machine.loads import tip_load
from designcalc.machine.tip_contact import tip_contact, tip_shear_stiffness

PIEZOS = 3
"""Under one tip."""


def stack_stiffness(r: DesignInputs) -> float:
    """Stiffness of one piezo, N/m."""
    return float(piezo_stiffness(r("piezo.blocking_force"), r("piezo.stroke")))


def stroke_ellipse(r: DesignInputs) -> TipEllipse:
    """Path of the tip at the drive's own stroke and phase."""
    return _ellipse(r, r("actuator.stroke_amplitude"))


def usable_ellipse(r: DesignInputs) -> tuple[float, float]:
    """X and Y of the ellipse at the drive's own stroke, or at the piezo's where that is less, m."""
    path = _ellipse(r, min(r("piezo.stroke") / 2, r("actuator.stroke_amplitude")))
    return float(path.along), float(path.normal)


def _ellipse(r: DesignInputs, amplitude: float) -> TipEllipse:
    return tip_ellipse(amplitude, r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height"))


def mass_on_piezos(r: DesignInputs) -> float:
    """Mass that moves on the piezos: the tip and a part of each stack, kg."""
    return r.tip_mass() + PIEZOS * r("piezo.moving_mass")


def tip_resonances(r: DesignInputs) -> tuple[float, float]:
    """Resonances of the free tip on its piezos, Hz: vertical on all three, rocking on the two along the travel."""
    mass, stack = mass_on_piezos(r), stack_stiffness(r)
    circle = r("actuator.piezo_spacing") / np.sqrt(3)
    inertia = tip_inertia(mass, circle, r("actuator.tip_height"))
    rocking = rocking_stiffness(stack, r("actuator.piezo_spacing"))
    return float(resonance(PIEZOS * stack, mass)), float(resonance(rocking, inertia))


def tip_resonance(r: DesignInputs) -> float:
    """The lower one of `tip_resonances`, Hz."""
    return min(tip_resonances(r))


def holding_stiffness(r: DesignInputs) -> float:
    """Stiffness with which a tip that does not slip holds the stage along its travel, N/m.

    Rocking of the tip on its piezos, and shear of the contact, in series.
    """
    rocking = rocking_stiffness(stack_stiffness(r), r("actuator.piezo_spacing")) / r("actuator.tip_height") ** 2
    shear = tip_shear_stiffness(r, tip_contact(r, tip_load(r)))
    return 1 / (1 / float(rocking) + 1 / shear)
