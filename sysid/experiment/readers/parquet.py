"""Apache Parquet files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import RecordFile, check_finite, to_numpy


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
            array = to_numpy(column.cast(pyarrow.float64(), safe=False))
            check_finite(array, self.name, self.labels[index])
            arrays.append(array)
        return arrays
