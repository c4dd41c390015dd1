"""The stage driven by its piezos: nanometre steps, speed, lift-off and tip-over, ellipses, coupling, the loop.

Every study is a function of the machine and of a way to run many independent cases (one after another, on all cores, on
a cluster).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from sim.friction_stage.stage_machine import driven_alone, driven_by_three, flexible_machine
from sim.stage.machine import StageMachine
from sim.stage.studies import STUDY_NAMES
from sim.stage.studies.coupling import coupling_study
from sim.stage.studies.ellipse import ellipse_search
from sim.stage.studies.hunting import hunting_study
from sim.stage.studies.planar import planar_study
from sim.stage.studies.positioning import positioning_study
from sim.stage.studies.speed import speed_study
from sim.stage.studies.steps import step_study
from sim.stage.studies.travel_map import travel_map
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses

RunAll = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


class Study(Protocol):
    """Result of a study."""

    def features(self) -> dict[str, tuple[float, str] | None]:
        """Numbers with SI units; none where there is nothing to measure."""
        ...


@dataclass(frozen=True)
class StageDrive:
    """Machines and drive of the studies.

    Args:
        single: the stage on actuator 1.
        triple: the stage on all three, without guide.
        amplitude: of a piezo, m: the design's, or half the stroke where that is less.
        phase: between piezos 1 and 2, rad.
        frequency: Hz.
    """

    single: StageMachine
    triple: StageMachine
    amplitude: float
    phase: float
    frequency: float


def stage_drive(design: Design, masses: BodyMasses) -> StageDrive:
    """Machines and drive of a design, with bending stage and swaying tips; the amplitude is limited to half the piezo's
    stroke."""
    machine = flexible_machine(design, masses)
    return StageDrive(
        single=driven_alone(design, machine),
        triple=driven_by_three(design, machine, masses),
        amplitude=min(design.si("actuator.stroke_amplitude"), 0.5 * machine.piezo.stroke),
        phase=design.si("actuator.phase"),
        frequency=design.si("actuator.frequency"),
    )


def _common(study: Callable[..., Study]) -> Callable[[StageDrive, RunAll], Study]:
    return lambda drive, run_all: study(drive.single, drive.amplitude, drive.phase, drive.frequency, run_all)


STUDIES: Mapping[str, Callable[[StageDrive, RunAll], Study]] = dict(
    zip(
        STUDY_NAMES,
        (
            lambda drive, run_all: step_study(drive.single, run_all),
            _common(speed_study),
            _common(travel_map),
            lambda drive, run_all: ellipse_search(drive.single, drive.amplitude, drive.frequency, run_all),
            _common(coupling_study),
            lambda drive, run_all: planar_study(drive.triple, drive.amplitude, drive.phase, drive.frequency, run_all),
            _common(positioning_study),
            _common(hunting_study),
        ),
        strict=True,
    )
)
"""Studies by name, in the order of a run."""


def run_serially(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
    """One case after another."""
    return [function(case) for case in cases]
