"""`stagecad compare`: fits the model as it stands; shows its error over noise, and on what the residual depends."""

from __future__ import annotations

from pathlib import Path

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options, experiment_options


@click.command("compare")
@click.option("--figures/--no-figures", default=True, help="Draw the figures and the HTML report into OUT.")
@click.option(
    "--bootstrap",
    type=click.IntRange(20, 100_000),
    default=None,
    metavar="DRAWS",
    help="Number of refits to records with resampled errors; their intervals stand beside the linear ones.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of the random numbers.")
@click.option("--scheduler", default=None, metavar="ADDRESS", help="Send the refits of --bootstrap to a cluster.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool, bootstrap: int | None, seed: int, scheduler: str | None) -> None:
    """Fit the model of EXPERIMENT (a folder or its experiment.toml) as it stands; show on what its residual depends."""
    if scheduler is not None and bootstrap is None:
        raise InputError("--scheduler: only --bootstrap has many independent runs")
    from sysid.compare import compare
    from sysid.report import comparison_json
    from workbench.console.identification import print_comparison
    from workbench.identification.design_values import design_values

    with run.busy("fitting the model as it stands"):
        found = compare(experiment, design_values(run.design))
    document = comparison_json(found)
    print_comparison(run, found, document)
    if bootstrap is not None:
        from workbench.console.tables import rich_table
        from workbench.identification.bootstrap import bootstrap_case, bootstrap_json
        from workbench.identification.tables import bootstrap_table

        drawn = bootstrap_case(run, found.problem, found.base.fitted, bootstrap, seed, scheduler)
        document["bootstrap"] = bootstrap_json(found.problem, drawn, seed)
        run.console.print(rich_table(bootstrap_table(document)))
        if figures:
            from workbench.report.page import write_bootstrap

            run.echo(f"figure: {write_bootstrap(run, found.problem, drawn, document)}")
    if figures:
        from workbench.report.page import write_comparison

        run.echo(f"report: {write_comparison(run, found, document)}")
    run.emit(document)
