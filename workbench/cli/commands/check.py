"""`stagecad check`: every design check, with value, limit, margin and what would pass."""

from pathlib import Path
from typing import Any

import click

from designcalc.checks.analysis.report import counted
from stagecad.parameters.errors import InputError
from workbench.cli.console import show
from workbench.cli.options import Run, common_options
from workbench.figures.plot import save
from workbench.operations.checks import Checks, chains, checks, ranges_of, sweep, tolerances, trust_checks
from workbench.report.checks import write_check_files
from workbench.report.stored_results import figures_of


@click.command("check")
@click.option(
    "--sweep",
    "swept",
    multiple=True,
    metavar="KEY=LOW:HIGH[:N]",
    help="Show the margins over a range of a parameter; several parameters form a grid.",
)
@click.option("--chains", is_flag=True, help="Show the tolerance chains, by worst case and statistically.")
@click.option("--tolerance", is_flag=True, help="Monte-Carlo over the tolerances of the dimensions.")
@click.option(
    "--samples",
    type=click.IntRange(100, 1_000_000),
    default=10_000,
    show_default=True,
    help="Number of samples of --tolerance.",
)
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures", is_flag=True, help="Draw the figures of the checks, into the report too.")
@click.option("--scheduler", metavar="ADDRESS", help="Send --sweep and --tolerance to a dask cluster.")
@click.option("--trust", is_flag=True, help="Consent to run the files of the folder checks as they are now.")
@common_options
def command(run: Run, **given: Any) -> int:
    """Run every design check on the parameter file; exit status 1 when one fails."""
    if given["scheduler"] is not None and not given["swept"] and not given["tolerance"]:
        raise InputError("--scheduler: only --sweep and --tolerance have many independent runs")
    if given["trust"]:
        trust(run)
    ranges = ranges_of(run.design, given["swept"])
    result = checks(run.design, given["solids"])
    folder = run.out / "checks"
    show(run, result.lines())
    run.echo(f"{counted(result.checks)}; every formula with its numbers: {folder / 'checks.html'}")
    drawn = _figures(result, folder) if given["figures"] else {}
    document: dict[str, Any] = {"checks": result.to_json()}
    studies = dict(_studies(run, result, ranges, given))
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


def _studies(run: Run, result: Checks, ranges: Any, given: dict[str, Any]) -> Any:
    """The studies that are asked for, by their key in the document."""
    if given["chains"]:
        yield "chains", chains(run.design)
    if ranges:
        with run.reporting() as report:
            study = sweep(run.design, ranges, result.masses is not None, given["scheduler"], report)
            yield study.name, study
    if given["tolerance"]:
        with run.reporting() as report:
            yield "tolerance", tolerances(run.design, result.masses, given["samples"], given["scheduler"], report)


def _figures(result: Checks, folder: Path) -> dict[str, Path]:
    """Every figure of the checks that this design has, by title."""
    drawn: dict[str, Path] = {}
    for title, (name, draw) in figures_of(result.design.values).items():
        figure = draw(result.design.values, result.masses)
        if figure is not None:
            drawn[title] = folder / f"{name}.png"
            save(figure, drawn[title])
    return drawn


def trust(run: Run) -> None:
    """Consent to run the user's own checks as they are now, and name them."""
    for name in trust_checks(run.design):
        run.note(f"trusted as it is now: {name}")
