"""Coarse run and fine settling in a closed loop.

Coarse: the tip follows its ellipse; the output of the controller is the signed amplitude along the travel. The
desired speed falls with the square root of the remaining distance; the output is proportional to the speed error.
Pressing the tip shifts the stage: the loop stays closed meanwhile, and beyond the reach of the fine loop the run is
repeated. Fine: the tip is pressed on the drive surface and leans by the integral of the error; the stage follows
through contact and bending stacks within its presliding, by a small part of the lean (`fine_motion`). Floor, amplifiers
and air disturb both.
"""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from sim.stage.constants import STEP
from sim.stage.drive_setting import Actuation, TipDrive
from sim.stage.machine import StageMachine
from sim.stage.sensors import Disturbances, FilteredProbe, Interferometer, Lvdt
from sim.stage.simulation import StageRun, StageSimulation
from sim.stage.statics import over_drive_surface, rest_with_load
from sim.stage.studies import RunAll
from sim.stage.studies.feedforward import FEEDFORWARD
from sim.stage.studies.fine_motion import (
    LEAN_HIGHEST,
    LOAD_SHARE,
    FineController,
    HeldStage,
    Tracked,
    held_stage,
    short_move,
    sine,
    tracked,
)

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
beyond that part of the reach, it is lifted again, and the run repeated with its shift taken into account."""
COARSE_LONGEST = 0.4
PRESS_TIME, STILL_TIME = 0.02, 0.06
"""s, in which the tip is pressed, and after which vibrations have decayed so far that their mean shows the place."""
FINE_TIME = 0.5
SETTLED = 10e-9
"""The coarsest resolution required, of every period; of the mean over `MEAN_TIME`, a tenth of it."""
MEAN_SETTLED, MEAN_TIME = 1e-9, 0.01


@dataclass(frozen=True)
class Loop:
    """Sensors and control of a move."""

    text: str  # description
    coarse: str  # name of the sensor of the run
    fine: str  # name of the sensor of the settling
    notched: bool = True  # whether the controller has notches at the resonances of the held stage
    controlled: bool = True  # whether the loop stays closed while the tip is pressed


LOOPS = {
    "interferometer": Loop("interferometer throughout", "interferometer", "interferometer"),
    "interferometer_and_probe": Loop("interferometer, then filtered probe", "interferometer", "probe"),
    "lvdt_and_probe": Loop("LVDT, then filtered probe", "lvdt", "probe"),
    "without_notches": Loop("interferometer, no notches", "interferometer", "interferometer", notched=False),
    "pressed_open": Loop("interferometer, pressed in open loop", "interferometer", "interferometer", controlled=False),
}


@dataclass(frozen=True)
class Positioning:
    """A move to a target."""

    run: StageRun  # the motion, one row a sample
    target: float  # m
    taken_over: float | None  # when the fine loop took over, s; None when the coarse run did not come near in time
    by_floor: np.ndarray  # motion of the held stage by the floor, m, shape (n,)
    controller: FineController

    @property
    def error(self) -> np.ndarray:
        """True error, m, shape (n,)."""
        return self.run.position[:, 0] + self.by_floor - self.target

    def within(self, limit: float, mean_time: float = 0.0) -> float | None:
        """Time from which the true error, averaged over `mean_time` (s), stays within a limit (m), s; None if never."""
        count = max(1, round(mean_time / float(np.diff(self.run.time[:2])[0])))
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
            f"{prefix}_rate": (self.controller.rate, "1/s"),
            **{f"{prefix}_{name}": margin for name, margin in self.controller.margins.items()},
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
    # sines and short moves by the feedforward of the lean
    tracked: dict[str, Tracked]
    moved: dict[str, Tracked]
    held: HeldStage

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {
            "probe_noise": (self.sensor_noise, "m"),
            "lvdt_error_over_probe_range": (self.hand_over_gap, "1"),
            "reach": (self.held.gain * LEAN_HIGHEST, "m"),
            **{f"resonance_{k}": (float(one), "Hz") for k, one in enumerate(self.held.resonances, 1)},
        }
        for name, move in self.moves.items():
            found |= move.features(name)
        found |= {f"tracking_{name}_error_rms": (one.rms, "m") for name, one in self.tracked.items()}
        for name, one in self.moved.items():
            settled = one.settled(MEAN_SETTLED)
            found[f"short_move_{name}_largest_error"] = (one.largest, "m")
            found[f"short_move_{name}_within_1nm"] = None if settled is None else (settled, "s")
        return found


def _sensor(name: str, machine: StageMachine, period: float) -> Any:
    if name == "probe":
        return FilteredProbe(machine.sensors, period, TARGET)
    return {"interferometer": Interferometer, "lvdt": Lvdt}[name](machine.sensors, period)


class _Move:
    """A move in progress: machine, sensors, disturbances, and where the coarse run is to stop."""

    def __init__(self, drive: TipDrive, loop: Loop, held: HeldStage) -> None:
        machine, self.actuation, self.loop, self.period = drive.machine, Actuation(drive), loop, held.period
        rest = over_drive_surface(machine, 0.0, COARSE_HEIGHT * self.actuation.path.normal)
        pressed = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
        self.lift = float(pressed.apex_heights[0] - rest.apex_heights[0])
        self.reach = held.gain * LEAN_HIGHEST
        self.simulation = StageSimulation(machine, rest, STEP)
        self.disturbances = Disturbances(machine.surroundings, machine.piezo, held.period, STEP)
        self.coarse, self.fine = (_sensor(name, machine, held.period) for name in (loop.coarse, loop.fine))
        self.before, self.speed, self.aim = 0.0, 0.0, TARGET

    def read(self, sensor: Any) -> float:
        true = self.simulation.travel + float(self.disturbances.floor(np.array([self.simulation.time]))[0])
        return sensor.read(true + (self.disturbances.air() if isinstance(sensor, Interferometer) else 0.0))

    def advance(self, *command: float) -> None:
        self.simulation.advance(self.disturbances.disturbed(self.actuation.commands(*command)), self.actuation.steps)

    def coarse_output(self) -> tuple[float, float]:
        """Distance left, m, and amplitude along the travel, -1 to 1."""
        seen = self.read(self.coarse)
        # The rounded position's difference is smoothed over some ten periods.
        self.speed += 0.2 * ((seen - self.before) / self.period - self.speed)
        self.before, left = seen, self.aim - seen
        desired = math.copysign(math.sqrt(2.0 * DECELERATION * abs(left)), left)
        return left, min(max((desired - self.speed) / SPEED_SCALE, -1.0), 1.0)

    def run_to_aim(self) -> float | None:
        """Coarse run; the time at which the stage is within reach of the fine loop and stops, s."""
        end = self.simulation.time + COARSE_LONGEST
        while self.simulation.time < end:
            left, output = self.coarse_output()
            if abs(left) < max(HAND_OVER * self.reach, self.coarse.count) and abs(self.speed) < STOPPED:
                return self.simulation.time
            self.advance(output, 1.0, 0.0, 0.0)
        return None

    def press(self, falls: bool = False) -> float:
        """Press the tip on the stage, or set it back to the height of the coarse run; the mean error left, m."""
        start, seen = self.simulation.time, []
        while self.simulation.time < start + PRESS_TIME + STILL_TIME:
            part = min((self.simulation.time - start) / PRESS_TIME, 1.0)
            share = 1.0 - part if falls else part
            output = self.coarse_output()[1] if self.loop.controlled and part < 1.0 else 0.0
            seen.append(self.read(self.fine) - TARGET)
            self.advance(output, 1.0 - share, share * self.lift, 0.0)
        # The stage still vibrates, about its new place.
        return float(np.mean(seen[-round(0.5 * STILL_TIME / self.period) :]))

    def settle(self, controller: FineController) -> None:
        """Fine settling; the controller makes up for what sway and pads leave of a motion of the tip."""
        end = self.simulation.time + FINE_TIME
        while self.simulation.time < end:
            self.advance(0.0, 0.0, self.lift, controller.lean(TARGET - self.read(self.fine)))


def move_to(drive: TipDrive, loop: Loop, held: HeldStage | None = None) -> Positioning:
    """Half a millimetre from rest; `held`: response of the held stage, measured when left out."""
    held = held or held_stage(drive)
    move, taken_over = _Move(drive, loop, held), None
    for attempt in range(ATTEMPTS):
        taken_over = move.run_to_aim()
        missed = move.press()
        if taken_over is None or abs(missed) < WITHIN_REACH * move.reach or attempt + 1 == ATTEMPTS:
            break
        move.aim -= missed
        move.press(falls=True)
    controller = FineController(held, move.fine.share, loop.notched)
    move.settle(controller)
    run = move.simulation.record()
    return Positioning(run, TARGET, taken_over, move.disturbances.floor(run.time), controller)


def positioning_study(drive: TipDrive, run_all: RunAll) -> PositioningStudy:
    """Moves of half a millimetre with each set of sensors and control; a sine and a short move by each feedforward."""
    held = held_stage(drive)
    found = run_all(partial(move_to, drive, held=held), list(LOOPS.values()))
    followed, moved = (
        dict(zip(FEEDFORWARD, run_all(partial(tracked, drive, held, motion), FEEDFORWARD)))
        for motion in (sine, short_move)
    )
    sensors = drive.machine.sensors
    noise = sensors.probe_noise * math.sqrt(sensors.filter_frequency / sensors.probe_bandwidth)
    gap = (sensors.lvdt_linearity_error + sensors.lvdt_count) / (0.5 * sensors.filtered_range)
    return PositioningStudy(dict(zip(LOOPS, found)), noise, gap, followed, moved, held)
