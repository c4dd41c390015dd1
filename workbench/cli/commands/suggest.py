"""`stagecad suggest`: the next measurement that would best separate the competing effects."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("suggest")
@click.option("--figures/--no-figures", default=True, help="Add to the HTML report in OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Name the motion that would best separate the competing effects of EXPERIMENT; write it as CSV into OUT."""
    from sysid.experiment_design.t_optimal_design import suggest
    from workbench.console.identification import search_progress
    from workbench.console.tables import rich_table
    from workbench.identification.design_values import design_values
    from workbench.identification.statements import suggestion_statements
    from workbench.identification.tables import motion_table
    from workbench.report.page import write_motions, write_suggestion

    with run.progress() as progress:
        found = suggest(experiment, design_values(run.design), search_progress(progress))
    motions = write_motions(run, found)
    run.console.print(rich_table(motion_table(motions)))
    for line in suggestion_statements(found):
        run.echo(line)
    run.echo(f"motions to run: {Path(motions[0]['file']).parent}")
    if figures:
        run.echo(f"report: {write_suggestion(run, found, motions)}")
    run.emit(motions)
