"""What every result has: a short text, a page for notebooks, a table, a JSON document."""

from __future__ import annotations

import html
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

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


def finite(value: Any) -> Any:
    """`value` with numbers that JSON cannot hold (infinite, not a number) as null, and numpy scalars as plain ones."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def frame(rows: Iterable[Any], *index: str, columns: Sequence[str] = ()) -> pd.DataFrame:
    """A table of rows, mappings or tuples under `columns`, with the columns `index` as its index."""
    import pandas as pd

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


@contextmanager
def without_options() -> Iterator[None]:
    """Errors in here do not name an option of the commands (`--set KEY: ...`), which is not known outside them."""
    try:
        yield
    except InputError as error:
        if not str(error).startswith("--"):
            raise
        raise InputError(re.sub(r"^--[a-z]+:? ?", "", str(error))) from None
