"""`stagecad diagnose`: which physical effect is missing, ranked, and which effects are indistinguishable."""

from __future__ import annotations

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
    from sysid.diagnose import diagnose
    from sysid.report import diagnosis_json
    from workbench.console.identification import print_diagnosis, search_progress
    from workbench.identification.design_values import design_values

    with run.progress() as progress:
        found = diagnose(experiment, all_effects, design_values(run.design), search_progress(progress))
    document = diagnosis_json(found)
    print_diagnosis(run, found, document)
    if figures:
        from workbench.report.page import write_diagnosis

        run.echo(f"report: {write_diagnosis(run, found, document)}")
    run.emit(document)
