"""CSV files: pyarrow reads them; where it fails, a slower reader finds the cell at fault."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import RecordFile, to_numpy
from sysid.experiment.toml_table import shown

_EMPTY = ("", "nan", "NaN", "NAN", "-nan", "NA", "null")


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
        arrays = [to_numpy(table.column(name)) for name in wanted]
        if any(np.isinf(array).any() for array in arrays):
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
