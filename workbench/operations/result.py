"""What every result has, a short text, a page for notebooks, a table, a JSON document; and what is printed of it.

Sentences and tables are plain data for the terminal, for HTML and for Markdown. The command line prints a `Table`, the
macro `data_table` of the report's template writes it as HTML."""

from __future__ import annotations

import html
import json
import logging
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.deferred import pd
from stagecad.parameters.errors import InputError, one_line

if TYPE_CHECKING:
    from jinja2 import Template

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

    @property
    def titles(self) -> tuple[str, ...]:
        """The column titles."""
        return tuple(title for title, _ in self.columns)

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
    """A table without a frame, the titles of its `columns` separated by `|`; `left` are those of text (`*`: all; the
    first one when left out), `quiet` those of prose among them."""
    titles = columns.split("|")
    text = titles if left == "*" else left.split("|") if left else titles[:1]
    prose = quiet.split("|") if quiet else []
    kinds = tuple((name, QUIET if name in prose else TEXT if name in text else NUMBER) for name in titles)
    return Table(title, kinds, tuple(tuple(row) for row in rows), plain=True)


def finite(value: Any) -> Any:
    """`value` with numbers that JSON cannot hold (infinite, not a number) as null, and numpy scalars as plain ones."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(value: Any, indent: int | None = None, ensure_ascii: bool = True) -> str:
    """A document as JSON, its numbers by `finite`: not rounded."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=ensure_ascii, allow_nan=False)


def render(template: str, **values: Any) -> str:
    """A page from a packaged template; an unknown name in the template is an error."""
    return _compiled(template).render(**values)


@cache
def _compiled(template: str) -> Template:
    """A packaged template; compiling it takes longer than to fill it in."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("workbench"),
        autoescape=template.endswith(".html"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template)


ProgressCallback = Callable[[str, int, int], None]
"""Called with the name of a step, the steps done, and all steps (0: not known)."""


def silent(step: str, done: int, steps: int) -> None:
    """The progress callback that shows nothing."""


def remark(text: str) -> None:
    """Log a remark of one line; it may quote a file. Without any logging set up, it goes to standard error."""
    logging.getLogger("stagecad").warning("%s", one_line(text))


def counted(progress: ProgressCallback, step: str, steps: int) -> Callable[..., None]:
    """What reports some steps more each time it is called; an empty `step` is the name that it is called with."""
    done = 0
    if step:
        progress(step, 0, steps)

    def advance(item: object = "", count: int = 1) -> None:
        nonlocal done
        done += count
        progress(step or str(item), done, steps)

    return advance


MOST_ROWS = 20
"""Rows of the table that a notebook shows."""

STYLE = (
    "<style>.stagecad table{border-collapse:collapse;margin:.4em 0}"
    ".stagecad th,.stagecad td{padding:.15em .9em .15em 0;text-align:left;vertical-align:top}</style>"
)


class Result(ABC):
    """A result: `print` shows one line, a notebook a table, `to_dataframe` gives the data, `to_json` the document."""

    @abstractmethod
    def to_dataframe(self) -> pd.DataFrame:
        """The result as a table."""

    @abstractmethod
    def to_json(self) -> Any:
        """The document that the command prints with `--json`."""

    @abstractmethod
    def __repr__(self) -> str: ...

    def summary(self) -> list[tuple[str, str]]:
        """Sentences shown above the table in a notebook, by their names."""
        return []

    def _table(self) -> pd.DataFrame:
        """The table shown in a notebook."""
        return self.to_dataframe()

    def _repr_html_(self) -> str:
        title = html.escape(repr(self).strip("<>"))
        facts = "".join(
            f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in self.summary()
        )
        table = self._table().to_html(max_rows=MOST_ROWS, border=0, float_format=lambda value: f"{value:.4g}")
        return f"<div class='stagecad'>{STYLE}<b>{title}</b>{f'<table>{facts}</table>' if facts else ''}{table}</div>"


def frame(rows: Iterable[Any], *index: str, columns: Sequence[str] = ()) -> pd.DataFrame:
    """A table of rows, mappings or tuples under `columns`, with the columns `index` as its index."""
    table = pd.DataFrame(list(rows), columns=list(columns) or None)
    return table.set_index(index[0] if len(index) == 1 else list(index)) if index else table


class Reported(Result):
    """A result of an experiment that has a section in its report, or changes one."""

    experiment: Any

    def write_report(self, out: str | Path) -> Path:
        """Write the figures of the result and the report of the experiment below the folder `out`; returns the file
        to open."""
        from workbench.report.identification import write_report

        return write_report(self, Path(out))


def update_report(result: Any, out: Path) -> None:
    """Write the report below `out` again where there is one, of a result or of the last of its steps."""
    last = [result, *getattr(result, "steps", ())][-1]
    if isinstance(last, Reported) and last.experiment.has_report(out):
        last.write_report(out)


@contextmanager
def without_options() -> Iterator[None]:
    """Errors in here do not name an option of the commands (`--set KEY: ...`), which is not known outside them."""
    try:
        yield
    except InputError as error:
        if not str(error).startswith("--"):
            raise
        raise InputError(re.sub(r"^--[a-z]+:? ?", "", str(error))) from None
