"""Tip on stage: pressure, stroke lost in the contact, stiffness; with the results of the thesis's printed formulas."""

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_most, change, show
from designcalc.contact.hertz_stress import edge_tension, peak_mises, point_shear_peak
from designcalc.friction_stage.physics.loads import tip_load
from designcalc.friction_stage.physics.plate_vibration import above_tip
from designcalc.friction_stage.physics.tip_dynamics import peak_tip_force, tip_contact, usable_ellipse
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_JOHNSON = "Johnson, Contact Mechanics (1985), section 4.2"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the tip's contact."""
    return [pressure, coating, lost_stroke, contact_stiffness]


def pressure(r: DesignInputs) -> Check:
    load = peak_tip_force(r)
    contact = tip_contact(r, load)
    ratio = contact.semi_axis_minor / contact.semi_axis_major
    limits = [
        r.material(part, "strength") / float(peak_mises(ratio, r.material(part, "poisson_ratio")))
        for part in ("tip", "stage")
    ]
    peak = float(contact.peak_pressure)
    shear = point_shear_peak(contact, r.material("stage", "poisson_ratio"))
    radius = r("tip.nose_radius")
    # The pressure falls as R^(-2/3), while the stiffer contact raises the peak force.
    grow = radius * (peak / min(limits)) ** 2.5
    return Check(
        "tip contact pressure",
        at_most(peak, min(limits), "Pa"),
        source=_JOHNSON + "; first yield below the surface, section 6.1; peak of a tip that carries the load in pulses",
        formula="p0 = (6 F E*^2/(pi^3 R^2))^(1/3) <= Sy/(largest von Mises stress over p0)",
        substituted=f"F = {show(load, 'N')}, R = {show(radius, 'm')}: p0 = {show(peak, 'Pa')}, limit "
        f"{show(min(limits), 'Pa')}",
        proposal="a larger nose radius (pressure falls as R^(-2/3)), or a harder tip",
        changes=change("tip.nose_radius", grow, "m", up=True),
        thesis=f"appendix A prints q = 3F/(3 pi c d), which gives {show(peak * 2 / 3, 'Pa')}; right is 3F/(2 pi c d), "
        f"{show(peak, 'Pa')}",
        note=f"peak shear {show(float(shear.shear), 'Pa')} at a depth of {show(float(shear.depth), 'm')}",
    )


def coating(r: DesignInputs) -> Check:
    """The nose's coating is thin compared with the contact: it has the strain of the body under it."""
    peak, mu = float(tip_contact(r, peak_tip_force(r)).peak_pressure), r("drive.friction")
    body, layer = (
        r.material("tip", "youngs_modulus") / (1 - r.material("tip", "poisson_ratio") ** 2),
        _coating(r, "youngs_modulus") / (1 - _coating(r, "poisson_ratio") ** 2),
    )
    tension = float(edge_tension(peak, r.material("tip", "poisson_ratio"), mu)) * layer / body
    return Check(
        "cracking of the tip's coating",
        at_most(tension, _coating(r, "strength"), "Pa"),
        source="Hamilton, Goodman (1966): tension at the trailing edge of the sliding contact; coating strained with "
        "the body",
        formula="p0 [(1 - 2 nu)/3 + mu pi (4 + nu)/8] x E'_coating/E'_tip <= strength",
        substituted=f"p0 = {show(peak, 'Pa')}, mu = {mu:.3g}, E' ratio {layer / body:.3g}: {show(tension, 'Pa')}",
        proposal="a larger nose radius, or a softer coating",
        requirement="Table 2: friction layer",
    )


def _coating(r: DesignInputs, quantity: str) -> float:
    return r(f"materials.{r.design.value('tip.coating_material')}.{quantity}")


def lost_stroke(r: DesignInputs) -> Check:
    contact = tip_contact(r, tip_load(r))
    rise, stage = usable_ellipse(r)[1], above_tip(r, tip_load(r))
    bent, lifted = float(stage.static[0]), float(stage.at_peak_force[0] - stage.static[0])
    lost = float(contact.approach) + bent + max(lifted, 0.0)
    # The printed deflection is the law of the semi-axes, ~F^(1/3); as a force's potential it must go as F^(2/3).
    # On a flat, Re = R/2 and lambda = 0.75.
    printed = printed_approach(float(contact.load), r("tip.nose_radius"), float(contact.approach))
    return Check(
        "tip stroke lost to the contact",
        at_most(lost, 0.2 * rise, "m"),
        source=_JOHNSON
        + "; stage as a plate on its pads, its modes shaken by the pulses of the tip; a fifth of the rise "
        "left as rule of thumb",
        formula="delta + F/K_stage + max(sum_k F_k Re G(k f), 0) <= 0.2 Y, delta = 3 F K/(2 pi a E*), Y the rise of "
        "the ellipse, G the stage's compliance above the tip",
        substituted=f"F = {show(float(contact.load), 'N')}: delta = {show(float(contact.approach), 'm')}, stage "
        f"{show(bent, 'm')}, at the peak of the force {show(lifted, 'm')} more, Y = {show(rise, 'm')}",
        proposal="less preload, a stiffer stage, or a larger nose radius",
        thesis=f"appendix A prints delta = lambda (3 F Re/(2 Ee))^(1/3), which gives {show(printed, 'm')}; right is "
        f"lambda (2 F^2/(3 Re Ee^2))^(1/3), {show(float(contact.approach), 'm')}",
    )


def printed_approach(load: float, radius: float, approach: float) -> float:
    """Result of appendix A's formula for a sphere on a flat whose true approach is known, m.

    ``lambda (3 F Re/(2 Ee))^(1/3)`` with lambda = 0.75, Re = R/2, and Ee from ``F = 4/3 Ee sqrt(R) delta^1.5``.
    """
    modulus = load / (4 / 3 * np.sqrt(radius) * approach**1.5)
    return float(0.75 * np.cbrt(3 * load * (radius / 2) / (2 * modulus)))


contact_stiffness = stated(
    "tip contact against piezo stiffness",
    "stiffness.contact >= stiffness.stack/2",
    ("tip.nose_radius", "tip.nose_radius*(check.limit/check.value)^3", True),
    source=_JOHNSON + "; dF/ddelta = 1.5 F/delta, so that less than two thirds of the deflection is the contact's; "
    "catalogue line of the piezo",
    proposal="a larger nose radius, or more preload (stiffness grows as (F R)^(1/3))",
)
