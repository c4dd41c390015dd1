"""`stagecad check`: every design check, with value, limit, margin and what would pass."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError
from workbench.options import Run, common_options

if TYPE_CHECKING:
    from designcalc.checks.analysis.sweep import Point, Range
    from designcalc.checks.analysis.tolerance import ToleranceStudy
    from designcalc.checks.check import Check
    from stagecad.parameters.mass_properties import BodyMasses


@click.command("check")
@click.option("--sweep", "swept", metavar="KEY=LOW:HIGH[:N]", help="Show how the margins move over one parameter.")
@click.option("--tolerance", is_flag=True, help="Monte-Carlo over the tolerances of the dimensions.")
@click.option(
    "--samples", type=click.IntRange(100, 1_000_000), default=10_000, show_default=True, help="Of --tolerance."
)
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures", is_flag=True, help="Draw what the checks can show, into the report too.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Send --sweep and --tolerance to a dask cluster.",
)
@common_options
def command(
    run: Run,
    swept: str | None,
    tolerance: bool,
    samples: int,
    solids: bool,
    figures: bool,
    scheduler: str | None,
) -> int:
    """Run every design check on the parameter file; exit status 1 when one fails."""
    from designcalc.checks import run_checks
    from designcalc.checks.analysis.sweep import read_range
    from workbench.report.checks import write_check_files

    if scheduler is not None and swept is None and not tolerance:
        raise InputError("--scheduler: only --sweep and --tolerance have many independent runs")
    design = run.design
    wanted = read_range(swept, design) if swept is not None else None
    masses = weighed_solids(run) if solids else None
    checks = run_checks(design, masses)
    folder = run.out / "checks"
    drawn = draw_figures(run, masses, folder) if figures else {}
    _print(run, checks)
    document: Any = [check.as_json() for check in checks]
    if wanted is not None or tolerance:
        document = {"checks": document}
    if wanted is not None:
        from designcalc.checks.analysis.sweep import table
        from workbench.machine.margins import sweep

        points = sweep(run, wanted, masses is not None, scheduler)
        document["sweep"] = table(wanted, points)
        drawn |= _print_sweep(run, wanted, points, folder)
    if tolerance:
        from workbench.machine.margins import tolerance as tolerance_study

        study = tolerance_study(run, masses, samples, scheduler)
        document["tolerance"] = study.as_json()
        drawn |= _print_tolerance(run, study, folder)
    for path in drawn.values():
        run.say(f"figure {path}")
    write_check_files(checks, design, masses, folder, drawn)
    run.emit(document)
    return 1 if any(check.verdict == "fails" for check in checks) else 0


def weighed_solids(run: Run) -> BodyMasses | None:
    """What the solids weigh, made when missing; None where they cannot be made."""
    from stagecad.solids.assembly.machine import body_masses

    try:
        return body_masses(run.design)
    except ImportError as error:
        run.note(f"no solids can be made here ({error}): masses are estimated from plain volumes")
        return None


def draw_figures(run: Run, masses: BodyMasses | None, folder: Path) -> dict[str, Path]:
    """Every figure of the checks that this design has, by title."""
    from workbench.report.check_figures import FIGURES

    drawn: dict[str, Path] = {}
    for title, (name, draw) in FIGURES.items():
        path = folder / f"{name}.png"
        if draw(run.design, masses, path):
            drawn[title] = path
    return drawn


_STYLE = {"passes": "green", "fails": "bold red", "out_of_range": "yellow", "undecidable": "yellow"}


def _print(run: Run, checks: Sequence[Check]) -> None:
    from rich.table import Table

    from designcalc.checks.analysis.report import counted, shown, shown_limit, shown_margin

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("check", "value", "limit", "margin", "verdict"):
        table.add_column(column, justify="right" if column in ("value", "margin") else "left")
    subject = ""
    for check in checks:
        if check.subject != subject:
            subject = check.subject
            table.add_row(f"[bold]{subject}[/bold]")
        style = _STYLE[check.verdict]
        table.add_row(
            f"  {check.name}",
            shown(check.value, check.unit),
            shown_limit(check),
            shown_margin(check),
            f"[{style}]{check.verdict}[/{style}]",
        )
    run.console.print(table)
    failing = [check for check in checks if check.verdict != "passes"]
    if failing:
        run.console.print("\n[bold]What would pass[/bold]")
    for check in failing:
        run.say(f"- {check.name}: {check.proposal or check.note or 'see the formula'}")
    run.say(f"{counted(checks)}; every formula with its numbers: {run.out / 'checks' / 'checks.html'}")


def _print_sweep(run: Run, wanted: Range, points: Sequence[Point], folder: Path) -> dict[str, Path]:
    from rich.table import Table

    from designcalc.checks.analysis.report import shown, shown_margin
    from designcalc.checks.analysis.sweep import moved

    names = moved(points)
    table = Table(title=f"margins over {wanted.key}", pad_edge=False)
    table.add_column(wanted.key, justify="right", no_wrap=True)
    for name in names[:6]:
        table.add_column(name, justify="right")
    unit = {"mm": "m", "deg": "rad"}.get(wanted.unit, wanted.unit)
    for point in points:
        found = {check.name: check for check in point.checks}
        cells = [shown_margin(found[name]) if name in found else "-" for name in names[:6]]
        table.add_row(shown(point.value, unit), *cells)
    run.console.print(table)
    for point in points:
        if point.refused:
            run.say(f"- {shown(point.value, unit)}: {point.refused}")
    if not names:
        run.say(f"no margin moves with {wanted.key}")
        return {}
    from workbench.report.check_figures import sweep_figure

    path = folder / f"sweep_{wanted.key.replace('.', '_')}.png"
    sweep_figure(wanted, points, names[:8], path)
    return {f"margins over {wanted.key}": path}


def _print_tolerance(run: Run, study: ToleranceStudy, folder: Path) -> dict[str, Path]:
    from rich.table import Table

    from workbench.report.check_figures import tolerance_figure

    table = Table(title=f"margins of {study.samples} machines", pad_edge=False)
    for column in ("check", "nominal", "5 %", "95 %", "failing", "moved most by"):
        table.add_column(column, justify="left" if column in ("check", "moved most by") else "right")
    for spread in sorted(study.spreads, key=lambda s: s.low - s.high):
        if spread.leading and spread.high - spread.low > 1e-4:
            numbers = [f"{100 * value:+.2f} %" for value in (spread.nominal, spread.low, spread.high)]
            table.add_row(spread.name, *numbers, f"{100 * spread.failing:.1f} %", spread.leading)
    run.console.print(table)
    for title, items in (("matter most", study.matter_most), ("could be loosened", study.could_be_loosened)):
        listed = "; ".join(f"{i.key} ({i.tolerance}: {100 * i.share:.2g} % of a margin, {i.check})" for i in items)
        run.say(f"{title}: {listed}")
    run.say("(as far as the checks know: what a fit or the assembly needs may be closer)")
    path = folder / "tolerance.png"
    tolerance_figure(study, path)
    return {"what the tolerances use up": path}
