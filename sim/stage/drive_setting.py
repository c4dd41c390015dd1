"""How a run of the stage is set: where it starts, how high the tip stands, and how it is brought to its speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sim.stage.constants import STEP
from sim.stage.machine import StageMachine
from sim.stage.run import StageRun
from sim.stage.simulation import drive_stage
from sim.stage.statics import over_sea
from sim.stage.waveforms import Ellipse, ellipse_wave, step_times

RISE_CYCLES = 10
SHORTEST_RISE, LONGEST_RISE = 2e-3, 20e-3
"""s: the ellipse grows over ten periods within these."""


@dataclass(frozen=True)
class Setting:
    """A drive with elliptical tips.

    Args:
        ellipse: of every tip.
        frequency: Hz.
        height: of the apex at mid-stroke over the sea as it stands without tips, m.
        position: of the stage's middle at the start, m.
        velocity: of the stage along x at the start, m/s.
        phases: of each actuator's turn, rad; none when all turn together.
    """

    ellipse: Ellipse
    frequency: float
    height: float
    position: float = 0.0
    velocity: float = 0.0
    phases: tuple[float, ...] | None = None


def run_setting(
    machine: StageMachine, setting: Setting, duration: float, step: float = STEP, stride: int = 20
) -> StageRun:
    """Drive the stage at a setting, its ellipse grown over the first periods.

    Args:
        machine, setting: what is driven, and how.
        duration: s.
        step: of the integration, s.
        stride: steps to a row.
    """
    time = step_times(round(duration / step / stride) * stride, step)
    rise = min(max(RISE_CYCLES / setting.frequency, SHORTEST_RISE), LONGEST_RISE)
    phases = None if setting.phases is None else np.array(setting.phases)
    envelope = np.minimum(time / rise, 1.0)
    wave = ellipse_wave(machine, setting.ellipse, setting.frequency, time, envelope, 0.0, phases)
    rest = over_sea(machine, setting.position, setting.height)
    return drive_stage(machine, rest, wave, step, stride, setting.velocity)


@dataclass(frozen=True)
class Steady:
    """A drive at its lasting speed, averaged over whole periods at the end of a run.

    Args:
        velocity: along x, across it (m/s) and of yaw (rad/s), shape (3,).
        still_changing: change of the velocity along x between the last two windows, over the velocity.
        tip_load: mean force of the tips on the stage, N.
        contact_share: part of the time that the first tip touches.
        lifted_share: part of the time that the pad most often lifted is off its way.
        largest_tip_force: N.
    """

    velocity: np.ndarray
    still_changing: float
    tip_load: float
    contact_share: float
    lifted_share: float
    largest_tip_force: float


def steady(machine: StageMachine, setting: Setting, shortest: float, longest: float = 0.5) -> Steady:
    """Lasting speed at a setting: five periods at least, started near it and so that the run passes mid-travel.

    Args:
        machine, setting: what is driven, and how; its position and velocity are chosen here.
        shortest, longest: of the run, s.
    """
    period = 1.0 / setting.frequency
    duration = min(max(shortest, 5.0 * period), longest)
    guess = 1.8 * 2.0 * setting.ellipse.along * setting.frequency
    reach = 0.5 * machine.travel
    begin = replace(setting, velocity=guess, position=max(-0.8 * guess * duration, -reach))
    run = run_setting(machine, begin, duration)
    cycles = max(1, math.floor(0.2 * duration * setting.frequency))
    window, end = cycles * period, float(run.time[-1])
    last, before = run.mean_velocity(end - window, end), run.mean_velocity(end - 2 * window, end - window)
    late = run.time >= end - window
    share = float(np.ptp(run.contact_time(0)[late])) / window
    lifted = max(float(np.ptp(run.lifted_time(k)[late])) for k in range(len(machine.pads.places))) / window
    return Steady(
        velocity=last,
        still_changing=abs(last[0] - before[0]) / max(abs(last[0]), 1e-12),
        tip_load=run.mean_tip_load(end - window, end),
        contact_share=share,
        lifted_share=lifted,
        largest_tip_force=float(run.tip_force(0)[late, 2].max()),
    )
