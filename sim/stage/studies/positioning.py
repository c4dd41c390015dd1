"""Coarse run and fine settling in a closed loop.

Coarse: the tip follows its ellipse; the output of the controller is the signed amplitude along the travel. The
desired speed falls with the square root of the remaining distance; the output is proportional to the speed error.
Pressing the tip shifts the stage: beyond the reach of the fine loop the run is repeated with the shift learned.
Fine: the tip is pressed on the drive surface and leans by the integral of the error; the stage follows through contact
and bending stacks within its presliding, by a small part of the lean. Floor, amplifiers and air disturb both
(`sim.stage.studies.positioning`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from designcalc.errors.dynamic_budget import base_response
from sim.stage.constants import STEP
from sim.stage.machine import Piezo, StageMachine, Surroundings
from sim.stage.run import StageRun, StageSimulation
from sim.stage.sensors import FilteredProbe, Interferometer, Lvdt
from sim.stage.statics import over_drive_surface, rest_with_load
from sim.stage.studies import RunAll
from sim.stage.studies.steps import LOAD_SHARE, small_signal_gain
from sim.stage.waveforms import TipDrive, volts_for

LINES = 24
"""Sine waves in each band of the floor's velocity."""


class Disturbances:
    """Samples of all disturbances, one a `period` of the controller, s; no surroundings are a quiet place."""

    def __init__(
        self, surroundings: Surroundings | None, piezo: Piezo, period: float, step: float, seed: int = 2
    ) -> None:
        self.surroundings, self.period = surroundings, period
        self.random = np.random.default_rng(seed)
        self.index = 0.0
        self.deviation = 0.0
        if surroundings is None:
            return
        # A first-order lag fed with independent values of deviation s leaves s sqrt(share/(2 - share)).
        share = 1.0 - math.exp(-2.0 * math.pi * piezo.bandwidth * step)
        self.deviation = surroundings.amplifier_noise * math.sqrt((2.0 - share) / share)
        self.kept = math.exp(-period / surroundings.air_time)
        self.waves = self._waves(surroundings)

    def _waves(self, surroundings: Surroundings) -> np.ndarray:
        """Angular frequency (rad/s), amplitude (m) and phase of the waves of the stage against its base, (3, n)."""
        edges = [np.linspace(low, high, LINES + 1) for low, high in surroundings.floor_bands]
        frequency = np.concatenate([self.random.uniform(one[:-1], one[1:]) for one in edges])
        # Each wave has an equal share of the power of its band: v^2 = lines x amplitude^2/2.
        velocity = surroundings.floor_velocity * math.sqrt(2.0 / LINES)
        response = base_response(frequency, surroundings.held_resonance, surroundings.held_damping)
        amplitude = velocity / (2.0 * math.pi * frequency) * np.abs(response)
        phase = self.random.uniform(0.0, 2.0 * math.pi, frequency.size)
        return np.stack([2.0 * math.pi * frequency, amplitude, phase])

    def floor(self, time: np.ndarray) -> np.ndarray:
        """Motion of the held stage against its base by the floor, m, at times (n,), s."""
        if self.surroundings is None:
            return np.zeros_like(time)
        rate, amplitude, phase = self.waves
        return np.sin(time[:, None] * rate + phase) @ amplitude

    def air(self) -> float:
        """Error of the next reading of an interferometer, m: a first-order random process that begins at zero."""
        if self.surroundings is None:
            return 0.0
        fresh = self.surroundings.air_error * math.sqrt(1.0 - self.kept**2)
        self.index = self.kept * self.index + fresh * float(self.random.standard_normal())
        return self.index

    def disturbed(self, volts: np.ndarray) -> np.ndarray:
        """Voltages of each step with the noise that leaves its rms behind the amplifiers' bandwidth."""
        if self.deviation == 0.0:
            return volts
        return volts + self.deviation * self.random.standard_normal(volts.shape)


TARGET = 0.5e-3
COARSE_HEIGHT = 0.25
"""Height of the apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height."""
DECELERATION = 0.15
"""m/s^2, of the desired speed; a tenth of what the pads' friction gives."""
SPEED_SCALE = 5e-3
"""Speed error at which the output is full, m/s."""
HAND_OVER, WITHIN_REACH, ATTEMPTS = 0.4, 0.9, 4
STOPPED = 0.2e-3
"""The tip is pressed within this part of the fine loop's reach of the target, at less than this speed, m/s. Pressed
beyond that part of the reach, it is lifted again, and the run repeated with the shift taken into account."""
COARSE_LONGEST = 0.4
PRESS_TIME = 0.02
LEAN_HIGHEST = 4e-6
FINE_TIME = 0.5
SETTLED = 10e-9
"""The coarsest resolution required, of every period; of the mean over `MEAN_TIME`, a tenth of it."""
MEAN_SETTLED, MEAN_TIME = 1e-9, 0.01


@dataclass(frozen=True)
class Loop:
    """Which sensors the loop has."""

    text: str  # description
    coarse: str  # name of the sensor of the run
    fine: str  # name of the sensor of the settling
    fine_rate: float  # of the integral loop with the held stage, 1/s, well within the sensor's bandwidth


LOOPS = {
    "interferometer": Loop("interferometer throughout", "interferometer", "interferometer", 60.0),
    "interferometer_and_probe": Loop("interferometer, then filtered probe", "interferometer", "probe", 45.0),
    "lvdt_and_probe": Loop("LVDT, then filtered probe", "lvdt", "probe", 45.0),
}


@dataclass(frozen=True)
class Positioning:
    """A move to a target."""

    run: StageRun  # the motion, one row a sample
    target: float  # m
    taken_over: float | None  # when the fine loop took over, s; None when the coarse run did not come near in time
    by_floor: np.ndarray  # motion of the held stage by the floor, m, shape (n,)

    @property
    def error(self) -> np.ndarray:
        """True error, m, shape (n,)."""
        return self.run.position[:, 0] + self.by_floor - self.target

    def within(self, limit: float, mean_time: float = 0.0) -> float | None:
        """Time from which the true error, averaged over `mean_time` (s), stays within a limit (m), s; None if never."""
        step = float(np.diff(self.run.time[:2])[0])
        count = max(1, round(mean_time / step))
        mean = np.convolve(self.error, np.full(count, 1.0 / count), mode="same")[: self.error.size - count // 2]
        outside = np.flatnonzero(np.abs(mean) > limit)
        if outside.size == 0:
            return float(self.run.time[0])
        if outside[-1] >= mean.size - count:
            return None
        return float(self.run.time[outside[-1] + 1])

    def features(self, prefix: str) -> dict[str, tuple[float, str] | None]:
        last = self.run.time > self.run.time[-1] - 0.1
        settled, mean_settled = self.within(SETTLED), self.within(MEAN_SETTLED, MEAN_TIME)
        return {
            f"{prefix}_taken_over": None if self.taken_over is None else (self.taken_over, "s"),
            f"{prefix}_within_10nm": None if settled is None else (settled, "s"),
            f"{prefix}_mean_within_1nm": None if mean_settled is None else (mean_settled, "s"),
            f"{prefix}_error_mean": (float(self.error[last].mean()), "m"),
            f"{prefix}_error_std": (float(self.error[last].std()), "m"),
            f"{prefix}_error_rms": (float(np.sqrt(np.mean(self.error[last] ** 2))), "m"),
        }


@dataclass(frozen=True)
class PositioningStudy:
    """Moves with each set of sensors."""

    moves: dict[str, Positioning] = field(repr=False)
    sensor_noise: float
    hand_over_gap: float

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {
            "probe_noise": (self.sensor_noise, "m"),
            "lvdt_error_over_probe_range": (self.hand_over_gap, "1"),
        }
        for name, move in self.moves.items():
            found |= move.features(name)
        return found


def _sensor(name: str, machine: StageMachine, period: float) -> Any:
    if name == "probe":
        return FilteredProbe(machine.sensors, period, TARGET)
    return {"interferometer": Interferometer, "lvdt": Lvdt}[name](machine.sensors, period)


class Actuation:
    """Voltages of one period of a drive with one actuator: an ellipse with a part of its travel, a lift and a lean."""

    def __init__(self, drive: TipDrive, step: float) -> None:
        self.machine, self.path = drive.machine, drive.path
        self.steps = round(1.0 / drive.frequency / step)
        turn = 2.0 * math.pi * (np.arange(self.steps) + 0.5) / self.steps
        self.along, self.up = -np.cos(turn) * self.path.along, np.sin(turn) * self.path.normal
        self.ramp = (np.arange(self.steps) + 0.5) / self.steps
        self.last = np.zeros(4)

    def commands(self, along: float, rise: float, lift: float, lean: float) -> np.ndarray:
        """Voltages (steps, 1, 3); each number changes linearly from its last value to the new one over the period.

        Args:
            along: signed amplitude of the ellipse along the travel, -1 to 1.
            rise: amplitude of its height, 0 to 1.
            lift: of its middle, m.
            lean: of its middle along x, m.
        """
        new = np.array([along, rise, lift, lean])
        now = self.last + self.ramp[:, None] * (new - self.last)
        self.last = new
        x = now[:, 0] * self.along + now[:, 3]
        z = now[:, 1] * self.up + now[:, 2]
        volts = volts_for(self.machine, x, np.zeros(self.steps), z)
        count = self.machine.piezo.highest_voltage / 2**self.machine.piezo.bits
        return (np.round(volts / count) * count)[:, None, :]


def move_to(drive: TipDrive, loop: Loop) -> Positioning:
    """Half a millimetre from rest."""
    machine, actuation = drive.machine, Actuation(drive, STEP)
    period = actuation.steps * STEP
    rest = over_drive_surface(machine, 0.0, COARSE_HEIGHT * actuation.path.normal)
    pressed = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    lift = float(pressed.apex_heights[0] - rest.apex_heights[0])
    gain = small_signal_gain(machine, pressed)
    reach = gain * LEAN_HIGHEST
    simulation = StageSimulation(machine, rest, STEP)
    disturbances = Disturbances(machine.surroundings, machine.piezo, period, STEP)
    coarse, fine = _sensor(loop.coarse, machine, period), _sensor(loop.fine, machine, period)

    def read(sensor: Any) -> float:
        true = simulation.travel + float(disturbances.floor(np.array([simulation.time]))[0])
        return sensor.read(true + (disturbances.air() if isinstance(sensor, Interferometer) else 0.0))

    def advance(volts: np.ndarray) -> None:
        simulation.advance(disturbances.disturbed(volts), actuation.steps)

    def run_to(target: float) -> float | None:
        """Coarse run; the time at which the stage is within reach of the fine loop and stops, s."""
        before, smooth, end = read(coarse), 0.0, simulation.time + COARSE_LONGEST
        while simulation.time < end:
            seen = read(coarse)
            # The rounded position's difference is smoothed over some ten periods.
            smooth += 0.2 * ((seen - before) / period - smooth)
            before, left = seen, target - seen
            if abs(left) < max(HAND_OVER * reach, coarse.count) and abs(smooth) < STOPPED:
                return simulation.time
            desired = math.copysign(math.sqrt(2.0 * DECELERATION * abs(left)), left)
            output = min(max((desired - smooth) / SPEED_SCALE, -1.0), 1.0)
            advance(actuation.commands(output, 1.0, 0.0, 0.0))
        return None

    def press(falls: bool) -> None:
        """Press the tip on the stage, or set it back to the height of the coarse run."""
        start = simulation.time
        while simulation.time < start + PRESS_TIME:
            part = min((simulation.time - start) / PRESS_TIME, 1.0)
            share = 1.0 - part if falls else part
            read(fine)
            advance(actuation.commands(0.0, 1.0 - share, share * lift, 0.0))

    taken_over, shift = None, 0.0
    for attempt in range(ATTEMPTS):
        taken_over = run_to(TARGET - shift)
        press(falls=False)
        missed = read(fine) - TARGET
        if taken_over is None or abs(missed) < WITHIN_REACH * reach or attempt + 1 == ATTEMPTS:
            break
        # The tip shifts the stage as it is pressed, much alike each time.
        shift += missed
        press(falls=True)
    lean, start = 0.0, simulation.time
    while simulation.time < start + FINE_TIME:
        # The controller makes up for what sway and pads leave of a motion of the tip.
        lean += loop.fine_rate / gain * period * (TARGET - read(fine))
        lean = min(max(lean, -LEAN_HIGHEST), LEAN_HIGHEST)
        advance(actuation.commands(0.0, 0.0, lift, lean))
    run = simulation.record()
    return Positioning(run, TARGET, taken_over, disturbances.floor(run.time))


def positioning_study(drive: TipDrive, run_all: RunAll) -> PositioningStudy:
    """A move of half a millimetre with each set of sensors."""
    found = run_all(partial(move_to, drive), list(LOOPS.values()))
    sensors = drive.machine.sensors
    noise = sensors.probe_noise * math.sqrt(sensors.filter_frequency / sensors.probe_bandwidth)
    gap = (sensors.lvdt_linearity_error + sensors.lvdt_count) / (0.5 * sensors.filtered_range)
    return PositioningStudy(dict(zip(LOOPS, found)), noise, gap)
