"""Friction drive: stroke, speed and the frequency it needs, traction, tip-over, travel."""

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, show
from designcalc.checks.formula_check import FormulaCheck
from designcalc.drive.friction_drive import acceleration_limit, tip_force_limit
from designcalc.friction_stage.physics.loads import gravity, load, load_centre, moved_mass, preload_ratio
from designcalc.friction_stage.physics.pads import pad_positions
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_SPEED = "kinematics of the elliptic tip: X f stopping, 2 X f coasting, pi X f at the apex"

# "Usually in the order of several kilohertz": a tip of ordinary build rather than a light one.
_NO_FREQUENCY = (
    "no frequency is stated; with a tip of 100 g, first resonance {sqrt(3*stiffness.stack/0.1 kg)/(2*pi)}, 200 mm/s is "
    "out of reach by any law"
)


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the drive."""
    return [
        stroke,
        frequency("stopping", "1"),
        frequency("coasting", "2"),
        frequency("apex", "pi", _NO_FREQUENCY),
        speed,
        acceleration("acceleration_low", "0.2 G"),
        acceleration("acceleration", "1 G"),
        preload_and_acceleration,
        tip_over,
        travel_left,
        stopping,
        stop_tipping,
        leads,
        cables,
        sea_length,
    ]


stroke = stated(
    "piezo stroke of the drive",
    "2*actuator.stroke_amplitude <= piezo.stroke",
    ("actuator.stroke_amplitude", "piezo.stroke/2", False),
    source="catalogue stroke of the piezo",
    proposal="less amplitude about mid-voltage",
    thesis="the simulated stroke of +-10 um is 20 um, more than the piezo's 17 um",
)


def frequency(law: str, factor: str, thesis: str = "") -> FormulaCheck:
    first = "min(resonance.tip_up, resonance.tip_rocking)"
    return stated(
        f"drive frequency for the speed, {law}",
        f"requirements.speed/({factor}*ellipse.along) <= {first}/3",
        ("requirements.speed", "requirements.speed*check.limit/check.value", False),
        source=_SPEED + "; a third of the first resonance as the usual limit",
        proposal="a longer lever h/D that gives X = {ellipse.along*check.value/check.limit}, or less speed",
        thesis=thesis,
        requirement="Table 1: speed",
    )


speed = stated(
    "speed at a third of the tip's resonance",
    "2*ellipse.along*min(resonance.tip_up, resonance.tip_rocking)/3 >= requirements.speed",
    ("requirements.speed", "check.value", False),
    source=_SPEED,
    proposal="{mass.on_piezos*(check.value/check.limit)^2} in all to move on the piezos, a lever h/D "
    "{check.limit/check.value} times longer, or drive at resonance with the ellipse measured",
    thesis="(4.2) leaves out h/D: as printed the tip would travel {ellipse.along*actuator.piezo_spacing/"
    "actuator.tip_height}, {actuator.piezo_spacing/actuator.tip_height} times what the listing rightly has",
    requirement="Table 1: speed",
)


def acceleration(key: str, label: str) -> FormulaCheck:
    return stated(
        f"acceleration of {label} without lift-off",
        f"drive.friction*(1 + load.preload/load.weight)*environment.gravity >= requirements.{key}",
        source="the tip presses at most with weight and preload",
        proposal=f"a preload of {{requirements.{key}/drive.friction/environment.gravity - 1}} times the weight "
        f"({{load.weight*(requirements.{key}/drive.friction/environment.gravity - 1)}})",
        requirement="Table 1: acceleration",
    )


preload_and_acceleration = stated(
    "acceleration of 1 G with the required preload",
    "drive.friction*(1 + preload.ratio)*environment.gravity >= requirements.acceleration",
    ("preload.ratio", "requirements.acceleration/drive.friction/environment.gravity - 1", True),
    source="the tip presses at most with weight and preload",
    proposal="ask for more preload "
    "({load.weight*(requirements.acceleration/drive.friction/environment.gravity - 1)}), and magnets that give it",
    thesis="a light preload of 10 % and 1 G do not go together: 0.33 g at mu = 0.3",
    requirement="Table 1: acceleration",
)
"""Two requirements that exclude each other, whatever the magnets really pull."""


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


travel_left = stated(
    "pads on the ways over the whole travel",
    "pads.spacing_along + pads.length <= bearing_way.length - stage.travel",
    source="geometry",
    proposal="pad spacing of at most {check.limit - pads.length}",
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


stop_tipping = stated(
    "pads on their ways as the end stops brake",
    "sqrt(load.moved_mass*end_stop.count*end_stop.stiffness)*requirements.speed"
    "*abs(height.centre_of_mass - end_stop.height) <= load.whole*reach.of_pads",
    source="moment of the buffers' largest force about the centre of mass against that of the load about the pads: the "
    "stage turns over its leading ones",
    proposal="softer buffers, or buffers at the height of the centre of mass",
)


cables = stated(
    "shift of the stage by its cables",
    "payload.cable_force/stiffness.along <= requirements.repeatability",
    source="change of the cables' force over the travel, against rocking, sway and contact of the tip",
    proposal="a softer cable, or hold the position in closed loop",
    requirement="Section 2.3.2: repeatability (Table 1 has none)",
)


leads = stated(
    "pull on the leads that reaches the piezos",
    "max(leads.pull - leads.clip, 0 N) <= leads.allowed",
    source="a clip holds each lead at the base up to its own limit",
    proposal="clips that hold {leads.pull - leads.allowed}",
    requirement="Section 2.2: modular",
)


sea_length = stated(
    "drive surface over the tip at both ends of the travel",
    "stage.length >= stage.travel + 2*sea.contact_margin",
    source="geometry",
    proposal="a stage of {check.limit}",
    requirement="Table 1: travel",
)
