"""Interface of the readers of record files: two pure functions of a path, one for the labels, one for the columns."""

import hashlib
import stat
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from stagecad.parameters.errors import InputError, nearest, require
from sysid.experiment.toml_table import TomlTable, kind_of, quantity, shown

DELIMITERS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", " ": "blanks"}
"""Characters between columns, and their names; any run of blanks and tabs is one delimiter for ' '."""

ASCII = "".join(map(chr, range(32, 127))) + "\\u0041\t\n"
"""A text that the encoding of a text file writes with the bytes of ASCII, besides zeros and byte order marks."""

OTHER_FORMATS = tomllib.loads(Path(__file__).with_name("other_formats.toml").read_text("utf-8"))["format"]

REPEATED_TIME = ("first", "mean", "spread")


@dataclass(frozen=True)
class Format:
    """Settings of `[format]` (docs/records.md); what is None is detected in the file.

    Rows are numbered from 1, as an editor counts them; 0 stands for none. Blanks and apostrophes between digits mean
    nothing but groups, so that a blank as `thousands` is none. `missing` are cells that mark a gap, besides empty ones;
    `time_format` has the codes of `strptime`; `repeated_time` says what to make of rows with the time of the row
    before; `sample_rate` is in Hz."""

    delimiter: str | None = None
    decimal: str | None = None
    thousands: str | None = None
    header: int | None = None
    units_row: int | None = None
    first_row: int | None = None
    encoding: str | None = None
    missing: tuple[str, ...] = ()
    time_format: str | None = None
    repeated_time: Literal["first", "mean", "spread"] | None = None
    sample_rate: float | None = None


def read_format(table: TomlTable) -> Format:
    """The settings in a table `[format]`."""
    table.allow(Format.__dataclass_fields__)
    delimiter = encoding = None
    if "delimiter" in table.data:
        names = {name: sign for sign, other in DELIMITERS.items() for name in (sign, other)} | {"space": " "}
        written = table.text("delimiter")
        if written not in names:
            raise InputError(
                f"{table.where('delimiter')}: {shown(written)} is not allowed; allowed: comma, semicolon, tab, bar, "
                "blanks, or the character itself"
            )
        delimiter = names[written]
    decimal = table.choice("decimal", (".", ",")) if "decimal" in table.data else None
    thousands = table.choice("thousands", (".", ",", "'", " ", "none")) if "thousands" in table.data else None
    thousands = "" if thousands == "none" else thousands
    if thousands and thousands == decimal:
        raise InputError(f"{table.where('thousands')}: {shown(thousands)} is the decimal sign too")
    if thousands in (".", ",") and decimal is None:
        decimal = "," if thousands == "." else "."
    if decimal == "," and delimiter == ",":
        raise InputError(f"{table.where('decimal')}: a comma cannot be both the decimal sign and the delimiter")
    if "encoding" in table.data:
        encoding = table.text("encoding")
        try:
            data = ASCII.encode(encoding)
            known = data.decode(encoding) == ASCII == data.translate(None, b"\0\xff\xfe\xef\xbb\xbf").decode("ascii")
        except (LookupError, ValueError):
            known = False
        if not known:
            raise InputError(
                f"{table.where('encoding')}: {shown(encoding)} is no text encoding; such as utf-8, utf-16, cp1252"
            )
    repeated: Any = table.choice("repeated_time", REPEATED_TIME) if "repeated_time" in table.data else None
    rate = quantity(table, "sample_rate", "Hz", positive=True) if "sample_rate" in table.data else None
    return Format(
        delimiter=delimiter,
        decimal=decimal,
        thousands=thousands,
        header=_row(table, "header", absent=True),
        units_row=_row(table, "units_row", absent=True),
        first_row=_row(table, "first_row"),
        encoding=encoding,
        missing=table.texts("missing"),
        time_format=table.text("time_format") if "time_format" in table.data else None,
        repeated_time=repeated,
        sample_rate=rate,
    )


def _row(table: TomlTable, key: str, absent: bool = False) -> int | None:
    """A row number from 1; with `absent`, `false` for no such row is 0."""
    value = table.data.get(key)
    if value is None:
        return None
    if absent and value is False:
        return 0
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST_ROWS:
        wanted = f"a row number from 1 to {MOST_ROWS}" + ", or false if there is none," * absent
        kind = f"{shown(value)} is {kind_of(value)}" if not isinstance(value, int) else f"{shown(value)} is not allowed"
        raise InputError(f"{table.where(key)}: {kind}; {wanted} is required")
    return value


MOST_BYTES = 2 * 1024**3
"""Largest text file, bytes. Of a binary one, which may hold what is not read, the reader's memory is limited."""
MEMORY = 4 * 1024**3
"""Largest memory that the reader of a binary file takes beyond the file's size, or twice `MOST_BYTES`, bytes."""
MOST_COLUMNS = 10_000
"""Largest number of columns of a record file."""
MOST_ROWS = 20_000_000
"""Largest number of rows of a record file."""


@dataclass(frozen=True)
class Header:
    """Columns of a file, as the file describes them: labels as written, and units by label where they stand apart.

    `remarks` say how the file is read where it is not the plain form of its format; `texts` is the first cell, by
    label, of columns of text; `dates` are columns that are read with the time of day of another; a file without labels
    is `numbered`; `layout` is where the reader finds the columns."""

    labels: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    texts: Mapping[str, str] = field(default_factory=dict)
    dates: tuple[int, ...] = ()
    numbered: bool = False
    layout: Any = None


class Column(NamedTuple):
    """The numbers of one column, (n,), NaN in gaps, and the number that was subtracted from them (`origin`), which
    is not zero in time stamps only; `said` is the note on it for the user. `notes` are on rows left out."""

    values: np.ndarray
    origin: float = 0.0
    said: str = ""
    notes: tuple[str, ...] = ()


class Reader(Protocol):
    """The reader of one format: its functions keep nothing. `name` stands in messages, `settings` is `[format]`."""

    def read_header(self, path: Path, name: str, settings: Format) -> Header:
        """The labels. InputError: not readable in this format."""
        ...

    def read_columns(
        self, path: Path, name: str, header: Header, indices: Sequence[int], settings: Format
    ) -> list[Column]:
        """The columns at `indices`. InputError: a cell that is not a number, with its row and column."""
        ...


def check_file(path: Path, name: str, suffixes: Sequence[str], is_text: bool) -> None:
    """Refuse a path that is not a file with something in it, or a large text; `suffixes` are those of record files."""
    require(not is_folder(path), f"{name}: is a folder, a CSV, Parquet or MAT file is required")
    try:
        found, start = path.stat(), b""
        if stat.S_ISREG(found.st_mode):
            with path.open("rb") as file:
                start = file.read(4096)
    except (FileNotFoundError, NotADirectoryError):
        folder = path.parent
        beside = [file.name for file in folder.iterdir() if file.suffix in suffixes] if folder.is_dir() else []
        raise InputError(f"{shown_path(name)}: no such file{nearest(path.name, beside) if beside else ''}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{shown_path(name)}: cannot be read: {reason}") from None
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{shown_path(name)}: is not a regular file; a CSV, Parquet or MAT file is required")
    if is_text and found.st_size > MOST_BYTES:
        most = f"{MOST_BYTES / 1024**3:g} GB"
        raise InputError(f"{shown_path(name)}: is larger than {most}; split it, or keep every n-th row")
    require(start.strip(), f"{name}: the file is empty; one header row and at least two rows of numbers are required")


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, read in pieces."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def shown_path(name: str) -> str:
    """A file name for a message: one line, its middle left out when it is very long."""
    text = " ".join(name.split())
    return text if len(text) <= 120 else f"{text[:60]}...{text[-40:]}"


def is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def check_finite(array: np.ndarray, file: str, label: str) -> None:
    """Refuse infinite values, naming the first."""
    if np.isinf(array).any():
        row = int(np.flatnonzero(np.isinf(array))[0])
        raise InputError(
            f"{file}: row {row + 1}, column '{label}': {array[row]} is not finite; leave a gap empty (NaN)"
        )


def to_numpy(column: Any) -> np.ndarray:
    """A chunked column of floats as one array, off its buffers: pyarrow's own conversion loads pandas, 0.3 s."""
    array = column.combine_chunks()
    validity, data = array.buffers()
    rows = slice(array.offset, array.offset + len(array))
    out = np.full(len(array), np.nan) if data is None else np.frombuffer(data, dtype=np.float64)[rows].copy()
    if validity is not None:
        out[np.unpackbits(np.frombuffer(validity, dtype=np.uint8), bitorder="little")[rows] == 0] = np.nan
    return out
