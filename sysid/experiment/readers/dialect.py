"""The form of a text file with columns: delimiter, decimal sign, header, units, first row; found in its first lines.

Each way to split the lines is tried, and the one in which most cells are numbers is taken. What is found never changes
a number silently: it is reported, and where two readings give different numbers the file is refused until `[format]`
says which one is meant.
"""

import csv
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from stagecad.deferred import pyarrow
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.units import to_si, unit_dimension
from sysid.experiment.column_settings import WORDS, column_unit
from sysid.experiment.readers.base import DELIMITERS, Column, Format
from sysid.experiment.readers.numbers import GAPS, HALF, STAMPS, NumberForm, is_hexadecimal, seconds

COMMENTS = ("#", "%", "//")

ROWS = 200
"""Lines at the end of the head from which width and kinds of the columns are taken."""

LEAST_ROWS = 3
"""Rows of numbers of another width above the first row of the columns that are no preamble."""

_QUANTITY = re.compile(r"(?P<number>.*?[\d.,])\s*(?P<unit>[A-Za-zµμ°Ω%][^\s,;]*)")

DIGITS = re.compile(r"[\W_]*\d[\W\d_]*")
"""Digits without a letter: a number in another form, or a time stamp."""

_UNIT_KEY = r"unit|einheit|unid|unità|unité"
_TYPES = r"l?real\d*|float\d*|double|single|u?[sld]?int\d*|bool|byte|[dl]?word|w?string"
"""Types of data of IEC 61131-3 and C."""

_TIME_WORDS = {*WORDS["channels"]["time"].split()}

_LEFT_OUT = re.compile(rf"\s*(?:{'|'.join(map(re.escape, COMMENTS))}|$)")
"""A line that is blank or a comment."""

Kind = str
"""`number`, `quantity`, `gap`, `text`, or a kind of time stamp."""
_TIMES: tuple[Kind, ...] = (*STAMPS, "stamp")
_DURATIONS = {"number", "minutes", "clock"}
"""Kinds of the cells of elapsed time that grows from seconds over minutes to hours."""
_VALUED: tuple[Kind, ...] = ("number", "quantity", *(kind for kind in _TIMES if kind != "day"))

_KEY = re.compile(r"(?:^|(?<=[\s,;|]))([^\W\d][^\s=:,;|]*)[ \t]*[=:][ \t]*(?=[-+.\d])")
"""A name before its number, as in `velocity=0.1` and `velocity: 0.1`."""

Row = tuple[int, list[str]]
"""Number of a line in the file, from 1, and its cells."""


@dataclass(frozen=True)
class Dialect:
    """The form of a text file with columns.

    Rows are numbered from 1, 0 for none; columns from 0. `spelled` has the columns whose numbers are not written as
    Python writes them, with the unit behind each number, `stamps` those of time stamps by kind, and `dates` the columns
    of a time of day with its date, or its half of the day, in the order in which they are read. `gaps` are cells that
    mark a gap, `texts` the first cell of columns of text by label, `remarks` what is not plain CSV. Each row of a
    `keyed` file has the names before its numbers.
    """

    encoding: str
    delimiter: str
    form: NumberForm
    spelled: Mapping[int, str]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    header_row: int
    units_row: int
    first_row: int
    width: int
    stamps: Mapping[int, str]
    dates: Mapping[int, tuple[int, ...]]
    gaps: tuple[str, ...]
    texts: dict[str, str]
    remarks: tuple[str, ...]
    keyed: bool
    settings: Format

    @property
    def numbered(self) -> bool:
        """Whether the file has no names of its columns."""
        return self.header_row == 0 and not self.keyed

    def cells(self, line: str) -> list[str]:
        """The cells of a row of numbers."""
        return split(_KEY.sub("", line) if self.keyed else line, self.delimiter)

    def kind(self, cell: str) -> Kind:
        """Kind of a cell; see `kind_of_cell`."""
        return kind_of_cell(cell, self.form, self.settings)

    def seconds(self, texts: Any, index: int, name: str) -> Column:
        """Seconds of the texts (n,) of a column of time stamps."""
        if isinstance(texts, list):
            texts = pyarrow.chunked_array([pyarrow.array(texts, pyarrow.string())])
        return seconds(texts, self.stamps[index], self.settings.time_format, name, self.labels[index])


def split(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    if delimiter == " ":
        # Stars fill a column of Fortran whose number is too wide, up to the one beside it.
        line = re.sub(r"(?<=[^\s*])(?=\*{3})|(?<=\*{3})(?=[^\s*])", " ", line)
        # A unit in brackets belongs to the name before it. No-break blanks do not separate.
        cells = re.findall(r'"[^"]*"|[\[(][^\])\s]*[\])](?!\S)|[^ \t\r\n]+(?:[ \t]+[\[(][^\])]*[\])])?', line)
        return [cell.strip('"') for cell in cells]
    if '"' in line:
        # A line that is no CSV (a cell of more than 128 kB) is split at every delimiter.
        with suppress(csv.Error):
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def is_comment(line: str) -> bool:
    """Whether a line is a comment."""
    return line.lstrip().startswith(COMMENTS)


def kind_of_cell(cell: str, form: NumberForm, settings: Format) -> Kind:
    """Kind of a cell. A text in `time_format` of the settings is a `stamp`, a number with a unit a `quantity`."""
    if cell in GAPS or cell in settings.missing:
        return "gap"
    if form.value(cell) is not None:
        return "compact" if STAMPS["compact"].fullmatch(cell) else "number"
    if settings.time_format is not None and _has_format(cell, settings.time_format):
        return "stamp"
    if unit_of_cell(cell, form):
        return "quantity"
    return next((kind for kind, pattern in STAMPS.items() if pattern.fullmatch(cell)), "text")


def unit_of_cell(cell: str, form: NumberForm) -> str:
    """The unit behind the number in a cell, as written; empty where there is no such unit."""
    match = _QUANTITY.fullmatch(cell) if len(cell) < 80 else None
    if match is None or form.respelled(match["number"]) is None or is_hexadecimal(cell) or form.respelled(cell):
        return ""
    return match["unit"] if column_unit(match["unit"]) is not None else ""


def unit_factor(written: str) -> tuple[float, Any]:
    """Factor to SI of a unit as written behind a number, and its dimension: of a temperature, the unit itself."""
    unit = column_unit(written) or ""
    return (1.0, unit) if "deg" in unit else (to_si(1.0, unit), unit_dimension(unit))


def _has_format(cell: str, time_format: str) -> bool:
    with suppress(ValueError):
        return bool(datetime.strptime(cell, time_format))
    return False


class _Way(NamedTuple):
    """A way to split the lines: share of the cells that are numbers, width, delimiter and form of the numbers, and how
    often another delimiter is in a cell."""

    share: float
    width: int
    delimiter: str
    form: NumberForm
    mixed: int


def find_dialect(lines: Sequence[str], encoding: str, settings: Format, name: str, complete: bool) -> Dialect:
    """The form of a file by its first lines."""
    kept = [(k, text) for k, text in enumerate(lines, start=1) if not _LEFT_OUT.match(text)]
    kept = kept if complete else kept[:-1]
    named = {tuple(_KEY.findall(text)) for _, text in kept[-ROWS:]}
    keys = next(iter(named)) if len(named) == 1 else ()
    if len(keys) > 1:
        kept = [(k, _KEY.sub("", text)) for k, text in kept if tuple(_KEY.findall(text)) == keys]
    way = _best_way([text for _, text in kept[-ROWS:]], settings)
    found = _layout(lines, [(k, split(text, way.delimiter)) for k, text in kept], way, encoding, settings, name)
    if len(keys) < 2:
        return found
    require(found.width == len(keys), f"{name}: row {found.first_row}: a name before each of its numbers is required")
    remarks = tuple("names before the numbers" if text.startswith("no header") else text for text in found.remarks)
    return replace(found, labels=keys, keyed=True, remarks=remarks)


def _best_way(sample: Sequence[str], settings: Format) -> _Way:
    ways: list[_Way] = []
    for delimiter in (settings.delimiter,) if settings.delimiter else DELIMITERS:
        rows = [split(text, delimiter) for text in sample]
        width = _width(rows)
        if width < 2 and settings.delimiter is None:
            continue
        for decimal in (settings.decimal,) if settings.decimal else (".", ","):
            if decimal == delimiter and not any('"' in text for text in sample):
                continue
            whole = [row for row in rows if len(row) == width]
            cells = [cell for row in whole for cell in row]
            form = _form(whole, cells, decimal, delimiter, settings)
            valued = [sum(kind_of_cell(cell, form, settings) in _VALUED for cell in row) for row in whole]
            filled = sum(cell != "" for row in rows if len(row) != width for cell in row)
            filled += sum(cell != "" for row, count in zip(whole, valued) if count for cell in row)
            good = sum(valued)
            if delimiter == "\t" and 2 * valued.count(width) > len(rows):
                # Blanks in cells between tabs stand in numbers and dates.
                return _Way(1.0, width, delimiter, form, 0)
            mixed = sum(other in cell for cell in cells for other in ";\t|")
            ways.append(_Way(round(good / max(filled, 1), 3), width, delimiter, form, mixed))
    # Blanks are tried last: names in columns that tabs separate may have blanks, too.
    tabs = {way.width for way in ways if way.delimiter == "\t"}
    ways = [way for way in ways if way.delimiter != " " or way.width not in tabs]
    best = max(ways, key=lambda way: (*way[:2], -way.mixed), default=None)
    if best is None or best.share == 0.0:
        # No row of numbers: the most columns, so that the message can say what the header has.
        ways = [way for way in ways if way.delimiter != " "] or ways
        return max(ways, key=lambda way: way.width, default=_Way(0.0, 1, settings.delimiter or ",", NumberForm(), 0))
    return best


def _form(
    rows: Sequence[Sequence[str]], cells: Sequence[str], decimal: str, delimiter: str, settings: Format
) -> NumberForm:
    """Form of the numbers: the other sign groups thousands where a number shows both, or two groups of digits, or where
    a column of whole numbers has it beside a column with the decimal sign."""
    blanks = delimiter != " "
    if settings.thousands is not None:
        return NumberForm(decimal, settings.thousands.strip(), blanks)
    other = "," if decimal == "." else "."
    first, last = re.escape(other), re.escape(decimal)
    shown = re.compile(rf"\D?\d{{1,3}}(?:(?:{first}\d{{2,3}})*{first}\d{{3}}{last}\d+|(?:{first}\d{{3}}){{2,}}).*")
    if any(shown.fullmatch(cell) for cell in cells):
        return NumberForm(decimal, other, blanks)
    plain, grouped = re.compile(r"[+-]?\d{1,3}"), re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{first}\d{{3}})+")
    fractions = any(re.fullmatch(rf"[+-]?(?:0|\d+){last}(?!\d{{3}}$)\d+", cell) for cell in cells)
    certain = fractions and any(
        {bool(grouped.fullmatch(cell)) for cell in column if not plain.fullmatch(cell)} == {True}
        and any(map(plain.fullmatch, column))
        for column in ([cell for cell in column if re.fullmatch(r"[+-]?[\d.,]+", cell)] for column in zip(*rows))
    )
    return NumberForm(decimal, other if certain else "", blanks)


def _width(rows: Sequence[Sequence[str]]) -> int:
    """The commonest number of cells of a row; the larger of two that are as common."""
    counts = Counter(len(row) for row in rows)
    return max(counts, key=lambda width: (counts[width], width), default=0)


def _layout(
    lines: Sequence[str], rows: Sequence[Row], way: _Way, encoding: str, settings: Format, name: str
) -> Dialect:
    """The dialect with the rows of header, units and numbers."""
    width, form = way.width, way.form
    columns = _kinds(rows, width, form, settings)
    least = settings.first_row or 1
    first = next(
        (k for k, (row, cells) in enumerate(rows) if row >= least and _is_data(cells, columns, form, settings)),
        len(rows),
    )
    data = [cells for _, cells in rows[first : first + ROWS] if len(cells) == width]
    if settings.decimal is None and settings.thousands is None and not form.thousands:
        _refuse_grouped([*data, *(cells for _, cells in rows[-ROWS:] if len(cells) == width)], form, name)
    places = {tuple(len(cell) for cell in re.split(r"(?<=\S)(?=\s)", lines[row - 1])) for row, _ in rows[first:][:ROWS]}
    if way.delimiter == " " and len(places) == 1:
        ends = [*accumulate(next(iter(places)))]
        rows = [(row, _cut(lines[row - 1], ends) or cells) for row, cells in rows[:first]] + [*rows[first:]]
    header, units = _header(lines, rows, first, columns, way, settings)
    labels, remark = _labels(header, rows[first:], columns, way.delimiter, name)
    last = max(header[0], units[0])
    start, cut = _first_row(rows[first:], [line for line in rows[:first] if line[0] > last], columns, form, settings)
    start = start or last + 1
    if len(cut) >= LEAST_ROWS:
        more = f"{len(cut[0][1])}; to leave them out: [format] first_row = {start}"
        raise InputError(f"{name}: row {start}: has {width} cells, the rows above have {more}")
    by_column, dates = _stamps(columns, data)
    apart = {place for places in dates.values() for place in places}
    # Rows above the header are never read; the header of a plain file is its first line.
    plain = next((k for k, text in enumerate(lines, start=1) if text.strip()), 1)
    remarks = _remarks(way, encoding, header[0], units[0], start, plain)
    remarks += [remark] if remark else []
    remarks += [f"row {row} is cut off; left out" for row, _ in cut]
    dated = [" and ".join(f"'{labels[place]}'" for place in dates.get(k, (k,)) if labels[place]) for k in by_column]
    remarks += [f"time stamps in {', '.join(dated)}"] if by_column else []
    spelled = _spelled(data, columns, form)
    if behind := sorted({unit for unit in spelled.values() if unit}):
        remarks.append(f"units behind the numbers: {', '.join(behind)}")
    return Dialect(
        encoding=encoding,
        delimiter=way.delimiter,
        form=form,
        spelled=spelled,
        labels=tuple(labels),
        units=tuple(units[1]),
        header_row=header[0],
        units_row=units[0],
        first_row=start,
        width=width,
        stamps=by_column,
        dates=dates,
        gaps=(*GAPS, *settings.missing),
        texts={
            labels[k]: cells[k]
            for k, kind in enumerate(columns)
            if kind == "text" and k not in apart
            for cells in reversed(data)
            if not DIGITS.fullmatch(cells[k]) and kind_of_cell(cells[k], form, settings) == "text"
        },
        remarks=tuple(remarks),
        keyed=False,
        settings=settings,
    )


def _stamps(
    columns: Sequence[Kind], rows: Sequence[Sequence[str]]
) -> tuple[dict[int, Kind], dict[int, tuple[int, ...]]]:
    """The kinds of the columns of time stamps, and the columns that are read together; see `Dialect`."""
    days = [k for k, kind in enumerate(columns) if kind == "day"]
    halves = [k for k, kind in enumerate(columns) if kind == "text" and all(HALF.fullmatch(row[k]) for row in rows)]
    dates: dict[int, tuple[int, ...]] = {}
    for k in [k for k, kind in enumerate(columns) if kind == "clock" and (days or halves)]:
        near = [sorted(places, key=lambda place: abs(place - k))[:1] for places in (days, halves)]
        dates[k] = (*near[0], k, *near[1])
    others = {place for k, places in dates.items() for place in places if place != k}
    by_column = {k: kind for k, kind in enumerate(columns) if kind in _TIMES and k not in others}
    by_column |= {k: "date" for k, places in dates.items() if places[0] != k}
    return by_column, dates


def _first_row(
    rows: Sequence[Row], above: Sequence[Row], columns: Sequence[Kind], form: NumberForm, settings: Format
) -> tuple[int, list[Row]]:
    """Number of the first row: of those `above` the rows that are numbers, the first of the columns' width that holds a
    number, since gaps may stand beside it. With it, rows of numbers above it of another width."""
    if settings.first_row:
        return settings.first_row, []
    held = [(row, cells, [form.value(cell) is not None for cell in cells]) for row, cells in above]
    # Different words in front of such rows are keys of the head; one word marks a gap.
    keys = {cells[0] for _, cells, numbers in held if not numbers[0]} - {*GAPS}
    begun = [
        row
        for row, cells, numbers in held
        if len(cells) >= len(columns) and any(numbers[: len(columns)]) and not any(numbers[len(columns) :])
        if len(keys) < 2 or cells[0] not in keys
    ]
    start = (begun or [row for row, _ in rows] or [0])[0]
    return start, [(row, cells) for row, cells, numbers in held if row < start and len(cells) > 1 and all(numbers)]


def _labels(
    header: Row, rows: Sequence[Row], columns: Sequence[Kind], delimiter: str, name: str
) -> tuple[list[str], str]:
    """A label for each column, and a remark where the header has another number of cells than the rows. Cells beyond
    the header that hold no numbers are left out. With numbers beyond it, which of its names belongs to which column is
    not known."""
    width, labels = len(columns), header[1]
    if not header[0]:
        return [f"column {k + 1}" for k in range(width)], ""
    if len(labels) == width:
        return labels, ""
    if len(labels) > width and delimiter == " ":
        raise InputError(
            f"{name}: row {header[0]}: the header has {len(labels)} words, the rows {width} cells; name the columns by "
            f"their numbers: [format] header = false and first_row = {rows[0][0] if rows else header[0] + 1}"
        )
    if len(labels) > width:
        left = [label for label in labels[width:] if label]
        return labels[:width], f"nothing under {', '.join(left)}" if left else ""
    beyond = columns[len(labels) :]
    if len(beyond) == 1 and ("day", "clock") in pairwise(columns):
        day = [*pairwise(columns)].index(("day", "clock"))
        times = [not _TIME_WORDS.isdisjoint(re.split(r"[\W_]+", label.casefold())) for label in labels]
        if times[day : day + 2] == [True, False]:
            return [*labels[:day], "", *labels[day:]], f"date and time under '{labels[day]}'"
    if len(beyond) == 1 and _numbers_rows(cells for _, cells in rows if len(cells) == width):
        return ["", *labels], "row numbers in front of the rows"
    if any(kind not in ("gap", "text") for kind in beyond):
        row, cells = next(((row, cells) for row, cells in rows if len(cells) == width), (header[0], labels))
        marks = sum(re.fullmatch(r"-?\d+", cell) is not None for cell in cells)
        decimal = "; is the decimal sign a comma? a point is required where commas separate the columns"
        by_number = "; name the columns by their numbers: [format] header = false"
        hint = decimal if marks > 1 and delimiter == "," else by_number
        raise InputError(f"{name}: row {row}: has {len(cells)} cells, the header {len(labels)}{hint}")
    end = len(beyond) == 1 and beyond[0] == "gap"
    remark = "a delimiter at the end of each row" if end else f"rows have {len(beyond)} more cells than the header"
    return [*labels, *[""] * len(beyond)], remark


def _cut(line: str, ends: Sequence[int]) -> list[str]:
    """The cells of a line above columns of fixed width that end at these places; none if a word or no cell is there."""
    cells = [line[start:end].strip() for start, end in pairwise([0, *ends[:-1], len(line)])]
    split_words = any(re.match(r"\w\w", line[end - 1 : end + 1]) for end in ends[:-1])
    return [] if split_words or not all(cells) else cells


def _numbers_rows(rows: Iterable[Sequence[str]]) -> bool:
    """Whether the first cell counts the rows and the second increases: row names, as R and pandas write them."""
    with suppress(ValueError):
        counts, values = zip(*((cells[0], float(cells[1])) for cells in rows))
        numbered = [tuple(str(k + first) for k in range(len(counts))) for first in (0, 1)]
        return len(counts) > 1 and counts in numbered and all(one < other for one, other in pairwise(values))
    return False


def _spelled(rows: Sequence[Sequence[str]], columns: Sequence[Kind], form: NumberForm) -> dict[int, str]:
    """Columns with numbers that are not written as Python writes them, and the unit behind each."""
    found: dict[int, str] = {}
    for k, kind in enumerate(columns):
        cells = [row[k] for row in rows if row[k] not in GAPS]
        if kind == "quantity":
            found[k] = next(filter(None, (unit_of_cell(cell, form) for cell in cells)), "")
        elif kind == "number" and any(
            re.search(r"[^0-9.,eE+\-]", cell) or (form.thousands and form.thousands in cell) for cell in cells
        ):
            found[k] = ""
    return found


def _kinds(rows: Sequence[Row], width: int, form: NumberForm, settings: Format) -> list[Kind]:
    """The commonest kind of the filled cells of each column, in the rows of this width."""
    tail = [cells for _, cells in rows[-ROWS:] if len(cells) == width]
    kinds: list[Any] = []
    for k in range(width):
        counts = Counter(kind_of_cell(cells[k], form, settings) for cells in tail)
        counts.pop("gap", None)
        kind: Any = max(counts, key=lambda kind: (counts[kind], kind != "text"), default="gap")
        units = {unit_of_cell(cells[k], form) for cells in tail} - {""} if kind == "quantity" else set()
        kind = "text" if len({unit_factor(unit)[1] for unit in units}) > 1 else kind
        kinds.append("minutes" if "minutes" in counts and counts.keys() <= {*_DURATIONS, "text"} else kind)
    return kinds


def _is_data(cells: Sequence[str], columns: Sequence[Kind], form: NumberForm, settings: Format) -> bool:
    """Whether a row has the width of the columns, and numbers where they have some. A word before them in a column that
    is empty is a key of the head."""
    if len(cells) != len(columns):
        return False
    kinds = [kind_of_cell(cell, form, settings) for cell in cells]
    if columns[0] == "gap" and kinds[0] == "text":
        return False
    valued = [(own, kind) for own, kind in zip(columns, kinds) if own not in ("text", "gap") and kind != "gap"]
    return bool(valued) and all(own == kind or (own == "minutes" and kind in _DURATIONS) for own, kind in valued)


def _header(
    lines: Sequence[str], rows: Sequence[Row], first: int, columns: Sequence[Kind], way: _Way, settings: Format
) -> tuple[Row, Row]:
    """Row number and cells of the header and of the units; row number 0 for none."""

    def cells_of(row: int) -> list[str]:
        text = lines[row - 1] if row <= len(lines) else ""
        return split(re.sub(r"^\s*(#+|%+|//+)\s*", "", text), way.delimiter)

    none: Row = (0, [])
    header, units = none, none
    if settings.units_row:
        units = (settings.units_row, [_bare(cell) for cell in cells_of(settings.units_row)])
    if settings.header is not None:
        header = (settings.header, cells_of(settings.header)) if settings.header else none
        if settings.header and settings.units_row is None and settings.first_row is None:
            below = cells_of(settings.header + 1)
            units = (settings.header + 1, [_bare(cell) for cell in below]) if _is_units(below) else none
        return header, units
    if first == len(rows):
        return (rows[0] if rows else none), units
    wide = len(columns)
    # A header names at least half of the columns of numbers; the line right above them may be longer than they are.
    named = [
        (row, cells)
        for k, (row, cells) in enumerate(rows[:first])
        if wide - 1 <= len(cells)
        and (len(cells) <= wide or k == first - 1)
        and any(kind_of_cell(cell, way.form, settings) == "text" and re.search(r"[^\W\d_]", cell) for cell in cells)
    ]
    wordy = [
        (row, cells)
        for row, cells in named
        if row != units[0]
        and sum(kind_of_cell(c, way.form, settings) == "text" for c in cells) * 2 > sum(map(bool, cells))
    ]
    below, keyed = none, _keyed_units(rows[:first], wide)
    if settings.units_row is None and not keyed[0]:
        below = next((line for line in reversed(wordy) if len(named) > 1 and _are_units(line[1], columns)), none)
    if settings.units_row is None:
        units = keyed if keyed[0] else (below[0], [_bare(cell) for cell in below[1]])
    least = sum(kind not in ("gap", "text") for kind in columns)
    telling = [
        (row, cells)
        for row, cells in wordy
        if row not in (units[0], below[0]) and 2 * sum(map(bool, cells)) >= least and not _tells_nothing(cells)
    ]
    if above := [at for at in named if at[1][0].casefold() == "name"] or [at for at in telling if at[0] < below[0]]:
        return above[-1], units
    if before := [line for line in named if line[0] < below[0]] if not telling else []:
        return before[-1], units
    if telling or wordy:
        return (telling or wordy)[-1], units if telling else (settings.units_row or 0, units[1])
    # A comment above the numbers may be the header; else the text right above them, whatever its width or delimiter.
    above_rows = range(1, rows[first][0])
    comments = [row for row in above_rows if is_comment(lines[row - 1]) and len(cells_of(row)) == wide]
    if comments and wide > 1:
        return (comments[-1], cells_of(comments[-1])), units
    row, direct = rows[first - 1] if first else none
    split_otherwise = [split(lines[row - 1], other) for other in DELIMITERS] if row else []
    for cells in (*(cells for cells in split_otherwise if len(cells) == wide), direct):
        texts = sum(kind_of_cell(cell, way.form, settings) == "text" for cell in cells)
        if 2 * texts > len(cells) > 1:
            return (row, cells), units
    return none, units


def _keyed_units(rows: Sequence[Row], wide: int) -> Row:
    """The units in rows whose first cell says that they are units: of the columns behind it, or of time alone."""
    number, units = 0, [""] * wide
    for row, cells in rows:
        stated = ["" if cell in (cells[0], "1") else _bare(cell) for cell in cells[1:wide]]
        if re.search(_UNIT_KEY, cells[0], re.IGNORECASE) and _is_units(stated):
            times = all(unit_dimension(column_unit(unit) or "") == unit_dimension("s") for unit in filter(None, stated))
            units = [next(filter(None, stated)), *units[1:]] if times else [units[0], *stated]
            number, units = row, [*units, *[""] * wide][:wide]
    return number, units


def _are_units(cells: Sequence[str], columns: Sequence[Kind]) -> bool:
    """Whether a row holds the units of most of the columns of numbers."""
    filled = [_bare(cell) for cell, kind in zip(cells, columns) if kind in ("number", "gap") and cell not in ("", "-")]
    return 2 * sum(column_unit(cell) is not None for cell in filled) > len(filled)


def _tells_nothing(cells: Sequence[str]) -> bool:
    """Whether a row repeats one part, or holds types of data."""
    periods = [p for p in range(1, len(cells) // 2 + 1) if len(cells) % p == 0]
    types = [cell for cell in cells if cell not in ("", cells[0])]
    return any(list(cells) == [*cells[:p]] * (len(cells) // p) for p in periods) or bool(
        types and all(re.fullmatch(_TYPES, cell, re.IGNORECASE) for cell in types)
    )


def _is_units(cells: Sequence[str]) -> bool:
    """Whether each filled cell is a unit, in brackets or not."""
    filled = [unit for cell in cells if (unit := _bare(cell))]
    return bool(filled) and all(column_unit(cell) is not None for cell in filled)


def _bare(cell: str) -> str:
    """A unit without its brackets, or a quantity in brackets behind it; empty for a dash, or `(None)`."""
    inner = re.fullmatch(r"[\[(<]\s*(.*?)\s*[\])>]|(?P<unit>\S+) \([^()]*\)", cell)
    text = (inner[1] or inner["unit"] or "") if inner else cell
    return "" if text == "-" or text in GAPS else text


def _refuse_grouped(rows: Sequence[Sequence[str]], form: NumberForm, name: str) -> None:
    """Refuse numbers whose mark may group thousands: where all commas of a file may, and where a column has whole
    numbers of up to three digits beside numbers of which each point may: with decimals, those would have them, too."""
    numbers = [[cell for cell in column if form.value(cell) is not None] for column in zip(*rows)]
    if form.decimal == ",":
        numbers = [[cell for column in numbers for cell in column if "," in cell]]
    else:
        numbers = [column for column in numbers if any(re.fullmatch(r"[+-]?\d{1,3}", cell) for cell in column)]
    grouped = re.compile(rf"[+-]?[1-9]\d{{0,2}}({re.escape(form.decimal)}\d{{3}})+")
    for column in numbers:
        marked = [cell for cell in column if form.decimal in cell]
        if marked and all(grouped.fullmatch(cell) for cell in marked):
            mark, word = form.decimal, "comma" if form.decimal == "," else "point"
            raise InputError(
                f"{name}: '{marked[0]}': is the {word} a decimal sign, or does it group thousands? If it is a decimal "
                f'sign, write [format] decimal = "{mark}"; if it groups thousands, [format] thousands = "{mark}"'
            )


def _remarks(way: _Way, encoding: str, header: int, units: int, first: int, plain: int) -> list[str]:
    """Differences from plain CSV: comma, decimal point, header in the first line, UTF-8."""
    remarks = [] if way.delimiter == "," else [DELIMITERS[way.delimiter]]
    remarks += ["decimal comma"] if way.form.decimal == "," else []
    remarks += [f"'{way.form.thousands}' groups thousands"] if way.form.thousands else []
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
