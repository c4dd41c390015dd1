"""Calculated numbers of the machine that the formulas of its checks name."""

import re
from functools import partial

import numpy as np

from designcalc.bearing import bolted_rail, fastener
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import DesignInputs, FormulaCheck, Quantities
from designcalc.contact.hertz import ShearPeak, contact_modulus, peak_mises, point_shear_peak
from designcalc.friction_stage.physics import clamp, heat, loads, pads, position_loop, stage_plate, tip_dynamics


def _way_thread(r: DesignInputs) -> fastener.Thread:
    return fastener.Thread(r("screws.way.diameter"), r("screws.way.pitch"))


def _way_depth(r: DesignInputs) -> float:
    """Engagement of the screws of the ways in the base, m."""
    return r("screws.way.length") - r("bearing_way.flange_thickness")


def _shear_peak(r: DesignInputs) -> ShearPeak:
    return point_shear_peak(
        tip_dynamics.tip_contact(r, tip_dynamics.peak_tip_force(r)), r.material("stage", "poisson_ratio")
    )


def _way_joint(r: DesignInputs) -> float:
    """Stiffness of one bolt joint of the way, N/m."""
    way = pads.rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    return float(bolted_rail.joint_stiffness(way, tau).joint_per_diameter) * way.bolt_diameter


def _averaging_radius(r: DesignInputs) -> float:
    """Radius of a pad's contact, m, where it averages the way's roughness."""
    radius = pads.film(r, pads.heaviest_pad(r)).radius
    averaged_roughness(1.0, r("bearing.roughness_correlation"), radius)  # refuses a contact that is too small
    return float(radius)


def _lift_of_pulses(r: DesignInputs) -> float:
    """Height above the tip at the peak of its force over that at its mean, m."""
    found = stage_plate.above_tip(r, loads.tip_load(r))
    return float(found.at_peak_force[0] - found.static[0])


def loose_fit(r: DesignInputs) -> float:
    """Play of the holder in its pocket beyond the nominal one by both tolerances, m."""
    return 2 * r("drawing.tolerance_x_xx")


def _farthest(axis: int, name: str, r: DesignInputs) -> float:
    """Distance of the farthest actuator from the middle along an axis, m."""
    places = r.design.derived.actuator_places
    return r.given(f"farthest actuator {name}", max(abs(p[axis]) for p in places) * 1e-3, "m", "layout of the pockets")


QUANTITIES: Quantities = {
    "ellipse.along": (lambda r: tip_dynamics.usable_ellipse(r)[0], "m"),
    "ellipse.rise": (lambda r: tip_dynamics.usable_ellipse(r)[1], "m"),
    "load.weight": (loads.weight, "N"),
    "load.preload": (loads.preload, "N"),
    "load.whole": (loads.load, "N"),
    "load.magnets": (loads.attraction, "N"),
    "load.of_tip": (loads.tip_load, "N"),
    "load.heaviest_pad": (pads.heaviest_pad, "N"),
    "stiffness.pads": (lambda r: pads.pads_stiffness(r).normal, "N/m"),
    "stiffness.along": (tip_dynamics.holding_stiffness, "N/m"),
    "stiffness.stack": (tip_dynamics.stack_stiffness, "N/m"),
    "stiffness.sway": (tip_dynamics.sway, "N/m"),
    "stiffness.contact": (lambda r: float(tip_dynamics.tip_contact(r, loads.tip_load(r)).stiffness), "N/m"),
    "stiffness.teeth": (lambda r: loads.CIRCUITS * loads.magnets(r).normal_stiffness, "N/m"),
    "flux.gap": (lambda r: loads.magnets(r).gap_flux_density, "T"),
    "depth.film": (lambda r: float(pads.film(r, pads.heaviest_pad(r)).indentation), "m"),
    "mass.tip": (loads.tip_mass, "kg"),
    "mass.on_piezos": (tip_dynamics.mass_on_piezos, "kg"),
    "resonance.tip_up": (lambda r: tip_dynamics.tip_resonances(r)[0], "Hz"),
    "resonance.tip_rocking": (lambda r: tip_dynamics.tip_resonances(r)[1], "Hz"),
    "resonance.tip_sway": (tip_dynamics.sway_resonance, "Hz"),
    "frequency.of_speed": (tip_dynamics.speed_frequency, "Hz"),
    "capacitance.driven": (tip_dynamics.driven_capacitance, "F"),
    "force.way_screw": (lambda r: clamp.screw_preload(r, "way"), "N"),
    "area.way_screw": (lambda r: _way_thread(r).stress_area, "m^2"),
    "area.bed_thread": (lambda r: float(fastener.strip_area_of_bed(_way_thread(r), _way_depth(r))), "m^2"),
    "area.screw_thread": (lambda r: float(fastener.strip_area_of_screw(_way_thread(r), _way_depth(r))), "m^2"),
    "radius.bare_crown": (lambda r: float(pads.pad_contact(r, pads.heaviest_pad(r)).semi_axis_major), "m"),
    "height.centre_of_mass": (lambda r: loads.moving_body(r).centre_of_mass[2], "m"),
    "reach.of_pads": (lambda r: float(np.max(pads.pad_positions(r)[:, 0])) - abs(loads.load_centre(r)[0]), "m"),
    "stiffness.pitch": (lambda r: pads.pads_stiffness(r).pitch, "N*m"),
    "stiffness.roll": (lambda r: pads.pads_stiffness(r).roll, "N*m"),
    "stiffness.teeth_across": (lambda r: loads.CIRCUITS * loads.magnets(r).lateral_stiffness, "N/m"),
    "load.moved_mass": (loads.moved_mass, "kg"),
    "load.peak_of_tip": (tip_dynamics.peak_tip_force, "N"),
    "load.lightest_pad": (lambda r: float(np.min(pads.pad_forces(r))), "N"),
    "modulus.tip_contact": (lambda r: float(contact_modulus(*tip_dynamics.elastic_constants(r, "tip", "stage"))), "Pa"),
    "mises.tip": (lambda r: float(peak_mises(1.0, r.material("tip", "poisson_ratio"))), ""),
    "mises.stage": (lambda r: float(peak_mises(1.0, r.material("stage", "poisson_ratio"))), ""),
    "shear.under_tip": (lambda r: float(_shear_peak(r).shear), "Pa"),
    "depth.of_shear": (lambda r: float(_shear_peak(r).depth), "m"),
    "bend.above_tip": (lambda r: float(stage_plate.above_tip(r, loads.tip_load(r)).static[0]), "m"),
    "lift.above_tip": (_lift_of_pulses, "m"),
    "give.above_tip": (stage_plate.give_at_tip, "m/N"),
    "give.of_way_edge": (lambda r: float(bolted_rail.bending_shear_compliance(pads.rail(r))), "m^2/N"),
    "stiffness.way_joint": (_way_joint, "N/m"),
    "force.touching_bore": (lambda r: float(tip_dynamics.bent_stack(r, 1.0).touch_force), "N"),
    "inertia.on_piezos": (tip_dynamics.inertia_on_piezos, "kg*m^2"),
    **{f"rise.{body}": (lambda r, k=k: float(heat.warmed(r).hottest[k]), "K") for k, body in enumerate(heat.BODIES)},
    "growth.by_heat": (lambda r: heat.growth(r)[0], "m"),
    "growth.in_period": (lambda r: heat.growth(r)[1], "m"),
    "pressure.of_pad": (lambda r: float(pads.film(r, pads.heaviest_pad(r)).peak_pressure), "Pa"),
    "radius.of_pad": (lambda r: float(pads.film(r, pads.heaviest_pad(r)).radius), "m"),
    "radius.of_averaging": (_averaging_radius, "m"),
    "frequency.of_loop": (lambda r: position_loop.suspension(r).resonance, "Hz"),
    "gain.of_loop": (lambda r: position_loop.suspension(r).gain, ""),
    "closure.of_finger": (lambda r: clamp.clamp_finger(r).closure, "m/N"),
    "stress.of_free_neck": (lambda r: clamp.clamp_finger(r).stress(1.0), "Pa/N"),
    "stress.of_neck": (lambda r: clamp.grip(r, loose_fit(r)).stress, "Pa"),
    "gap.of_clamp": (lambda r: clamp.clamp_gap(r, loose_fit(r)), "m"),
    "force.of_clamp_screw": (lambda r: clamp.screw_preload(r, "clamp_long"), "N"),
    "force.of_finger": (lambda r: clamp.grip(r, loose_fit(r)).press, "N"),
    "force.on_rim": (lambda r: clamp.grip(r).rim, "N"),
    "angle.of_finger": (clamp.press_angle, "rad"),
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
