"""`stagecad suggest`: the next measurement that would best separate the competing effects."""

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("suggest")
@click.option("--figures/--no-figures", default=True, help="Add to the HTML report in OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Name the motion that would best separate the competing effects of EXPERIMENT; write it as CSV into OUT."""
    from workbench.cli.console import search_progress, show
    from workbench.operations.measurement.suggest import suggest

    with run.progress() as progress:
        suggestion = suggest(experiment, run.design, search_progress(progress)).write_below(run.out)
    show(run, suggestion.lines())
    run.echo(f"motions to run: {Path(suggestion.files[0]).parent}")
    if figures:
        run.echo(f"report: {suggestion.write_report(run.out)}")
    run.emit(suggestion.to_json())
