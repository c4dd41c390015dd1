"""Jobs of the simulation view: the experiments of the thesis at the values of the sliders."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from workbench.machine.design_source import DesignSource
from workbench.page.curves import write_curves
from workbench.page.job_process import Report

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

STAGE = "stage-"
"""Begins the name of a study of the driven stage."""


def simulate(
    text: str | None,
    name: str,
    overrides: list[str],
    experiment: str,
    models: list[str],
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """One experiment: the document of `stagecad simulate --json`, and its curves."""
    if experiment.startswith(STAGE):
        return _stage(DesignSource(text, name, tuple(overrides)).design(), experiment, Path(folder), report)
    from sim.integration.simulate import SimulationError
    from workbench.simulation.experiments import features_of, moving_mass, simulate_experiment
    from workbench.simulation.tables import tables_of

    design = DesignSource(text, name, tuple(overrides)).design(rules=False)
    count = 0

    def advance() -> None:
        nonlocal count
        count += 1
        report(experiment, count, len(models))

    report(experiment, 0, len(models))
    try:
        results = simulate_experiment(design, experiment, tuple(models), moving_mass(design, None), advance)
    except SimulationError as failure:
        raise InputError(str(failure)) from None
    tables = tables_of(experiment, results)
    document = features_of({experiment: results})
    return {"experiment": experiment, "document": document, "curves": _curves(tables, f"{experiment}_", Path(folder))}


def _stage(design: Design, experiment: str, folder: Path, report: Report) -> dict[str, Any]:
    """One study of the driven stage, its cases side by side."""
    from sim.experiments.stage import STUDIES, stage_drive
    from stagecad.parallel import fork_map
    from stagecad.solids.assembly.machine import body_masses
    from workbench.simulation.experiments import features_of
    from workbench.simulation.tables import stage_tables

    study = experiment.removeprefix(STAGE)

    def run_cases(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
        done = 0

        def advance(case: Any) -> None:
            nonlocal done
            done += 1
            report(study, done, len(cases))

        report(study, 0, len(cases))
        return fork_map(function, cases, progress=advance)

    found = {study: STUDIES[study](stage_drive(design, body_masses(design)), run_cases)}
    curves = _curves(stage_tables(found), f"stage_{study}_", folder)
    return {"experiment": experiment, "document": {experiment: features_of(found)[study]}, "curves": curves}


def _curves(tables: Mapping[str, Mapping[str, Any]], prefix: str, folder: Path) -> list[dict[str, Any]]:
    return [
        {**write_curves(folder, number, columns), "title": title.removeprefix(prefix)}
        for number, (title, columns) in enumerate(tables.items())
    ]
