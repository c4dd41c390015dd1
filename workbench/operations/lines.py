"""What is printed of a result: sentences and tables, as plain data for the terminal, for HTML and for Markdown.

The command line prints a `Table`, the macro `data_table` of the report's template writes it as HTML.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from stagecad.parameters.errors import one_line

TEXT, NUMBER, STRONG, CODE, REMARK, BAR, QUIET = "", "n", "n strong", "code", "warn", "bar", "quiet"
"""Kinds of a column: the classes of its cells in HTML. Cells of BAR are a width in percent, drawn in HTML only."""


@dataclass(frozen=True)
class Table:
    """Formatted cells under their column titles; `note` is printed below the table in HTML.

    A `plain` one has no frame.
    """

    title: str
    columns: tuple[tuple[str, str], ...]  # title and kind of each column
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    plain: bool = False

    def as_json(self) -> dict[str, Any]:
        """The table as it is stored with a section of the report."""
        return {"title": self.title, "columns": self.columns, "rows": self.rows, "note": self.note}


class Note(str):
    """A line that is printed as a remark beside the result."""


class Warned(str):
    """A line that is printed as a warning."""


Line = str | Table
"""What a command prints of a result: a sentence, a `Note`, a warning or a table."""


def plain_table(title: str, columns: str, rows: Iterable[Sequence[str]], left: str = "", quiet: str = "") -> Table:
    """A table without a frame.

    Args:
        title: of the table.
        columns: their titles, separated by `|`.
        rows: of cells.
        left: titles of the columns that hold text, separated by `|`; `*` for all, the first one when left out.
        quiet: titles of those of them that hold prose.
    """
    titles = columns.split("|")
    text = titles if left == "*" else left.split("|") if left else titles[:1]
    prose = quiet.split("|")
    kinds = tuple((name, QUIET if name in prose else TEXT if name in text else NUMBER) for name in titles)
    return Table(title, kinds, tuple(tuple(row) for row in rows), plain=True)


def markdown(table: Table) -> list[str]:
    """The lines of a table in Markdown."""
    cells = [[title for title, _ in table.columns], ["---"] * len(table.columns), *table.rows]
    return ["| " + " | ".join(text.replace("|", "\\|") for text in row) + " |" for row in cells]


ProgressCallback = Callable[[str, int, int], None]
"""Called with the name of a step, the steps done, and all steps (0: not known)."""


def silent(step: str, done: int, steps: int) -> None:
    """The progress callback that shows nothing."""


def remark(text: str) -> None:
    """Log a remark of one line; it may quote a file. Without any logging set up, it goes to standard error."""
    logging.getLogger("stagecad").warning("%s", one_line(text))


def counted(progress: ProgressCallback | None, step: str, steps: int) -> Callable[..., None]:
    """What reports some steps more each time it is called; an empty `step` is the name that it is called with."""
    done = 0
    if step and progress is not None:
        progress(step, 0, steps)

    def advance(item: object = "", count: int = 1) -> None:
        nonlocal done
        done += count
        if progress is not None:
            progress(step or str(item), done, steps)

    return advance
