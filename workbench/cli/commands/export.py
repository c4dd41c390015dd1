"""`stagecad export`: the fitted model of an experiment for use elsewhere."""

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("export")
@click.option("--to", "language", required=True, help="python, c, modelica, fmu, matlab or table.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, language: str) -> None:
    """Fit the model of EXPERIMENT (a folder or its experiment.toml) as it stands, and write it in another language."""
    from workbench.operations.measurement.export import export

    with run.busy("fitting the model as it stands"):
        result = export(experiment, language, run.out, run.design)
    for line in result.lines():
        run.echo(line)
    run.emit(result.to_json())
