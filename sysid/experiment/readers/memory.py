"""Columns in memory, read as a record file is."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import RecordFile, check_finite


class MemoryTable:
    """Columns of one record in memory; stands in place of the path of a record file.

    Args:
        name: of the record, shown in messages.
        columns: values (n,) by label, `name [unit]` or `name` alone.
    """

    def __init__(self, name: str, columns: Mapping[str, np.ndarray]) -> None:
        self.name = name
        self.columns = {label: np.asarray(values) for label, values in columns.items()}
        sizes = {values.shape for values in self.columns.values()}
        if len(sizes) > 1 or any(len(shape) != 1 for shape in sizes):
            raise InputError(f"{name}: its columns have the shapes {sorted(sizes)}; one length is wanted for all")

    def __str__(self) -> str:
        return self.name


class MemoryFile(RecordFile):
    """A table in memory with the interface of a record file."""

    def __init__(self, table: MemoryTable) -> None:
        self.path = Path(table.name)
        self.name = table.name
        self.table = table
        self.labels = list(table.columns)
        self.units: dict[str, str] = {}

    def sha256(self) -> str:
        """Hash of the labels and the values."""
        found = hashlib.sha256()
        for label, values in self.table.columns.items():
            found.update(label.encode())
            found.update(np.ascontiguousarray(values).data)
        return found.hexdigest()

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """Columns as floats; see `RecordFile.columns`."""
        arrays = []
        for index in indices:
            label = self.labels[index]
            values = self.table.columns[label]
            if values.dtype.kind not in "biuf":
                raise InputError(f"{self.name}: column '{label}': holds {values.dtype}, numbers are wanted")
            array = values.astype(float)
            check_finite(array, self.name, label)
            arrays.append(array)
        return arrays
