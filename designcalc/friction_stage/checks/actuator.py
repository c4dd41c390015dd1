"""Piezo actuator: resonances against the drive, force, current, heat, tension and bending of the stacks, step size."""

from designcalc.checks.check import CheckFunction
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_ACTUATOR = "Table 2: actuator"
SLIP_SHARE = 0.421
"""Mean of ``|pi/2 sin wt - 1|`` over half a period. A tip that touches for half of each period slips by this part of X
while the stage moves by 2 X, under twice its mean force."""


def checks(design: Design) -> list[CheckFunction]:
    """Every check of tip and piezos."""
    return [
        tip_weight,
        drive_frequency,
        sway_mode,
        pushing_force,
        heat,
        stack_rise,
        heat_drift,
        current,
        tension,
        bending,
        tilt,
        step_size,
        amplifier_noise,
        creep,
        tip_wear,
    ]


tip_weight = stated(
    "mass of the tip",
    "mass.tip <= tip.mass_limit",
    source="solid of the tip; the limit itself where no solids were made",
    proposal="a deeper relief bore, or thinner arms",
)


drive_frequency = stated(
    "drive frequency against the tip's resonances",
    "actuator.frequency <= min(resonance.tip_up, resonance.tip_rocking)/3",
    ("actuator.frequency", "check.limit", False),
    source="rigid tip on three springs, f_up = sqrt(3 k/m)/(2 pi), f_rock = sqrt(k D^2/(2 J))/(2 pi); a third of the "
    "first resonance as the usual limit",
    proposal="drive more slowly, or at the resonance itself with the ellipse measured",
    requirement=_ACTUATOR,
    note="in contact with the stage the tip's resonances rise; between the strikes it is free",
)


pushing_force = stated(
    "force of the piezos against the load",
    "load.whole <= 3*piezo.blocking_force/4",
    source="catalogue line of the piezo at half its stroke, factor 2",
    proposal="stronger stacks",
    requirement=_ACTUATOR,
)


heat = stated(
    "heat of the piezos at full speed",
    "2*pi*frequency.of_speed*capacitance.driven*(piezo.highest_voltage/2)^2*piezo.loss_factor <= actuator.heat_limit",
    source="dielectric loss of a sine, two stacks; capacitance at full stroke",
    proposal="full speed for {100*check.limit/check.value} % of the time, or a holder that takes {check.value}",
    thesis="'milliwatts' is {check.value} at the required speed",
    requirement=_ACTUATOR,
)


_DUTY = "full speed for {heat.moving} of each {heat.period}"
stack_rise = stated(
    "temperature of the stacks over the duty cycle",
    "rise.stacks <= heat.highest_rise",
    ("heat.period", "heat.period*check.value/check.limit", True),
    source="network of stacks, tip, holder and base in the periodic state; stacks through their ends and the air of "
    "their bores",
    proposal="fewer moves, or a heat-conducting filling of the bores",
    requirement=_ACTUATOR,
    note=_DUTY + "; tip {rise.tip}, holder {rise.holder}, base {rise.base} over the surroundings",
)


heat_drift = stated(
    "drift of the tip by the heat of its stacks",
    "abs(growth.by_heat) <= 0.1*ellipse.rise",
    source="growth of stacks, tip and holder's floor from the surroundings' temperature to the end of a move",
    proposal="less speed or shorter moves, or a bias of the piezos that follows the temperature",
    requirement="Table 2: low thermal expansion",
    note=_DUTY + "; {growth.by_heat}, {growth.in_period} of it in each period",
)


current = stated(
    "peak current of one piezo at full speed",
    "pi*frequency.of_speed*capacitance.driven*piezo.highest_voltage <= amplifier.current",
    ("amplifier.current", "check.value", True),
    source="sine on a capacitor, that of the stack at full stroke",
    proposal="more current, or {frequency.of_speed*check.limit/check.value} at most",
    requirement=_ACTUATOR,
    note="{check.value*piezo.highest_voltage/pi} drawn on the mean from a linear amplifier",
)


_RATE = "(2*pi*frequency.of_speed)^2"
_SWING = (
    f"sqrt((mass.on_piezos*{_RATE}*ellipse.rise/4)^2"
    f" + (inertia.on_piezos*{_RATE}*ellipse.along/(2*actuator.tip_height)/actuator.piezo_spacing)^2)"
)
_PUSH = "drive.friction*load.peak_of_tip*actuator.tip_height/actuator.piezo_spacing"
_SLOWER = f"sqrt(max(piezo.strain_limit*piezo.element_area - {_PUSH}, 0 N)/{_SWING})"
_PULL = "{check.value*piezo.element_area}"
tension = stated(
    "tension of a piezo by the tip's inertia and drive force",
    f"({_SWING} + {_PUSH})/piezo.element_area <= piezo.strain_limit",
    ("requirements.speed", f"requirements.speed*{_SLOWER}", False),
    source="inertia of the tip's rise and rocking at the frequency of the required speed, shared by the two driven "
    "stacks; the moment of the peak drive force as push and pull on them",
    proposal=f"preload each stack by {_PULL} or more, or drive at {{frequency.of_speed*{_SLOWER}}} at most",
    requirement=_ACTUATOR,
    note=f"{{{_SWING}}} of inertia and {{{_PUSH}}} of drive; preloaded by {_PULL}, "
    "{100*check.value*piezo.element_area/piezo.blocking_force} % of the blocking force, the ceramic stays in "
    "compression",
)


_SIDE = f"drive.friction*load.peak_of_tip/{PIEZOS}"
_BORE = "(holder.height - holder.floor)"
bending = stated(
    "side load of the drive on a piezo",
    f"6/piezo.element_area^1.5*max(min({_SIDE}, force.touching_bore)*piezo.length,"
    f" abs({_SIDE}*piezo.length - max({_SIDE} - force.touching_bore, 0 N)*(3*piezo.length - {_BORE})/2),"
    f" {_SIDE}*(piezo.length - {_BORE})) <= piezo.strain_limit",
    source="element bent as a cantilever, and propped by the mouth of its bore once it touches: moments at its foot up "
    "to the touch and beyond it, and at the mouth; its case neglected",
    proposal="stacks preloaded by {check.value*piezo.element_area}, or guided in their bores without play",
    thesis="'lateral stiffness is provided by the piezo housing': with play in the bore the stacks bend first",
    requirement=_ACTUATOR,
    note=f"{{{_SIDE}}} across each stack, which touches its bore at {{force.touching_bore}}",
)


sway_mode = stated(
    "sway of the tip on its stacks against the drive",
    "resonance.tip_sway >= 3*actuator.frequency",
    source="three stacks as cantilevers within the play of their bores, sqrt(3 x 3 E I/L^3/m)/(2 pi); a third of the "
    "resonance as usual limit",
    proposal="a flexure that guides the tip across the stacks, or stacks held in their bores without play",
    thesis="'lateral stiffness is provided by the piezo housing': with play in the bore only the stacks do",
    requirement=_ACTUATOR,
    note="{stiffness.sway} under {mass.on_piezos}",
)


tilt = stated(
    "bending of a piezo by the tip's tilt",
    "piezo.blocking_force/2*piezo.end_radius*ellipse.along/(2*actuator.tip_height)*6/piezo.element_area^1.5"
    " <= piezo.strain_limit",
    source="rounded end that rolls on the tip: the reaction, half the blocking force, moves by R theta",
    proposal="a smaller end radius",
    requirement=_ACTUATOR,
    note="with flat, bonded ends it would be {4*piezo.material.youngs_modulus*sqrt(piezo.element_area)/2*ellipse.along/"
    "(2*actuator.tip_height)/piezo.length}",
)


step_size = stated(
    "smallest step of the tip",
    "2*actuator.tip_height/actuator.piezo_spacing*piezo.stroke/2^amplifier.bits <= requirements.resolution_coarse",
    source="one count on both piezos, opposed; without slip the stage follows the tip",
    proposal="more bits",
    requirement="Table 1: resolution",
    note="open loop the piezo's hysteresis is far larger: this is the resolution of the loop, not its accuracy",
)


amplifier_noise = stated(
    "noise of the amplifiers at the tip",
    "sqrt(2)*amplifier.noise*piezo.stroke/piezo.highest_voltage*actuator.tip_height/actuator.piezo_spacing"
    " <= requirements.resolution",
    source="independent noise of two amplifiers through the stacks' mean gain and the tip's lever",
    proposal="a quieter amplifier, or a filter before the stack",
    requirement="Table 1: resolution",
)


creep = stated(
    "creep of the piezos in a decade of time",
    "piezo.creep*ellipse.along/2 <= requirements.resolution_coarse",
    source="logarithmic creep of the stacks after a move to the end of the pressed tip's range, in open loop",
    proposal="hold the position in closed loop, or drive the stacks by charge",
    requirement="Table 1: resolution",
)


tip_wear = stated(
    "wear of the tip's coating",
    f"pi*tip.nose_radius*tip.coating_thickness^2/(drive.tip_wear_rate*load.of_tip)/{SLIP_SHARE} >= bearing.life",
    source="Archard on the nose's cap under the largest mean load; slip of a sinusoidal tip against a steady stage",
    proposal="a thicker or harder coating, a larger nose radius, or less preload",
    requirement="Table 2: friction layer",
)
