"""`stagecad compare`: fits the model as it stands; shows where it fails, and how far above the noise."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.options import Run, common_options


@click.command("compare")
@click.argument("experiment", type=click.Path(path_type=Path))
@click.option("--figures/--no-figures", default=True, help="Draw the figures and the HTML report into OUT.")
@common_options
def command(run: Run, experiment: Path, figures: bool) -> None:
    """Fit the model of EXPERIMENT (a folder or its experiment.toml) as it stands; show where it fails."""
    from sysid.compare import compare
    from sysid.document import comparison_json
    from workbench.design_values import design_values
    from workbench.loop_text import say_comparison

    found = compare(experiment, design_values(run))
    document = comparison_json(found.case, found.base, found.fit, found.validate, found.maps, found.seconds)
    say_comparison(run, found, document)
    if figures:
        from workbench.loop_report import write_comparison

        run.say(f"report: {write_comparison(run, found, document)}")
    run.emit(document)
