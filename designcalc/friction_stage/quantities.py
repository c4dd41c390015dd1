"""Calculated numbers of the machine that the formulas of its checks name."""

import numpy as np

from designcalc.bearing.fastener import Thread, strip_area_of_bed, strip_area_of_screw
from designcalc.checks.check import DesignInputs
from designcalc.checks.formula_check import FormulaCheck, Quantities
from designcalc.friction_stage.physics.body import moving_body, tip_mass
from designcalc.friction_stage.physics.clamp import screw_preload
from designcalc.friction_stage.physics.loads import load, load_centre, moved_mass, preload, tip_load, weight
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pad_contact, pad_positions, pads_stiffness
from designcalc.friction_stage.physics.teeth import CIRCUITS, attraction, magnets
from designcalc.friction_stage.physics.tip_dynamics import (
    driven_capacitance,
    holding_stiffness,
    mass_on_piezos,
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
}
"""SI value and unit by name."""


def stated(name: str, formula: str, *changes: tuple[str, str, bool], **texts: str) -> FormulaCheck:
    """A check of the machine by one formula; arguments as of `FormulaCheck`."""
    return FormulaCheck(name, formula, texts, QUANTITIES, changes)
