"""Effects of sliding on the pads: running in, wear, heat."""

from __future__ import annotations

import numpy as np

from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance, friction_heat
from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, ratio, show
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.pads import heaviest_pad, pad_contact
from stagecad.parameters.design import Design


def checks(design: Design) -> list[CheckFunction]:
    """Film, running in, life, heat."""
    return [film_thickness, running_in, life, heat]


def film_thickness(r: DesignInputs) -> Check:
    """The heat of sliding passes through the film into the stage, and warms the film by its thickness."""
    thickness, warming = r("bearing.film_thickness"), r("bearing.film_warming")
    contact = pad_contact(r, heaviest_pad(r))
    area = np.pi * float(contact.semi_axis_major) ** 2
    flux = r("bearing.dynamic_friction") * heaviest_pad(r) * r("requirements.speed") / area
    limit = r("bearing.film_conductivity") * warming / flux
    return Check(
        "PTFE film as printed, '1 mm - 2 um'",
        at_most(thickness, limit, "m"),
        source="heat of sliding conducted through the film at full speed, on the spot of the bare crown",
        formula="t <= lambda dT/q, q = mu N v/(pi a^2)",
        substituted=f"q = {flux:.3g} W/m^2 over a = {show(float(contact.semi_axis_major), 'm')}: the film of "
        f"{show(thickness, 'm')} warms by {show(thickness * warming / limit, 'K')}, {show(warming, 'K')} allowed",
        proposal="1 to 2 um",
        thesis="'1 mm - 2 um' is a misprint for 1 - 2 um: a film of 1 mm would be "
        f"{1e-3 / r('bearing.thickest_film'):.3g} times as thick as Nanosurf 2's",
    )


def running_in(r: DesignInputs) -> Check:
    """Running in must not wear out the film."""
    cycles, travel = r("bearing.run_in_cycles"), r("stage.travel")
    distance = 2 * travel * cycles
    radius = r("pads.crown_radius")
    worn = float(crown_wear_depth(distance, radius, r("bearing.run_in_wear_rate"), heaviest_pad(r)))
    thickness = r("bearing.film_thickness")
    limit = thickness / 2
    hours = distance / r("requirements.speed") / 3600
    rate = r("bearing.run_in_wear_rate") * (limit / worn) ** 2
    return Check(
        "wear of the PTFE film by running in",
        at_most(worn, limit, "m"),
        source="Archard on a crown over the thesis's several thousand cycles; half the film kept",
        formula="h = sqrt(k F s/(pi R)) <= t/2, s = 2 travel x cycles",
        substituted=f"{cycles:.0f} cycles, {show(distance, 'm')}, {hours:.2g} h at full speed: {show(worn, 'm')} of "
        f"{show(thickness, 'm')}",
        proposal=f"flat pads, a shorter running in, or a film that wears by {show(rate, 'm^2/N')} at most "
        "(filled PTFE: 1e-15 m^2/N)",
        changes=change("bearing.run_in_wear_rate", rate, "m^2/N", up=False),
    )


def life(r: DesignInputs) -> Check:
    heaviest = heaviest_pad(r)
    radius, depth = r("pads.crown_radius"), r("bearing.film_thickness") / 2
    distance = float(crown_wear_distance(depth, radius, r("bearing.wear_rate"), heaviest))
    wanted = r("bearing.life")
    rate = r("bearing.wear_rate") * distance / wanted
    return Check(
        "life of the PTFE film",
        at_least(distance, wanted, "m"),
        source="Archard, the crown worn by half the film",
        formula="s = pi R (t/2)^2/(k F)",
        substituted=f"R = {show(radius, 'm')}, F = {show(heaviest, 'N')}: {show(distance, 'm')}, "
        f"{distance / (2 * r('stage.travel')):.3g} strokes there and back",
        proposal=f"flat pads, or a film that wears by {show(rate, 'm^2/N')} at most (filled PTFE reaches 1e-15 m^2/N)",
        changes=change("bearing.wear_rate", rate, "m^2/N", up=False),
    )


def heat(r: DesignInputs) -> Check:
    force = load(r)
    watts = float(friction_heat(r("bearing.dynamic_friction"), force, r("requirements.speed")))
    limit = r("bearing.heat_limit")
    return Check(
        "heat of sliding at full speed",
        at_most(watts, limit, "W"),
        source="friction power",
        formula="mu N v",
        substituted=f"{show(force, 'N')}: {show(watts, 'W')}",
        proposal=f"full speed for {100 * min(ratio(limit, watts), 1.0):.2g} % of the time, or less preload",
        note=f"the worst friction the thesis allows, mu = {r('bearing.dynamic_friction_high'):.2g}, makes it "
        f"{show(watts * r('bearing.dynamic_friction_high') / r('bearing.dynamic_friction'), 'W')}",
    )
