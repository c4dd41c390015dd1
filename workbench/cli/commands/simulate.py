"""`stagecad simulate`: the thesis's experiments, the driven stage, and records of the model of an EXPERIMENT."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import click

from sim.stage.studies import STUDY_NAMES
from stagecad.parameters.errors import InputError, nearest
from workbench.cli.options import Run, common_options, consent, trust_option
from workbench.simulation.experiments import (
    EXPERIMENTS,
    EXTRA,
    Selection,
    features_of,
    friction_of,
    moving_mass,
    parse_mass,
    simulate_experiment,
)

NAMES = (*EXPERIMENTS, *EXTRA)


@dataclass(frozen=True)
class Options:
    """The options of the command besides the common ones."""

    mass: str | None
    models: tuple[str, ...]
    studies: tuple[str, ...]
    swept: str | None
    draws: int | None
    seed: int
    scheduler: str | None
    kinds: str
    figures: bool
    motion: Path | None
    noise: bool
    trust: bool

    @property
    def formats(self) -> tuple[str, ...]:
        """Formats of the data files."""
        return {"both": ("csv", "parquet"), "none": ()}.get(self.kinds, (self.kinds,))


@dataclass
class Output:
    """Folder and formats of the files, and the files written so far."""

    folder: Path
    formats: tuple[str, ...]
    figures: bool
    written: list[Path] = field(default_factory=list)

    def write(self, tables: dict[str, dict[str, Any]]) -> None:
        """Write tables, by the name of their file, in the formats wanted."""
        from workbench.simulation.tables import write_table

        for name, columns in tables.items():
            self.written += write_table(self.folder / name, columns, self.formats)


@click.command("simulate")
@click.argument("names", nargs=-1, metavar="[EXPERIMENT | tip presliding hysteresis stick-slip stage passivity]")
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
    "--sweep",
    "swept",
    default=None,
    metavar="KEY=LOW:HIGH[:N]",
    help="Show the features of the results over a range of a parameter.",
)
@click.option(
    "--draws",
    type=click.IntRange(2, 1_000_000),
    default=None,
    help="Number of machines to simulate, sampled from the deviations (+-) and tolerances of the parameters.",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the random numbers of --draws and of the noise.",
)
@click.option(
    "--motion",
    type=click.Path(path_type=Path),
    default=None,
    metavar="FILE",
    help="Simulate EXPERIMENT on the inputs in this file (CSV, Parquet, MAT) instead of its own.",
)
@trust_option
@click.option("--noise/--no-noise", default=True, help="Add the noise of each channel to the records of EXPERIMENT.")
@click.option(
    "--scheduler", default=None, metavar="ADDRESS", help="Send the many runs of stage, --sweep or --draws to a cluster."
)
@click.option(
    "--format",
    "kinds",
    type=click.Choice(["csv", "parquet", "both", "none"]),
    default="csv",
    show_default=True,
    help="Format of the data.",
)
@click.option("--figures/--no-figures", default=True, help="Draw the figures.")
@common_options
def command(run: Run, names: tuple[str, ...], **given: Any) -> None:
    """Simulate the thesis's experiments and the driven stage; data and figures go to OUT/simulate.

    Without a name: tip, presliding, hysteresis, stick-slip, stage. `passivity` audits the energy of the friction
    models. EXPERIMENT, a folder or its experiment.toml: its model is simulated on its inputs, and records with noise
    are written with an experiment.toml to OUT/simulate/NAME.
    """
    options = Options(**given)
    if any(_is_experiment(name) for name in names):
        _simulate_records(run, names, options)
        return
    if options.motion is not None or not options.noise or options.trust:
        option = "motion" if options.motion else "trust" if options.trust else "no-noise"
        raise InputError(f"--{option}: only for an EXPERIMENT; name its folder")
    selection = _selection(names, options)
    output = Output(run.out / "simulate", options.formats, options.figures)
    if options.swept is not None:
        _sweep(run, options, selection, output)
    elif options.draws is not None:
        if not names:
            selection = replace(selection, names=EXPERIMENTS[:-1])
        _monte_carlo(run, options, selection, output)
    else:
        _simulate(run, selection, options.scheduler, output)


def _is_experiment(name: str) -> bool:
    """Whether a name is that of an experiment's folder or file, and not of one of the thesis's experiments."""
    return name not in NAMES and (name.endswith(".toml") or "/" in name or "\\" in name or Path(name).is_dir())


def _simulate_records(run: Run, names: tuple[str, ...], options: Options) -> None:
    """Records of the model of an experiment, and their experiment.toml."""
    from workbench.console.simulation import print_simulated_records
    from workbench.simulation.records import write_simulated_records

    if len(names) != 1:
        raise InputError(f"{' '.join(names)}: one EXPERIMENT at a time, without other names")
    foreign = {"mass": options.mass, "model": options.models, "study": options.studies, "sweep": options.swept}
    for option, value in {**foreign, "draws": options.draws, "scheduler": options.scheduler}.items():
        if value:
            raise InputError(f"--{option}: not for an EXPERIMENT, whose model is in its experiment.toml")
    if options.trust:
        consent(run, Path(names[0]))
    seed = options.seed if options.noise else None
    document = write_simulated_records(run, Path(names[0]), options.motion, seed, options.formats)
    print_simulated_records(run, document)
    run.emit(document)


def _selection(names: tuple[str, ...], options: Options) -> Selection:
    """The selected simulations.

    Raises:
        InputError: an unknown name, or options that do not go together.
    """
    from sim.experiments.friction_models import MODELS

    for given, known, text in (
        (names, NAMES, "no experiment '{}'"),
        (options.models, MODELS, "--model {}: no such friction model"),
        (options.studies, STUDY_NAMES, "--study {}: no such study of the stage"),
    ):
        for name in given:
            if name not in known:
                raise InputError(text.format(name) + nearest(name, known))
    if options.mass is not None and options.mass != "design":
        parse_mass(options.mass)
    chosen = tuple(name for name in NAMES if name in names) if names else EXPERIMENTS
    if options.studies and "stage" not in chosen:
        raise InputError("--study: only the experiment 'stage' has studies; name it")
    if options.scheduler is not None and "stage" not in chosen and options.swept is None and options.draws is None:
        raise InputError("--scheduler: only 'stage', --sweep and --draws have many independent runs")
    if options.swept is not None and options.draws is not None:
        raise InputError("--sweep and --draws: one or the other")
    models = tuple(model for model in MODELS if not options.models or model in options.models)
    studies = tuple(study for study in STUDY_NAMES if not options.studies or study in options.studies)
    return Selection(chosen, models, options.mass, studies)


def _simulate(run: Run, selection: Selection, scheduler: str | None, output: Output) -> None:
    """The selected experiments at the design's own values."""
    from sim.integration.simulate import SimulationError
    from workbench.console.simulation import print_features

    mass = moving_mass(run.design.values, selection.mass) if selection.friction_experiments else 1.0
    if selection.friction_experiments:
        run.echo(f"mass {mass:.6g} kg")
    document: dict[str, Any] = {}
    output.folder.mkdir(parents=True, exist_ok=True)
    runs = sum(1 if name == "tip" else len(selection.models) for name in selection.names if name != "stage")
    try:
        with run.progress() as progress:
            task = progress.add_task("simulations", total=runs)
            for name in selection.names:
                progress.update(task, description=name)
                if name == "stage":
                    document[name] = _stage(run, selection, scheduler, output, progress)
                else:
                    document[name] = _experiment(
                        run, name, selection.models, mass, output, lambda: progress.advance(task)
                    )
    except SimulationError as failure:
        raise InputError(str(failure)) from None
    for name, features in document.items():
        print_features(run, name, features)
    run.echo(f"{len(output.written)} files in {output.folder}")
    run.emit(document)


def _experiment(
    run: Run, name: str, models: tuple[str, ...], mass: float, output: Output, advance: Callable[[], None]
) -> dict[str, Any]:
    """Simulate an experiment, write its tables and figures; its features."""
    from workbench.simulation.figures import FIGURES
    from workbench.simulation.tables import tables_of

    if name == "passivity":
        from sim.experiments.passivity import passive_below

        below = passive_below(friction_of(run.design.values))
        run.echo(f"lugre is passive at any stretch below 4 Fc/a1 = {below * 1e3:.2f} mm/s")
    results = simulate_experiment(run.design.values, name, models, mass, advance)
    if output.formats:
        output.write(tables_of(name, results))
    if output.figures:
        output.written += FIGURES[name](output.folder, results)
    return features_of(results)


def _stage(run: Run, selection: Selection, scheduler: str | None, output: Output, progress: Any) -> dict[str, Any]:
    """Run the studies of the stage, write their tables and figures; their features."""
    from sim.friction_stage.studies import STUDIES, stage_drive
    from stagecad.friction_stage.assembly.machine import body_masses
    from stagecad.processes import fork_map, parallel_map

    drive = stage_drive(run.design.values, body_masses(run.design.values))
    # A forked process has the compiled kernels; a new one would load them, for each study.
    forking = scheduler is None and sys.platform == "linux"
    map_cases: Callable[..., list[Any]] = fork_map if forking else partial(parallel_map, scheduler=scheduler)
    found = {}
    for study in selection.studies:
        task = progress.add_task(f"stage: {study.replace('_', ' ')}", total=None)

        def run_cases(function: Callable[[Any], Any], cases: Sequence[Any], task: Any = task) -> list[Any]:
            progress.update(task, total=len(cases))
            advance = partial(progress.update, task, advance=1)
            return map_cases(function, cases, progress=lambda case: advance())

        found[study] = STUDIES[study](drive, run_cases)
    if output.formats:
        from workbench.simulation.tables import stage_tables

        output.write(stage_tables(found))
    if output.figures:
        from workbench.simulation.stage_figures import draw_stage

        output.written += draw_stage(output.folder, found)
    return features_of(found)


def _sweep(run: Run, options: Options, selection: Selection, output: Output) -> None:
    """Features at every value of a range; the table is written to OUT/simulate/sweep."""
    from designcalc.checks.analysis.sweep import read_range
    from workbench.simulation.sweep import sweep, sweep_columns, sweep_document

    assert options.swept is not None
    swept = read_range(options.swept, run.design.values)
    points = sweep(run, swept, selection, options.scheduler)
    if all(isinstance(point, str) for point in points):
        raise InputError(f"--sweep {swept.key}: every value is refused: {points[0]}")
    columns = sweep_columns(swept, points)
    output.write({"sweep": columns})
    for value, point in zip(swept.values, points):
        if isinstance(point, str):
            run.note(f"{swept.key} = {value:g} {swept.unit}: {point}")
    counts = f"{len(points)} values of {swept.key}, {len(columns) - 1} features each"
    run.echo(f"{counts}; {len(output.written)} files in {output.folder}")
    run.emit({"sweep": sweep_document(swept, points)})


def _monte_carlo(run: Run, options: Options, selection: Selection, output: Output) -> None:
    """Simulate sampled machines; a row for each is written to OUT/simulate/draws."""
    from workbench.console.simulation import print_monte_carlo
    from workbench.simulation.monte_carlo import run_monte_carlo

    assert options.draws is not None
    study = run_monte_carlo(run, selection, options.draws, options.seed, options.scheduler)
    output.write({"draws": study.columns()})
    if output.figures:
        from workbench.simulation.monte_carlo_figures import draw_study

        output.written += draw_study(output.folder, study)
    print_monte_carlo(run, study)
    run.echo(f"{len(output.written)} files in {output.folder}")
    run.emit(study.as_json(options.seed))
