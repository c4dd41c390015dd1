"""Results in the terminal: their tables and sentences, and the progress of an operation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import click
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from stagecad.parameters.errors import one_line
from workbench.cli.options import Run
from workbench.operations.result import BAR, NUMBER, QUIET, Line, Note, Table, Warned

if TYPE_CHECKING:
    from rich.progress import Progress

STYLES = {"passes": "green", "fails": "bold red", "out_of_range": "yellow", "undecidable": "yellow"}
"""Style of a cell that is a verdict."""
ROOM = 100
"""Width below which sentences stand below the other cells of a plain table."""
LONGEST_NAME = 40
"""Characters of phrases in a first column that are not broken into lines, half of the narrowest usual terminal."""


def show(run: Run, lines: Iterable[Line]) -> None:
    """Print what an operation says of its result."""
    for line in lines:
        if isinstance(line, Table):
            if not _is_listed(line, run.console.width):
                run.console.print(rich_table(line, run.console.width))
            for text in _below(line, run.console.width):
                run.echo(text)
        elif isinstance(line, Note):
            run.note(line)
        else:
            run.echo(click.style(f"warning: {one_line(line)}", fg="yellow") if isinstance(line, Warned) else line)


def rich_table(table: Table, width: int = 1000) -> RichTable:
    """The table for `rich`, without its bars; in a plain one, a row with nothing but its first cell is a heading.

    No word is cut: names are typed again. A table whose words do not fit into `width` has no frame, and its quiet cells
    are left for `_below`.
    """
    narrow = _is_narrow(table, width)
    kept = [k for k, (_, kind) in enumerate(table.columns) if kind != BAR and not (narrow and kind == QUIET)]
    out = RichTable(title=table.title or None, title_justify="left")
    if table.plain or narrow:
        out.box, out.pad_edge, out.header_style = None, False, "bold"
        out.show_header = any(title for title, _ in table.columns)
    if narrow:
        out.padding = (0, 1, 0, 0)
    edges = len(kept) - 1 if narrow else 3 * len(kept) + 1
    widths = [None] * len(kept) if table.plain else _widths(table, kept, width - edges, narrow)
    for k, letters in zip(kept, widths):
        title, kind = table.columns[k]
        justify = "right" if kind.startswith(NUMBER) else "left"
        whole = table.plain and _is_whole(table, k)
        out.add_column(Text(title), justify=justify, overflow="fold", width=letters, no_wrap=whole)
    for row in table.rows:
        heading = "bold" if table.plain and row[0] and not any(row[1:]) else ""
        out.add_row(*(_cell(row[k], STYLES.get(row[k]) or heading) for k in kept))
    return out


def _is_whole(table: Table, column: int) -> bool:
    """Whether no cell is broken into lines: the first column has names that are typed again; phrases may be broken."""
    return column == 0 and all(len(row[0]) <= LONGEST_NAME for row in table.rows if " " in row[0].strip())


def _cells(table: Table, column: int) -> list[str]:
    return [table.columns[column][0], *(row[column] for row in table.rows)]


def _words(table: Table, column: int) -> list[str]:
    return " ".join(_cells(table, column)).split()


def _longest_word(table: Table, column: int) -> int:
    """Letters of the longest word; a quantity is one word."""
    title, *cells = _cells(table, column)
    words = cells if table.columns[column][1].startswith(NUMBER) else " ".join(cells).split()
    return max((len(word) for word in (*title.split(), *words)), default=0)


def _widths(table: Table, columns: Sequence[int], room: int, narrow: bool) -> list[int | None]:
    """Letters of each column: that of its longest word, and of the rest first what the least wide ones need, in a
    narrow table their cells before their titles. Where there is no rest, quantities are broken before their units."""
    whole = {k: max(len(cell) for cell in _cells(table, k)) for k in columns}
    given = {k: _longest_word(table, k) for k in columns}
    rest = room - sum(given.values())
    for k in columns:
        parts = max(map(len, _words(table, k)), default=0)
        less = min(max(-rest, 0), given[k] - parts)
        given[k], rest = given[k] - less, rest + less
    if sum(whole.values()) <= room or rest < 0:
        return [None] * len(columns)
    of_cells = {k: max([given[k], *map(len, _cells(table, k)[1:])]) for k in columns}
    for wanted in (of_cells, whole) if narrow else (whole,):
        for place, k in enumerate(sorted(columns, key=lambda k: wanted[k] - given[k])):
            more = min(wanted[k] - given[k], rest // (len(columns) - place))
            given[k] += more
            rest -= more
    return [given[k] for k in columns]


def _is_narrow(table: Table, width: int) -> bool:
    """Whether the words of a framed table do not fit."""
    kept = [k for k, (_, kind) in enumerate(table.columns) if kind != BAR]
    return not table.plain and sum(_longest_word(table, k) for k in kept) + 3 * len(kept) + 1 > width


def _is_listed(table: Table, width: int) -> bool:
    """Whether each row is a paragraph: the words do not fit without a frame, or the sentences of a plain table have no
    room."""
    if table.plain and width < ROOM and any(kind == QUIET for _, kind in table.columns):
        return True
    kept = [k for k, (_, kind) in enumerate(table.columns) if kind not in (BAR, *[QUIET] * (not table.plain))]
    cells = {k: _cells(table, k) if table.plain and _is_whole(table, k) else _words(table, k) for k in kept}
    return (
        sum(max(map(len, found), default=0) for found in cells.values()) + (len(kept) - 1) * (1 + table.plain) > width
    )


def _below(table: Table, width: int) -> list[str]:
    """Quiet cells of a table that is too narrow for them, a paragraph for each row, or all cells of a listed one."""
    quiet = [k for k, (_, kind) in enumerate(table.columns) if kind == QUIET]
    if not _is_listed(table, width):
        texts = [(row[0], ", ".join(row[k] for k in quiet if row[k])) for row in table.rows if _is_narrow(table, width)]
        return [fill(f"{name}: {text}", width, subsequent_indent="  ") for name, text in texts if text]
    lines = [table.title] if table.title else []
    beside = [k for k in range(len(table.columns)) if k not in quiet and (k == 0 or table.plain)]
    for row in table.rows:
        lines.append("  ".join(row[k] for k in beside if row[k]))
        texts = [
            f"  {title}: {row[k]}"
            for k, (title, kind) in enumerate(table.columns)
            if k not in beside and row[k] and kind != BAR
        ]
        lines += [fill(text, width, subsequent_indent="    ", break_long_words=False) for text in texts]
    return lines


def _cell(text: str, style: str) -> Text | Padding:
    """A cell whose leading spaces indent all its lines."""
    bare = Text(text.lstrip(), style=style)
    return Padding(bare, (0, 0, 0, len(text) - len(bare))) if len(bare) < len(text) else bare


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
