"""`stagecad ladder`: the error after each effect added so far, as a table and a figure."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("ladder")
@click.option("--figures/--no-figures", default=True, help="Draw the figure into OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Show the error after each effect added so far to the model of EXPERIMENT."""
    from sysid.experiment.experiment import load_experiment
    from sysid.ladder import current_ladder
    from workbench.console.tables import rich_table
    from workbench.identification.design_values import design_values
    from workbench.identification.statements import in_command
    from workbench.identification.tables import ladder_table

    found = load_experiment(experiment, design_values(run.design))
    rungs, edited = current_ladder(found)
    if not rungs:
        command = f"stagecad diagnose {in_command(found.folder)}"
        run.echo(f"{found.folder}: nothing added yet; '{command}' finds what is missing")
    else:
        run.console.print(rich_table(ladder_table(rungs)))
        if edited:
            run.note("note: [model] was edited by hand since the last rung")
        if figures:
            from workbench.report.page import write_ladder

            run.echo(f"figure: {write_ladder(run, found.folder.name, rungs)}")
    run.emit(rungs)
