"""Design checks in the terminal: the table of margins, a sweep, a tolerance study."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from designcalc.checks.analysis.grid import GridPoint
from designcalc.checks.analysis.report import counted, shown, shown_limit, shown_margin
from designcalc.checks.analysis.sweep import Point, Range, changing_checks
from designcalc.checks.analysis.tolerance import ToleranceStudy
from designcalc.checks.check import Check
from designcalc.friction_stage.physics.tolerance_chains import Chain
from workbench.cli.console import plain_table
from workbench.cli.options import Run

_STYLE = {"passes": "green", "fails": "bold red", "out_of_range": "yellow", "undecidable": "yellow"}
MOST_COLUMNS, MOST_CURVES = 6, 8
"""Checks in the table and in the figure of a sweep."""
MOST_ROWS = 12
"""Combinations in the table of a grid of more than two ranges."""


def print_checks(run: Run, checks: Sequence[Check]) -> None:
    """Every check with value, limit, margin and verdict; then the proposals of those that do not pass."""
    table = plain_table(None, "check", "value", "limit", "margin", "verdict", left=("check", "limit", "verdict"))
    subject = ""
    for check in checks:
        if check.subject != subject:
            subject = check.subject
            table.add_row(f"[bold]{subject}[/bold]")
        style = _STYLE[check.verdict]
        value, limit, margin = shown(check.value, check.unit), shown_limit(check), shown_margin(check)
        table.add_row(f"  {check.name}", value, limit, margin, f"[{style}]{check.verdict}[/{style}]")
    run.console.print(table)
    failing = [check for check in checks if check.verdict != "passes"]
    if failing:
        run.console.print("\n[bold]What would pass[/bold]")
    for check in failing:
        run.echo(f"- {check.name}: {check.proposal or check.note or 'see the formula'}")
    run.echo(f"{counted(checks)}; every formula with its numbers: {run.out / 'checks' / 'checks.html'}")


def print_sweep(run: Run, swept: Range, points: Sequence[Point]) -> list[str]:
    """Margins over the values of a parameter; returns the checks to be drawn in the figure."""
    names = changing_checks(points)
    table = Table(title=f"margins over {swept.key}", pad_edge=False)
    table.add_column(swept.key, justify="right", no_wrap=True)
    for name in names[:MOST_COLUMNS]:
        table.add_column(name, justify="right")
    unit = {"mm": "m", "deg": "rad"}.get(swept.unit, swept.unit)
    for point in points:
        found = {check.name: check for check in point.checks}
        cells = [shown_margin(found[name]) if name in found else "-" for name in names[:MOST_COLUMNS]]
        table.add_row(shown(point.value, unit), *cells)
    run.console.print(table)
    for point in points:
        if point.refused:
            run.echo(f"- {shown(point.value, unit)}: {point.refused}")
    if not names:
        run.echo(f"no margin changes with {swept.key}")
    return names[:MOST_CURVES]


def print_grid(run: Run, ranges: Sequence[Range], points: Sequence[GridPoint]) -> None:
    """The number of failed checks at every point of a grid of two ranges; the points with fewest for more ranges."""
    units = [{"mm": "m", "deg": "rad"}.get(one.unit, one.unit) for one in ranges]
    if len(ranges) == 2:
        columns = len(ranges[1].values)
        table = Table(title=f"failed checks over {ranges[0].key} (down) and {ranges[1].key}", pad_edge=False)
        table.add_column("", justify="right", no_wrap=True)
        for point in points[:columns]:
            table.add_column(shown(point.values[1], units[1]), justify="right")
        for start in range(0, len(points), columns):
            row = points[start : start + columns]
            cells = ["refused" if point.refused else str(len(point.failing)) for point in row]
            table.add_row(shown(row[0].values[0], units[0]), *cells)
    else:
        table = Table(title="combinations with fewest failed checks", pad_edge=False)
        for one in ranges:
            table.add_column(one.key, justify="right")
        table.add_column("failed checks", justify="right")
        best = sorted((point for point in points if point.checks), key=lambda point: len(point.failing))
        for point in best[:MOST_ROWS]:
            cells = [shown(value, unit) for value, unit in zip(point.values, units, strict=True)]
            table.add_row(*cells, str(len(point.failing)))
    run.console.print(table)
    refused = [point for point in points if point.refused]
    if refused:
        run.echo(f"{len(refused)} of {len(points)} combinations are refused, the first: {refused[0].refused}")


def print_tolerance(run: Run, study: ToleranceStudy) -> None:
    """Margins over the sampled machines, and the tolerances that matter most and least."""
    table = Table(title=f"margins of {study.samples} machines", pad_edge=False)
    for column in ("check", "nominal", "5 %", "95 %", "failing", "depends most on"):
        table.add_column(column, justify="left" if column in ("check", "depends most on") else "right")
    for spread in sorted(study.spreads, key=lambda s: s.low - s.high):
        if spread.leading and spread.high - spread.low > 1e-4:
            numbers = [f"{100 * value:+.2f} %" for value in (spread.nominal, spread.low, spread.high)]
            table.add_row(spread.name, *numbers, f"{100 * spread.failing:.1f} %", spread.leading)
    run.console.print(table)
    for title, items in (("matter most", study.matter_most), ("could be loosened", study.could_be_loosened)):
        listed = "; ".join(f"{i.key} ({i.tolerance}: {100 * i.share:.2g} % of a margin, {i.check})" for i in items)
        run.echo(f"{title}: {listed}")
    run.echo("(as far as the checks cover: a fit or the assembly may need a closer tolerance)")


def print_chains(run: Run, found: Sequence[Chain]) -> None:
    """The tolerance chains: limits by worst case and statistically, and the share of each dimension."""
    table = plain_table(None, "tolerance chain", "nominal", "worst case", "99.73 %", left=("tolerance chain",))
    for chain in found:
        limits = [f"{shown(low, 'm')} to {shown(high, 'm')}" for low, high in (chain.worst_case, chain.statistical)]
        table.add_row(f"[bold]{chain.name}[/bold]", shown(chain.nominal, "m"), *limits)
        for link in chain.links:
            sign = "-" if link.coefficient < 0 else "+"
            table.add_row(
                f"  {sign} {link.key}",
                shown(link.nominal, "m"),
                f"{shown(link.low, 'm')} / {shown(link.high, 'm')}",
                "",
            )
    run.console.print(table)
