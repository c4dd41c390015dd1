"""Effects of sliding on the pads: running in, wear, heat."""

from designcalc.checks.check import CheckFunction
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design


def checks(design: Design) -> list[CheckFunction]:
    """Film, running in, life, heat."""
    return [film_thickness, running_in, life, heat]


film_thickness = stated(
    "PTFE film as printed, '1 mm - 2 um'",
    "bearing.film_thickness <= bearing.film_conductivity*bearing.film_warming"
    "*pi*radius.bare_crown^2/(bearing.dynamic_friction*load.heaviest_pad*requirements.speed)",
    source="heat of sliding conducted through the film into the stage at full speed, on the spot of the bare crown",
    proposal="1 to 2 um",
    thesis="'1 mm - 2 um' is a misprint for 1 - 2 um: a film of 1 mm would be {1 mm/bearing.thickest_film} times as "
    "thick as Nanosurf 2's",
    note="the film warms by {bearing.film_warming*check.value/check.limit}, {bearing.film_warming} allowed",
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
