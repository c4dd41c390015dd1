"""Columns in memory, read as a record file is."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import Column, Format, Header
from sysid.experiment.readers.formats.arrays import read_arrays
from sysid.experiment.readers.texts import as_texts


class MemoryTable:
    """Columns (n,) of one record in memory by `name [unit]` or `name`, and their `Reader`, in place of the path of a
    file."""

    def __init__(self, name: str, columns: Mapping[str, np.ndarray]) -> None:
        self.name = name
        self.columns = {label: np.asarray(values) for label, values in columns.items()}
        self.columns |= {
            k: as_texts(v.tolist()) for k, v in self.columns.items() if v.dtype.kind == "O" and v.ndim == 1
        }
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

    def _read(self, indices: Sequence[int], name: str, settings: Format) -> tuple[Header, list[Column]]:
        return read_arrays(Header(tuple(self.columns)), dict(enumerate(self.columns.values())), indices, name, settings)

    def read_header(self, path: Path, name: str, settings: Format) -> Header:
        """The labels; see `Reader`."""
        return self._read((), name, settings)[0]

    def read_columns(
        self, path: Path, name: str, header: Header, indices: Sequence[int], settings: Format
    ) -> list[Column]:
        """Columns as floats; see `Reader`."""
        return self._read(indices, name, settings)[1]
