"""Piezo actuator: resonances against the drive, force, current, heat, tension and bending of the stacks, step size."""

from __future__ import annotations

import numpy as np

from designcalc.bearing.sliding import crown_wear_distance
from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, ratio, show
from designcalc.drive.piezo_stack import drive_pull, stack_current, stack_heat, stack_tension, tilt_stress
from designcalc.friction_stage.physics.body import tip_mass
from designcalc.friction_stage.physics.loads import load, tip_load
from designcalc.friction_stage.physics.tip_dynamics import (
    PIEZOS,
    bent_stack,
    driven_capacitance,
    inertia_on_piezos,
    mass_on_piezos,
    peak_tip_force,
    speed_frequency,
    sway,
    sway_resonance,
    tilt_amplitude,
    tip_noise,
    tip_resonances,
    usable_ellipse,
)
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
        current,
        tension,
        bending,
        tilt,
        step_size,
        amplifier_noise,
        creep,
        tip_wear,
    ]


def tip_weight(r: DesignInputs) -> Check:
    return Check(
        "mass of the tip",
        at_most(tip_mass(r), r("tip.mass_limit"), "kg"),
        source="solid of the tip; the limit itself where no solids were made",
        formula="m_tip <= limit",
        proposal="a deeper relief bore, or thinner arms",
    )


def drive_frequency(r: DesignInputs) -> Check:
    up, rocking = tip_resonances(r)
    limit = min(up, rocking) / 3
    return Check(
        "drive frequency against the tip's resonances",
        at_most(r("actuator.frequency"), limit, "Hz"),
        source="rigid tip on three springs; a third of the first resonance as the usual limit",
        formula="f <= min(f_up, f_rock)/3, f_up = sqrt(3 k/m)/(2 pi), f_rock = sqrt(k D^2/(2 J))/(2 pi)",
        substituted=f"f_up = {show(up, 'Hz')}, f_rock = {show(rocking, 'Hz')}",
        proposal="drive more slowly, or at the resonance itself with the ellipse measured",
        changes=change("actuator.frequency", limit, "Hz", up=False),
        requirement=_ACTUATOR,
        note="in contact with the stage the tip's resonances rise; between the strikes it is free",
    )


def pushing_force(r: DesignInputs) -> Check:
    """The lift-off force at mid-stroke, where each piezo has half of its blocking force left."""
    force = load(r)
    available = PIEZOS * r("piezo.blocking_force") / 2
    return Check(
        "force of the piezos against the load",
        at_most(force, available / 2, "N"),
        source="catalogue line of the piezo at half its stroke, factor 2",
        formula="W (1+p) <= 3 F_block/4",
        substituted=f"{show(force, 'N')} against {show(available, 'N')} at mid-stroke",
        proposal="stronger stacks",
        requirement=_ACTUATOR,
    )


def heat(r: DesignInputs) -> Check:
    f = speed_frequency(r)
    voltage, loss = r("piezo.highest_voltage"), r("piezo.loss_factor")
    watts = 2 * float(stack_heat(driven_capacitance(r), voltage, f, loss))
    limit = r("actuator.heat_limit")
    duty = ratio(limit, watts)
    return Check(
        "heat of the piezos at full speed",
        at_most(watts, limit, "W"),
        source="dielectric loss of a sine, two stacks; capacitance at full stroke",
        formula="P = 2 pi f C (V/2)^2 tan(delta)",
        substituted=f"f = {show(f, 'Hz')}, V = {show(voltage, 'V')}, C = {show(driven_capacitance(r), 'F')}, "
        f"tan(delta) = {loss:.3g}: {show(watts, 'W')}",
        proposal=f"full speed for {100 * duty:.2g} % of the time, or a holder that takes {show(watts, 'W')}",
        thesis=f"'milliwatts' is {show(watts, 'W')} at the required speed",
        requirement=_ACTUATOR,
    )


def current(r: DesignInputs) -> Check:
    f = speed_frequency(r)
    peak = float(stack_current(driven_capacitance(r), r("piezo.highest_voltage"), f))
    available = r("amplifier.current")
    return Check(
        "peak current of one piezo at full speed",
        at_most(peak, available, "A"),
        source="sine on a capacitor, that of the stack at full stroke",
        formula="I = pi f C V",
        substituted=f"f = {show(f, 'Hz')}, C = {show(driven_capacitance(r), 'F')}: {show(peak, 'A')}, "
        f"{show(peak * r('piezo.highest_voltage') / np.pi, 'W')} "
        "drawn on the mean from a linear amplifier",
        proposal=f"more current, or {show(f * available / peak, 'Hz')} at most",
        changes=change("amplifier.current", peak, "A", up=True),
        requirement=_ACTUATOR,
    )


def tension(r: DesignInputs) -> Check:
    """Tension at the frequency of the required speed, like heat and current."""
    f, spacing = speed_frequency(r), r("actuator.piezo_spacing")
    _, Y = usable_ellipse(r)
    swing = float(stack_tension(mass_on_piezos(r), inertia_on_piezos(r), f, Y, tilt_amplitude(r), spacing))
    side = r("drive.friction") * peak_tip_force(r)
    push = float(drive_pull(side, r("actuator.tip_height"), spacing))
    area, limit = r("piezo.element_area"), r("piezo.strain_limit")
    pull = swing + push
    slower = f * np.sqrt(max(limit * area - push, 0.0) / swing) if swing > 0 else f
    return Check(
        "tension of a piezo by the tip's inertia and drive force",
        at_most(pull / area, limit, "Pa"),
        source="inertia of the tip's rise and rocking, shared by the two driven stacks; the moment of the peak drive "
        "force as push and pull on them",
        formula="{sqrt[(m w^2 Y/4)^2 + (J w^2 theta/D)^2] + mu N h/D}/A <= tensile limit",
        substituted=f"f = {show(f, 'Hz')}: ({show(swing, 'N')} + {show(push, 'N')})/{show(area * 1e6, '')} mm^2",
        proposal=f"preload each stack by {show(pull, 'N')} or more, or drive at {show(slower, 'Hz')} at most",
        changes=change("requirements.speed", r("requirements.speed") * slower / f, "m/s", up=False),
        requirement=_ACTUATOR,
        note=f"preloaded by {show(pull, 'N')}, {100 * pull / r('piezo.blocking_force'):.2g} % of the blocking force, "
        "the ceramic stays in compression",
    )


def bending(r: DesignInputs) -> Check:
    """The tip's side force bends the stacks until they touch their bores."""
    force = r("drive.friction") * peak_tip_force(r) / PIEZOS
    play = (r("holder.bore_diameter") - r("piezo.diameter")) / 2
    limit = r("piezo.strain_limit")
    bent = bent_stack(r, force)
    return Check(
        "side load of the drive on a piezo",
        at_most(float(bent.stress), limit, "Pa"),
        source="element bent as a cantilever, and propped by the mouth of its bore once it touches; its case neglected",
        formula="max M c/I <= tensile limit, M = F L at the foot up to the touch, F (L - b) at the mouth; F = mu N/3",
        substituted=f"F = {show(force, 'N')}, touches its bore at {show(float(bent.touch_force), 'N')} by "
        f"{show(play, 'm')} of play; end bends {show(float(bent.deflection), 'm')}",
        proposal=f"stacks preloaded by {show(float(bent.stress) * r('piezo.element_area'), 'N')}, or guided in their "
        "bores without play",
        thesis="'lateral stiffness is provided by the piezo housing': with play in the bore the stacks bend first",
        requirement=_ACTUATOR,
    )


def sway_mode(r: DesignInputs) -> Check:
    """Resonance of the tip on bending stacks, above which it yields to the drive force."""
    first, drive = sway_resonance(r), r("actuator.frequency")
    return Check(
        "sway of the tip on its stacks against the drive",
        at_least(first, 3 * drive, "Hz"),
        source="three stacks as cantilevers within the play of their bores; a third of the resonance as usual limit",
        formula="sqrt(3 x 3 E I/L^3/m)/(2 pi) >= 3 f",
        substituted=f"{show(sway(r), 'N/m')} under {show(mass_on_piezos(r), 'kg')}: {show(first, 'Hz')}; drive "
        f"{show(drive, 'Hz')}",
        proposal="a flexure that guides the tip across the stacks, or stacks held in their bores without play",
        thesis="'lateral stiffness is provided by the piezo housing': with play in the bore only the stacks do",
        requirement=_ACTUATOR,
    )


def tilt(r: DesignInputs) -> Check:
    """Opposed strokes tilt the tip and would bend stacks with flat bonded ends; therefore the ends are round."""
    angle = tilt_amplitude(r)
    flat = float(tilt_stress(angle, r("piezo.length"), r("piezo.element_area"), r.material("piezo", "youngs_modulus")))
    # A round end rolls: the reaction moves by R theta across a preload of half the blocking force.
    roll = r("piezo.end_radius") * angle
    side = np.sqrt(r("piezo.element_area"))
    rounded = r("piezo.blocking_force") / 2 * roll * (side / 2) / (side**4 / 12)
    return Check(
        "bending of a piezo by the tip's tilt",
        at_most(rounded, r("piezo.strain_limit"), "Pa"),
        source="rounded end that rolls on the tip; the reaction moves by R theta at half the blocking force",
        formula="sigma = F_block/2 R theta c/I, theta = X/(2 h)",
        substituted=f"theta = {show(angle, 'rad')}, R = {show(r('piezo.end_radius'), 'm')}: {show(rounded, 'Pa')}",
        proposal="a smaller end radius",
        requirement=_ACTUATOR,
        note=f"with flat, bonded ends it would be {show(flat, 'Pa')}",
    )


def step_size(r: DesignInputs) -> Check:
    bits = r("amplifier.bits")
    step = 2 * r("actuator.tip_height") / r("actuator.piezo_spacing") * r("piezo.stroke") / 2**bits
    return Check(
        "smallest step of the tip",
        at_most(step, r("requirements.resolution_coarse"), "m"),
        source="one count on both piezos, opposed; without slip the stage follows the tip",
        formula="2 (h/D) stroke/2^bits <= 10 nm",
        substituted=f"{bits:.0f} bits: {show(step, 'm')}",
        proposal="more bits",
        requirement="Table 1: resolution",
        note="open loop the piezo's hysteresis is far larger: this is the resolution of the loop, not its accuracy",
    )


def amplifier_noise(r: DesignInputs) -> Check:
    noise = tip_noise(r)
    return Check(
        "noise of the amplifiers at the tip",
        at_most(noise, r("requirements.resolution"), "m"),
        source="independent noise of two amplifiers through the stacks' mean gain and the tip's lever",
        formula="sqrt(2) u stroke/V h/D <= finest resolution",
        substituted=f"{show(r('amplifier.noise'), 'V')} rms: {show(noise, 'm')} rms",
        proposal="a quieter amplifier, or a filter before the stack",
        requirement="Table 1: resolution",
    )


def creep(r: DesignInputs) -> Check:
    """After a move to the end of its range the pressed tip moves on by the creep of its stacks."""
    reach = usable_ellipse(r)[0] / 2
    drift = r("piezo.creep") * reach
    return Check(
        "creep of the piezos in a decade of time",
        at_most(drift, r("requirements.resolution_coarse"), "m"),
        source="logarithmic creep of the stacks, in open loop",
        formula="creep X/2 <= 10 nm",
        substituted=f"{100 * r('piezo.creep'):.3g} % of {show(reach, 'm')}: {show(drift, 'm')}",
        proposal="hold the position in closed loop, or drive the stacks by charge",
        requirement="Table 1: resolution",
    )


def tip_wear(r: DesignInputs) -> Check:
    """While the stage coasts at 2 X f the tip slips by part of its path in every contact."""
    mean, layer = tip_load(r), r("tip.coating_thickness")
    worn_over = float(crown_wear_distance(layer, r("tip.nose_radius"), r("drive.tip_wear_rate"), mean))
    travelled = worn_over / SLIP_SHARE
    return Check(
        "wear of the tip's coating",
        at_least(travelled, r("bearing.life"), "m"),
        source="Archard on the nose's cap under the largest mean load; slip of a sinusoidal tip against a steady stage",
        formula="s = pi R t^2/(k F)/0.42 >= life",
        substituted=f"R = {show(r('tip.nose_radius'), 'm')}, t = {show(layer, 'm')}, F = {show(mean, 'N')}: "
        f"{show(travelled, 'm')} of travel",
        proposal="a thicker or harder coating, a larger nose radius, or less preload",
        requirement="Table 2: friction layer",
    )
