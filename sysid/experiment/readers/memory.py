"""Columns in memory, read as a record file is."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import Column, Format, Header, check_finite


class MemoryTable:
    """Columns (n,) of one record in memory by `name [unit]` or `name`, and their `Reader`, in place of the path of a
    file."""

    def __init__(self, name: str, columns: Mapping[str, np.ndarray]) -> None:
        self.name = name
        self.columns = {label: np.asarray(values) for label, values in columns.items()}
        sizes = {values.shape for values in self.columns.values()}
        if len(sizes) > 1 or any(len(shape) != 1 for shape in sizes):
            raise InputError(f"{name}: its columns have the shapes {sorted(sizes)}; one length is required for all")

    def __str__(self) -> str:
        return self.name

    def sha256(self) -> str:
        """Hash of the labels and the values."""
        found = hashlib.sha256()
        for label, values in self.columns.items():
            found.update(label.encode())
            found.update(np.ascontiguousarray(values).data)
        return found.hexdigest()

    def read_header(self, path: Path, name: str, settings: Format) -> Header:
        """The labels; see `Reader`."""
        return Header(tuple(self.columns))

    def read_columns(
        self, path: Path, name: str, header: Header, indices: Sequence[int], settings: Format
    ) -> list[Column]:
        """Columns as floats; see `Reader`."""
        found = []
        for index in indices:
            label = header.labels[index]
            values = self.columns[label]
            if values.dtype.kind not in "biuf":
                raise InputError(f"{name}: column '{label}': holds {values.dtype}, numbers are required")
            array = values.astype(float)
            check_finite(array, name, label)
            found.append(Column(array))
        return found
