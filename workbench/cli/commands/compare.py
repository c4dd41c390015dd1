"""`stagecad compare`: fits the model as it stands; shows its error over noise, and on what the residual depends."""

from pathlib import Path

import click

from stagecad.parameters.errors import require
from workbench.cli.options import Run, common_options, experiment_options, whole_number

BOOTSTRAP = "Number of refits to records with resampled errors; their intervals stand beside the linear ones."


@click.command("compare")
@click.option("--figures/--no-figures", default=True, help="Draw the figures and the HTML report into OUT.")
@whole_number("--bootstrap", 20, 100_000, None, BOOTSTRAP, "DRAWS")
@whole_number("--seed", 0, None, 1, "Seed of the random numbers.")
@click.option("--scheduler", default=None, metavar="ADDRESS", help="Send the refits of --bootstrap to a cluster.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool, bootstrap: int | None, seed: int, scheduler: str | None) -> None:
    """Fit the model of EXPERIMENT (a folder or its experiment.toml) as it stands; show on what its residual depends."""
    require(scheduler is None or bootstrap is not None, "--scheduler: only --bootstrap has many independent runs")
    from workbench.cli.console import show
    from workbench.operations.measurement.compare import compare

    with run.busy("fitting the model as it stands"):
        comparison = compare(experiment, run.design)
    document = comparison.document
    show(run, comparison.lines())
    if bootstrap is not None:
        with run.reporting("refits") as progress:
            refits = comparison.bootstrap(bootstrap, seed, scheduler, progress)
        document = refits.document
        show(run, [refits.table()])
        if figures:
            run.echo(f"figure: {refits.write_figure(run.out)}")
    if figures:
        run.echo(f"report: {comparison.write_report(run.out)}")
    run.emit(document)
