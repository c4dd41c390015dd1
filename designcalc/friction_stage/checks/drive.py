"""Friction drive: stroke, speed and the frequency it needs, traction, tip-over, travel."""

from __future__ import annotations

from functools import partial

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, show
from designcalc.drive.friction_drive import acceleration_limit, preload_ratio_for, resonance, tip_force_limit
from designcalc.drive.tip_ellipse import frequency_for, speed_of
from designcalc.friction_stage.physics.body import moving_body
from designcalc.friction_stage.physics.loads import gravity, load, load_centre, moved_mass, preload_ratio, weight
from designcalc.friction_stage.physics.pads import pad_positions
from designcalc.friction_stage.physics.tip_dynamics import (
    PIEZOS,
    holding_stiffness,
    mass_on_piezos,
    stack_stiffness,
    tip_resonance,
    usable_ellipse,
)
from stagecad.parameters.design import Design

_SPEED = "kinematics of the elliptic tip: X f stopping, 2 X f coasting, pi X f at the apex"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the drive."""
    return [
        stroke,
        *(partial(frequency, law=law) for law in ("stopping", "coasting", "apex")),
        speed,
        partial(acceleration, key="acceleration_low", label="0.2 G"),
        partial(acceleration, key="acceleration", label="1 G"),
        preload_and_acceleration,
        tip_over,
        travel_left,
        stopping,
        stop_tipping,
        leads,
        cables,
        sea_length,
    ]


def stroke(r: DesignInputs) -> Check:
    amplitude, available = r("actuator.stroke_amplitude"), r("piezo.stroke")
    return Check(
        "piezo stroke of the drive",
        at_most(2 * amplitude, available, "m"),
        source="catalogue stroke of the piezo",
        formula="2 A <= free stroke",
        substituted=f"2 x {show(amplitude, 'm')} against {show(available, 'm')}",
        proposal="less amplitude about mid-voltage",
        changes=change("actuator.stroke_amplitude", available / 2, "m", up=False),
        thesis="the simulated stroke of +-10 um is 20 um, more than the piezo's 17 um",
    )


def frequency(r: DesignInputs, law: str) -> Check:
    X, _ = usable_ellipse(r)
    wanted = r("requirements.speed")
    needed = float(frequency_for(wanted, X)[law])
    first = tip_resonance(r)
    # "Usually in the order of several kilohertz": a tip of ordinary build rather than a light one.
    heavy = float(resonance(PIEZOS * stack_stiffness(r), 0.1))
    return Check(
        f"drive frequency for the speed, {law}",
        at_most(needed, first / 3, "Hz"),
        source=_SPEED + "; a third of the first resonance as the usual limit",
        formula="f = v/(c X) <= f_1/3, c = 1, 2, pi",
        substituted=f"v = {show(wanted, 'm/s')}, X = {show(X, 'm')}: f = {show(needed, 'Hz')}; f_1 = "
        f"{show(first, 'Hz')}",
        proposal=f"a longer lever h/D that gives X = {show(X * needed / (first / 3), 'm')}, or less speed",
        changes=change("requirements.speed", wanted * first / 3 / needed, "m/s", up=False),
        thesis=(
            f"no frequency is stated; with a tip of 100 g, first resonance {show(heavy, 'Hz')}, 200 mm/s is out of "
            "reach by any law"
            if law == "apex"
            else ""
        ),
        requirement="Table 1: speed",
    )


def speed(r: DesignInputs) -> Check:
    X, _ = usable_ellipse(r)
    first = tip_resonance(r)
    lever = r("actuator.piezo_spacing") / r("actuator.tip_height")
    reached = float(speed_of(X, first / 3)["coasting"])
    wanted = r("requirements.speed")
    return Check(
        "speed at a third of the tip's resonance",
        at_least(reached, wanted, "m/s"),
        source=_SPEED,
        formula="v = 2 X f_1/3",
        substituted=f"2 x {show(X, 'm')} x {show(first / 3, 'Hz')}",
        proposal=f"{show(mass_on_piezos(r) * (reached / wanted) ** 2, 'kg')} in all to move on the piezos, a lever h/D "
        f"{wanted / reached:.3g} times longer, or drive at resonance with the ellipse measured",
        changes=change("requirements.speed", reached, "m/s", up=False),
        thesis=f"(4.2) leaves out h/D: as printed the tip would travel {show(X * lever, 'm')}, {lever:.2f} times what "
        "the listing rightly has",
        requirement="Table 1: speed",
    )


def acceleration(r: DesignInputs, key: str, label: str) -> Check:
    wanted = r(f"requirements.{key}")
    mu, p, g = r("drive.friction"), preload_ratio(r), gravity(r)
    limit = float(acceleration_limit(mu, p, gravity=g))
    needed = float(preload_ratio_for(wanted, mu, g))
    return Check(
        f"acceleration of {label} without lift-off",
        at_least(limit, wanted, "m/s^2"),
        source="the tip presses at most with weight and preload",
        formula="a <= mu (1 + p) g",
        substituted=f"mu = {mu:.3g}, p = {p:.3g}: {limit / g:.3g} g",
        proposal=f"a preload of {needed:.3g} times the weight ({show(needed * weight(r), 'N')})",
        requirement="Table 1: acceleration",
    )


def preload_and_acceleration(r: DesignInputs) -> Check:
    """Two requirements that exclude each other, whatever the magnets really pull."""
    wanted, mu, share, g = r("requirements.acceleration"), r("drive.friction"), r("preload.ratio"), gravity(r)
    limit = float(acceleration_limit(mu, share, gravity=g))
    needed = float(preload_ratio_for(wanted, mu, g))
    return Check(
        "acceleration of 1 G with the required preload",
        at_least(limit, wanted, "m/s^2"),
        source="the tip presses at most with weight and preload",
        formula="a <= mu (1 + p) g, p the required ratio of preload to load",
        substituted=f"mu = {mu:.3g}, p = {share:.3g}: {limit / g:.3g} g",
        proposal=f"ask for more preload ({show(needed * weight(r), 'N')}), and magnets that give it",
        changes=change("preload.ratio", needed, "", up=True),
        thesis="a light preload of 10 % and 1 G do not go together: 0.33 g at mu = 0.3",
        requirement="Table 1: acceleration",
    )


def tip_over(r: DesignInputs) -> Check:
    mu, mu_pad, p, g = r("drive.friction"), r("bearing.dynamic_friction"), preload_ratio(r), gravity(r)
    end = r("stage.travel") / 2
    places = pad_positions(r)
    centre = load_centre(r)
    shares = [tip_force_limit(places, centre, (side * end, 0.0)) for side in (-1, 1)]
    share = min(shares)
    wanted = r("requirements.acceleration_low")
    reached = float(acceleration_limit(mu, p, share, mu_pad, g))
    # share needed, from a = g (1+p) [mu s - mu_pad (1-s)], and the half-span that gives it
    needed = (wanted / (g * (1 + p)) + mu_pad) / (mu + mu_pad)
    span = needed * end / (1 - needed) if needed < 1 else np.inf
    return Check(
        "acceleration at the end of the travel without tipping",
        at_least(reached, wanted, "m/s^2"),
        source="moments about the pads' edge; F/W = s/(s + x)",
        formula="a = g (1+p) [mu s/(s+x) - mu_pad x/(s+x)]",
        substituted=f"x = {show(end, 'm')}: the tip may carry {share:.3g} of the load, and accelerates "
        f"{reached / g:.3g} g",
        proposal=f"a half-span of the pads on the tip's line of {show(float(span), 'm')}, a preload that stays over "
        "the tip, or pads fixed on the base under the tip",
        changes=change("pads.spacing_along", r("pads.spacing_along") * span / (share * end / (1 - share)), "m", up=True)
        if 0 < share < 1
        else (),
        thesis="a tip force away from the pads tips the stage; the thesis considers the middle of the travel only",
        requirement="Table 1: acceleration",
    )


def travel_left(r: DesignInputs) -> Check:
    way, travel = r("bearing_way.length"), r("stage.travel")
    envelope = r("pads.spacing_along") + r("pads.length")
    return Check(
        "pads on the ways over the whole travel",
        at_most(envelope, way - travel, "m"),
        source="geometry",
        formula="pad spacing + pad length <= way - travel",
        substituted=f"{show(envelope, 'm')} against {show(way, 'm')} - {show(travel, 'm')} = {show(way - travel, 'm')}",
        proposal=f"pad spacing of at most {show(way - travel - r('pads.length'), 'm')}",
        requirement="Table 1: travel",
    )


def _stop_room(r: DesignInputs) -> float:
    """Way beyond the pads at the end of the travel, m."""
    return (r("bearing_way.length") - r("stage.travel") - r("pads.spacing_along") - r("pads.length")) / 2


def stopping(r: DesignInputs) -> Check:
    """Without drive the stage meets its end stops at full speed; without end stops only the pads brake it."""
    energy, brake = 0.5 * moved_mass(r) * r("requirements.speed") ** 2, r("bearing.dynamic_friction") * load(r)
    spring = r("end_stop.count") * r("end_stop.stiffness")
    alone = energy / brake
    if spring > 0:
        # Friction, and the buffers from their gap on: k s^2/2 + f (gap + s) = E.
        gap = r("end_stop.gap")
        left = max(energy - brake * gap, 0.0)
        pressed = (np.sqrt(brake**2 + 2 * spring * left) - brake) / spring
        way, room = gap + pressed, min(_stop_room(r), gap + r("end_stop.compression"))
        said = f"gap {show(gap, 'm')}, buffers of {show(spring, 'N/m')} pressed by {show(pressed, 'm')}"
    else:
        way, room, said = alone, _stop_room(r), "no end stops"
    return Check(
        "stopping at the end of the travel",
        at_most(way, room, "m"),
        source="energy of stage and payload at full speed against end stops and the pads' friction",
        formula="m v^2/2 = k s^2/2 + mu N (gap + s); gap + s <= way beyond the pads, compression of the buffers",
        substituted=f"{show(energy, 'J')}, friction {show(brake, 'N')}: {said}; way {show(room, 'm')}",
        proposal=f"end stops that take {show(energy, 'J')}, or less speed near the ends",
        requirement="Table 1: travel",
        note=f"without end stops the pads' friction alone needs {show(alone, 'm')} of {show(_stop_room(r), 'm')}",
    )


def stop_tipping(r: DesignInputs) -> Check:
    """Buffers below the centre of mass turn the stage over its leading pads."""
    energy, spring = 0.5 * moved_mass(r) * r("requirements.speed") ** 2, r("end_stop.count") * r("end_stop.stiffness")
    force = float(np.sqrt(2 * energy * spring))
    lever = moving_body(r).centre_of_mass[2] - r("end_stop.height")
    reach = float(np.max(pad_positions(r)[:, 0])) - abs(load_centre(r)[0])
    return Check(
        "pads on their ways as the end stops brake",
        at_most(abs(force * lever), load(r) * reach, "N*m"),
        source="moment of the buffers' largest force about the centre of mass against that of the load about the pads",
        formula="sqrt(2 E k) |h_c - h_s| <= N s/2",
        substituted=f"{show(force, 'N')} x {show(lever, 'm')} against {show(load(r), 'N')} x {show(reach, 'm')}",
        proposal="softer buffers, or buffers at the height of the centre of mass",
    )


def cables(r: DesignInputs) -> Check:
    force, hold = r("payload.cable_force"), holding_stiffness(r)
    return Check(
        "shift of the stage by its cables",
        at_most(force / hold, r("requirements.repeatability"), "m"),
        source="change of the cables' force over the travel, against rocking, sway and contact of the tip",
        formula="F/K <= repeatability",
        substituted=f"{show(force, 'N')}/{show(hold, 'N/m')} = {show(force / hold, 'm')}",
        proposal="a softer cable, or hold the position in closed loop",
        requirement="Section 2.3.2: repeatability (Table 1 has none)",
    )


def leads(r: DesignInputs) -> Check:
    pull, clip = r("leads.pull"), r("leads.clip")
    return Check(
        "pull on the leads that reaches the piezos",
        at_most(max(pull - clip, 0.0), r("leads.allowed"), "N"),
        source="a clip holds each lead at the base up to its own limit",
        formula="pull - clip <= allowed",
        substituted=f"{show(pull, 'N')} - {show(clip, 'N')}",
        proposal=f"clips that hold {show(pull - r('leads.allowed'), 'N')}",
        requirement="Section 2.2: modular",
    )


def sea_length(r: DesignInputs) -> Check:
    length, travel, margin = r("stage.length"), r("stage.travel"), r("sea.contact_margin")
    return Check(
        "drive surface over the tip at both ends of the travel",
        at_least(length, travel + 2 * margin, "m"),
        source="geometry",
        formula="length of the drive surface >= travel + 2 margins",
        substituted=f"{show(length, 'm')} against {show(travel + 2 * margin, 'm')}",
        proposal=f"a stage of {show(travel + 2 * margin, 'm')}",
        requirement="Table 1: travel",
    )
