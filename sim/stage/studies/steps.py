"""Nanometre steps: the tip stays on the drive surface and leans, the stage follows through contact and presliding."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from sim.stage.constants import STEP, make_constants
from sim.stage.drive_setting import TipDrive, knots_wave, step_times
from sim.stage.machine import StageMachine
from sim.stage.run import StageRun, drive_stage
from sim.stage.state import Constants, piezo_response
from sim.stage.statics import Rest, rest_with_load
from sim.stage.studies import RunAll

SIZES = {"1_count": None, "10nm": 10e-9, "100nm": 100e-9}
"""Commanded steps of the unloaded apex, m; none: one count of the converter on the two piezos, opposed."""
HOLD = 0.02
RISE = 0.002
STEPS_EACH_WAY = 6
LOAD_SHARE = 0.3
"""Part of weight and preload that the tip carries in fine motion: its friction holds the pads' fivefold."""


@dataclass(frozen=True)
class Staircase:
    """Steps up and down again."""

    run: StageRun  # the motion
    commanded_step: float  # of the unloaded apex by the stacks' mean gain, m a step
    levels: np.ndarray  # position along x at the end of each hold, m, shape (2 n + 1,)

    @property
    def steps(self) -> np.ndarray:
        """Steps made, up positive, m, shape (2 n,)."""
        return np.diff(self.levels)

    @property
    def mean_step(self) -> float:
        """Mean of the steps up after the first, m."""
        return float(np.mean(self.steps[1:STEPS_EACH_WAY]))

    @property
    def spread(self) -> float:
        """Largest less smallest of these steps, m."""
        return float(np.ptp(self.steps[1:STEPS_EACH_WAY]))

    @property
    def lost(self) -> float:
        """Mean step less the first step back, m."""
        return self.mean_step + float(self.steps[STEPS_EACH_WAY])

    @property
    def left(self) -> float:
        """Position after as many steps down as up, m."""
        return float(self.levels[-1] - self.levels[0])


@dataclass(frozen=True)
class StepStudy:
    """Staircases by name, and what a count comes to."""

    staircases: dict[str, Staircase]  # by the names of `SIZES`
    count: float  # motion of the apex for one count of the converter on two piezos, opposed, by the mean gain, m
    static: float  # step of the stage over step of the free apex, in closed form, small signal

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {"count": (self.count, "m"), "static_ratio": (self.static, "1")}
        for name, stairs in self.staircases.items():
            found[f"step_{name}"] = (stairs.mean_step, "m")
            found[f"spread_{name}"] = (stairs.spread, "m")
            found[f"lost_{name}"] = (stairs.lost, "m")
            found[f"left_{name}"] = (stairs.left, "m")
        return found


def static_stiffnesses(constants: Constants, rest: Rest) -> tuple[float, float]:
    """Stiffnesses along the travel of tip and contact in series, and of the pads against them, N/m.

        1/k = 1/k_contact + h^2/k_tilt + 1/k_sway

    k_tilt = (stiffness of a piezo) sum p_x^2, k_sway that of the bending stacks, k_contact = (tangential ratio) (normal
    stiffness at the load), k_pads = sum of (pad load) (bristle stiffness per load).
    """
    depth = (float(rest.tip_loads.sum()) / constants.contact_rate) ** (2.0 / 3.0)
    contact = constants.contact_ratio * 1.5 * constants.contact_rate * math.sqrt(depth)
    tilt = constants.piezo_stiffness * float(np.sum(constants.piezo_at[:, 0] ** 2)) / constants.tip_height**2
    series = 1.0 / (1.0 / contact + 1.0 / tilt)
    if constants.sway_stiffness > 0.0:
        series = 1.0 / (1.0 / series + 1.0 / constants.sway_stiffness)
    return series, constants.pad_bristle * float(rest.pad_loads.sum())


def small_signal_gain(machine: StageMachine, rest: Rest) -> float:
    """Motion of the stage over that commanded by the stacks' mean gain, for steps well within presliding."""
    mean = machine.piezo.stroke / machine.piezo.highest_voltage
    series, pads = static_stiffnesses(make_constants(machine, rest), rest)
    return series / (series + pads) * piezo_response(machine.piezo).small_signal_gain / mean


def converter_count(machine: StageMachine) -> float:
    """Motion of the apex along x for one count on piezos 1 and 2, opposed, by the mean gain, m."""
    volts = machine.piezo.highest_voltage / 2**machine.piezo.bits
    spacing = float(machine.tip.piezo_places[1, 0] - machine.tip.piezo_places[0, 0])
    return 2.0 * machine.tip.height / spacing * volts * machine.piezo.stroke / machine.piezo.highest_voltage


def staircase(machine: StageMachine, size: float | None) -> Staircase:
    """Steps of one size (m; none: a count) up and down; each rises in 2 ms and is held for 20 ms."""
    commanded_step = converter_count(machine) if size is None else size
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    ups = np.concatenate([np.arange(STEPS_EACH_WAY + 1), np.arange(STEPS_EACH_WAY - 1, -1, -1)]) * commanded_step
    starts = HOLD * np.arange(ups.size)
    knots = np.column_stack([starts, starts + HOLD - RISE]).ravel()
    apex = np.zeros((knots.size, 3))
    apex[:, 0] = np.repeat(ups, 2)
    time = step_times(round(HOLD * ups.size / STEP), STEP)
    wave = knots_wave(machine, time, knots, apex)
    volt = machine.piezo.highest_voltage / 2**machine.piezo.bits
    run = drive_stage(machine, rest, np.round(wave / volt) * volt, STEP, 50)
    ends = starts + HOLD - RISE
    levels = [float(np.mean(run.position[(run.time > end - 0.25 * HOLD) & (run.time < end), 0])) for end in ends]
    return Staircase(run, commanded_step, np.array(levels))


def step_study(drive: TipDrive, run_all: RunAll) -> StepStudy:
    """Staircases of every size."""
    machine = drive.machine
    found = run_all(partial(staircase, machine), list(SIZES.values()))
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    return StepStudy(dict(zip(SIZES, found)), converter_count(machine), small_signal_gain(machine, rest))
