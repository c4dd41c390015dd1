"""Hardware tables of a project: CSV files of piezos, screws, threads and materials beside the parameter file.

The table `[hardware]` of the parameter file names them: `piezos = "piezos.csv"`. The first row of a file has the names
of its columns, which are those of the keys, with the unit of bare numbers in brackets: `name, stroke [um]`.
The column `name` is what the parameter file chooses a row by; a column `source` has the origin of its values, that of a
catalogue unless it begins like another one (`assumed: `).
"""

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError, nearest, require, require_known
from stagecad.parameters.input_file import decoded, read_input
from stagecad.parameters.schema import Declaration, FileEntry
from stagecad.parameters.units import parse_quantity, quoted

HARDWARE = "hardware"
"""The table of the parameter file that names the tables."""
ROW = "row"
"""The key of a part by which it chooses a row."""
NO_ROW = "none"
"""Value of that key for a part whose values are those of the parameter file."""
NAME, SOURCE = "name", "source"
_LARGEST = 1_000_000
"""Largest accepted size of a table, bytes."""
_HEADING = re.compile(r"(?P<column>[^\[\]]*?)\s*(\[(?P<unit>[^\[\]]*)\])?")
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True)
class Kind:
    """What a table may hold."""

    columns: Mapping[str, Declaration]  # by name, with their declarations
    slots: tuple[str, ...] = ()  # tables of the parameter file that choose a row by their key `row`
    optional: tuple[str, ...] = ()  # columns that may be left out or empty; the parameter file has their values
    names: tuple[str, ...] = ()  # the rows to which the optional columns do not apply; empty for none


@dataclass(frozen=True)
class Row:
    """A row of a table: its values by column as a parameter file would have them, empty ones left out; their origin."""

    name: str
    cells: Mapping[str, FileEntry]
    origin: str


@dataclass(frozen=True)
class ProjectTable:
    """A table by its kind and its file."""

    kind: str
    file: str
    rows: tuple[Row, ...]


def read_project_tables(
    named: Mapping[str, Any], folder: Path, file: str, kinds: Mapping[str, Kind]
) -> tuple[ProjectTable, ...]:
    """Read the tables that a parameter file names."""
    found = []
    for kind, name in named.items():
        place = f"{file}: {HARDWARE}.{kind}"
        require_known(kind, kinds, f"{place}: no such kind of table")
        if not isinstance(name, str) or not name:
            raise InputError(f"{place}: write the name of a CSV file in this folder, like '{kind}.csv'")
        rows = tuple(_rows(_text(name, folder, place), name, kinds[kind]))
        require(rows, f"{name}: has no rows below its columns; write one for each of the {kind}")
        found.append(ProjectTable(kind, name, rows))
    return tuple(found)


def _text(name: str, folder: Path, place: str) -> str:
    """Text of a file of the folder."""
    shown = quoted(name)
    try:
        path, root = (folder / name).resolve(), folder.resolve()
        if Path(name).is_absolute() or root not in path.parents:
            raise InputError(f"{place} = {shown}: lies outside the folder of the parameter file; put the table into it")
        data = read_input(path, _LARGEST)
    except FileNotFoundError:
        raise InputError(f"{place} = {shown}: no such file in the folder of the parameter file") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{place} = {shown}: cannot be read ({getattr(error, 'strerror', error)})") from None
    return decoded(data, name, "row")


def _rows(text: str, file: str, kind: Kind) -> Iterator[Row]:
    reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
    headings: list[tuple[str, str]] | None = None
    seen: dict[str, int] = {}
    try:
        for cells in reader:
            if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                continue
            if headings is None:
                headings = _headings(cells, f"{file}: row {reader.line_num}", kind)
                continue
            row = _row(cells, headings, file, reader.line_num, kind)
            if row.name in seen:
                raise InputError(
                    f"{file}: row {reader.line_num}: '{row.name}' is in row {seen[row.name]} already; keep one"
                )
            seen[row.name] = reader.line_num
            yield row
    except csv.Error as error:
        raise InputError(f"{file}: row {reader.line_num}: no CSV ({error})") from None


def _headings(cells: Iterable[str], place: str, kind: Kind) -> list[tuple[str, str]]:
    """Names of the columns with the units of their numbers."""
    found: dict[str, str] = {}
    for cell in cells:
        match = _HEADING.fullmatch(cell.strip())
        column, unit = (match["column"], (match["unit"] or "").strip()) if match else (cell, "")
        allowed = (NAME, *kind.columns, SOURCE)
        if column not in allowed:
            hint = "; separate the columns by commas" if ";" in cell else nearest(column, allowed)
            raise InputError(f"{place}: no column {quoted(column)}{hint}")
        require(column not in found, f"{place}: the column '{column}' is there twice; keep one")
        if unit:
            declared = kind.columns.get(column)
            if declared is None or declared.kind != "number" or not declared.unit:
                raise InputError(f"{place}: the column '{column}' has no unit; write '{column}' alone")
            parse_quantity(f"1 {unit}", declared.unit, f"{place}: column '{column} [{unit}]'")
        found[column] = unit
    for column in (NAME, *kind.columns):
        if column not in found and column not in kind.optional:
            unit = kind.columns[column].unit if column != NAME else ""
            raise InputError(f"{place}: the column '{column}{f' [{unit}]' if unit else ''}' is missing; add it")
    return list(found.items())


def _row(cells: list[str], headings: list[tuple[str, str]], file: str, line: int, kind: Kind) -> Row:
    place = f"{file}: row {line}"
    if len(cells) != len(headings):
        raise InputError(
            f"{place}: {len(cells)} cells, but there are {len(headings)} columns; put a text with a comma in quotes"
        )
    texts = {column: cell.strip() for (column, _), cell in zip(headings, cells, strict=True)}
    name = texts[NAME]
    where = f"{place}, column {NAME}: {quoted(name)}"
    require(kind.slots or _IDENTIFIER.fullmatch(name), f"{where}: write letters, digits and _, beginning with a letter")
    if not name or not name.isprintable() or len(name) > 100 or "|" in name or name == NO_ROW:
        raise InputError(f"{where}: write a line of text without '|', other than '{NO_ROW}'")
    source = texts.get(SOURCE) or f"{file}, {name}"
    stated = source.startswith(("thesis ", "catalogue ", "assumed: ", "measured: "))
    origin = source if stated else f"catalogue {source}"
    values: dict[str, FileEntry] = {}
    for column, unit in headings:
        text = texts[column]
        if column in (NAME, SOURCE):
            continue
        where = f"{place}, column {column}"
        if not text:
            require(column in kind.optional, f"{where}: is empty; give '{name}' a value")
            continue
        if text.startswith("="):
            raise InputError(f"{where}: {quoted(text)}: a table has values; formulas are for the parameter file")
        if kind.columns[column].kind == "switch":
            text = text.lower()
        values[column] = FileEntry(f"{text} {unit}" if unit and _is_number(text) else text, where, origin=origin)
    missing = [column for column in kind.optional if column not in values]
    if kind.names and name not in kind.names and missing:
        raise InputError(
            f"{place}: '{name}' is not in the packaged table{nearest(name, kind.names)}; for one of your own "
            f"give its {' and '.join(missing)}"
        )
    require(source.isprintable(), f"{place}, column {SOURCE}: contains characters that cannot be printed")
    return Row(name, values, origin)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
