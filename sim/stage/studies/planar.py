"""Three actuators under the stage, driven together to a commanded direction (the thesis's 2-D layout).

Without teeth nothing guides the stage but its own drive. A start from rest shows the direction of the thrust.
"""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sim.stage.drive_setting import Ellipse, Setting, TipDrive, run_setting, scaled_to, two_piezo_ellipse
from sim.stage.machine import StageMachine
from sim.stage.simulation import StageRun
from sim.stage.studies import RunAll

DIRECTIONS = tuple(math.radians(degrees) for degrees in range(0, 360, 30))
DURATION = 0.06
HEIGHT = -0.45
"""Height of each apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height."""
IN_STEP = (0.0, 0.0, 0.0)
IN_THIRDS = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
"""Phases of the three actuators' turns."""
WITHIN_CURRENT = 0.8
"""Part of the frequency up to which the amplifier follows a sine of the full stroke."""


@dataclass(frozen=True)
class PlanarStudy:
    """Starts from rest in each direction."""

    directions: np.ndarray  # commanded, rad, shape (n,)
    frequencies: dict[str, float]  # by drive, Hz
    runs: dict[str, list[StageRun]] = field(repr=False)  # by drive, one a direction

    def ends(self, drive: str) -> np.ndarray:
        """Final position of the stage (x, y, yaw), m, m, rad, shape (n, 3)."""
        return np.array([run.position[-1] for run in self.runs[drive]])

    def direction_errors(self, drive: str) -> np.ndarray:
        """Direction of the motion less that commanded, rad, shape (n,)."""
        ends = self.ends(drive)
        away = np.arctan2(ends[:, 1], ends[:, 0]) - self.directions
        return (away + math.pi) % (2.0 * math.pi) - math.pi

    def heave(self, drive: str) -> np.ndarray:
        """Rms heave about its mean in the second half of each run, m, shape (n,)."""
        return np.array([float(np.std(run.attitude[run.time > 0.5 * DURATION, 0])) for run in self.runs[drive]])

    def lifted(self, drive: str) -> np.ndarray:
        """Part of the time that the pad most often lifted is off, shape (n,)."""
        pads = range(len(self.runs[drive][0].machine.pads.places))
        return np.array([max(run.lifted_time(k)[-1] for k in pads) / DURATION for run in self.runs[drive]])

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for drive in self.runs:
            found[f"{drive}_frequency"] = (self.frequencies[drive], "Hz")
            ends = self.ends(drive)
            distance = np.hypot(ends[:, 0], ends[:, 1])
            found[f"{drive}_distance_least"] = (float(distance.min()), "m")
            found[f"{drive}_distance_most"] = (float(distance.max()), "m")
            found[f"{drive}_direction_error"] = (float(np.abs(self.direction_errors(drive)).max()), "rad")
            found[f"{drive}_yaw"] = (float(np.abs(ends[:, 2]).max()), "rad")
            found[f"{drive}_heave_rms"] = (float(self.heave(drive).max()), "m")
            found[f"{drive}_lifted"] = (float(self.lifted(drive).max()), "1")
        return found


def directed(machine: StageMachine, amplitude: float, phase: float, direction: float) -> Ellipse:
    """The ellipse of the one-axis drive turned to a direction, with the most active piezo at `amplitude`, m."""
    upright = two_piezo_ellipse(machine, amplitude, phase)
    return scaled_to(machine, Ellipse(upright.along, upright.normal, upright.lag, direction), amplitude)


def planar_study(drive: TipDrive, run_all: RunAll) -> PlanarStudy:
    """Starts in twelve directions: at the design's frequency, and at one within the amplifier's current, the actuators
    in step and a third of a turn apart."""
    machine = drive.machine
    slow = min(drive.frequency, WITHIN_CURRENT * machine.piezo.unclipped_frequency(drive.amplitude))
    drives = {"in_step": (drive.frequency, IN_STEP), "slower": (slow, IN_STEP), "slower_in_thirds": (slow, IN_THIRDS)}
    cases = []
    for turn_frequency, turns in drives.values():
        for direction in DIRECTIONS:
            path = directed(machine, drive.amplitude, drive.phase, direction)
            cases.append(Setting(path, turn_frequency, HEIGHT * path.normal, phases=turns))
    found = run_all(partial(run_setting, machine, duration=DURATION, stride=50), cases)
    count = len(DIRECTIONS)
    runs = {name: found[i * count : (i + 1) * count] for i, name in enumerate(drives)}
    return PlanarStudy(np.array(DIRECTIONS), {name: drive[0] for name, drive in drives.items()}, runs)
