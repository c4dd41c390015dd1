"""Positions on the travel and heights of the tip at which pads and tip lose contact or the stage tips over."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from designcalc.drive.friction_drive import tip_force_limit
from sim.stage.constants import STEP
from sim.stage.drive_setting import Setting, TipDrive, knots_wave, run_setting, step_times
from sim.stage.machine import StageMachine
from sim.stage.simulation import drive_stage
from sim.stage.statics import rest_with_load
from sim.stage.studies import RunAll

POSITIONS = 9
HEIGHTS = (-0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0)
"""Heights of the apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height."""
DURATION = 0.03
PUSH_TIME = 0.06
PUSH_HIGHEST = 7e-6
LIFTED = 0.01
"""A pad counts as lifted when it is off its way for more than this part of the time."""


@dataclass(frozen=True)
class DrivenPoint:
    """Result of a drive at one position: parts of the time with each pad and the tip off, shape (pads,) and a number;
    mean tip load, N; mean acceleration, m/s^2."""

    lifted: np.ndarray
    tip_off: float
    tip_load: float
    acceleration: float


@dataclass(frozen=True)
class TravelMap:
    """Maps over position and height."""

    positions: np.ndarray  # of the stage's middle, m, shape (n,)
    heights: np.ndarray  # of the apex over the drive surface, m, shape (m,)
    lifted: np.ndarray  # part of the time that the pad most often lifted is off, shape (m, n)
    tip_off: np.ndarray  # part of the time that the tip is off, shape (m, n)
    load_share: np.ndarray  # mean tip load over weight and preload, shape (m, n)
    acceleration: np.ndarray  # at the start from rest, m/s^2, shape (m, n)
    pushed: np.ndarray  # tip force over load at which the first pad lifts, pushed slowly, shape (n,)
    limit: np.ndarray  # the same by the moments about the pads' edge (`designcalc`), shape (n,)

    def highest_clean(self, position: int) -> int | None:
        """Index of the greatest height up to which no pad lifts at a position."""
        clean = self.lifted[:, position] <= LIFTED
        if not clean[0]:
            return None
        return int(np.argmin(clean)) - 1 if not clean.all() else clean.size - 1

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for name, at in (("middle", self.positions.size // 2), ("end", self.positions.size - 1)):
            found[f"tip_over_share_{name}"] = (float(self.pushed[at]), "1")
            found[f"tip_over_limit_{name}"] = (float(self.limit[at]), "1")
            highest = self.highest_clean(at)
            for key, values, unit in (
                ("height", self.heights, "m"),
                ("load_share", self.load_share[:, at], "1"),
                ("acceleration", self.acceleration[:, at], "m/s^2"),
            ):
                value = None if highest is None else (float(values[highest]), unit)
                found[f"{key}_without_lift_{name}"] = value
        found["largest_difference_from_limit"] = (float(np.max(np.abs(self.pushed - self.limit))), "1")
        return found


def _driven(machine: StageMachine, setting: Setting) -> DrivenPoint:
    run = run_setting(machine, setting, DURATION)
    # The first third is the rise of the ellipse and the bounce it leaves.
    late = run.time >= DURATION / 3.0
    span = float(np.ptp(run.time[late]))
    lifted = np.array([np.ptp(run.lifted_time(k)[late]) for k in range(len(machine.pads.places))]) / span
    start, end = float(run.time[late][0]), float(run.time[-1])
    half = 0.5 * (start + end)
    gained = run.mean_velocity(half, end)[0] - run.mean_velocity(start, half)[0]
    return DrivenPoint(
        lifted=lifted,
        tip_off=1.0 - float(np.ptp(run.contact_time(0)[late])) / span,
        tip_load=run.mean_tip_load(start, end),
        acceleration=float(gained) / (0.5 * span),
    )


def pushed_over(machine: StageMachine, position: float) -> float:
    """Tip force over load at which the first pad lifts, the tip slowly raised under the stage at a position, m."""
    rest = rest_with_load(machine, position, 0.0)
    time = step_times(round(PUSH_TIME / STEP), STEP)
    wave = knots_wave(machine, time, np.array([0.0, PUSH_TIME]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, PUSH_HIGHEST]]))
    run = drive_stage(machine, rest, wave, STEP, 20)
    off = np.min([run.pad_force(k)[:, 2] for k in range(len(machine.pads.places))], axis=0) <= 0.0
    lifted = int(np.argmax(off)) if off.any() else -1
    return float(run.tip_force(0)[lifted, 2]) / machine.load


def load_centre(machine: StageMachine) -> np.ndarray:
    """Point of action of weight and preload together, from the stage's middle, m, shape (2,)."""
    return machine.stage.mass * machine.gravity * np.asarray(machine.stage.centre)[:2] / machine.load


def travel_map(drive: TipDrive, run_all: RunAll) -> TravelMap:
    """Lift-off and tip-over over the travel."""
    machine, ellipse = drive.machine, drive.path
    positions = np.linspace(-0.5, 0.5, POSITIONS) * machine.travel
    heights = np.array(HEIGHTS) * ellipse.normal
    cases = [Setting(ellipse, drive.frequency, height, position) for height in heights for position in positions]
    points: list[DrivenPoint] = run_all(partial(_driven, machine), cases)
    pushed = run_all(partial(pushed_over, machine), list(positions))
    # The tip is stationary: relative to the stage's middle it is at minus the stage's position.
    tip = machine.actuators[0]
    centre = load_centre(machine)
    limit = [tip_force_limit(machine.pads.places, centre, tip - [position, 0.0]) for position in positions]

    def grid(values: list[float]) -> np.ndarray:
        return np.array(values).reshape(heights.size, positions.size)

    return TravelMap(
        positions=positions,
        heights=heights,
        lifted=grid([float(point.lifted.max()) for point in points]),
        tip_off=grid([point.tip_off for point in points]),
        load_share=grid([point.tip_load / machine.load for point in points]),
        acceleration=grid([point.acceleration for point in points]),
        pushed=np.array(pushed),
        limit=np.array(limit),
    )
