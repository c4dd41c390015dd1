"""Text files with columns: pyarrow reads them; where it fails, a slower reader finds the cell at fault."""

import array
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from stagecad.deferred import compute, pyarrow
from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import OTHER_FORMATS, Column, Format, Header, to_numpy
from sysid.experiment.readers.dialect import DIGITS, Dialect, find_dialect, is_comment, unit_factor, unit_of_cell
from sysid.experiment.readers.limited_text import BLOCK, is_gzip, need_few_rows, open_bytes
from sysid.experiment.readers.numbers import SCPI_OVERLOAD, is_hexadecimal, respelled_column
from sysid.experiment.toml_table import shown

HEAD = 1 << 18
"""Bytes at the start of a file in which its form is looked for."""

_MARKS = (
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
    (b"\xef\xbb\xbf", "utf-8-sig"),
)


def read_head(path: Path, name: str) -> tuple[bytes, bool]:
    """The first bytes of a file, decompressed, and whether it has more."""
    with open_bytes(path, name) as file:
        data = file.read(HEAD)
        more = bool(file.read(1))
    for other in OTHER_FORMATS:
        if "begins" in other and data.startswith(bytes.fromhex(other["begins"])):
            raise InputError(f"{name}: is {other['is']}; {other['instead']}")
    if b"\x00" in data[:4096] and not data.startswith(tuple(mark for mark, _ in _MARKS)) and not _utf_16(data):
        raise InputError(f"{name}: holds binary data, no CSV text")
    if more and b"\n" not in data and b"\r" not in data:
        raise InputError(f"{name}: its first row is longer than {HEAD // 1024} kB; is it a file with columns?")
    return data, more


def _utf_16(head: bytes) -> str:
    """The encoding of a text without a byte order mark that has the bytes of ASCII letters in UTF-16; else empty."""
    first, second = head[0:200:2], head[1:200:2]
    little, big = all(first) and not any(second), all(second) and not any(first)
    return "utf-16-le" if second and little else "utf-16-be" if second and big else ""


def encoding_of(head: bytes, settings: Format, name: str) -> str:
    """The encoding of a text by its first bytes: by its byte order mark, else UTF-8, else Windows-1252, whose numbers
    have the same bytes."""
    if settings.encoding is not None:
        try:
            head[: len(head) // 4 * 4 - 8 if len(head) == HEAD else None].decode(settings.encoding)
        except UnicodeError as error:
            raise InputError(
                f"{name}: byte {getattr(error, 'start', 0) + 1} is not {settings.encoding}; see [format] encoding"
            ) from None
        return settings.encoding
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    if encoding := _utf_16(head):
        return encoding
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        # A character may be cut by the end of the head.
        if error.start < len(head) - 3 or len(head) < HEAD:
            return "cp1252"
    return "utf-8"


def lines_of(path: Path, encoding: str, name: str) -> Iterator[str]:
    """Every line of a file without its end."""
    with open_bytes(path, name) as file:
        # Bytes that cp1252 leaves undefined stand in no number.
        text = io.TextIOWrapper(file, encoding, errors="replace" if encoding == "cp1252" else "strict", newline=None)
        row = 0
        try:
            for line in text:
                row += 1
                yield line.rstrip("\n").lstrip("\ufeff")
        except UnicodeError:
            raise InputError(
                f"{name}: near row {row + 1}: a byte is not {encoding.upper()}; name the encoding: "
                '[format] encoding = "..."'
            ) from None


class SingleBlanks(io.RawIOBase):
    """A stream in which each run of blanks and tabs is one blank, none at the ends of lines."""

    def __init__(self, source: BinaryIO) -> None:
        self.source = source
        self.rest = b""
        self.ready = b""

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        while not self.ready:
            block = self.source.read(BLOCK)
            # A block is cut at the end of a line, so that no run of blanks is cut.
            whole, end, rest = (self.rest + block).rpartition(b"\n")
            self.rest = rest
            if not block:
                whole, end, self.rest = rest, b"", b""
                if not whole:
                    return 0
            singled = re.sub(rb"[ \t]+", b" ", whole + end)
            self.ready = re.sub(rb"(?m)^ +| +(?=\r?$)", b"", singled)
        count = min(len(buffer), len(self.ready))
        buffer[:count] = self.ready[:count]
        self.ready = self.ready[count:]
        return count


MOST_CELLS = 10_000
"""In a row that is read cell by cell."""
LONG_DIGITS = 10
"""Digits before the decimal sign from which a number (a Unix time) is read exactly and counted from its first row."""

_MARK = re.compile(r"\D*|[<>≤≥].*|[^\d.,]+\d{0,4}|-?\d\.#\w*")
"""What may stand for a number that is not there: words, `>5.0`, `E201`, and `1.#R`, which is 1.#QNAN rounded."""
LONGEST_MARK = 80
"""Characters below which a cell is proposed as a mark of a gap."""
_STAMP = re.compile(r"\d{1,4}[./-]\d{1,2}[./-]\d{1,4}|\d:\d\d")
"""The numbers are bounded, since a search begins at each digit of a cell, which may be a million digits long."""


def read_header(path: Path, name: str, settings: Format) -> Header:
    """The labels of a text file; its form is `layout`, a `Dialect`."""
    head, more = read_head(path, name)
    return _header_of(head, more, is_gzip(path), name, settings)


@lru_cache(maxsize=8)
def _header_of(head: bytes, more: bool, gzipped: bool, name: str, settings: Format) -> Header:
    """The labels of a file that begins with `head`; a command opens each of its files several times."""
    encoding = encoding_of(head, settings, name)
    text = head.decode(encoding, errors="replace")
    lines = re.split(r"\r\n|\r|\n", text)
    found = find_dialect(lines, encoding, settings, name, complete=not more)
    if found.header_row and not any(label.strip() for label in found.labels):
        raise InputError(f"{name}: row {found.header_row}: the header is empty; required: time [s], position [m], ...")
    by_column = {k: unit for k, unit in enumerate(found.units) if unit}
    by_column |= {**dict.fromkeys(found.stamps, "s"), **{k: unit for k, unit in found.spelled.items() if unit}}
    # Columns of one name and several units, as of two sensors: their names carry them. A unit may have no name above.
    named = [label or f"column {k + 1}" * bool("".join(found.units[k : k + 1])) for k, label in enumerate(found.labels)]
    labels = tuple(
        f"{label} [{by_column[k]}]" if k in by_column and named.count(label) > 1 else label
        for k, label in enumerate(named)
    )
    units = {label: by_column[k] for k, label in enumerate(labels) if k in by_column}
    remarks = (*(["gzip"] if gzipped else []), *found.remarks)
    dates = tuple({*chain(*found.dates.values())} - {*found.dates})
    return Header(labels, units, remarks, found.texts, dates, found.numbered, found)


def read_columns(path: Path, name: str, header: Header, indices: Sequence[int], settings: Format) -> list[Column]:
    """Columns of a text file; see `Reader`."""
    dialect: Dialect = header.layout
    wanted = list(dict.fromkeys(indices))
    found = None
    # Spelled numbers that begin below the head are found by the second try, other faults by the slow reader.
    tries = (dialect.spelled, {**dict.fromkeys(set(wanted) - set(dialect.stamps), ""), **dialect.spelled})
    for spelled in () if dialect.keyed else tries:
        found = found or _fast_columns(path, name, dialect, wanted, spelled)
    if found is None:
        found = dict(zip(wanted, _columns_slowly(path, name, dialect, wanted)))
    if cut := _cut_number(path, dialect):
        note = f"the last row is cut off in its last number, '{cut}'; left out"
        for index, column in found.items():
            found[index] = column._replace(values=column.values[:-1], notes=(*column.notes, note))
    for column in found.values():
        column.values[np.abs(column.values) >= SCPI_OVERLOAD] = np.nan
    return [found[index] for index in indices]


def _cut_number(path: Path, dialect: Dialect) -> str:
    """The number at the end of a file without the end of its last row, if all rows above have more digits behind the
    decimal sign; else empty."""
    if is_gzip(path) or dialect.encoding not in ("utf-8", "utf-8-sig", "cp1252"):
        return ""
    with path.open("rb") as file:
        file.seek(-min(path.stat().st_size, BLOCK >> 8), io.SEEK_END)
        text = file.read().decode(dialect.encoding, errors="replace")
    rows = [dialect.cells(line) for line in re.split(r"\r\n|\r|\n", text)[1:]]
    if not rows or any(len(row) != dialect.width or dialect.form.value(row[-1]) is None for row in rows):
        return ""
    digits = [len(row[-1].partition(dialect.form.decimal)[2]) for row in rows]
    return rows[-1][-1] if len({*digits[:-1]}) == 1 and digits[-1] < digits[0] else ""


def _fast_columns(
    path: Path, name: str, dialect: Dialect, wanted: Sequence[int], spelled: Mapping[int, str]
) -> dict[int, Column] | None:
    """The columns by index as pyarrow reads them; None where a row or a cell needs a look."""
    table = _arrow_table(path, name, dialect, wanted, spelled)
    if table is None:
        return None
    found: dict[int, Column] = {}
    for index in wanted:
        cells, places = table.column(f"c{index}"), dialect.dates.get(index, ())
        if places:
            parts = [table.column(f"c{place}") for place in places]
            cells = compute.binary_join_element_wise(*parts, " ")  # type: ignore[attr-defined]
        elif index in spelled and index not in dialect.stamps:
            cells = respelled_column(cells, dialect.form, dialect.gaps, spelled[index])
        table = table.drop_columns([f"c{index}"])
        column = None
        # A text among the time stamps may stand below the numbers: the slow reader knows.
        with suppress(InputError):
            column = None if cells is None else _from_arrow(cells, dialect, index, name)
        if column is None:
            return None
        found[index] = column
    return found


def row_number(path: Path, name: str, header: Header, row: int) -> int:
    """Row number as an editor or spreadsheet shows it."""
    for k, (place, _) in enumerate(_data_rows(path, name, header.layout, [])):
        if k == row:
            return place
    return header.layout.first_row + row


def _arrow_table(path: Path, name: str, dialect: Dialect, indices: Sequence[int], spelled: Mapping[int, str]) -> Any:
    """The columns as pyarrow reads them; None where it cannot."""
    from pyarrow import csv as arrow

    names = [f"c{place}" for place in range(dialect.width)]
    texts = {*dialect.stamps, *spelled}
    parts = {place for k in indices for place in dialect.dates.get(k, ())}
    indices, texts = [*{*indices, *parts}], texts | parts
    types = {f"c{k}": pyarrow.string() if k in texts else pyarrow.float64() for k in indices}
    types |= {f"c{k}": pyarrow.decimal128(32, 12) for k in _long_numbers(path, dialect) if k in {*indices} - texts}
    try:
        need_few_rows(path, name)
        with open_bytes(path, name) as file:
            return arrow.read_csv(
                io.BufferedReader(SingleBlanks(file)) if dialect.delimiter == " " else file,
                read_options=arrow.ReadOptions(
                    skip_rows=dialect.first_row - 1,
                    column_names=names,
                    encoding="utf8" if dialect.encoding in ("utf-8", "utf-8-sig") else dialect.encoding,
                ),
                parse_options=arrow.ParseOptions(delimiter=dialect.delimiter, newlines_in_values=False),
                convert_options=arrow.ConvertOptions(
                    include_columns=list(types),
                    column_types=types,
                    null_values=list(dialect.gaps),
                    strings_can_be_null=True,
                    decimal_point=dialect.form.decimal,
                    check_utf8=False,
                ),
            )
    except (pyarrow.ArrowInvalid, UnicodeError):
        return None


def _long_numbers(path: Path, dialect: Dialect) -> list[int]:
    """Columns that begin with a number of many digits."""
    for _, cells in _rows(path, str(path), dialect):
        if len(cells) != dialect.width:
            return []
        return [k for k, cell in enumerate(cells) if re.match(rf"[+-]?\d{{{LONG_DIGITS},19}}(?!\d)", cell)]
    return []


def _from_arrow(column: Any, dialect: Dialect, index: int, name: str) -> Column | None:
    """A column off pyarrow's; None where a cell needs the slow reader."""
    if index in dialect.stamps:
        return dialect.seconds(column, index, name)
    if pyarrow.types.is_decimal(column.type):
        if column.null_count:
            column = column.cast(pyarrow.float64())
        else:
            first = column[0]
            counted = compute.subtract(column, first).cast(pyarrow.float64())  # type: ignore[attr-defined]
            return Column(
                to_numpy(counted), float(first.as_py()), f"'{dialect.labels[index]}' is counted from its first row"
            )
    values = to_numpy(column)
    return None if np.isinf(values).any() else Column(values)


def _rows(path: Path, name: str, dialect: Dialect) -> Iterator[tuple[int, list[str]]]:
    """Every row of numbers with its number in the file, without blank lines and comments."""
    for row, line in enumerate(lines_of(path, dialect.encoding, name), start=1):
        if row >= dialect.first_row and line.strip() and not is_comment(line):
            if line.count(dialect.delimiter) > MOST_CELLS:
                raise InputError(f"{name}: row {row}: has more than {MOST_CELLS} cells")
            yield row, dialect.cells(line)


def _data_rows(path: Path, name: str, dialect: Dialect, notes: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Every row of numbers with its number in the file. Rows that repeat the header, and text or a cut row below the
    numbers, are left out with a note."""
    held: list[tuple[int, list[str]]] = []
    repeated = wider = texts = 0
    labels = [label.strip() for label in dialect.labels]
    headers = [cells for cells in (labels, [*filter(None, labels)], [*dialect.units]) if dialect.header_row and cells]
    for row, cells in _rows(path, name, dialect):
        beyond = filter(None, cells[dialect.width :])
        if len(cells) > dialect.width and all(dialect.form.value(cell) is None for cell in beyond):
            wider, cells = wider + 1, cells[: dialect.width]
        if cells in headers:
            # A second header is repeated with the lines above it, such as those of a segment of LabVIEW.
            repeated += 1
            above = [line for line in held if dialect.form.value(line[1][0]) is None]
            texts, held = texts + len(above), [line for line in held if line not in above]
        elif len(cells) != dialect.width or _is_text(cells, dialect):
            held.append((row, cells))
        else:
            for at, other in held:
                kinds = {dialect.kind(cell) for cell in other}
                words = {*filter(None, other)} if dialect.settings.sample_rate is None else {}
                whole = not any(dialect.delimiter in cell for cell in other)
                if whole and kinds <= {"text", "gap"} and (len(other) != dialect.width or len(words) > 1):
                    if len(other) == dialect.width and all(
                        cell or label in ("", *dialect.texts) for cell, label in zip(other, labels)
                    ):
                        seen = shown(", ".join(other)[:80])
                        raise InputError(f"{name}: row {at}: {seen} is another header; split the file above it")
                    texts += 1
                    continue
                if len(other) != dialect.width:
                    raise InputError(f"{name}: row {at}: {_wrong_width(other, dialect)}")
                yield at, other
            held.clear()
            yield row, cells
    if repeated:
        notes.append(f"{repeated} row{'s' * (repeated > 1)} repeat{'s' * (repeated == 1)} the header; left out")
    if wider:
        notes.append(f"{wider} row{'s have' if wider > 1 else ' has'} cells beyond the last column; left out")
    if texts:
        notes.append(f"{texts} row{'s' * (texts > 1)} of text between the numbers; left out")
    if held:
        last = f"row {held[0][0]}" if len(held) == 1 else f"rows {held[0][0]} to {held[-1][0]}"
        numbers = [not _is_text(cells, dialect) for _, cells in held]
        if numbers[0] and (len(held) > 1 or len(held[0][1]) > dialect.width):
            raise InputError(f"{name}: row {held[0][0]}: {_wrong_width(held[0][1], dialect)}")
        without = f"hold{'s' * (len(held) == 1)} no numbers"
        why = "is cut off" if numbers[0] else "begin with text" if any(numbers) else without
        notes.append(f"{last} at the end {why}; left out")


def _is_text(cells: Sequence[str], dialect: Dialect) -> bool:
    """Whether no filled cell of a row is a number or a time, or the first one is a word in a column of numbers. Digits
    without a letter are no text: a number that is written otherwise than those above it."""

    def kind(cell: str) -> str:
        return "number" if DIGITS.fullmatch(cell) else dialect.kind(cell)

    if dialect.form.value(cells[0]) is None and dialect.labels[0] not in dialect.texts:
        return kind(cells[0]) == "text"
    return all(dialect.form.value(cell) is None for cell in cells) and {*map(kind, cells)} - {"gap"} == {"text"}


def _columns_slowly(path: Path, name: str, dialect: Dialect, indices: Sequence[int]) -> list[Column]:
    """The columns read line by line, or an error that names the cell at fault."""
    numbers = {index: array.array("d") for index in indices}
    texts: dict[int, list[str]] = {index: [] for index in indices if index in dialect.stamps}
    notes: list[str] = []
    for row, cells in _data_rows(path, name, dialect, notes):
        for index in indices:
            if index in texts:
                texts[index].append(" ".join(cells[k] for k in dialect.dates.get(index, (index,))))
            else:
                numbers[index].append(number_of(cells[index], name, row, index, dialect))
    times = {index: dialect.seconds(cells, index, name) for index, cells in texts.items()}
    found = (times.get(index) or Column(np.array(numbers[index], dtype=float)) for index in indices)
    return [column._replace(notes=tuple(notes)) for column in found]


def _wrong_width(cells: Sequence[str], dialect: Dialect) -> str:
    whole = sum(re.fullmatch(r"-?\d+", cell) is not None for cell in cells)
    # A comma too many at the end of a row is not a decimal comma.
    decimal = dialect.delimiter == "," and len(cells) > dialect.width and whole > 1 and cells[-1] != ""
    hint = "; is the decimal sign a comma? a point is required where commas separate the columns" if decimal else ""
    other = f"the header has {dialect.width}" if dialect.header_row else f"the others have {dialect.width}"
    return f"has {len(cells)} cell{'s' * (len(cells) != 1)}, {other}{hint}"


def number_of(cell: str, name: str, row: int, index: int, dialect: Dialect) -> float:
    """The number in a cell, NaN in a gap. InputError: neither, with the setting to write."""
    unit = dialect.spelled.get(index, "")
    bare = cell.removesuffix(unit).rstrip() if unit else cell
    value = math.nan if cell in dialect.gaps else dialect.form.value(bare)
    if value is not None and not math.isinf(value):
        return value
    written = unit_of_cell(cell, dialect.form)
    if unit and written and unit_factor(written)[1] == unit_factor(unit)[1]:
        # Displays of instruments choose a prefix for each number.
        number = dialect.form.value(cell.removesuffix(written).rstrip())
        return (math.nan if number is None else number) * unit_factor(written)[0] / unit_factor(unit)[0]
    problem = "is not a number" if value is None else "is not finite"
    hint = "; a number is required, or nothing for a gap"
    decimal, other = dialect.form.decimal, written
    if is_hexadecimal(cell):
        hint = "; counts in hexadecimal digits are not read: let the logger write decimal numbers"
    elif grouped := re.fullmatch(r"[+-]?\d{1,3}(?:([.,])\d{3})+(?:(?!\1)[.,]\d+)?", cell):
        hint = f"; if '{grouped[1]}' groups thousands: [format] thousands = \"{grouped[1]}\""
    elif re.fullmatch(r"-?\d+[.,]\d+", cell) and decimal not in cell:
        required = "point" if decimal == "." else "comma"
        hint = f'; a {required} is required as decimal sign, or [format] decimal = "{",."[decimal == ","]}"'
    elif re.fullmatch(r"\d{1,2}:\d\d", cell):
        hint = '; is it minutes and seconds, or hours and minutes? write [format] time_format = "%M:%S" or "%H:%M"'
    elif _STAMP.search(cell):
        hint = '; if it is a time stamp, name its form, such as [format] time_format = "%d.%m.%Y %H:%M:%S.%f"'
    elif re.search(r"\d[+-]\d", cell):
        hint = "; numbers touch; a delimiter between the columns is required"
    elif other and other != unit:
        hint = (
            f"; its unit is '{other}', the column's '{unit}'" if unit else f"; its unit '{other}' is in one cell only"
        )
    elif len(cell) < LONGEST_MARK and (value is not None or _MARK.fullmatch(cell)):
        hint = f'{hint}; if {shown(cell)} marks a gap: [format] missing = ["{cell}"]'
    raise InputError(f"{name}: row {row}, column '{dialect.labels[index].strip()}': {shown(cell)} {problem}{hint}")
