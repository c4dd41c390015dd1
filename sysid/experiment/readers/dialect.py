"""The form of a text file with columns: delimiter, decimal sign, header, units, first row; found in its first lines.

Each way to split the lines is tried, and the one in which most cells are numbers is taken. What is found never changes
a number silently: it is reported, and where two readings give different numbers the file is refused until `[format]`
says which one is meant.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, overload

from stagecad.parameters.errors import InputError
from sysid.experiment.columns.units import column_unit
from sysid.experiment.readers.format import DELIMITERS, Format

GAPS = ("", "nan", "NaN", "NAN", "-nan", "NA", "null")
COMMENTS = ("#", "%", "//")

ROWS = 200
"""Lines at the end of the head from which width and kinds of the columns are taken."""

_DATE = re.compile(r"\d{4}-\d\d-\d\d[ T]\d\d:\d\d(:\d\d([.,]\d+)?)?(Z|[+-]\d\d:?\d\d)?")
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d+)?")
_COMMA_NUMBER = re.compile(r"[+-]?(\d+(,\d*)?|,\d+)([eE][+-]?\d+)?")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")

_LEFT_OUT = re.compile(rf"\s*(?:{'|'.join(map(re.escape, COMMENTS))}|$)")
"""A line that is blank or a comment."""

Kind = Literal["number", "date", "clock", "stamp", "gap", "text"]


class Line(NamedTuple):
    """A line that is neither blank nor a comment: its number in the file, from 1, and its text."""

    number: int
    text: str


Row = tuple[int, list[str]]
"""Number of a line in the file, from 1, and its cells."""


class _Rows(Sequence[Row]):
    """The rows of lines, each split into cells when it is accessed: the cells of most lines are not needed."""

    def __init__(self, lines: Sequence[Line], delimiter: str) -> None:
        self._lines, self._delimiter = lines, delimiter

    def __len__(self) -> int:
        return len(self._lines)

    @overload
    def __getitem__(self, place: int) -> Row: ...
    @overload
    def __getitem__(self, place: slice) -> list[Row]: ...
    def __getitem__(self, place: int | slice) -> Row | list[Row]:
        if isinstance(place, slice):
            return [self._row(line) for line in self._lines[place]]
        return self._row(self._lines[place])

    def _row(self, line: Line) -> Row:
        return line.number, split(line.text, self._delimiter)


@dataclass(frozen=True)
class Dialect:
    """The form of a text file with columns.

    Args:
        encoding: of the text.
        delimiter: between columns; a blank stands for any run of blanks and tabs.
        decimal: decimal sign.
        labels: of the columns.
        units: row of units, by column; empty without one.
        header_row, units_row: numbers of the rows, from 1; 0 for none.
        first_row: number of the first row of numbers.
        width: cells of a row.
        stamps: columns of time stamps, and their kinds.
        gaps: cells that mark a gap.
        texts: first cell, by label, of columns of text.
        remarks: on what is not plain CSV, for the user.
    """

    encoding: str
    delimiter: str
    decimal: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    header_row: int
    units_row: int
    first_row: int
    width: int
    stamps: Mapping[int, str]
    gaps: tuple[str, ...]
    texts: dict[str, str]
    remarks: tuple[str, ...]

    @property
    def numbered(self) -> bool:
        """Whether the file has no header."""
        return self.header_row == 0


def split(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        # A line that is no CSV (a cell of more than 128 kB) is split at every delimiter.
        with suppress(csv.Error):
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def number(cell: str, decimal: str = ".") -> float | None:
    """The number in a cell; None if it is none."""
    if decimal == "," and ("," in cell or "." in cell):
        return float(cell.replace(",", ".")) if _COMMA_NUMBER.fullmatch(cell) else None
    try:
        return float(cell) if "_" not in cell else None
    except ValueError:
        return None


def is_comment(line: str) -> bool:
    """Whether a line is a comment."""
    return line.lstrip().startswith(COMMENTS)


def kind_of_cell(cell: str, decimal: str, settings: Format) -> Kind:
    """Kind of a cell. A text in `time_format` of the settings is a `stamp`."""
    if cell in GAPS or cell in settings.missing:
        return "gap"
    if number(cell, decimal) is not None:
        return "number"
    if _DATE.fullmatch(cell):
        return "date"
    if _CLOCK.fullmatch(cell):
        return "clock"
    return "stamp" if settings.time_format is not None and _has_format(cell, settings.time_format) else "text"


def _has_format(cell: str, time_format: str) -> bool:
    from datetime import datetime

    try:
        datetime.strptime(cell, time_format)
    except ValueError:
        return False
    return True


class _Way(NamedTuple):
    """A way to split the lines: share of the cells that are numbers, width, and its two signs."""

    share: float
    width: int
    delimiter: str
    decimal: str


def find_dialect(lines: Sequence[str], encoding: str, settings: Format, name: str, complete: bool) -> Dialect:
    """The form of a file by its first lines.

    Raises:
        InputError: no rows of numbers, or the decimal sign is ambiguous; the message names the setting to write.
    """
    kept = [Line(k, text) for k, text in enumerate(lines, start=1) if not _LEFT_OUT.match(text)]
    kept = kept if complete else kept[:-1]
    way = _best_way(kept, settings)
    return _layout(lines, _Rows(kept, way.delimiter), way, encoding, settings, name)


def _best_way(lines: Sequence[Line], settings: Format) -> _Way:
    ways = []
    sample = [line.text for line in lines[-ROWS:]]
    for delimiter in (settings.delimiter,) if settings.delimiter else DELIMITERS:
        rows = [split(text, delimiter) for text in sample]
        width = _width(rows)
        if width < 2 and settings.delimiter is None:
            continue
        for decimal in (settings.decimal,) if settings.decimal else (".", ","):
            if decimal == delimiter and not any('"' in text for text in sample):
                continue
            cells = [cell for row in rows if len(row) == width for cell in row]
            kinds = Counter(kind_of_cell(cell, decimal, settings) for cell in cells)
            filled = sum(cell != "" for row in rows for cell in row)
            good = kinds["number"] + kinds["date"] + kinds["clock"] + kinds["stamp"]
            ways.append(_Way(round(good / max(filled, 1), 3), width, delimiter, decimal))
    best = max(ways, key=lambda way: way[:2], default=None)
    if best is None or best.share == 0.0:
        # No row of numbers: the most columns, so that the message can say what the header has.
        ways = [way for way in ways if way.delimiter != " "] or ways
        return max(ways, key=lambda way: way.width, default=_Way(0.0, 1, settings.delimiter or ",", "."))
    return best


def _width(rows: Sequence[Sequence[str]]) -> int:
    """The commonest number of cells of a row; the larger of two that are as common."""
    counts = Counter(len(row) for row in rows)
    return max(counts, key=lambda width: (counts[width], width), default=0)


def _layout(
    lines: Sequence[str], rows: Sequence[Row], way: _Way, encoding: str, settings: Format, name: str
) -> Dialect:
    """The dialect with the rows of header, units and numbers."""
    width, decimal = way.width, way.decimal
    columns = _kinds(rows, width, decimal, settings)
    least = settings.first_row or 1
    first = next(
        (k for k, (row, cells) in enumerate(rows) if row >= least and _is_data(cells, columns, decimal, settings)),
        len(rows),
    )
    if settings.decimal is None and decimal == ",":
        _refuse_grouped([cells for _, cells in rows[first : first + ROWS]], name)
    header, units = _header(lines, rows, first, columns, way, settings)
    end_delimiter = False
    labels = header[1] if header[0] else [f"column {k + 1}" for k in range(width)]
    if header[0] and len(labels) != width:
        end_delimiter = len(labels) == width - 1 and all(not c[-1] for _, c in rows[first:] if len(c) == width)
        if end_delimiter:
            labels = [*labels, ""]
        elif len(labels) == width + 1 and not labels[-1]:
            labels = labels[:-1]
    start = settings.first_row or max(header[0], units[0]) + 1
    if not header[0] and not settings.first_row:
        start = _first_of_numbers(rows, first, columns, decimal, settings)
    by_column = {k: kind for k, kind in enumerate(columns) if kind in ("date", "clock", "stamp")}
    # Rows above the header are never read; the header of a plain file is its first line.
    plain = next((k for k, text in enumerate(lines, start=1) if text.strip()), 1)
    remarks = _remarks(way, encoding, header[0], units[0], start, plain)
    remarks += ["a delimiter at the end of each row"] * end_delimiter
    remarks += ["time stamps in " + ", ".join(f"'{labels[k]}'" for k in by_column)] if by_column else []
    return Dialect(
        encoding=encoding,
        delimiter=way.delimiter,
        decimal=decimal,
        labels=tuple(labels),
        units=tuple(units[1]),
        header_row=header[0],
        units_row=units[0],
        first_row=start,
        width=len(labels),
        stamps=by_column,
        gaps=(*GAPS, *settings.missing),
        texts={
            labels[k]: cell
            for k, cell in enumerate(rows[first][1] if first < len(rows) else [])
            if columns[k] == "text" and kind_of_cell(cell, decimal, settings) == "text"
        },
        remarks=tuple(remarks),
    )


def _kinds(rows: Sequence[Row], width: int, decimal: str, settings: Format) -> list[Kind]:
    """The commonest kind of the filled cells of each column, in the rows of this width."""
    tail = [cells for _, cells in rows[-ROWS:] if len(cells) == width]
    kinds: list[Any] = []
    for k in range(width):
        counts = Counter(kind_of_cell(cells[k], decimal, settings) for cells in tail)
        counts.pop("gap", None)
        kinds.append(max(counts, key=lambda kind: (counts[kind], kind != "text"), default="gap"))
    return kinds


def _is_data(cells: Sequence[str], columns: Sequence[Kind], decimal: str, settings: Format) -> bool:
    """Whether a row has the width of the columns, and numbers where they have some."""
    if len(cells) != len(columns):
        return False
    kinds = [kind_of_cell(cell, decimal, settings) for cell in cells]
    valued = [(own, kind) for own, kind in zip(columns, kinds) if own not in ("text", "gap") and kind != "gap"]
    return bool(valued) and all(own == kind for own, kind in valued)


def _header(
    lines: Sequence[str],
    rows: Sequence[Row],
    first: int,
    columns: Sequence[Kind],
    way: _Way,
    settings: Format,
) -> tuple[Row, Row]:
    """Row number and cells of the header and of the units; row number 0 for none."""

    def cells_of(row: int) -> list[str]:
        text = lines[row - 1] if row <= len(lines) else ""
        return split(_uncommented(text), way.delimiter)

    none: Row = (0, [])
    header, units = none, none
    if settings.units_row:
        units = (settings.units_row, [_bare(cell) for cell in cells_of(settings.units_row)])
    if settings.header is not None:
        header = (settings.header, cells_of(settings.header)) if settings.header else none
        if settings.header and settings.units_row is None and settings.first_row is None:
            units = _units_below(settings.header, cells_of)
        return header, units
    if first == len(rows):
        return (rows[0] if rows else none), units
    wordy = [
        (row, cells)
        for row, cells in rows[:first]
        if row != units[0] and sum(kind_of_cell(c, way.decimal, settings) == "text" for c in cells) * 2 > len(cells)
    ]
    of_width = [(row, cells) for row, cells in wordy if len(cells) in (len(columns), len(columns) - 1)]
    if not of_width:
        # A comment above the numbers may be the header; else the text right above them, whatever its width.
        above = range(1, rows[first][0])
        comments = [row for row in above if is_comment(lines[row - 1]) and len(cells_of(row)) == len(columns)]
        if comments and len(columns) > 1:
            return (comments[-1], cells_of(comments[-1])), units
        direct = [line for line in wordy if first and line[0] == rows[first - 1][0] and len(line[1]) > 1]
        return (direct[-1] if direct else none), units
    header = of_width[-1]
    if settings.units_row is None and len(of_width) > 1 and _is_units(header[1]):
        units, header = (header[0], [_bare(cell) for cell in header[1]]), of_width[-2]
    return header, units


def _units_below(header: int, cells_of: Callable[[int], list[str]]) -> Row:
    below = cells_of(header + 1)
    return (header + 1, [_bare(cell) for cell in below]) if _is_units(below) else (0, [])


def _is_units(cells: Sequence[str]) -> bool:
    """Whether each filled cell is a unit, in brackets or not."""
    filled = [_bare(cell) for cell in cells if cell not in ("", "-")]
    return bool(filled) and all(column_unit(cell) is not None for cell in filled)


def _bare(cell: str) -> str:
    """A unit without its brackets; empty for a dash."""
    inner = re.fullmatch(r"[\[(<]\s*(.*?)\s*[\])>]", cell)
    text = inner[1] if inner else cell
    return "" if text == "-" else text


def _uncommented(line: str) -> str:
    return re.sub(r"^\s*(#+|%+|//+)\s*", "", line)


def _first_of_numbers(rows: Sequence[Row], first: int, columns: Sequence[Kind], decimal: str, settings: Format) -> int:
    """Row from which a file without a header is read: the first of the columns' width that holds a number."""
    for row, cells in rows[:first]:
        if len(cells) == len(columns) and any(kind_of_cell(cell, decimal, settings) == "number" for cell in cells):
            return row
    return rows[first][0] if first < len(rows) else 1


def _refuse_grouped(rows: Sequence[Sequence[str]], name: str) -> None:
    """Refuse numbers with commas that may all group thousands."""
    cells = [cell for row in rows for cell in row if "," in cell and number(cell, ",") is not None]
    if cells and all(_GROUPED.fullmatch(cell) for cell in cells):
        raise InputError(
            f"{name}: '{cells[0]}': is the comma a decimal sign, or does it group thousands? If it is a decimal sign, "
            'write [format] decimal = ","; grouped thousands are not read'
        )


def _remarks(way: _Way, encoding: str, header: int, units: int, first: int, plain: int) -> list[str]:
    """Differences from plain CSV: comma, decimal point, header in the first line, UTF-8."""
    remarks = [] if way.delimiter == "," else [DELIMITERS[way.delimiter]]
    remarks += ["decimal comma"] if way.decimal == "," else []
    remarks += [encoding.upper()] if encoding not in ("utf-8", "utf-8-sig") else []
    if header == 0:
        remarks.append("no header" + (f", numbers from row {first}" if first > 1 else ""))
    elif header != plain:
        remarks.append(f"header in row {header}")
    if units:
        remarks.append(f"units in row {units}")
    elif header and first != header + 1:
        remarks.append(f"numbers from row {first}")
    return remarks
