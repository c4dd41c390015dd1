"""Jobs of the simulation view: the experiments of the thesis at the values of the sliders."""

from pathlib import Path
from typing import Any

from workbench.operations.simulation.simulate import Simulation
from workbench.operations.simulation.simulate import simulate as simulate_design
from workbench.page.curves import write_curves
from workbench.page.job_process import Report
from workbench.page.tasks.machine import design_of

STAGE = "stage-"
"""Begins the name of a study of the driven stage."""


def simulate(
    text: str | None,
    name: str,
    overrides: dict[str, str],
    experiment: str,
    models: list[str],
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """One experiment: the document of `stagecad simulate --json`, and its curves."""
    if experiment.startswith(STAGE):
        study = experiment.removeprefix(STAGE)
        found = simulate_design("stage", design_of(text, name, overrides), studies=[study], progress=report)
        prefix = f"stage_{study}_"
    else:
        design = design_of(text, name, overrides, rules=False)
        found = simulate_design(experiment, design, models, progress=report)
        prefix = f"{experiment}_"
    assert isinstance(found, Simulation)
    curves = [
        {**write_curves(Path(folder), number, columns), "title": title.removeprefix(prefix)}
        for number, (title, columns) in enumerate(found.columns.items())
    ]
    return {"experiment": experiment, "document": found.to_json(), "curves": curves}
