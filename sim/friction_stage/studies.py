"""The stage driven by its piezos: nanometre steps, speed, lift-off and tip-over, ellipses, coupling, the loop.

Every study is a function of the machine and of a way to run many independent cases (one after another, on all cores, on
a cluster).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from sim.friction_stage.stage_machine import driven_alone, driven_by_three, flexible_machine
from sim.stage.drive_setting import TipDrive
from sim.stage.studies import ON_REQUEST, STUDY_NAMES, RunAll
from sim.stage.studies.coupling import coupling_study
from sim.stage.studies.ellipse import ellipse_search
from sim.stage.studies.fine_motion import step_study
from sim.stage.studies.hunting import hunting_study
from sim.stage.studies.planar import planar_study
from sim.stage.studies.positioning import positioning_study
from sim.stage.studies.speed import speed_study
from sim.stage.studies.tip_motion import tip_motions
from sim.stage.studies.travel_map import travel_map
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses


class Study(Protocol):
    """Result of a study."""

    def features(self) -> dict[str, tuple[float, str] | None]:
        """Numbers with SI units; none where there is nothing to measure."""
        ...


@dataclass(frozen=True)
class StageDrive:
    """The driven machines of the studies: on actuator 1, and on all three without guide."""

    single: TipDrive
    triple: TipDrive


def stage_drive(design: Design, masses: BodyMasses) -> StageDrive:
    """The driven machines of a design, with bending stage and swaying tips; the amplitude is limited to half the
    piezo's stroke."""
    machine = flexible_machine(design, masses)
    amplitude = min(design.si("actuator.stroke_amplitude"), 0.5 * machine.piezo.stroke)
    phase, frequency = design.si("actuator.phase"), design.si("actuator.frequency")
    machines = driven_alone(design, machine), driven_by_three(design, machine, masses)
    return StageDrive(*(TipDrive(one, amplitude, phase, frequency) for one in machines))


_ON_THREE = ("planar",)
"""Studies of the machine on three actuators."""
_FUNCTIONS = (
    *(step_study, speed_study, travel_map, ellipse_search),
    *(coupling_study, planar_study, positioning_study, hunting_study, tip_motions),
)


def _run(name: str, study: Callable[[TipDrive, RunAll], Study], drive: StageDrive, run_all: RunAll) -> Study:
    return study(drive.triple if name in _ON_THREE else drive.single, run_all)


STUDIES: Mapping[str, Callable[[StageDrive, RunAll], Study]] = {
    name: partial(_run, name, study) for name, study in zip((*STUDY_NAMES, *ON_REQUEST), _FUNCTIONS, strict=True)
}
"""Studies by name, in the order of a run."""
