"""`stagecad simulate`: the thesis's experiments, the driven stage, and records of the model of an EXPERIMENT."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from sim.stage.studies import ON_REQUEST, STUDY_NAMES
from stagecad.parameters.errors import InputError
from workbench.cli.options import FILE, Run, common_options, consent, trust_option


@click.command("simulate")
@click.argument(
    "names", nargs=-1, metavar="[EXPERIMENT | tip presliding hysteresis stick-slip stage passivity limit-cycles]"
)
@click.option("--mass", default=None, metavar="QUANTITY|design", help="Moving mass (default: the thesis's 1 kg).")
@click.option(
    "--model", "models", multiple=True, metavar="NAME", help="Friction model; may be repeated (default: all)."
)
@click.option(
    "--study",
    "studies",
    multiple=True,
    metavar="NAME",
    help=f"Study of the stage; may be repeated (default: {', '.join(STUDY_NAMES)}; further: {', '.join(ON_REQUEST)}).",
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
    type=FILE,
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
def command(run: Run, names: tuple[str, ...], **options: Any) -> None:
    """Simulate the thesis's experiments and the driven stage; data and figures go to OUT/simulate.

    Without a name: tip, presliding, hysteresis, stick-slip, stage. `passivity` audits the energy of the friction
    models; `limit-cycles` shows stick-slip over speed and stiffness. EXPERIMENT, a folder or its experiment.toml: its
    model is simulated on its inputs, and records with noise are written with an experiment.toml to OUT/simulate/NAME.
    """
    from workbench.operations.simulation.simulate import EXPERIMENTS, EXTRA

    # A name of the thesis's experiments is not that of a folder.
    others = [name for name in names if name not in (*EXPERIMENTS, *EXTRA)]
    if any(name.endswith(".toml") or "/" in name or "\\" in name or Path(name).is_dir() for name in others):
        _simulate_records(run, names, options)
        return
    if options["motion"] is not None or not options["noise"] or options["trust"]:
        option = "motion" if options["motion"] else "trust" if options["trust"] else "no-noise"
        raise InputError(f"--{option}: only for an EXPERIMENT; name its folder")
    _simulate(run, names, options)


def _formats(options: dict[str, Any]) -> tuple[str, ...]:
    return {"both": ("csv", "parquet"), "none": ()}.get(options["kinds"], (options["kinds"],))


def _simulate_records(run: Run, names: tuple[str, ...], options: dict[str, Any]) -> None:
    """Records of the model of an experiment, and their experiment.toml."""
    from workbench.cli.console import show
    from workbench.operations.simulation.simulate import simulate_into

    if len(names) != 1:
        raise InputError(f"{' '.join(names)}: one EXPERIMENT at a time, without other names")
    foreign = {"mass": "mass", "model": "models", "study": "studies", "sweep": "swept"}
    for option, name in {**foreign, "draws": "draws", "scheduler": "scheduler"}.items():
        if options[name]:
            raise InputError(f"--{option}: not for an EXPERIMENT, whose model is in its experiment.toml")
    if options["trust"]:
        consent(run, Path(names[0]))
    seed = options["seed"] if options["noise"] else None
    with run.busy("fitting the model where it has no values"):
        simulated = simulate_into(run.out, Path(names[0]), run.design, options["motion"], seed, _formats(options))
    show(run, simulated.lines())
    run.emit(simulated.to_json())


def _simulate(run: Run, names: tuple[str, ...], options: dict[str, Any]) -> None:
    """The selected experiments: at the design's own values, over a range of a parameter, or of sampled machines."""
    from designcalc.checks.analysis.sweep import read_range
    from workbench.cli.console import show
    from workbench.operations.simulation import study as simulation_study
    from workbench.operations.simulation.simulate import EXPERIMENTS, read_selection, simulate_one

    given = {name: options[name] for name in ("models", "mass", "studies", "scheduler", "swept", "draws")}
    selection = read_selection(names, **given)
    folder, formats, scheduler = run.out / "simulate", _formats(options), options["scheduler"]
    with run.reporting() as steps:
        if options["swept"] is not None:
            swept = read_range(options["swept"], run.design.values)
            sweep = simulation_study.sweep(run.design, swept, selection, scheduler, steps)
            lines, document, files = list(sweep.lines()), {"sweep": sweep.to_json()}, sweep.write(folder, formats)
            summary = f"{len(sweep.points)} values of {swept.key}, {len(sweep.columns) - 1} features each; "
        elif options["draws"] is not None:
            chosen = selection if names else replace(selection, names=EXPERIMENTS[:-1])
            count, seed = options["draws"], options["seed"]
            study = simulation_study.run_monte_carlo(run.design, chosen, count, seed, scheduler, steps)
            lines, document = list(study.lines()), study.to_json()
            files, summary = study.write(folder, formats, options["figures"]), ""
        else:
            lines, document, files, summary = selection.remarks(run.design.values), {}, [], ""
            show(run, lines)
            lines = []
            folder.mkdir(parents=True, exist_ok=True)
            for name in selection.names:
                simulation = simulate_one(name, run.design.values, selection, scheduler, steps)
                files += simulation.write(folder, formats, options["figures"])
                lines += simulation.lines()
                document |= simulation.to_json()
    show(run, lines)
    run.echo(f"{summary}{len(files)} files in {folder}")
    run.emit(document)
