"""Record files as they lie on disk: CSV, Parquet, MAT; header first, then the columns that are asked for.

The CSV reader takes pyarrow's fast path; only where that fails does a slow one look for the cell at fault, so a good
file of 20 000 rows costs some hundredths of a second, and pandas is never loaded.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from sysid.experiment.toml_table import shown

if TYPE_CHECKING:
    import numpy as np

SUFFIXES = {".csv": "CSV", ".parquet": "Parquet", ".pq": "Parquet", ".mat": "MAT"}
_EMPTY = ("", "nan", "NaN", "NAN", "-nan", "NA", "null")


class RecordFile:
    """An open record file: its labels, and its columns as arrays on demand.

    Args:
        path: the file.
        name: shown in messages.

    Raises:
        InputError: no such file, another format, nothing in it, not readable as what its name says.
    """

    labels: list[str]

    def __init__(self, path: Path, name: str) -> None:
        self.path = path
        self.name = name
        self.data = _read_bytes(path, name)
        self.units: dict[str, str] = {}

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """The columns at `indices` as floats of shape (n,), NaN where a cell is empty."""
        raise NotImplementedError

    def row_name(self, row: int) -> str:
        """How the user would find row `row` (from 0) of the columns in the file."""
        return f"row {row + 1}"


def _read_bytes(path: Path, name: str) -> bytes:
    if _is_folder(path):
        raise InputError(f"{name}: is a folder, a CSV, Parquet or MAT file is wanted")
    try:
        data = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        folder = path.parent
        beside = [file.name for file in folder.iterdir() if file.suffix in SUFFIXES] if folder.is_dir() else []
        raise InputError(f"{shown_path(name)}: no such file{nearest(path.name, beside) if beside else ''}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{shown_path(name)}: cannot be read: {reason}") from None
    if not data.strip():
        raise InputError(f"{name}: the file is empty; one header row and at least two rows of numbers are wanted")
    return data


def shown_path(name: str) -> str:
    """A file name for a message: one line, its middle left out when it is very long."""
    text = " ".join(name.split())
    return text if len(text) <= 120 else f"{text[:60]}...{text[-40:]}"


def open_record_file(path: Path, name: str) -> RecordFile:
    """Open a record file by its suffix.

    Raises:
        InputError: as `RecordFile`.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES and not _is_folder(path):
        raise InputError(f"{shown_path(name)}: '{suffix}' is no record format; allowed: .csv, .parquet, .mat")
    if SUFFIXES.get(suffix, "CSV") == "CSV":
        return CsvFile(path, name)
    if SUFFIXES[suffix] == "Parquet":
        return ParquetFile(path, name)
    from sysid.experiment.readers.mat import MatFile

    return MatFile(path, name)


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


class CsvFile(RecordFile):
    """Comma-separated values with one header row."""

    def __init__(self, path: Path, name: str) -> None:
        super().__init__(path, name)
        if self.data[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise InputError(f"{name}: is UTF-16; save it as UTF-8")
        if self.data[:4] == b"PAR1":
            raise InputError(f"{name}: is a Parquet file; give it the suffix .parquet")
        if b"\x00" in self.data[:4096]:
            raise InputError(f"{name}: holds binary data, no CSV text")
        self.data = self.data.removeprefix(b"\xef\xbb\xbf")
        ends = [place for place in (self.data.find(b"\n"), self.data.find(b"\r")) if place >= 0]
        first = self.data[: min(ends)] if ends else self.data
        try:
            header = first.decode("utf-8")
        except UnicodeDecodeError as error:
            raise InputError(f"{name}: row 1: byte {error.start + 1} is not UTF-8; save the file as UTF-8") from None
        for separator, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
            if separator in header and "," not in header:
                raise InputError(
                    f"{name}: row 1: columns are separated by {word}; "
                    "commas are wanted between columns, and a point as decimal sign"
                )
        self.labels = next(csv.reader([header]), [])
        if not any(label.strip() for label in self.labels):
            raise InputError(f"{name}: row 1: the header is empty; wanted: time [s], position [m], ...")
        if header.lstrip().startswith(("#", "%", "//")):
            raise InputError(f"{name}: row 1: is a comment, the header is wanted there: time [s], position [m], ...")
        if all(_number(label) is not None for label in self.labels):
            raise InputError(f"{name}: row 1: holds numbers, a header is wanted: time [s], position [m], ...")

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """Columns as floats; see `RecordFile.columns`."""
        import pyarrow
        from pyarrow import csv as arrow

        names = [f"c{place}" for place in range(len(self.labels))]
        wanted = [names[index] for index in indices]
        try:
            table = arrow.read_csv(
                io.BytesIO(self.data),
                read_options=arrow.ReadOptions(skip_rows=1, column_names=names),
                parse_options=arrow.ParseOptions(newlines_in_values=False),
                convert_options=arrow.ConvertOptions(
                    include_columns=list(dict.fromkeys(wanted)),
                    column_types=dict.fromkeys(wanted, pyarrow.float64()),
                    null_values=list(_EMPTY),
                    strings_can_be_null=True,
                ),
            )
        except pyarrow.ArrowInvalid:
            return self._columns_slowly(indices)
        arrays = [_to_numpy(table.column(name)) for name in wanted]
        if any(_has_infinity(array) for array in arrays):
            return self._columns_slowly(indices)
        return arrays

    def _rows(self) -> list[tuple[int, list[str]]]:
        """Every row that is not blank with its number in the file, as a spreadsheet counts it."""
        try:
            text = self.data.decode("utf-8")
        except UnicodeDecodeError as error:
            row = len(re.findall(rb"\r\n|\r|\n", self.data[: error.start])) + 1
            raise InputError(f"{self.name}: row {row}: a byte is not UTF-8; save the file as UTF-8") from None
        try:
            lines = re.split(r"\r\n|\r|\n", text)
            return [(number, cells) for number, cells in enumerate(csv.reader(lines), start=1) if cells][1:]
        except csv.Error as error:
            raise InputError(f"{self.name}: not readable as CSV: {error}") from None

    def _columns_slowly(self, indices: Sequence[int]) -> list[np.ndarray]:
        import numpy as np

        width = len(self.labels)
        rows = self._rows()
        columns: list[list[float]] = [[] for _ in indices]
        for row, cells in rows:
            if len(cells) != width:
                whole = sum(re.fullmatch(r"-?\d+", cell.strip()) is not None for cell in cells)
                # A comma too many at the end of a row is no decimal comma.
                decimal = len(cells) > width and whole > 1 and cells[-1].strip() != ""
                hint = "; is the decimal sign a comma? a point is wanted" if decimal else ""
                has = f"{len(cells)} cell{'s' * (len(cells) != 1)}"
                raise InputError(f"{self.name}: row {row}: has {has}, the header has {width}{hint}")
            for column, index in zip(columns, indices):
                cell = cells[index].strip()
                value = math.nan if cell in _EMPTY else _number(cell)
                if value is None or math.isinf(value):
                    problem = "is no number" if value is None else "is not finite"
                    hint = "; a point is wanted as decimal sign" if re.fullmatch(r"-?\d+,\d+", cell) else ""
                    raise InputError(
                        f"{self.name}: row {row}, column '{self.labels[index].strip()}': {shown(cell)} {problem}"
                        f"{hint or '; a number is wanted, or nothing for a gap'}"
                    )
                column.append(value)
        return [np.array(column, dtype=float) for column in columns]

    def row_name(self, row: int) -> str:
        """Row number as a spreadsheet or editor shows it (the header is row 1)."""
        rows = self._rows()
        return f"row {rows[row][0]}" if row < len(rows) else f"row {row + 2}"


def _number(cell: str) -> float | None:
    try:
        return float(cell) if "_" not in cell else None
    except ValueError:
        return None


def _has_infinity(array: np.ndarray) -> bool:
    import numpy as np

    return bool(np.isinf(array).any())


class ParquetFile(RecordFile):
    """An Apache Parquet file with columns of numbers."""

    def __init__(self, path: Path, name: str) -> None:
        super().__init__(path, name)
        import pyarrow
        from pyarrow import parquet

        try:
            self.file: Any = parquet.ParquetFile(io.BytesIO(self.data))
        except (pyarrow.ArrowException, OSError):
            raise InputError(f"{name}: is no Parquet file, or a damaged one") from None
        self.labels = list(self.file.schema_arrow.names)

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """Columns as floats; see `RecordFile.columns`."""
        import pyarrow

        try:
            table = self.file.read()
        except (pyarrow.ArrowException, OSError):
            raise InputError(f"{self.name}: is a damaged Parquet file") from None
        arrays = []
        for index in indices:
            column = table.column(index)
            if not (pyarrow.types.is_integer(column.type) or pyarrow.types.is_floating(column.type)):
                raise InputError(f"{self.name}: column '{self.labels[index]}': holds {column.type}, numbers are wanted")
            array = _to_numpy(column.cast(pyarrow.float64(), safe=False))
            check_finite(array, self.name, self.labels[index])
            arrays.append(array)
        return arrays


def _to_numpy(column: Any) -> np.ndarray:
    """A chunked column of floats as one array, off its buffers: pyarrow's own conversion loads pandas, 0.3 s."""
    import numpy as np

    parts = [np.empty(0)]
    for chunk in column.chunks:
        validity, data = chunk.buffers()
        rows = slice(chunk.offset, chunk.offset + len(chunk))
        values = np.frombuffer(data, dtype=np.float64)[rows] if data is not None else np.full(len(chunk), np.nan)
        if validity is not None:
            valid = np.unpackbits(np.frombuffer(validity, dtype=np.uint8), bitorder="little")[rows]
            values = np.where(valid, values, np.nan)
        parts.append(values)
    return np.concatenate(parts)


def check_finite(array: np.ndarray, file: str, label: str) -> None:
    """Refuse infinite values, naming the first."""
    import numpy as np

    if np.isinf(array).any():
        row = int(np.flatnonzero(np.isinf(array))[0])
        raise InputError(
            f"{file}: row {row + 1}, column '{label}': {array[row]} is not finite; leave a gap empty (NaN)"
        )
