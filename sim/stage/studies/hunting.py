"""Limit cycles about a target: an integral controller with static friction, and one that is too fast for the stage."""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sim.stage.constants import STEP
from sim.stage.drive_setting import Actuation, TipDrive
from sim.stage.sensors import Interferometer
from sim.stage.simulation import StageRun, StageSimulation
from sim.stage.statics import over_drive_surface, rest_with_load
from sim.stage.studies import RunAll
from sim.stage.studies.fine_motion import LEAN_HIGHEST, LOAD_SHARE, small_signal_gain
from sim.stage.studies.positioning import COARSE_HEIGHT

DURATION = 1.0
STILL = 5e-9
"""m: less than this peak to peak is not a limit cycle, but the count of the interferometer."""


@dataclass(frozen=True)
class HoldingLoop:
    """A loop that holds the stage at a target, by the interferometer."""

    text: str  # description
    # action of the loop's output: `ellipse` scales the whole path, so that a small one does not touch the drive
    # surface; `travel` scales its travel along only; `lean` leans the pressed tip
    moves: str
    proportional: float  # output per metre, 1/m
    integral: float  # 1/(m s). For `lean` the output is in metres: 1 and 1/s, with the held stage
    target: float = 20e-6  # m


HOLDS = {
    "ellipse_no_integral": HoldingLoop("whole ellipse, no integral action", "ellipse", 2e4, 0.0),
    "ellipse_slow": HoldingLoop("whole ellipse, slow integral", "ellipse", 2e4, 2e6),
    "ellipse_fast": HoldingLoop("whole ellipse, fast integral", "ellipse", 2e4, 3e6),
    "travel_slow": HoldingLoop("travel only, slow integral", "travel", 2e4, 1e6),
    "lean_fast": HoldingLoop("pressed tip, integral of 300 /s with the held stage", "lean", 0.0, 300.0, target=40e-9),
}


@dataclass(frozen=True)
class HoldingRun:
    """A run of a hold."""

    run: StageRun  # the motion, one row a sample
    target: float  # m
    output: np.ndarray  # of the loop, -1 to 1, or m of lean; shape (n,)

    @property
    def error(self) -> np.ndarray:
        """m, shape (n,)."""
        return self.run.position[:, 0] - self.target

    def cycle(self) -> tuple[float, float | None]:
        """Peak-to-peak motion in the second half (m), and the period of its strongest wave (s; none when still)."""
        late = self.error[self.run.time > 0.5 * self.run.time[-1]]
        size = float(np.ptp(late))
        if size < STILL:
            return size, None
        step = float(np.diff(self.run.time[:2])[0])
        bend = np.polyfit(np.arange(late.size), late, 1)
        spectrum = np.abs(np.fft.rfft(late - np.polyval(bend, np.arange(late.size))))
        peak = 1 + int(np.argmax(spectrum[1:]))
        return size, late.size * step / peak


@dataclass(frozen=True)
class HuntingStudy:
    """Holds by name."""

    holds: dict[str, HoldingRun] = field(repr=False)

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for name, held in self.holds.items():
            size, period = held.cycle()
            late = held.run.time > 0.5 * held.run.time[-1]
            found[f"{name}_motion"] = (size, "m")
            found[f"{name}_period"] = None if period is None else (period, "s")
            found[f"{name}_error"] = (float(np.mean(held.error[late])), "m")
        return found


def held(drive: TipDrive, hold: HoldingLoop) -> HoldingRun:
    """A hold from rest."""
    machine, actuation = drive.machine, Actuation(drive)
    period = actuation.steps * STEP
    if hold.moves == "lean":
        rest, most = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load), LEAN_HIGHEST
    else:
        rest, most = over_drive_surface(machine, 0.0, COARSE_HEIGHT * actuation.path.normal), 1.0
    gain = small_signal_gain(machine, rest) if hold.moves == "lean" else 1.0
    simulation = StageSimulation(machine, rest, STEP)
    sensor = Interferometer(machine.sensors, period)
    total, outputs = 0.0, []
    for _ in range(round(DURATION / period)):
        error = hold.target - sensor.read(simulation.travel)
        total = min(max(total + hold.integral / gain * period * error, -most), most)
        output = min(max(hold.proportional * error + total, -most), most)
        outputs.append(output)
        if hold.moves == "lean":
            command = (0.0, 0.0, 0.0, output)
        else:
            command = (output, abs(output) if hold.moves == "ellipse" else 1.0, 0.0, 0.0)
        simulation.advance(actuation.commands(*command), actuation.steps)
    return HoldingRun(simulation.record(), hold.target, np.array(outputs))


def hunting_study(drive: TipDrive, run_all: RunAll) -> HuntingStudy:
    """Every hold of `HOLDS`."""
    return HuntingStudy(dict(zip(HOLDS, run_all(partial(held, drive), list(HOLDS.values())))))
