"""`stagecad suggest`: the next measurement that would best separate the rivals left."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.options import Run, common_options


@click.command("suggest")
@click.argument("experiment", type=click.Path(path_type=Path))
@click.option("--figures/--no-figures", default=True, help="Add to the HTML report in OUT.")
@common_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Name the motion that would best separate what the records of EXPERIMENT leave open; write it as CSV into OUT."""
    from sysid.experiment_design.t_optimal_design import suggest
    from workbench.console.progress import shown_on
    from workbench.identification.design_values import design_values
    from workbench.report.suggestion import sentences, suggestion_section, suggestion_table, worth_json, write_motions

    with run.progress() as progress:
        found = suggest(experiment, design_values(run), shown_on(progress))
    paths = write_motions(run, found)
    run.console.print(suggestion_table(found))
    for line in sentences(found):
        run.say(line)
    run.say(f"motions to run: {paths[0].parent}")
    if figures:
        from workbench.report.page import write_section

        run.say(f"report: {write_section(run, found.case.experiment.folder.name, suggestion_section(found))}")
    run.emit([worth_json(worth, path) for worth, path in zip(found.motions, paths, strict=True)])
