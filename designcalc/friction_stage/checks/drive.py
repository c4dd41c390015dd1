"""Friction drive: stroke, speed and the frequency it needs, traction, tip-over, travel."""

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, FormulaCheck
from designcalc.drive.friction_drive import tip_force_limit
from designcalc.friction_stage.checks.preload import preload_and_acceleration
from designcalc.friction_stage.physics.loads import load_centre, preload_ratio
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


def tip_over(r: DesignInputs) -> Check:
    mu, mu_pad, end = r("drive.friction"), r("bearing.dynamic_friction"), r("stage.travel") / 2
    share = min(tip_force_limit(pad_positions(r), load_centre(r), (side * end, 0.0)) for side in (-1, 1))
    # share needed, from a = g (1+p) [mu s - mu_pad (1-s)], and the half-span that gives it
    pull = r("environment.gravity") * (1 + preload_ratio(r))
    needed = (r("requirements.acceleration_low") / pull + mu_pad) / (mu + mu_pad)
    span = needed * end / (1 - needed) if needed < 1 else np.inf
    return stated(
        "acceleration at the end of the travel without tipping",
        "environment.gravity*(1 + load.preload/load.weight)"
        "*(drive.friction*share.of_tip - bearing.dynamic_friction*(1 - share.of_tip)) >= requirements.acceleration_low",
        ("pads.spacing_along", "pads.spacing_along*span.needed*(1 - share.of_tip)/(share.of_tip*stage.travel/2)", True),
        given={"share.of_tip": (share, ""), "span.needed": (span, "m")},
        source="moments about the pads' edge: at the end of the travel the tip may carry the share s/(s + x) of the "
        "load",
        proposal="a half-span of the pads on the tip's line of {span.needed}, a preload that stays over the tip, or "
        "pads fixed on the base under the tip",
        thesis="a tip force away from the pads tips the stage; the thesis considers the middle of the travel only",
        requirement="Table 1: acceleration",
    )(r)


travel_left = stated(
    "pads on the ways over the whole travel",
    "pads.spacing_along + pads.length <= bearing_way.length - stage.travel",
    source="geometry",
    proposal="pad spacing of at most {check.limit - pads.length}",
    requirement="Table 1: travel",
)


_ENERGY, _BRAKE = "load.moved_mass*requirements.speed^2/2", "(bearing.dynamic_friction*load.whole)"
_BUFFERS = "(end_stop.count*end_stop.stiffness)"
_ROOM = "(bearing_way.length - stage.travel - pads.spacing_along - pads.length)/2"


def stopping(r: DesignInputs) -> Check:
    """Without drive the stage meets its end stops at full speed; without end stops only the pads brake it."""
    formula = f"{_ENERGY}/{_BRAKE} <= {_ROOM}"
    if r("end_stop.count") * r("end_stop.stiffness") > 0:
        # Friction, and the buffers from their gap on: k s^2/2 + f (gap + s) = E.
        left = f"max({_ENERGY} - {_BRAKE}*end_stop.gap, 0 J)"
        pressed = f"(sqrt({_BRAKE}^2 + 2*{_BUFFERS}*{left}) - {_BRAKE})/{_BUFFERS}"
        formula = f"end_stop.gap + {pressed} <= min({_ROOM}, end_stop.gap + end_stop.compression)"
    return stated(
        "stopping at the end of the travel",
        formula,
        source="energy of stage and payload at full speed against end stops and the pads' friction",
        proposal=f"end stops that take {{{_ENERGY}: J}}, or less speed near the ends",
        requirement="Table 1: travel",
        note=f"without end stops the pads' friction alone needs {{{_ENERGY}/{_BRAKE}}} of {{{_ROOM}}}",
    )(r)


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
