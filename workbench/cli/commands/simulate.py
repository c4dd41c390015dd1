"""`stagecad simulate`: the thesis's experiments, the driven stage, and records of the model of an EXPERIMENT."""

from pathlib import Path
from typing import Any

import click

from sim.stage.studies import ON_REQUEST, STUDY_NAMES
from stagecad.parameters.errors import InputError
from workbench.cli.options import FILE, Run, common_options, consent, trust_option, whole_number

NAMES = "[EXPERIMENT | tip presliding hysteresis stick-slip stage passivity limit-cycles]"
STUDY = f"Study of the stage; may be repeated (default: {', '.join(STUDY_NAMES)}; further: {', '.join(ON_REQUEST)})."
MODEL = "Friction model; may be repeated (default: all)."
DRAWS = "Number of machines to simulate, sampled from the deviations (+-) and tolerances of the parameters."
MOTION = "Simulate EXPERIMENT on the inputs in this file (CSV, Parquet, MAT) instead of its own."
SWEEP = "Show the features of the results over a range of a parameter."
SCHEDULER = "Send the many runs of stage, --sweep or --draws to a cluster."
KINDS = click.Choice(["csv", "parquet", "both", "none"])


@click.command("simulate")
@click.argument("names", nargs=-1, metavar=NAMES)
@click.option("--mass", metavar="QUANTITY|design", help="Moving mass (default: the thesis's 1 kg).")
@click.option("--model", "models", multiple=True, metavar="NAME", help=MODEL)
@click.option("--study", "studies", multiple=True, metavar="NAME", help=STUDY)
@click.option("--sweep", "swept", metavar="KEY=LOW:HIGH[:N]", help=SWEEP)
@whole_number("--draws", 2, 1_000_000, None, DRAWS)
@whole_number("--seed", 0, None, 1, "Seed of the random numbers of --draws and of the noise.")
@click.option("--motion", type=FILE, metavar="FILE", help=MOTION)
@trust_option
@click.option("--noise/--no-noise", default=True, help="Add the noise of each channel to the records of EXPERIMENT.")
@click.option("--scheduler", metavar="ADDRESS", help=SCHEDULER)
@click.option("--format", "kinds", type=KINDS, default="csv", show_default=True, help="Format of the data.")
@click.option("--figures/--no-figures", default=True, help="Draw the figures.")
@common_options
def command(run: Run, names: tuple[str, ...], **options: Any) -> None:
    """Simulate the thesis's experiments and the driven stage; data and figures go to OUT/simulate.

    Without a name: tip, presliding, hysteresis, stick-slip, stage. `passivity` audits the energy of the friction
    models; `limit-cycles` shows stick-slip over speed and stiffness. EXPERIMENT, a folder or its experiment.toml: its
    model is simulated on its inputs, and records with noise are written with an experiment.toml to OUT/simulate/NAME.
    """
    from workbench.cli.console import show
    from workbench.operations.simulation.simulate import EXPERIMENTS, EXTRA, read_selection, simulate_into
    from workbench.operations.simulation.study import Runs

    kinds, motion, noise, trust = (options.pop(name) for name in ("kinds", "motion", "noise", "trust"))
    formats = {"both": ("csv", "parquet"), "none": ()}.get(kinds, (kinds,))
    # A name of the thesis's experiments is not that of a folder.
    others = [name for name in names if name not in (*EXPERIMENTS, *EXTRA)]
    if any(name.endswith(".toml") or "/" in name or "\\" in name or Path(name).is_dir() for name in others):
        _refuse(names, options)
        if trust:
            consent(run, Path(names[0]))
        seed = options["seed"] if noise else None
        with run.busy("fitting the model where it has no values"):
            simulated = simulate_into(run.out, Path(names[0]), run.design, motion, seed, formats)
        show(run, simulated.lines())
        run.emit(simulated.to_json())
        return
    if motion is not None or not noise or trust:
        option = "motion" if motion else "trust" if trust else "no-noise"
        raise InputError(f"--{option}: only for an EXPERIMENT; name its folder")
    figures, seed = options.pop("figures"), options.pop("seed")
    runs, folder = Runs(read_selection(names, **options), not names, seed, options), run.out / "simulate"
    with run.reporting() as steps:
        lines, document, files = runs.simulate(run.design, folder, formats, figures, steps)
    show(run, lines)
    run.echo(f"{files} in {folder}")
    run.emit(document)


def _refuse(names: tuple[str, ...], options: dict[str, Any]) -> None:
    """Refuse what an EXPERIMENT does not have."""
    if len(names) != 1:
        raise InputError(f"{' '.join(names)}: one EXPERIMENT at a time, without other names")
    for option in ("mass", "models", "studies", "swept", "draws", "scheduler"):
        if options[option]:
            flag = {"models": "model", "studies": "study", "swept": "sweep"}.get(option, option)
            raise InputError(f"--{flag}: not for an EXPERIMENT, whose model is in its experiment.toml")
