"""Differences of two designs in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from designcalc.checks.analysis.report import shown, shown_margin
from stagecad.parameters.units import format_quantity
from workbench.cli.console import plain_table
from workbench.cli.options import Run

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from workbench.machine.comparison import MarginChange, MassChange, SheetChange, VolumeChange


def print_changes(
    run: Run,
    masses: Sequence[MassChange],
    margins: Sequence[MarginChange],
    volumes: Sequence[VolumeChange],
    sheets: Sequence[SheetChange],
) -> None:
    """One table for each kind of difference; nothing for a kind without any."""
    if run.json_target is not None:
        return
    if masses:
        table = plain_table("mass", "", "first", "second", left=("",))
        for item in masses:
            table.add_row(item.name, *(_amount(value, "kg") for value in (item.before, item.after)))
        run.console.print(table)
    if volumes:
        table = plain_table("solids", "part", "first", "second", "removed", "added", left=("part",))
        for item in volumes:
            values = (item.before, item.after, item.removed, item.added)
            table.add_row(item.part, *(_volume(value) for value in values))
        run.console.print(table)
    if margins:
        table = plain_table("margins", "check", "first", "second", "verdict", left=("check", "verdict"))
        for item in margins:
            before, after = item.verdicts
            verdict = before if before == after else f"[bold]{before} -> {after}[/bold]"
            table.add_row(item.name, _margin(item.before), _margin(item.after), verdict)
        run.console.print(table)
    for item in sheets:
        where = f", marked in {item.marked} ({item.regions} regions)" if item.marked else ""
        run.echo(f"sheet {item.sheet}: {item.change}{where}")


def _amount(value: float | None, unit: str) -> str:
    return "absent" if value is None else format_quantity(value, unit, 6)


def _volume(value: float | None) -> str:
    return "-" if value is None else f"{value * 1e6:.4f} cm^3"


def _margin(check: Check | None) -> str:
    return "absent" if check is None else f"{shown(check.value, check.unit)} ({shown_margin(check)})"
