"""Friction drive: stroke, speed and the frequency it needs, traction, tip-over, resonances, heat, stacks."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.machine import (
    moved_mass,
    normal_stiffness,
    pads,
    preload_ratio,
    stack_stiffness,
    weight,
)
from designcalc.checks.reading import Reading, show
from designcalc.friction_drive import (
    GRAVITY,
    acceleration_limit,
    frequency_for,
    inertial_pull,
    preload_ratio_for,
    resonance,
    speed_of,
    stack_current,
    stack_heat,
    tip_ellipse,
    tip_force_limit,
)

_PIEZOS = 3  # under one tip
_SPEED = "kinematics of the elliptic tip: X f stopping, 2 X f coasting, pi X f at the apex"


def checks(r: Reading) -> Iterator[partial[Check]]:
    """Every check of the drive."""
    yield partial(stroke, r)
    for law in ("stopping", "coasting", "apex"):
        yield partial(frequency, r, law)
    yield partial(speed, r)
    yield partial(acceleration, r, "acceleration_low", "0.2 G")
    yield partial(acceleration, r, "acceleration", "1 G")
    yield partial(tip_over, r)
    yield partial(travel_left, r)
    yield partial(sea_length, r)
    yield partial(pad_resonance, r)
    yield partial(heat, r)
    yield partial(current, r)
    yield partial(stack_pull, r)
    yield partial(step_size, r)
    yield partial(pushing_force, r)


def usable_ellipse(r: Reading) -> tuple[float, float]:
    """X and Y of the ellipse at what the piezo has, or at the drive's own stroke where that is less, m."""
    amplitude = min(r("piezo.stroke") / 2, r("actuator.stroke_amplitude"))
    path = tip_ellipse(amplitude, r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height"))
    return float(path.along), float(path.normal)


def tip_resonance(r: Reading) -> float:
    """First resonance of the tip on its three piezos, Hz; a third of each stack moves with the tip."""
    return float(resonance(_PIEZOS * stack_stiffness(r), r("tip.mass_limit")))


def stroke(r: Reading) -> Check:
    amplitude, available = r("actuator.stroke_amplitude"), r("piezo.stroke")
    return r.check(
        "piezo stroke of the drive",
        2 * amplitude,
        available,
        "m",
        "at most",
        "catalogue stroke of the piezo",
        "2 A <= free stroke",
        f"2 x {show(amplitude, 'm')} against {show(available, 'm')}",
        f"amplitude of {show(available / 2, 'm')} about mid-voltage",
        thesis="the simulated stroke of +-10 um is 20 um, more than the piezo's 17 um",
    )


def frequency(r: Reading, law: str) -> Check:
    X, _ = usable_ellipse(r)
    wanted = r("requirements.speed")
    needed = float(frequency_for(wanted, X)[law])
    first = tip_resonance(r)
    heavy = float(resonance(_PIEZOS * stack_stiffness(r), r.given("tip, heavy", 0.1, "kg", "thesis 2.3.1 digest")))
    return r.check(
        f"drive frequency for the speed, {law}",
        needed,
        first / 3,
        "Hz",
        "at most",
        _SPEED + "; a third of the first resonance as the usual limit",
        "f = v/(c X) <= f_1/3, c = 1, 2, pi",
        f"v = {show(wanted, 'm/s')}, X = {show(X, 'm')}: f = {show(needed, 'Hz')}; f_1 = {show(first, 'Hz')}",
        f"a longer lever h/D that gives X = {show(X * needed / (first / 3), 'm')}, or a speed of "
        f"{show(wanted * first / 3 / needed, 'm/s')}",
        thesis=f"200 mm/s with a tip of 100 g, first resonance {show(heavy, 'Hz')}, is out of reach by any law"
        if law == "apex"
        else "",
        requirement="Table 1: speed",
    )


def speed(r: Reading) -> Check:
    X, _ = usable_ellipse(r)
    first = tip_resonance(r)
    lever = r("actuator.piezo_spacing") / r("actuator.tip_height")
    reached = float(speed_of(X, first / 3)["coasting"])
    return r.check(
        "speed at a third of the tip's resonance",
        reached,
        r("requirements.speed"),
        "m/s",
        "at least",
        _SPEED,
        "v = 2 X f_1/3",
        f"2 x {show(X, 'm')} x {show(first / 3, 'Hz')}",
        "a lighter tip, a higher tip over closer piezos, or drive at resonance with the ellipse measured",
        thesis=f"(4.2) leaves out h/D: as printed the tip would travel {show(X * lever, 'm')}, {lever:.2f} times what "
        "the listing rightly has",
        requirement="Table 1: speed",
    )


def acceleration(r: Reading, key: str, label: str) -> Check:
    wanted = r(f"requirements.{key}")
    mu, p = r("drive.friction"), preload_ratio(r)
    limit = float(acceleration_limit(mu, p))
    needed = float(preload_ratio_for(wanted, mu))
    return r.check(
        f"acceleration of {label} without lift-off",
        limit,
        wanted,
        "m/s^2",
        "at least",
        "the tip presses at most with weight and preload",
        "a <= mu (1 + p) g",
        f"mu = {mu:.3g}, p = {p:.3g}: {limit / GRAVITY:.3g} g",
        f"a preload of {needed:.3g} times the weight ({show(needed * weight(r), 'N')})",
        thesis="a light preload of 10 % and 1 G do not go together: 0.33 g at mu = 0.3"
        if key == "acceleration"
        else "",
        requirement="Table 1: acceleration",
    )


def tip_over(r: Reading) -> Check:
    mu, mu_pad, p = r("drive.friction"), r("bearing.dynamic_friction"), preload_ratio(r)
    end = r("stage.travel") / 2
    places = pads(r)
    centre = r.centre()
    shares = [tip_force_limit(places, centre, (side * end, 0.0)) for side in (-1, 1)]
    share = min(shares)
    wanted = r("requirements.acceleration_low")
    reached = float(acceleration_limit(mu, p, share, mu_pad))
    # share needed, from a = g (1+p) [mu s - mu_pad (1-s)], and the half-span that gives it
    needed = (wanted / (GRAVITY * (1 + p)) + mu_pad) / (mu + mu_pad)
    span = needed * end / (1 - needed) if needed < 1 else np.inf
    return r.check(
        "acceleration at the end of the travel without tipping",
        reached,
        wanted,
        "m/s^2",
        "at least",
        "moments about the pads' edge; F/W = s/(s + x)",
        "a = g (1+p) [mu s/(s+x) - mu_pad x/(s+x)]",
        f"x = {show(end, 'm')}: the tip may carry {share:.3g} of the load, and accelerates {reached / GRAVITY:.3g} g",
        f"a half-span of the pads on the tip's line of {show(float(span), 'm')}, a preload that stays over the tip, "
        "or pads on the base that stand still under the tip",
        thesis="a tip force away from the pads tips the stage; the thesis looks at the middle of the travel only",
        requirement="Table 1: acceleration",
    )


def travel_left(r: Reading) -> Check:
    way, travel = r("bearing_way.length"), r("stage.travel")
    envelope = r("pads.spacing_along") + r("pads.length")
    return r.check(
        "pads on the ways over the whole travel",
        envelope,
        way - travel,
        "m",
        "at most",
        "geometry",
        "pad spacing + pad length <= way - travel",
        f"{show(envelope, 'm')} against {show(way, 'm')} - {show(travel, 'm')} = {show(way - travel, 'm')}",
        f"pad spacing of at most {show(way - travel - r('pads.length'), 'm')}",
        requirement="Table 1: travel",
    )


def sea_length(r: Reading) -> Check:
    length, travel, margin = r("stage.length"), r("stage.travel"), r("sea.contact_margin")
    return r.check(
        "sea over the tip at both ends of the travel",
        length,
        travel + 2 * margin,
        "m",
        "at least",
        "geometry",
        "sea >= travel + 2 margins",
        f"{show(length, 'm')} against {show(travel + 2 * margin, 'm')}",
        f"a stage of {show(travel + 2 * margin, 'm')}",
        requirement="Table 1: travel",
    )


def pad_resonance(r: Reading) -> Check:
    bounce = float(resonance(normal_stiffness(r), moved_mass(r)))
    drive_frequency = r("actuator.frequency")
    ratio = max(bounce, drive_frequency) / min(bounce, drive_frequency)
    return r.check(
        "bounce of the stage on its pads against the drive",
        ratio,
        1.5,
        "",
        "at least",
        "pads as crowned contacts",
        "larger over smaller of f_pads and f_drive >= 1.5",
        f"f_pads = {show(bounce, 'Hz')}, f_drive = {show(drive_frequency, 'Hz')}",
        "another drive frequency, or another crown radius",
    )


def heat(r: Reading) -> Check:
    X, _ = usable_ellipse(r)
    f = float(frequency_for(r("requirements.speed"), X)["coasting"])
    loss = r.given("loss factor, large signal", 0.05, "", "assumed: soft PZT at large signal")
    watts = 2 * float(stack_heat(r("piezo.capacitance"), r("piezo.highest_voltage"), f, loss))
    return r.check(
        "heat of the piezos at full speed",
        watts,
        r.given("heat that the holder takes", 1.0, "W", "assumed: 1 W through tip and holder is felt as microns"),
        "W",
        "at most",
        "dielectric loss of a sine, two stacks",
        "P = 2 pi f C (V/2)^2 tan(delta)",
        f"f = {show(f, 'Hz')}: {show(watts, 'W')}",
        "count it as watts: conduct it into the holder, or drive in bursts",
        thesis=f"'milliwatts' is {show(watts, 'W')} at the speed asked for",
    )


def current(r: Reading) -> Check:
    X, _ = usable_ellipse(r)
    f = float(frequency_for(r("requirements.speed"), X)["coasting"])
    peak = float(stack_current(r("piezo.capacitance"), r("piezo.highest_voltage"), f))
    return r.check(
        "peak current of one piezo at full speed",
        peak,
        r.given("amplifier", 2.0, "A", "assumed: a common linear piezo amplifier"),
        "A",
        "at most",
        "sine on a capacitor",
        "I = pi f C V",
        f"f = {show(f, 'Hz')}: {show(peak, 'A')}",
        "a smaller stack, or resonance",
    )


def stack_pull(r: Reading) -> Check:
    _, Y = usable_ellipse(r)
    pull = float(inertial_pull(r("tip.mass_limit"), r("actuator.frequency"), Y)) / 2
    area = np.pi / 4 * r("piezo.diameter") ** 2
    return r.check(
        "tension of a piezo by the tip's inertia",
        pull / area,
        r("piezo.strain_limit"),
        "Pa",
        "at most",
        "peak inertia of the tip shared by the two driven stacks",
        "m (2 pi f)^2 Y/2/(2 A) <= tensile limit",
        f"{show(pull, 'N')} on {area * 1e6:.3g} mm^2",
        f"preload each stack by {show(pull, 'N')} or more",
    )


def step_size(r: Reading) -> Check:
    bits = r.given("bits of the drive's converter", 16, "", "assumed: a common converter over the whole voltage")
    step = 2 * r("actuator.tip_height") / r("actuator.piezo_spacing") * r("piezo.stroke") / 2**bits
    return r.check(
        "smallest step of the tip",
        step,
        r("requirements.resolution_coarse"),
        "m",
        "at most",
        "one count on both piezos, opposed; without slip the stage follows the tip",
        "2 (h/D) stroke/2^bits <= 10 nm",
        f"{bits:.0f} bits: {show(step, 'm')}",
        "more bits",
        note="open loop the piezo's hysteresis is far larger: this is the resolution of the loop, not its accuracy",
        requirement="Table 1: resolution",
    )


def pushing_force(r: Reading) -> Check:
    """The lift-off force is asked of the piezos at mid-stroke, where each has half of its blocking force left."""
    force = weight(r) + r("preload.force")
    available = _PIEZOS * r("piezo.blocking_force") / 2
    return r.check(
        "force of the piezos against the load",
        force,
        available / 2,
        "N",
        "at most",
        "catalogue line of the piezo at half its stroke, factor 2",
        "W (1+p) <= 3 F_block/4",
        f"{show(force, 'N')} against {show(available, 'N')} at mid-stroke",
        "stronger stacks",
    )
