"""Apache Parquet files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MOST_ROWS, to_numpy


class ParquetColumns:
    """The columns of numbers of an Apache Parquet file."""

    def __init__(self, data: bytes, name: str) -> None:
        import pyarrow
        from pyarrow import parquet

        self.name = name
        self.units: dict[str, str] = {}
        try:
            self.file: Any = parquet.ParquetFile(io.BytesIO(data))
            self.labels = list(self.file.schema_arrow.names)
        except (pyarrow.ArrowException, OSError, UnicodeDecodeError):
            raise InputError(f"{name}: is no Parquet file, or a damaged one") from None
        rows = self.file.metadata.num_rows
        if rows > MOST_ROWS:
            raise InputError(f"{name}: has {rows} rows; at most {MOST_ROWS} are read")

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """The columns at `indices` as floats; the others are not read."""
        import pyarrow

        wanted = [self.labels[index] for index in indices]
        unique = len(set(self.labels)) == len(self.labels)
        try:
            table = self.file.read(columns=wanted if unique else None, use_threads=False)
        except pyarrow.ArrowMemoryError:
            raise
        except (pyarrow.ArrowException, OSError, UnicodeDecodeError):
            raise InputError(f"{self.name}: is a damaged Parquet file") from None
        arrays = []
        for index, label in zip(indices, wanted, strict=True):
            column = table.column(label if unique else index)
            if not (pyarrow.types.is_integer(column.type) or pyarrow.types.is_floating(column.type)):
                raise InputError(f"{self.name}: column '{label}': holds {column.type}, numbers are wanted")
            arrays.append(to_numpy(column.cast(pyarrow.float64(), safe=False)))
        return arrays
