"""`stagecad ladder`: the error after each effect added so far, as a table and a figure."""

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("ladder")
@click.option("--figures/--no-figures", default=True, help="Draw the figure into OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Show the error after each effect added so far to the model of EXPERIMENT."""
    from workbench.cli.console import show
    from workbench.operations.measurement.add import ladder

    grown = ladder(experiment, run.design)
    show(run, grown.lines())
    if grown.rungs and figures:
        run.echo(f"figure: {grown.write_report(run.out)}")
    run.emit(grown.to_json())
