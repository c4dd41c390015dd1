"""Motion of the tip on its piezos: ellipse, moved mass, resonances, sway, peak force, stiffness along the travel."""

from dataclasses import dataclass

import numpy as np

from designcalc.checks.check import DesignInputs, remembered
from designcalc.contact.hertz import PointContact, contact_modulus, point_contact, tangential_stiffness
from designcalc.contact.pulsed import peak_of_mean
from designcalc.drive import piezo_stack
from designcalc.drive.friction_drive import resonance
from designcalc.drive.tip_ellipse import frequency_for, tip_ellipse
from designcalc.friction_stage.physics.loads import tip_load, tip_mass
from stagecad.parameters.mass_properties import BodyMasses


def elastic_constants(r: DesignInputs, first: str, second: str) -> tuple[float, float, float, float]:
    """Young's modulus (Pa) and Poisson's ratio of the materials of two parts."""
    return (
        r.material(first, "youngs_modulus"),
        r.material(first, "poisson_ratio"),
        r.material(second, "youngs_modulus"),
        r.material(second, "poisson_ratio"),
    )


@remembered
def tip_contact(r: DesignInputs, load: float) -> PointContact:
    """Nose of the tip on the stage's underside under `load`, N."""
    modulus = contact_modulus(*elastic_constants(r, "tip", "stage"))
    return point_contact(load, r("tip.nose_radius"), np.inf, modulus)


@dataclass(frozen=True)
class ContactStiffness:
    """The tip on the stage at one load, SI."""

    load: float  # N
    normal: float  # tangent stiffness normal to the surface, N/m
    tangential: float  # stiffness along the surface before any of it slips, N/m
    rate: float  # K of ``F = K delta^1.5``, N/m^1.5; the same at every load

    @property
    def tangential_ratio(self) -> float:
        """Tangential over normal stiffness, the same at every load: ``2 (1 - nu)/(2 - nu)`` for equal materials."""
        return self.tangential / self.normal


@remembered
def contact_stiffness(r: DesignInputs, load: float) -> ContactStiffness:
    """The contact under a load, N: ``k_n = 2 a E*``, ``k_t = 8 a G*``, each body with its own Poisson's ratio.

    Both grow with the cube root of the load, so that a tip with half of the load is a fifth softer; a surface that
    slips at its edge, or is rough, is softer too.
    """
    contact = tip_contact(r, load)
    tangential = float(tangential_stiffness(contact, *elastic_constants(r, "tip", "stage")))
    return ContactStiffness(load, float(contact.stiffness), tangential, load / float(contact.approach) ** 1.5)


PIEZOS = 3
"""Number of piezos under one tip."""


def stack_stiffness(r: DesignInputs) -> float:
    """Stiffness of one piezo, N/m."""
    return float(piezo_stack.piezo_stiffness(r("piezo.blocking_force"), r("piezo.stroke")))


def driven_capacitance(r: DesignInputs) -> float:
    """Capacitance of one piezo driven over its stroke, F: catalogues state that at small signals."""
    return r("piezo.capacitance") * r("piezo.full_stroke_capacitance")


@remembered
def usable_ellipse(r: DesignInputs) -> tuple[float, float]:
    """X and Y of the ellipse at the drive's own stroke, or at the piezo's where that is less, m."""
    amplitude = min(r("piezo.stroke") / 2, r("actuator.stroke_amplitude"))
    path = tip_ellipse(amplitude, r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height"))
    return float(path.along), float(path.normal)


def speed_frequency(r: DesignInputs) -> float:
    """Frequency of the drive at the required speed, coasting, Hz."""
    return float(frequency_for(r("requirements.speed"), usable_ellipse(r)[0])["coasting"])


def mass_on_piezos(r: DesignInputs) -> float:
    """Mass that moves on the piezos: the tip and a part of each stack, kg."""
    return tip_mass(r) + PIEZOS * r("piezo.moving_mass")


@remembered
def inertia_on_piezos(r: DesignInputs) -> float:
    """Moment of inertia of the same about an axis in the plane of the stacks' ends, kg m^2.

    The tip by its solid (mean of both axes), or as a disc and a column; the moving part of each stack as a point.
    """
    if isinstance(r.masses, BodyMasses):
        about = r.masses.tip.inertia_about((0.0, 0.0, 0.0))
        own = r.given("tip inertia", 0.5 * (about[0][0] + about[1][1]), "kg*m^2", "measured from the solids")
    else:
        own = float(
            piezo_stack.tip_inertia(tip_mass(r), r("actuator.piezo_spacing") / np.sqrt(3), r("actuator.tip_height"))
        )
    return own + r("piezo.moving_mass") * r("actuator.piezo_spacing") ** 2 / 2


@remembered
def tip_resonances(r: DesignInputs) -> tuple[float, float]:
    """Resonances of the free tip on its piezos, Hz: vertical on all three, rocking on the two along the travel."""
    stack = stack_stiffness(r)
    rocking = piezo_stack.rocking_stiffness(stack, r("actuator.piezo_spacing"))
    return float(resonance(PIEZOS * stack, mass_on_piezos(r))), float(resonance(rocking, inertia_on_piezos(r)))


def tip_resonance(r: DesignInputs) -> float:
    """The lower one of `tip_resonances`, Hz."""
    return min(tip_resonances(r))


def tip_noise(r: DesignInputs) -> float:
    """Motion of the tip along the travel by the noise of two amplifiers, m rms."""
    gain = r("piezo.stroke") / r("piezo.highest_voltage")
    return float(np.sqrt(2)) * r("amplifier.noise") * gain * r("actuator.tip_height") / r("actuator.piezo_spacing")


def sway(r: DesignInputs) -> float:
    """Stiffness of the tip across its stacks, which bend within the play of their bores, N/m."""
    one = piezo_stack.sway_stiffness(r("piezo.length"), r("piezo.element_area"), r.material("piezo", "youngs_modulus"))
    return PIEZOS * float(one)


def sway_resonance(r: DesignInputs) -> float:
    """Resonance of the free tip that sways on its stacks, Hz."""
    return float(resonance(sway(r), mass_on_piezos(r)))


def bent_stack(r: DesignInputs, force: float) -> piezo_stack.SideLoad:
    """One stack of the design under a force across its end, N."""
    proud = r("piezo.length") + r("holder.floor") - r("holder.height")
    play = (r("holder.bore_diameter") - r("piezo.diameter")) / 2
    modulus = r.material("piezo", "youngs_modulus")
    return piezo_stack.side_load(force, r("piezo.length"), proud, r("piezo.element_area"), modulus, play)


@remembered
def sway_limit(r: DesignInputs) -> tuple[float, float]:
    """Sway of the tip at which its stacks touch the mouths of their bores, m, and the stiffness that the bores add for
    all stacks beyond it, N/m; infinite and none for stacks that stand proud of their holder altogether."""
    touch = float(bent_stack(r, 1.0).touch_force)
    if not np.isfinite(touch):
        return np.inf, 0.0
    at, beyond = (float(bent_stack(r, k * touch).deflection) for k in (1.0, 2.0))
    return at, PIEZOS * touch / (beyond - at) - sway(r)


@remembered
def peak_tip_force(r: DesignInputs) -> float:
    """Peak of the tip's normal force when it carries the whole load in pulses, N.

    Between the resonance of the stage on its pads and that of the tip on its stacks: below the former the stage follows
    the tip, near the latter the tip rises farther than commanded.
    """
    load = tip_load(r)
    rate = contact_stiffness(r, load).rate
    peak = peak_of_mean(load, usable_ellipse(r)[1], rate, PIEZOS * stack_stiffness(r))
    return r.given("peak tip force", peak, "N", "the load carried in pulses over the rise of the ellipse")


@remembered
def holding_stiffness(r: DesignInputs) -> float:
    """Stiffness with which a tip that does not slip holds the stage along its travel, N/m.

    Rocking of the tip on its piezos, sway of the stacks, and shear of the contact, in series.
    """
    rocking = (
        piezo_stack.rocking_stiffness(stack_stiffness(r), r("actuator.piezo_spacing")) / r("actuator.tip_height") ** 2
    )
    shear = contact_stiffness(r, tip_load(r)).tangential
    return 1 / (1 / float(rocking) + 1 / shear + 1 / sway(r))
