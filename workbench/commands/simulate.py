"""`stagecad simulate`: the thesis's experiments and the driven stage, with data, features and figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from sim.stage.studies import STUDY_NAMES
from stagecad.parameters.errors import InputError, nearest
from workbench.options import Run, common_options
from workbench.simulation.inputs import mass_given, moving_mass
from workbench.simulation.jobs import Job, features_document
from workbench.simulation.sweep import Wanted

EXPERIMENTS = ("tip", "presliding", "hysteresis", "stick-slip", "stage")
EXTRA = ("passivity",)
"""Run only when named."""


@click.command("simulate")
@click.argument("names", nargs=-1, metavar="[tip] [presliding] [hysteresis] [stick-slip] [stage] [passivity]")
@click.option("--mass", default=None, metavar="QUANTITY|design", help="Moving mass (default: the thesis's 1 kg).")
@click.option(
    "--model", "models", multiple=True, metavar="NAME", help="Friction model; may be repeated (default: all)."
)
@click.option(
    "--study",
    "studies",
    multiple=True,
    metavar="NAME",
    help=f"Study of the stage; may be repeated (default: all of {', '.join(STUDY_NAMES)}).",
)
@click.option(
    "--sweep", "swept", default=None, metavar="KEY=LOW:HIGH[:N]", help="Features over the values of a parameter."
)
@click.option(
    "--draws",
    type=click.IntRange(2, 1_000_000),
    default=None,
    help="Simulate so many machines drawn from the deviations (+-) and tolerances of the parameters.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Of the random numbers of --draws.")
@click.option(
    "--scheduler", default=None, metavar="ADDRESS", help="Send the many runs of stage, --sweep or --draws to a cluster."
)
@click.option(
    "--format",
    "kinds",
    type=click.Choice(["csv", "parquet", "both", "none"]),
    default="csv",
    show_default=True,
    help="Form of the data.",
)
@click.option("--figures/--no-figures", default=True, help="Draw the figures.")
@common_options
def command(
    run: Run,
    names: tuple[str, ...],
    mass: str | None,
    models: tuple[str, ...],
    studies: tuple[str, ...],
    swept: str | None,
    draws: int | None,
    seed: int,
    scheduler: str | None,
    kinds: str,
    figures: bool,
) -> None:
    """Simulate the thesis's experiments and the driven stage; data and figures go to OUT/simulate.

    Without a name: tip, presliding, hysteresis, stick-slip, stage. `passivity` audits the energy of the friction
    models.
    """
    from sim.experiments.friction_models import MODELS
    from sim.integration.simulate import SimulationError

    for name in names:
        if name not in (*EXPERIMENTS, *EXTRA):
            raise InputError(f"no experiment '{name}'{nearest(name, (*EXPERIMENTS, *EXTRA))}")
    for model in models:
        if model not in MODELS:
            raise InputError(f"--model {model}: no such friction model{nearest(model, MODELS)}")
    for study in studies:
        if study not in STUDY_NAMES:
            raise InputError(f"--study {study}: no such study of the stage{nearest(study, STUDY_NAMES)}")
    if mass is not None and mass != "design":
        mass_given(mass)
    wanted = tuple(name for name in (*EXPERIMENTS, *EXTRA) if name in names) if names else EXPERIMENTS
    if studies and "stage" not in wanted:
        raise InputError("--study: only the experiment 'stage' has studies; name it")
    if scheduler is not None and "stage" not in wanted and swept is None and draws is None:
        raise InputError("--scheduler: only 'stage', --sweep and --draws have many independent runs")
    if swept is not None and draws is not None:
        raise InputError("--sweep and --draws: one or the other")
    folder = run.out / "simulate"
    chosen_models = tuple(m for m in MODELS if not models or m in models)
    chosen_studies = tuple(study for study in STUDY_NAMES if not studies or study in studies)
    forms = {"both": ("csv", "parquet"), "none": ()}.get(kinds, (kinds,))
    if swept is not None:
        _sweep(run, swept, Wanted(wanted, chosen_models, mass, chosen_studies), scheduler, folder, forms)
        return
    if draws is not None:
        asked = Wanted(
            names=wanted if names else EXPERIMENTS[:-1], models=chosen_models, mass=mass, studies=chosen_studies
        )
        _draws(run, asked, (draws, seed), scheduler, folder, forms, figures)
        return
    folder.mkdir(parents=True, exist_ok=True)
    job = Job(run, folder, chosen_models, forms, figures)
    frictional = [name for name in wanted if name not in ("tip", "stage")]
    kilograms = moving_mass(run, mass) if frictional else 1.0
    if frictional:
        run.say(f"mass {kilograms:.6g} kg")
    document: dict[str, Any] = {}
    try:
        with run.progress() as progress:
            task = progress.add_task(
                "simulations",
                total=sum(1 if name == "tip" else len(job.models) for name in wanted if name != "stage"),
            )
            job.advance = lambda: progress.advance(task)
            for name in wanted:
                progress.update(task, description=name)
                if name == "stage":
                    document[name] = _stage(run, job, chosen_studies, scheduler, progress)
                else:
                    document[name] = job.run_one(name, kilograms)
    except SimulationError as failure:
        raise InputError(str(failure)) from None
    from workbench.console.simulation import print_features

    for name, models_found in document.items():
        print_features(run, name, models_found)
    run.say(f"{len(job.written)} files in {folder}")
    run.emit(document)


def _stage(run: Run, job: Job, studies: tuple[str, ...], scheduler: str | None, progress: Any) -> dict[str, Any]:
    """The studies of the stage, written and drawn; their features."""
    from sim.experiments.stage import stage_drive
    from stagecad.solids.assembly.machine import body_masses
    from workbench.simulation.stage import run_studies

    drive = stage_drive(run.design, body_masses(run.design))
    task = progress.add_task("stage: cases", total=None)
    found = run_studies(
        drive, studies, scheduler, lambda done, total: progress.update(task, completed=done, total=total)
    )
    if job.forms:
        from workbench.simulation.stage_tables import stage_tables

        for name, columns in stage_tables(found).items():
            job.write(name, columns)
    if job.figures:
        from workbench.simulation.stage_figures import draw_stage

        job.written += draw_stage(job.folder, found)
    return features_document(found)


def _sweep(
    run: Run,
    text: str,
    wanted: Wanted,
    scheduler: str | None,
    folder: Path,
    forms: tuple[str, ...],
) -> None:
    """Features at every value of a range; the table goes to OUT/simulate/sweep."""
    from designcalc.checks.analysis.sweep import read_range
    from workbench.simulation.data import write_table
    from workbench.simulation.sweep import sweep, sweep_columns, sweep_document

    swept = read_range(text, run.design)
    points = sweep(run, swept, wanted, scheduler)
    if all(isinstance(point, str) for point in points):
        raise InputError(f"--sweep {swept.key}: no value stands: {points[0]}")
    folder.mkdir(parents=True, exist_ok=True)
    columns = sweep_columns(swept, points)
    written = write_table(folder / "sweep", columns, forms) if forms else []
    for value, point in zip(swept.values, points):
        if isinstance(point, str):
            run.note(f"{swept.key} = {value:g} {swept.unit}: {point}")
    run.say(f"{len(points)} values of {swept.key}, {len(columns) - 1} features each; {len(written)} files in {folder}")
    run.emit({"sweep": sweep_document(swept, points)})


def _draws(
    run: Run,
    wanted: Wanted,
    drawn: tuple[int, int],
    scheduler: str | None,
    folder: Path,
    forms: tuple[str, ...],
    figures: bool,
) -> None:
    """Simulate drawn machines; a row for each goes to OUT/simulate/draws."""
    from workbench.console.simulation import print_monte_carlo
    from workbench.simulation.data import write_table
    from workbench.simulation.monte_carlo import draw_machines
    from workbench.simulation.monte_carlo_tables import study_columns, study_document

    study = draw_machines(run, wanted, *drawn, scheduler)
    folder.mkdir(parents=True, exist_ok=True)
    written = write_table(folder / "draws", study_columns(study), forms) if forms else []
    if figures:
        from workbench.simulation.monte_carlo_figures import draw_study

        written += draw_study(folder, study)
    print_monte_carlo(run, study)
    run.say(f"{len(written)} files in {folder}")
    run.emit(study_document(study, *drawn))


def simulate_into(
    run: Run, folder: Path, names: Sequence[str], advance: Callable[[str], None] = lambda name: None
) -> list[Path]:
    """Run the named experiments at the design's own values, all models; data and figures go to `folder`.

    `advance` is called with each name as it is done. Returns the files written.
    """
    from sim.experiments.friction_models import MODELS

    folder.mkdir(parents=True, exist_ok=True)
    job = Job(run, folder, tuple(MODELS), ("csv",), figures=True)
    mass = moving_mass(run, None)
    for name in names:
        job.run_one(name, mass)
        advance(name)
    return job.written
