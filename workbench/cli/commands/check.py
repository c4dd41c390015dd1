"""`stagecad check`: every design check, with value, limit, margin and what would pass."""

from typing import Any

import click

from designcalc.checks.report import counted
from stagecad.parameters.errors import InputError
from workbench.cli.console import show
from workbench.cli.options import Run, common_options, design_trust, whole_number
from workbench.figures.plot import save
from workbench.operations.checks import checks, ranges_of
from workbench.report.machine import write_check_files

SWEEP = "Show the margins over a range of a parameter; several parameters form a grid."


@click.command("check")
@click.option("--sweep", "swept", multiple=True, metavar="KEY=LOW:HIGH[:N]", help=SWEEP)
@click.option("--chains", is_flag=True, help="Show the tolerance chains, by worst case and statistically.")
@click.option("--tolerance", is_flag=True, help="Monte-Carlo over the tolerances of the dimensions.")
@whole_number("--samples", 100, 1_000_000, 10_000, "Number of samples of --tolerance.")
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures", is_flag=True, help="Draw the figures of the checks, into the report too.")
@click.option("--scheduler", metavar="ADDRESS", help="Send --sweep and --tolerance to a dask cluster.")
@design_trust("the folder checks")
@common_options
def command(run: Run, **given: Any) -> int:
    """Run every design check on the parameter file; exit status 1 when one fails."""
    if given["scheduler"] is not None and not given["swept"] and not given["tolerance"]:
        raise InputError("--scheduler: only --sweep and --tolerance have many independent runs")
    ranges = ranges_of(run.design, given["swept"])
    result = checks(run.design, given["solids"])
    folder = run.out / "checks"
    show(run, result.lines())
    run.echo(f"{counted(result.checks)}; every formula with its numbers: {folder / 'checks.html'}")
    drawn = result.write_figures(folder) if given["figures"] else {}
    document: dict[str, Any] = {"checks": result.to_json()}
    samples = given["samples"] if given["tolerance"] else 0
    studies = result.studies(given["chains"], ranges, samples, given["scheduler"], run.reporting)
    for name, study in studies.items():
        show(run, study.lines())
        document[name] = study.to_json()
        if name != "chains" and (figure := study.plot()) is not None:
            drawn[study.title] = folder / study.file
            save(figure, drawn[study.title])
    for path in drawn.values():
        run.echo(f"figure {path}")
    write_check_files(result.checks, run.design.values, result.masses, folder, drawn)
    run.emit(document if studies else document["checks"])
    return 1 if result.failed else 0
