"""Setting of a run of the stage: start, height of the tip, and run-up to its speed."""

import math
from dataclasses import dataclass

import numpy as np

from sim.stage.constants import STEP
from sim.stage.machine import StageMachine
from sim.stage.run import StageRun, StageSimulation, drive_stage
from sim.stage.statics import over_drive_surface
from sim.stage.waveforms import Ellipse, ellipse_wave, step_times

RISE_CYCLES = 10
SHORTEST_RISE, LONGEST_RISE = 2e-3, 20e-3
"""s: the ellipse grows over ten periods within these."""
GUESS = 1.8
"""Steady speed over X f, with which a first run begins."""
SETTLED = 0.01
"""A speed is steady when it changes by less than this part of X f in a fifth of the run."""
PIECES = 10
"""Pieces of the shortest run; before each the stage is set back, so that it stays near mid-travel."""
LOOKED_AT = (1, 2, 4, 8)
"""Shortest runs after which it is checked whether the speed is steady: the fifths grow, and
fluctuations average out."""
STRIDE, STEADY_STRIDE = 20, 10
"""Steps to a row, and where a swing is read off the rows."""


@dataclass(frozen=True)
class Setting:
    """A drive with elliptical tips."""

    ellipse: Ellipse  # of every tip
    frequency: float  # Hz
    height: float  # of the apex at mid-stroke over the drive surface without tips, m
    position: float = 0.0  # of the stage's middle at the start, m
    velocity: float = 0.0  # of the stage along x at the start, m/s
    phases: tuple[float, ...] | None = None  # of each actuator's turn, rad; none when all turn together


def run_setting(
    machine: StageMachine, setting: Setting, duration: float, step: float = STEP, stride: int = STRIDE
) -> StageRun:
    """Drive the stage at a setting for `duration`, s, its ellipse grown over the first periods."""
    time = step_times(round(duration / step / stride) * stride, step)
    rest = over_drive_surface(machine, setting.position, setting.height)
    return drive_stage(machine, rest, _wave(machine, setting, time), step, stride, setting.velocity)


def _wave(machine: StageMachine, setting: Setting, time: np.ndarray) -> np.ndarray:
    """Voltages (n, actuators, 3) at times since the start, s, shape (n,): the ellipse grows, then stays."""
    rise = min(max(RISE_CYCLES / setting.frequency, SHORTEST_RISE), LONGEST_RISE)
    phases = None if setting.phases is None else np.array(setting.phases)
    envelope = np.minimum(time / rise, 1.0)
    return ellipse_wave(machine, setting.ellipse, setting.frequency, time, envelope, 0.0, phases)


@dataclass(frozen=True)
class Steady:
    """A drive at its steady speed, averaged over whole periods at the end of a run."""

    velocity: np.ndarray  # along x, across it (m/s) and of yaw (rad/s), shape (3,)
    changed: float  # velocity along x in the last fifth of the run less that in the fifth before, m/s
    swing: float  # of the first tip's apex along x, peak to peak, m
    tip_load: float  # mean force of the tips on the stage, N
    contact_share: float  # part of the time that the first tip touches
    lifted_share: float  # part of the time that the pad most often lifted is off its way
    largest_tip_force: float  # N
    ripple: float  # of the velocity along x, m/s rms
    power: float  # mechanical, that the stacks put in, W
    slip_heat: float  # of the tips on the stage, W


def steady(
    machine: StageMachine, setting: Setting, shortest: float, longest: float = 0.5, guess: float = GUESS
) -> Steady:
    """Steady speed at a setting, whose position and velocity are chosen here, about mid-travel.

    The run continues until its last two fifths are equally fast: pads may take a second to bring a stage to rest
    that its tip drives too weakly, and a speed on the way down is not steady. The shortest run has five periods, within
    `shortest` and `longest`, s; with another `guess` of the speed over X f it may end in another limit cycle.
    """
    duration = min(max(shortest, 5.0 / setting.frequency), longest) / PIECES
    steps = round(duration / STEP / STEADY_STRIDE) * STEADY_STRIDE
    full = 2.0 * setting.ellipse.along * setting.frequency
    begin = -0.5 * guess * full * duration
    simulation = StageSimulation(machine, over_drive_surface(machine, begin, setting.height), STEP, guess * full)
    piece, changed = 0, math.inf
    while abs(changed) > SETTLED * full and piece < LOOKED_AT[-1] * PIECES:
        before = simulation.travel
        time = step_times(steps, STEP, simulation.time)
        simulation.advance(_wave(machine, setting, time), STEADY_STRIDE)
        gone = simulation.travel - before
        simulation.set_back(begin + 1.5 * gone)
        begin = -0.5 * gone
        piece += 1
        if piece in [runs * PIECES for runs in LOOKED_AT]:
            changed = _averaged(simulation.record(), setting.frequency).changed
    return _averaged(simulation.record(), setting.frequency)


def _averaged(run: StageRun, frequency: float) -> Steady:
    """Averages over the last fifth of a run."""
    end = float(run.time[-1])
    window = max(1, math.floor(0.2 * end * frequency)) / frequency
    last, before = run.mean_velocity(end - window, end), run.mean_velocity(end - 2 * window, end - window)
    late = run.time >= end - window
    share = float(np.ptp(run.contact_time(0)[late])) / window
    lifted = max(float(np.ptp(run.lifted_time(k)[late])) for k in range(len(run.machine.pads.places))) / window
    return Steady(
        velocity=last,
        changed=float(last[0] - before[0]),
        swing=float(np.ptp(run.apex(0)[late, 0])),
        tip_load=run.mean_tip_load(end - window, end),
        contact_share=share,
        lifted_share=lifted,
        largest_tip_force=float(run.tip_force(0)[late, 2].max()),
        ripple=float(np.std(run.velocity[late, 0])),
        power=float(np.ptp(run.energy["drive"][late])) / window,
        slip_heat=float(np.ptp(run.energy["contacts"][late])) / window,
    )
