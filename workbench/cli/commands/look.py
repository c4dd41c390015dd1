"""`stagecad look`: all raw channels of an experiment, with what is wrong in them, before any fit."""

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("look")
@click.option("--figures/--no-figures", default=True, help="Draw the channels into OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Show every channel of EXPERIMENT (a folder or its experiment.toml) as it is logged, before any fit."""
    from workbench.figures.plot import save
    from workbench.operations.measurement.experiment import results_key
    from workbench.operations.measurement.look import look

    with run.busy("reading the records"):
        seen = look(experiment, run.design)
    for note in dict.fromkeys(note for record in seen.records for note in record.notes):
        run.note(f"note: {note}")
    for line in seen.lines():
        run.echo(line)
    for warning in seen.warnings:
        run.echo(f"warning: {warning}")
    if not seen.warnings:
        run.echo("nothing is wrong in the rows")
    document = seen.to_json()
    if figures:
        target = run.out / results_key(run.out, seen.experiment.folder) / "look.png"
        save(seen.plot(), target)
        document["figure"] = str(target)
        run.echo(f"figure: {target}")
    run.emit(document)
