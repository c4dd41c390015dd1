"""Calculated numbers of the machine that the formulas of its checks name."""

import re
from functools import partial

import numpy as np

from designcalc.bearing.bolted_rail import bending_shear_compliance, joint_stiffness
from designcalc.bearing.fastener import Thread, strip_area_of_bed, strip_area_of_screw
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import DesignInputs, FormulaCheck, Quantities
from designcalc.contact.hertz import ShearPeak, contact_modulus, peak_mises, point_shear_peak
from designcalc.friction_stage.physics.clamp import clamp_finger, clamp_gap, grip, press_angle, screw_preload
from designcalc.friction_stage.physics.heat import BODIES, growth, warmed
from designcalc.friction_stage.physics.loads import (
    CIRCUITS,
    attraction,
    load,
    load_centre,
    magnets,
    moved_mass,
    moving_body,
    preload,
    tip_load,
    tip_mass,
    weight,
)
from designcalc.friction_stage.physics.pads import (
    film,
    heaviest_pad,
    pad_contact,
    pad_forces,
    pad_positions,
    pads_stiffness,
    rail,
)
from designcalc.friction_stage.physics.position_loop import suspension
from designcalc.friction_stage.physics.stage_plate import above_tip, give_at_tip
from designcalc.friction_stage.physics.tip_dynamics import (
    bent_stack,
    driven_capacitance,
    elastic_constants,
    holding_stiffness,
    inertia_on_piezos,
    mass_on_piezos,
    peak_tip_force,
    speed_frequency,
    stack_stiffness,
    sway,
    sway_resonance,
    tip_contact,
    tip_resonances,
    usable_ellipse,
)


def _way_thread(r: DesignInputs) -> Thread:
    return Thread(r("screws.way.diameter"), r("screws.way.pitch"))


def _way_depth(r: DesignInputs) -> float:
    """Engagement of the screws of the ways in the base, m."""
    return r("screws.way.length") - r("bearing_way.flange_thickness")


def _shear_peak(r: DesignInputs) -> ShearPeak:
    return point_shear_peak(tip_contact(r, peak_tip_force(r)), r.material("stage", "poisson_ratio"))


def _way_joint(r: DesignInputs) -> float:
    """Stiffness of one bolt joint of the way, N/m."""
    way = rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    return float(joint_stiffness(way, tau).joint_per_diameter) * way.bolt_diameter


def _averaging_radius(r: DesignInputs) -> float:
    """Radius of a pad's contact, m, where it averages the way's roughness."""
    radius = film(r, heaviest_pad(r)).radius
    averaged_roughness(1.0, r("bearing.roughness_correlation"), radius)  # refuses a contact that is too small
    return float(radius)


def _lift_of_pulses(r: DesignInputs) -> float:
    """Height above the tip at the peak of its force over that at its mean, m."""
    found = above_tip(r, tip_load(r))
    return float(found.at_peak_force[0] - found.static[0])


def _rise(body: int, r: DesignInputs) -> float:
    return float(warmed(r).hottest[body])


def loose_fit(r: DesignInputs) -> float:
    """Play of the holder in its pocket beyond the nominal one by both tolerances, m."""
    return 2 * r("drawing.tolerance_x_xx")


def _farthest(axis: int, name: str, r: DesignInputs) -> float:
    """Distance of the farthest actuator from the middle along an axis, m."""
    places = r.design.derived.actuator_places
    return r.given(f"farthest actuator {name}", max(abs(p[axis]) for p in places) * 1e-3, "m", "layout of the pockets")


QUANTITIES: Quantities = {
    "ellipse.along": (lambda r: usable_ellipse(r)[0], "m"),
    "ellipse.rise": (lambda r: usable_ellipse(r)[1], "m"),
    "load.weight": (weight, "N"),
    "load.preload": (preload, "N"),
    "load.whole": (load, "N"),
    "load.magnets": (attraction, "N"),
    "load.of_tip": (tip_load, "N"),
    "load.heaviest_pad": (heaviest_pad, "N"),
    "stiffness.pads": (lambda r: pads_stiffness(r).normal, "N/m"),
    "stiffness.along": (holding_stiffness, "N/m"),
    "stiffness.stack": (stack_stiffness, "N/m"),
    "stiffness.sway": (sway, "N/m"),
    "stiffness.contact": (lambda r: float(tip_contact(r, tip_load(r)).stiffness), "N/m"),
    "stiffness.teeth": (lambda r: CIRCUITS * magnets(r).normal_stiffness, "N/m"),
    "flux.gap": (lambda r: magnets(r).gap_flux_density, "T"),
    "depth.film": (lambda r: float(film(r, heaviest_pad(r)).indentation), "m"),
    "mass.tip": (tip_mass, "kg"),
    "mass.on_piezos": (mass_on_piezos, "kg"),
    "resonance.tip_up": (lambda r: tip_resonances(r)[0], "Hz"),
    "resonance.tip_rocking": (lambda r: tip_resonances(r)[1], "Hz"),
    "resonance.tip_sway": (sway_resonance, "Hz"),
    "frequency.of_speed": (speed_frequency, "Hz"),
    "capacitance.driven": (driven_capacitance, "F"),
    "force.way_screw": (lambda r: screw_preload(r, "way"), "N"),
    "area.way_screw": (lambda r: _way_thread(r).stress_area, "m^2"),
    "area.bed_thread": (lambda r: float(strip_area_of_bed(_way_thread(r), _way_depth(r))), "m^2"),
    "area.screw_thread": (lambda r: float(strip_area_of_screw(_way_thread(r), _way_depth(r))), "m^2"),
    "radius.bare_crown": (lambda r: float(pad_contact(r, heaviest_pad(r)).semi_axis_major), "m"),
    "height.centre_of_mass": (lambda r: moving_body(r).centre_of_mass[2], "m"),
    "reach.of_pads": (lambda r: float(np.max(pad_positions(r)[:, 0])) - abs(load_centre(r)[0]), "m"),
    "stiffness.pitch": (lambda r: pads_stiffness(r).pitch, "N*m"),
    "stiffness.roll": (lambda r: pads_stiffness(r).roll, "N*m"),
    "stiffness.teeth_across": (lambda r: CIRCUITS * magnets(r).lateral_stiffness, "N/m"),
    "load.moved_mass": (moved_mass, "kg"),
    "load.peak_of_tip": (peak_tip_force, "N"),
    "load.lightest_pad": (lambda r: float(np.min(pad_forces(r))), "N"),
    "modulus.tip_contact": (lambda r: float(contact_modulus(*elastic_constants(r, "tip", "stage"))), "Pa"),
    "mises.tip": (lambda r: float(peak_mises(1.0, r.material("tip", "poisson_ratio"))), ""),
    "mises.stage": (lambda r: float(peak_mises(1.0, r.material("stage", "poisson_ratio"))), ""),
    "shear.under_tip": (lambda r: float(_shear_peak(r).shear), "Pa"),
    "depth.of_shear": (lambda r: float(_shear_peak(r).depth), "m"),
    "bend.above_tip": (lambda r: float(above_tip(r, tip_load(r)).static[0]), "m"),
    "lift.above_tip": (_lift_of_pulses, "m"),
    "give.above_tip": (give_at_tip, "m/N"),
    "give.of_way_edge": (lambda r: float(bending_shear_compliance(rail(r))), "m^2/N"),
    "stiffness.way_joint": (_way_joint, "N/m"),
    "force.touching_bore": (lambda r: float(bent_stack(r, 1.0).touch_force), "N"),
    "inertia.on_piezos": (inertia_on_piezos, "kg*m^2"),
    **{f"rise.{body}": (partial(_rise, k), "K") for k, body in enumerate(BODIES)},
    "growth.by_heat": (lambda r: growth(r)[0], "m"),
    "growth.in_period": (lambda r: growth(r)[1], "m"),
    "pressure.of_pad": (lambda r: float(film(r, heaviest_pad(r)).peak_pressure), "Pa"),
    "radius.of_pad": (lambda r: float(film(r, heaviest_pad(r)).radius), "m"),
    "radius.of_averaging": (_averaging_radius, "m"),
    "frequency.of_loop": (lambda r: suspension(r).resonance, "Hz"),
    "gain.of_loop": (lambda r: suspension(r).gain, ""),
    "closure.of_finger": (lambda r: clamp_finger(r).closure, "m/N"),
    "stress.of_free_neck": (lambda r: clamp_finger(r).stress(1.0), "Pa/N"),
    "stress.of_neck": (lambda r: grip(r, loose_fit(r)).stress, "Pa"),
    "gap.of_clamp": (lambda r: clamp_gap(r, loose_fit(r)), "m"),
    "force.of_clamp_screw": (lambda r: screw_preload(r, "clamp_long"), "N"),
    "force.of_finger": (lambda r: grip(r, loose_fit(r)).press, "N"),
    "force.on_rim": (lambda r: grip(r).rim, "N"),
    "angle.of_finger": (press_angle, "rad"),
    "farthest.along": (partial(_farthest, 0, "along"), "m"),
    "farthest.across": (partial(_farthest, 1, "across"), "m"),
}
"""SI value and unit by name."""


def quantity_key(group: str, name: str) -> str:
    """Name of a quantity in formulas from words."""
    return f"{group}.{re.sub(r'[^a-z]+', '_', name)}"


def stated(
    name: str, formula: str, *changes: tuple[str, str, bool], given: Quantities | None = None, **texts: str
) -> FormulaCheck:
    """A check of the machine by one formula; arguments as of `FormulaCheck`, `given` names further quantities."""
    return FormulaCheck(name, formula, texts, {**QUANTITIES, **(given or {})}, changes)
