"""Tables in the terminal, and features of a simulation as text."""

from __future__ import annotations

from typing import Any

from rich.table import Table as RichTable

from workbench.identification.tables import BAR, Table


def rich_table(table: Table) -> RichTable:
    """The table for `rich`, without its bars."""
    out = RichTable(title=table.title, title_justify="left")
    kept = [k for k, (_, kind) in enumerate(table.columns) if kind != BAR]
    for k in kept:
        title, kind = table.columns[k]
        out.add_column(title, justify="right" if kind.startswith("n") else "left")
    for row in table.rows:
        out.add_row(*(row[k] for k in kept))
    return out


def plain_table(title: str | None, *columns: str, left: tuple[str, ...] = ("",)) -> RichTable:
    """An empty table without a frame; columns are right-aligned, those named in `left` are not."""
    out = RichTable(title=title, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for column in columns:
        out.add_column(column, justify="left" if column in left else "right")
    return out


def feature_text(feature: dict[str, Any] | None) -> str:
    """A feature of a simulation in the unit that suits its size; a dash where there is none."""
    if feature is None:
        return "-"
    value, unit = feature["value"], feature["unit"]
    if unit == "m" and abs(value) < 1e-7:
        return f"{value * 1e9:.3f} nm"
    if unit == "m" and abs(value) < 1e-3:
        return f"{value * 1e6:.3f} um"
    if unit == "1":
        return f"{value:.4f}"
    return f"{value:.4f} {unit}" if abs(value) >= 1e-3 or value == 0.0 else f"{value:.3e} {unit}"
