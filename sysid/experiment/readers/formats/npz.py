"""NumPy files: `.npz` with named arrays, and `.npy` with one."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sysid.experiment.readers.base import Column, Header
from sysid.experiment.readers.format import Format
from sysid.experiment.readers.formats.arrays import columns_of, damaged, header_of, row_number, vectors

__all__ = ["read_columns", "read_header", "row_number"]


def read_header(path: Path, name: str, settings: Format) -> Header:
    """The labels of a NumPy file: its arrays, the columns of matrices by number."""
    return header_of(list(_load(path, name)), {}, name)


def read_columns(path: Path, name: str, header: Header, indices: Sequence[int], settings: Format) -> list[Column]:
    """Columns of a NumPy file; see `Reader`."""
    found = list(_load(path, name).values())
    return columns_of([found[index] for index in indices], name, header, indices)


def _load(path: Path, name: str) -> dict[str, np.ndarray]:
    try:
        held = np.load(path, allow_pickle=False)
        if isinstance(held, np.ndarray):
            return dict(vectors(held, "array"))
        with held:
            return {key: values for entry in held.files for key, values in vectors(held[entry], entry)}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile):
        raise damaged(name, "npz") from None
