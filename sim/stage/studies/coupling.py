"""Motion of the stage across its travel under faults of the drive."""

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from sim.stage.constants import STEP
from sim.stage.drive_setting import SHORTEST_RISE, TipDrive, ellipse_wave, step_times, two_piezo_ellipse
from sim.stage.machine import StageMachine
from sim.stage.simulation import StageRun, drive_stage
from sim.stage.statics import over_drive_surface
from sim.stage.studies import RunAll

DURATION = 0.1
HEIGHT = 0.5
"""Height of the apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height: no pad lifts at
mid-travel."""


@dataclass(frozen=True)
class Fault:
    """A drive with a fault."""

    text: str  # description of the fault
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)  # of the three piezos' waves about the bias, shape (3,)
    delays: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the three piezos' waves, rad of the drive
    offset: float = 0.0  # of the actuator across the travel, m
    ample: bool = False  # an amplifier without limits of current and bandwidth
    linear: bool = False  # stacks without hysteresis and creep besides


FAULTS = {
    "linear_piezos": Fault("no hysteresis, no limit of current", ample=True, linear=True),
    "ample_current": Fault("no limit of current", ample=True),
    "as_designed": Fault("as designed"),
    "piezo_2_late": Fault("piezo 2 late by 10 deg", delays=(0.0, math.radians(10.0), 0.0)),
    "piezo_3_late": Fault("piezo 3 late by 10 deg", delays=(0.0, 0.0, math.radians(10.0))),
    "piezo_3_weak": Fault("piezo 3 weak by 5 %", gains=(1.0, 1.0, 0.95)),
    "piezo_3_still": Fault("piezo 3 not driven", gains=(1.0, 1.0, 0.0)),
    "off_centre": Fault("actuator 1 mm off the centre line", offset=1e-3),
}


@dataclass(frozen=True)
class CouplingStudy:
    """Runs with each fault."""

    runs: dict[str, StageRun] = field(repr=False)

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for name, run in self.runs.items():
            along, across, yaw = run.position[-1]
            apex = run.apex(0)[run.time >= 0.5 * DURATION]
            found[f"{name}_travel"] = (float(along), "m")
            found[f"{name}_across"] = (float(across), "m")
            found[f"{name}_yaw"] = (float(yaw), "rad")
            found[f"{name}_tip_across"] = (float(np.ptp(apex[:, 1])), "m")
        return found


def with_ample_amplifier(machine: StageMachine) -> StageMachine:
    """The machine without limits of current, slew rate and bandwidth."""
    return replace(machine, piezo=replace(machine.piezo, current=math.inf, slew_rate=math.inf, bandwidth=1e6))


def faulty_run(drive: TipDrive, fault: Fault) -> StageRun:
    """A run with a fault."""
    machine = drive.machine
    if fault.ample:
        machine = with_ample_amplifier(machine)
    if fault.linear:
        machine = replace(machine, piezo=replace(machine.piezo, hysteresis=0.0, creep=0.0))
    machine = replace(machine, actuators=machine.actuators + [0.0, fault.offset])
    ellipse = two_piezo_ellipse(machine, drive.amplitude, drive.phase)
    time = step_times(round(DURATION / STEP), STEP)
    envelope = np.minimum(time / SHORTEST_RISE, 1.0)
    bias = machine.piezo.bias
    wave = np.empty((time.size, 1, 3))
    for i in range(3):
        late = time - fault.delays[i] / (2.0 * math.pi * drive.frequency)
        whole = ellipse_wave(machine, ellipse, drive.frequency, late, envelope)
        wave[:, :, i] = bias + fault.gains[i] * (whole[:, :, i] - bias)
    return drive_stage(machine, over_drive_surface(machine, 0.0, HEIGHT * ellipse.normal), wave, STEP, 50)


def coupling_study(drive: TipDrive, run_all: RunAll) -> CouplingStudy:
    """A tenth of a second from rest with each fault."""
    return CouplingStudy(dict(zip(FAULTS, run_all(partial(faulty_run, drive), list(FAULTS.values())))))
