"""`stagecad make`: all results of the parameter file, and one HTML report; results with unchanged inputs are kept."""

import click

from workbench.cli.options import Run, common_options, design_trust
from workbench.report.make import make


@click.command("make")
@click.option("--simulations/--no-simulations", default=True, help="Run the thesis's friction experiments too.")
@design_trust("the folder checks")
@common_options
def command(run: Run, simulations: bool) -> None:
    """Make everything from the parameter file: parts, assembly, drawings, list of parts, checks, simulations, report.

    Exit status 0 once all is built, whatever the verdicts of the checks.
    """
    run.emit(make(run.design, run.out, simulations, run.reporting, run.echo))
