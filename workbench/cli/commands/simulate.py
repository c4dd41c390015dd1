"""`stagecad simulate`: the thesis's experiments, the driven stage, and records of the model of an EXPERIMENT."""

from typing import Any

import click

from sim.stage.studies import ON_REQUEST, STUDY_NAMES
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
    from workbench.operations.simulation.simulate import named_experiment, simulate_into
    from workbench.operations.simulation.study import simulate_selected

    kinds, motion, noise, trust = (options.pop(name) for name in ("kinds", "motion", "noise", "trust"))
    formats = {"both": ("csv", "parquet"), "none": ()}.get(kinds, (kinds,))
    experiment = named_experiment(names, options, {"motion": motion, "trust": trust, "no-noise": not noise})
    if experiment is not None:
        if trust:
            consent(run, experiment)
        seed = options["seed"] if noise else None
        with run.busy("fitting the model where it has no values"):
            simulated = simulate_into(run.out, experiment, run.design, motion, seed, formats)
        lines, document = simulated.lines(), simulated.to_json()
    else:
        with run.reporting() as steps:
            lines, document = simulate_selected(run.design, run.out / "simulate", formats, names, options, steps)
    show(run, lines)
    run.emit(document)
