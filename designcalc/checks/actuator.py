"""Piezo actuator: resonances against the drive, force, current, heat, tension and bending of the stacks, step size."""

from __future__ import annotations

import numpy as np

from designcalc.checks.check import Check, CheckFunction, at_least, at_most, ratio, show
from designcalc.drive.friction_drive import frequency_for, resonance, stack_current, stack_heat
from designcalc.drive.piezo_stack import drive_pull, side_load, stack_tension, tilt_stress
from designcalc.machine.inputs import DesignInputs
from designcalc.machine.loads import moved_mass, weight
from designcalc.machine.pads import pads_stiffness
from designcalc.machine.tip_dynamics import PIEZOS, mass_on_piezos, tip_resonances, usable_ellipse
from stagecad.parameters.design import Design

_ACTUATOR = "Table 2: actuator"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of tip and piezos."""
    return [tip_weight, drive_frequency, pad_resonance, pushing_force, heat, current, tension, bending, tilt, step_size]


def tip_weight(r: DesignInputs) -> Check:
    return Check(
        "mass of the tip",
        at_most(r.tip_mass(), r("tip.mass_limit"), "kg"),
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
        proposal=f"drive at {show(limit, 'Hz')} at most, or at the resonance itself with the ellipse measured",
        requirement=_ACTUATOR,
        note="in contact with the stage the tip's resonances rise; between the strikes it is free",
    )


def pad_resonance(r: DesignInputs) -> Check:
    springs = pads_stiffness(r)
    about_along, about_across = r.tilting_inertia()
    modes = {
        "bounce": float(resonance(springs.normal, moved_mass(r))),
        "pitch": float(resonance(springs.pitch, about_across)),
        "roll": float(resonance(springs.roll, about_along)),
    }
    drive = r("actuator.frequency")
    ratios = {name: max(f, drive) / min(f, drive) for name, f in modes.items()}
    nearest = min(ratios, key=lambda name: ratios[name])
    return Check(
        "resonances of the stage on its pads against the drive",
        at_least(ratios[nearest], 1.5, ""),
        source="pads as crowned contacts; stage and payload as one rigid body",
        formula="larger over smaller of f_pads and f_drive >= 1.5 for bounce, pitch and roll",
        substituted=", ".join(f"{name} {show(f, 'Hz')}" for name, f in modes.items()) + f"; drive {show(drive, 'Hz')}",
        proposal=f"another drive frequency, or another crown radius or pad spacing: {nearest} is nearest",
    )


def pushing_force(r: DesignInputs) -> Check:
    """The lift-off force at mid-stroke, where each piezo has half of its blocking force left."""
    force = weight(r) + r("preload.force")
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


def _speed_frequency(r: DesignInputs) -> float:
    """Of the drive at the required speed, coasting, Hz."""
    X, _ = usable_ellipse(r)
    return float(frequency_for(r("requirements.speed"), X)["coasting"])


def heat(r: DesignInputs) -> Check:
    f = _speed_frequency(r)
    voltage, loss = r("piezo.highest_voltage"), r("piezo.loss_factor")
    watts = 2 * float(stack_heat(r("piezo.capacitance"), voltage, f, loss))
    limit = r("actuator.heat_limit")
    duty = ratio(limit, watts)
    return Check(
        "heat of the piezos at full speed",
        at_most(watts, limit, "W"),
        source="dielectric loss of a sine, two stacks",
        formula="P = 2 pi f C (V/2)^2 tan(delta)",
        substituted=f"f = {show(f, 'Hz')}, V = {show(voltage, 'V')}, tan(delta) = {loss:.3g}: {show(watts, 'W')}",
        proposal=f"full speed for {100 * duty:.2g} % of the time, or a holder that takes {show(watts, 'W')}",
        thesis=f"'milliwatts' is {show(watts, 'W')} at the required speed",
        requirement=_ACTUATOR,
    )


def current(r: DesignInputs) -> Check:
    f = _speed_frequency(r)
    peak = float(stack_current(r("piezo.capacitance"), r("piezo.highest_voltage"), f))
    available = r("amplifier.current")
    return Check(
        "peak current of one piezo at full speed",
        at_most(peak, available, "A"),
        source="sine on a capacitor",
        formula="I = pi f C V",
        substituted=f"f = {show(f, 'Hz')}: {show(peak, 'A')}, {show(peak * r('piezo.highest_voltage') / np.pi, 'W')} "
        "drawn on the mean from a linear amplifier",
        proposal=f"an amplifier of {show(peak, 'A')}, or {show(f * available / peak, 'Hz')} at most",
        requirement=_ACTUATOR,
    )


def tension(r: DesignInputs) -> Check:
    _, Y = usable_ellipse(r)
    swing = float(stack_tension(mass_on_piezos(r), r("actuator.frequency"), Y))
    side = r("drive.friction") * (weight(r) + r("preload.force"))
    push = float(drive_pull(side, r("actuator.tip_height"), r("actuator.piezo_spacing")))
    area, limit = r("piezo.element_area"), r("piezo.strain_limit")
    pull = swing + push
    return Check(
        "tension of a piezo by the tip's inertia and drive force",
        at_most(pull / area, limit, "Pa"),
        source="peak inertia of the tip shared by the two driven stacks; the drive force's moment as push and pull on "
        "them",
        formula="[m (2 pi f)^2 Y/4 + mu N h/D]/A <= tensile limit",
        substituted=f"({show(swing, 'N')} + {show(push, 'N')})/{show(area * 1e6, '')} mm^2",
        proposal=f"preload each stack by {show(pull, 'N')} or more, or drive at "
        f"{show(r('actuator.frequency') * np.sqrt(max(limit * area - push, 0.0) / swing), 'Hz')} at most",
        requirement=_ACTUATOR,
        note=f"preloaded by {show(pull, 'N')}, {100 * pull / r('piezo.blocking_force'):.2g} % of the blocking force, "
        "the ceramic stays in compression",
    )


def bending(r: DesignInputs) -> Check:
    """The tip's side force bends the stacks until they touch their bores."""
    force = r("drive.friction") * (weight(r) + r("preload.force")) / PIEZOS
    proud = r("piezo.length") + r("holder.floor") - r("holder.height")
    play = (r("holder.bore_diameter") - r("piezo.diameter")) / 2
    limit = r("piezo.strain_limit")
    load = side_load(
        force, r("piezo.length"), proud, r("piezo.element_area"), r.material("piezo", "youngs_modulus"), play
    )
    return Check(
        "side load of the drive on a piezo",
        at_most(float(load.stress), limit, "Pa"),
        source="element bent as a cantilever until its bore holds it; its case neglected",
        formula="sigma = F L c/I <= tensile limit, F = mu N/3",
        substituted=f"F = {show(force, 'N')}: end bends {show(float(load.deflection), 'm')} in {show(play, 'm')} of "
        f"play, {'the bore holds it' if load.touches else 'the bore does not hold it'}",
        proposal=f"a bore of less than {show(r('piezo.diameter') + 2 * float(load.deflection), 'm')}, which holds the "
        f"stack, or stacks preloaded by {show(float(load.stress) * r('piezo.element_area'), 'N')}",
        thesis=(
            "'lateral stiffness is provided by the piezo housing': with play in the bore the stacks bend first"
            if not load.touches
            else ""
        ),
        requirement=_ACTUATOR,
    )


def tilt(r: DesignInputs) -> Check:
    """Why the ends are round: opposed strokes tilt the tip, and flat bonded ends would bend with it."""
    X, _ = usable_ellipse(r)
    angle = X / 2 / r("actuator.tip_height")
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
