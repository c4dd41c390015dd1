"""Error budgets at the payload: resolution, smoothness, straightness, repeatability, each contribution named."""

from collections.abc import Callable
from functools import partial

import numpy as np

from designcalc.bearing.bolted_rail import total_stiffness
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.drive.friction_drive import resonance
from designcalc.errors.error_budget import AXES, Budget, Contribution, budget
from designcalc.errors.sensors import filtered_noise
from designcalc.errors.thermal import floor_motion
from designcalc.friction_stage.physics import loads, pads, position_loop, stage_plate, tip_dynamics
from designcalc.friction_stage.quantities import quantity_key, stated


def _pads_height(r: DesignInputs, height: float) -> float:
    """Mean of the pads' heights that are each off by `height` at random, m."""
    return height / np.sqrt(r("pads.count"))


def _vibration(r: DesignInputs, stiffness: float, damping: str) -> float:
    first = resonance(stiffness, loads.moved_mass(r))
    return float(floor_motion(r("environment.floor_velocity"), first, r(damping)))


def resolution(r: DesignInputs, place: int) -> list[Contribution]:
    """Smallest step along the travel, in closed loop with the stage at rest."""
    noise = filtered_noise(
        r("sensors.probe.resolution"), r("sensors.probe.bandwidth"), r("sensors.filtered_probe.filter_frequency")
    )
    step = 2 * r("actuator.tip_height") / r("actuator.piezo_spacing") * r("piezo.stroke") / 2 ** r("amplifier.bits")
    floor = _vibration(r, tip_dynamics.holding_stiffness(r), "piezo.damping_ratio")
    return [
        Contribution("sensor noise", "capacitive probe behind its filter", (float(noise), 0, 0)),
        Contribution("count of the converter", "one count on both piezos", (step / np.sqrt(12), 0, 0)),
        Contribution("floor", "stage held by the tip", (floor, 0, 0)),
        Contribution("amplifier noise", "two amplifiers through the tip's lever", (tip_dynamics.tip_noise(r), 0, 0)),
    ]


def smoothness(r: DesignInputs, place: int) -> list[Contribution]:
    """Error normal to the motion, shorter than the travel, at the least required acceleration."""
    radius = pads.film(r, pads.heaviest_pad(r)).radius
    roughness, length = r("bearing.proposed_way_roughness"), r("bearing.roughness_correlation")
    rough = float(averaged_roughness(roughness, length, radius))
    wave = r("bearing.way_waviness") / np.sqrt(2)
    lever = r("pads.spacing_along")
    pulse = min(loads.moved_mass(r) * r("requirements.acceleration_low") / r("drive.friction"), loads.tip_load(r))
    way = pads.rail(r)
    M, tau = r("bearing_way.bolt_spacing") / way.bolt_diameter, r("bearing_way.flange_thickness") / way.bolt_diameter
    payload = stage_plate.at_payload(r, pulse)
    bent = float(payload.static[place]) + pulse / (2 * float(total_stiffness(way, M, tau)))
    shaken = float(payload.vibration[place])
    floor = _vibration(r, pads.pads_stiffness(r).normal, "bearing.damping_ratio")
    turn = pulse * r("drive.friction") * loads.moving_body(r).centre_of_mass[2] / pads.pads_stiffness(r).pitch
    bends = "change of the load bends stage, pads and ways"
    return [
        Contribution("roughness", "averaged by each pad", (0, 0, _pads_height(r, rough))),
        Contribution("roughness, pitch", "pads unlike", rotation=(0, rough * np.sqrt(2) / lever, 0)),
        Contribution("waves of the way", "lapped way; the pads follow them", (0, 0, _pads_height(r, wave))),
        Contribution("waves of the way, pitch", "pads unlike", rotation=(0, wave * np.sqrt(2) / lever, 0)),
        Contribution("floor", "stage on its pads", (0, 0, floor)),
        Contribution("the tip's pulsation", bends, (0, 0, bent), random=False),
        Contribution("the tip's pulsation, modes", "its pulses shake the plate", (0, 0, shaken), random=False),
        Contribution("the tip's pulsation, pitch", "its side force", rotation=(0, turn, 0), random=False),
    ]


def straightness(r: DesignInputs, place: int) -> list[Contribution]:
    """Error normal to the motion over the travel."""
    bow, length = r("bearing.way_straightness"), r("bearing_way.length")
    share = (r("stage.travel") / length) ** 2  # of a bow over the way's length, what the travel covers
    turn, roll = 4 * bow / length * r("stage.travel") / length, bow / 2 / r("pads.spacing_across")
    return [
        Contribution("bow of the ways", "lapped way", (0, 0, bow * share), random=False),
        Contribution("bow of the ways, pitch", "slope of the bow", rotation=(0, turn, 0), random=False),
        Contribution("ways unlike", "half a bow over the pads' width", rotation=(roll, 0, 0)),
        Contribution("waves of the way", "lapped way", (0, 0, _pads_height(r, r("bearing.way_waviness")))),
    ]


def repeatability(r: DesignInputs, place: int) -> list[Contribution]:
    """Repeatability of a position along the travel after a change of temperature."""
    change = r("environment.temperature_change")
    growth = r.material("base", "expansion") * r("stage.travel") / 2 * change
    plate = r.material("stage", "expansion") * r("stage.length") / 2 * change
    friction = r("bearing.static_friction") * loads.load(r)
    bow, length = r("bearing.way_straightness"), r("bearing_way.length")
    linearity = r("sensors.probe.linearity") * r("sensors.probe.range")
    # A tenth of the pitch is not repeatable: the pads settle differently on their film.
    turn = 0.1 * 4 * bow / length
    slip = friction / tip_dynamics.holding_stiffness(r)
    air = position_loop.air_error(r)
    pulled = r("payload.cable_force") / tip_dynamics.holding_stiffness(r)
    return [
        Contribution("growth of the base", "half the travel from its middle", (growth, 0, 0), random=False),
        Contribution("growth of the stage", "target on its end face", (plate, 0, 0), random=False),
        Contribution("wind-up by the pads' friction", "tip and contact deflect before the stage moves", (slip, 0, 0)),
        Contribution("refractive index of the air", "interferometer over its dead path and the travel", (air, 0, 0)),
        Contribution("cables", "change of their force over the travel", (pulled, 0, 0)),
        Contribution("linearity of the probe", "over its range", (linearity, 0, 0)),
        Contribution("pitch that does not come back", "payload off the line of measurement", rotation=(0, turn, 0)),
    ]


_KINDS: dict[str, tuple[str, str, str, Callable[[DesignInputs, int], list[Contribution]]]] = {
    "resolution": ("along", "resolution_coarse", "Table 1: resolution", resolution),
    "smoothness": ("normal", "smoothness", "Table 1: smoothness", smoothness),
    "straightness": ("normal", "straightness", "Section 2.3.2: straightness (Table 1 has none)", straightness),
    "repeatability": ("along", "repeatability", "Section 2.3.2: repeatability (Table 1 has none)", repeatability),
}
"""Budgets by name: the direction that is judged, the key of the limit, the requirement, the contributions at one of
`payload_places`."""


def worked_out(r: DesignInputs, name: str) -> Budget:
    """One budget at the payload, at its place with the largest error."""
    direction, key, requirement, parts = _KINDS[name]
    axis, height = AXES[direction], stage_plate.payload_height(r)
    points = [(*place, height) for place in stage_plate.payload_places(r)]
    found = [budget(parts(r, k), point) for k, point in enumerate(points)]
    worst = int(np.argmax([total[axis] for _, total in found]))
    rows, total = found[worst]
    rows = [row for row in rows if row[1][axis] != 0.0]
    rows.sort(key=lambda row: -abs(row[1][axis]))
    return Budget(name, direction, key, requirement, tuple(rows), total, points[worst])


def budgets(r: DesignInputs) -> list[Budget]:
    """All budgets."""
    return [worked_out(r, name) for name in _KINDS]


def total_error(r: DesignInputs, name: str) -> Check:
    found = worked_out(r, name)
    first = found.rows[0][0]
    _, rest = budget([cause for cause, _ in found.rows[1:]], found.point)
    squares = " + ".join(f"{quantity_key('error', cause.name)}^2" for cause, _ in found.rows if cause.random)
    sizes = [quantity_key("error", cause.name) for cause, _ in found.rows if not cause.random]
    errors = {quantity_key("error", cause.name): (abs(float(e[found.axis])), "m") for cause, e in found.rows}
    return stated(
        f"error budget at the payload: {name}",
        " + ".join([*sizes, f"sqrt({squares})"]) + f" <= requirements.{found.key}",
        given={**errors, "error.without_first": (float(rest[found.axis]), "m")},
        source=f"homogeneous transforms, {found.direction} at the worst foot or corner of the payload; random errors "
        "by squares, systematic ones by size",
        proposal=f"start with {first.name} ({first.source}): without it {{error.without_first}}",
        requirement=found.requirement,
    )(r)


CHECKS: list[CheckFunction] = [partial(total_error, name=name) for name in _KINDS]
"""One check for each budget."""
