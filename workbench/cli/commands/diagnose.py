"""`stagecad diagnose`: which physical effect is missing, ranked, and which effects are indistinguishable."""

from pathlib import Path

import click

from workbench.cli.options import Run, common_options, experiment_options


@click.command("diagnose")
@click.option("--all-effects", is_flag=True, help="Try every other effect of the library besides the public names.")
@click.option("--figures/--no-figures", default=True, help="Draw the figures and the HTML report into OUT.")
@common_options
@experiment_options
def command(run: Run, experiment: Path, all_effects: bool, figures: bool) -> None:
    """Find which physical effect is missing from the model of EXPERIMENT (a folder or its experiment.toml)."""
    from workbench.cli.console import search_progress, show
    from workbench.operations.measurement.diagnose import diagnose

    with run.progress() as progress:
        diagnosis = diagnose(experiment, all_effects, run.design, search_progress(progress))
    show(run, diagnosis.lines())
    if figures:
        run.echo(f"report: {diagnosis.write_report(run.out)}")
    run.emit(diagnosis.document)
