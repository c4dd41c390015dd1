"""Effects of sliding on the pads: running in, wear, heat."""

from __future__ import annotations

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_most, show
from designcalc.friction_stage.physics.pads import heaviest_pad, pad_contact
from designcalc.friction_stage.quantities import stated
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


running_in = stated(
    "wear of the PTFE film by running in",
    "sqrt(bearing.run_in_wear_rate*load.heaviest_pad*2*stage.travel*bearing.run_in_cycles/(pi*pads.crown_radius))"
    " <= bearing.film_thickness/2",
    ("bearing.run_in_wear_rate", "bearing.run_in_wear_rate*(check.limit/check.value)^2", False),
    source="Archard on a crown over the thesis's several thousand cycles; half the film kept",
    proposal="flat pads, a shorter running in, or a film that wears by "
    "{bearing.run_in_wear_rate*(check.limit/check.value)^2} at most (filled PTFE: 1e-15 m^2/N)",
)


life = stated(
    "life of the PTFE film",
    "pi*pads.crown_radius*(bearing.film_thickness/2)^2/(bearing.wear_rate*load.heaviest_pad) >= bearing.life",
    ("bearing.wear_rate", "bearing.wear_rate*check.value/check.limit", False),
    source="Archard, the crown worn by half the film",
    proposal="flat pads, or a film that wears by {bearing.wear_rate*check.value/check.limit} at most (filled PTFE "
    "reaches 1e-15 m^2/N)",
    note="{check.value/(2*stage.travel)} strokes there and back",
)


heat = stated(
    "heat of sliding at full speed",
    "bearing.dynamic_friction*load.whole*requirements.speed <= bearing.heat_limit",
    source="friction power",
    proposal="full speed for {100*min(check.limit/check.value, 1)} % of the time, or less preload",
    note="the worst friction the thesis allows, mu = {bearing.dynamic_friction_high}, makes it "
    "{check.value*bearing.dynamic_friction_high/bearing.dynamic_friction}",
)
