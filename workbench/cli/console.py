"""Results in the terminal: their tables and sentences, and the progress of an operation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import click
from rich.table import Table as RichTable
from rich.text import Text

from stagecad.parameters.errors import one_line
from workbench.cli.options import Run
from workbench.operations.lines import BAR, NUMBER, Line, Note, Table, Warned

if TYPE_CHECKING:
    from rich.progress import Progress

STYLES = {"passes": "green", "fails": "bold red", "out_of_range": "yellow", "undecidable": "yellow"}
"""Style of a cell that is a verdict."""


def show(run: Run, lines: Iterable[Line]) -> None:
    """Print what an operation says of its result."""
    for line in lines:
        if isinstance(line, Table):
            run.console.print(rich_table(line))
        elif isinstance(line, Note):
            run.note(line)
        else:
            run.echo(click.style(f"warning: {one_line(line)}", fg="yellow") if isinstance(line, Warned) else line)


def rich_table(table: Table) -> RichTable:
    """The table for `rich`, without its bars; in a plain one, a row with nothing but its first cell is a heading."""
    kept = [k for k, (_, kind) in enumerate(table.columns) if kind != BAR]
    out = RichTable(title=table.title or None, title_justify="left")
    if table.plain:
        out.box, out.pad_edge, out.header_style = None, False, "bold"
        out.show_header = any(title for title, _ in table.columns)
    for k in kept:
        title, kind = table.columns[k]
        out.add_column(Text(title), justify="right" if kind.startswith(NUMBER) else "left")
    for row in table.rows:
        heading = "bold" if table.plain and row[0] and not any(row[1:]) else ""
        out.add_row(*(Text(row[k], style=STYLES.get(row[k]) or heading) for k in kept))
    return out


def search_progress(
    progress: Progress, afterwards: str = "comparing the candidates"
) -> Callable[[str, int, int], None]:
    """A callback (name, count, total) that counts the steps of a search; then the bar runs on without a total.

    The number of steps after the refits depends on their results, and they take less time than those counted.
    """
    task = progress.add_task("reading, and fitting the model as it stands", total=None)
    began = progress.tasks[-1].start_time

    def restart(text: str, total: int | None) -> None:
        # The total of a bar cannot be removed: a new bar replaces it and takes over its start time.
        nonlocal task
        progress.remove_task(task)
        task = progress.add_task(text, total=total)
        progress.tasks[-1].start_time = began

    def show_step(name: str, count: int, total: int) -> None:
        if count == total:
            restart(afterwards, None)
            return
        if count == 0:
            restart(name, total)
        progress.update(task, description=name, completed=count)

    return show_step
