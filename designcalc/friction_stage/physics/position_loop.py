"""The fine position loop of a stage at rest, and the disturbances that reach the payload through it.

The tip, pressed on the drive surface, leans; its contact, stacks and rocking pull the stage against the shear of the
pads' film, which sticks. An integral controller follows the filtered probe or the interferometer. Normal to the motion
there is no loop; the plate bends on pads and tip.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import DesignInputs, remembered
from designcalc.drive.friction_drive import resonance
from designcalc.errors import dynamic_budget as spectra
from designcalc.errors.dynamic_budget import Disturbance, DynamicBudget, PositionLoop, Response
from designcalc.errors.sensors import air_index_error, count_size
from designcalc.errors.thermal import THIRD_OCTAVES
from designcalc.friction_stage.physics.loads import load, moved_mass, moving_body
from designcalc.friction_stage.physics.pads import pads_stiffness
from designcalc.friction_stage.physics.stage_plate import held_plate, payload_height
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS, holding_stiffness, tip_noise

Array = NDArray[np.float64]

PROBE, INTERFEROMETER = "filtered probe", "interferometer"
_EDGES = (THIRD_OCTAVES[0] * 2.0 ** ((np.arange(THIRD_OCTAVES.size + 1) - 0.5) / 3)).tolist()
BANDS = list(pairwise(_EDGES))
"""Third octaves of the floor's vibration, Hz."""
LOWEST, HIGHEST = 1e-4, 1e5
"""Hz: three hours, and beyond the amplifiers' bandwidth."""


def pads_shear_stiffness(r: DesignInputs) -> float:
    """Stiffness along the travel of the pads' film while it sticks, N/m.

    Slope at rest of the presliding curve ``F = mu_s N [1 - (1 - x/x_p)^2]``: ``2 mu_s N/x_p``.
    """
    return 2 * r("bearing.static_friction") * load(r) / r("bearing.presliding_distance")


@dataclass(frozen=True)
class Suspension:
    """How the stage is held along its travel while the pads stick."""

    gain: float  # displacement of the stage over that of the free tip, static
    resonance: float  # Hz
    damping: float  # ratio


def suspension(r: DesignInputs) -> Suspension:
    """Tip and pads side by side."""
    tip, pads = holding_stiffness(r), pads_shear_stiffness(r)
    first = float(resonance(tip + pads, moved_mass(r)))
    return Suspension(tip / (tip + pads), first, r("bearing.damping_ratio"))


def position_loop(r: DesignInputs, sensor: str) -> PositionLoop:
    """The loop with one of the two sensors; its integral gain makes up for the static gain of the suspension."""
    held = suspension(r)
    corner = r("sensors.filtered_probe.filter_frequency") if sensor == PROBE else math.inf
    return PositionLoop(r("loop.crossover"), held.resonance, held.damping, corner, r("loop.sample_rate"))


def air_error(r: DesignInputs) -> float:
    """Error of the interferometer by the change of the air's index over its dead path and the travel, m."""
    path = r("stage.travel") + r("sensors.interferometer.dead_path")
    return float(air_index_error(path, r("environment.temperature_change"), r("environment.pressure_change")))


def dynamic_budgets(r: DesignInputs) -> list[DynamicBudget]:
    """Budgets along the travel with either sensor, and normal to it."""
    return [dynamic_budget(r, position) for position in range(3)]


@remembered
def dynamic_budget(r: DesignInputs, position: int) -> DynamicBudget:
    """One of `dynamic_budgets`."""
    return _normal(r) if position == 2 else _along(r, (PROBE, INTERFEROMETER)[position])


def _grid(held: list[tuple[float, float]]) -> Array:
    return spectra.frequencies(LOWEST, HIGHEST, held, _EDGES)


def _along(r: DesignInputs, sensor: str) -> DynamicBudget:
    held, loop = suspension(r), position_loop(r, sensor)
    pitch, pitch_damping = _pitch_mode(r)
    f = _grid([(held.resonance, held.damping), (pitch, pitch_damping)])
    sensitivity = loop.sensitivity(f)
    noise = sensitivity - 1
    floor = spectra.floor_density(f, r("environment.floor_velocity"), BANDS)
    relative = spectra.base_response(f, held.resonance, held.damping) * sensitivity
    command = held.gain * loop.plant(f) * sensitivity
    pitched, amplifiers = np.abs(_pitch_per_floor(r, f, relative)), _amplifiers(r, f)
    count = spectra.count_density(f, _tip_count(r), loop.sample_rate)
    sensed = _sensor_noise(r, sensor, f, loop, noise)
    grown = _growth(r, f) * np.abs(spectra.first_order_lag(f, 1 / (2 * np.pi * r("environment.part_time"))))
    rows = [
        Disturbance("floor", "VC criterion, stage held by tip and pads", floor * np.abs(relative)),
        Disturbance("floor, pitch of the stage", "payload above the pads", floor * pitched),
        Disturbance("amplifier noise", "two amplifiers, tip and stage", amplifiers * np.abs(command)),
        Disturbance("count of the converter", "one count on both piezos", count * np.abs(command)),
        *sensed,
        Disturbance("drift of the parts", "growth of base and stage, which follow the air", grown),
    ]
    return DynamicBudget(f"along, {sensor}", f, tuple(rows))


def _sensor_noise(r: DesignInputs, sensor: str, f: Array, loop: PositionLoop, noise: Response) -> list[Disturbance]:
    if sensor == PROBE:
        bandwidth = r("sensors.probe.bandwidth")
        lagged = np.abs(spectra.first_order_lag(f, bandwidth))
        white = spectra.band_density(r("sensors.probe.resolution"), bandwidth) * lagged
        span = r("sensors.probe.range") / r("sensors.filtered_probe.gain")
        count = float(count_size(span, r("sensors.filtered_probe.bits")))
        # The converter comes behind the filter.
        rounded = spectra.count_density(f, count, loop.sample_rate) * np.abs(noise / loop.sensor(f))
        return [
            Disturbance("sensor noise", "probe behind its filter", white * np.abs(noise)),
            Disturbance("count of the sensor", "its converter", rounded),
        ]
    rounded = spectra.count_density(f, r("sensors.interferometer.resolution"), loop.sample_rate)
    air = spectra.fluctuation_density(f, air_error(r), r("environment.air_time"))
    return [
        Disturbance("count of the sensor", "resolution of the interferometer", rounded * np.abs(noise)),
        Disturbance("refractive index of the air", "over dead path and travel", air * np.abs(noise)),
    ]


def _normal(r: DesignInputs) -> DynamicBudget:
    """At the place of the payload with the largest error."""
    held = held_plate(r)
    f = _grid(list(zip(held.frequency.tolist(), held.damping.tolist(), strict=True)))
    # Two amplifiers tilt the tip by d2 - d1 times h/D; three raise it by the mean of d1, d2, d3.
    rise = r("actuator.piezo_spacing") / r("actuator.tip_height") / math.sqrt(2) / math.sqrt(PIEZOS)
    floor, (shaken, lifted) = spectra.floor_density(f, r("environment.floor_velocity"), BANDS), held.responses(f)
    amplifiers = _amplifiers(r, f) * rise
    power = (floor[:, None] * np.abs(shaken)) ** 2 + (amplifiers[:, None] * np.abs(lifted)) ** 2
    worst = int(np.argmax(np.trapezoid(power, f, axis=0)))
    lift = amplifiers * np.abs(lifted[:, worst])
    rows = (
        Disturbance("floor", "VC criterion, modes of the plate on pads and tip", floor * np.abs(shaken[:, worst])),
        Disturbance("amplifier noise", "three amplifiers; the tip lifts stage and payload", lift),
    )
    return DynamicBudget("normal", f, rows)


def _amplifiers(r: DesignInputs, f: Array) -> Array:
    """Density of the free tip's motion along the travel by the amplifiers' noise, m/sqrt(Hz)."""
    bandwidth = r("amplifier.bandwidth")
    return spectra.band_density(tip_noise(r), bandwidth) * np.abs(spectra.first_order_lag(f, bandwidth))


def _tip_count(r: DesignInputs) -> float:
    """Displacement of the free tip by one count on both piezos, opposed, m."""
    lever = 2 * r("actuator.tip_height") / r("actuator.piezo_spacing")
    return lever * r("piezo.stroke") / 2 ** r("amplifier.bits")


def _growth(r: DesignInputs, f: Array) -> Array:
    """Density of the growth of base and stage between the line of measurement and the payload, m/sqrt(Hz), as if they
    followed the temperature of the air at once."""
    base = r.material("base", "expansion") * r("stage.travel") / 2
    per_kelvin = base + r.material("stage", "expansion") * r("stage.length") / 2
    change, time = r("environment.temperature_change"), r("environment.air_time")
    return spectra.fluctuation_density(f, per_kelvin * change, time)


def _pitch_mode(r: DesignInputs) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the rigid stage that pitches on its pads."""
    body = moving_body(r)
    inertia = body.inertia[1][1] + body.mass * body.centre_of_mass[2] ** 2
    return math.sqrt(pads_stiffness(r).pitch / inertia) / (2 * math.pi), r("bearing.damping_ratio")


def _pitch_per_floor(r: DesignInputs, f: Array, relative: Response) -> Response:
    """Motion of the payload by pitch over that of the floor: the centre of mass lies above the tip and the pads."""
    body = moving_body(r)
    first, damping = _pitch_mode(r)
    acceleration = (2 * np.pi * f) ** 2 * (1 + relative)
    moment = body.mass * body.centre_of_mass[2] * acceleration
    return payload_height(r) * moment / pads_stiffness(r).pitch * spectra.resonant_response(f, first, damping)
