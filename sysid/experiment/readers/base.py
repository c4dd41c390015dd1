"""The interface of record files: labels first, then the columns that are asked for."""

from __future__ import annotations

import hashlib
import stat
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError, nearest

MOST_BYTES = 2 * 1024**3
"""Largest record file, bytes."""
MOST_COLUMNS = 10_000
"""Largest number of columns of a record file."""
MOST_ROWS = 20_000_000
"""Largest number of rows of a record file."""
SUFFIXES = {".csv": "CSV", ".parquet": "Parquet", ".pq": "Parquet", ".mat": "MAT"}


class RecordFile(ABC):
    """An open record file: its labels, and its columns as arrays on demand.

    Args:
        path: the file.
        name: shown in messages.

    Raises:
        InputError: no such file, another format, nothing in it, not readable in the format of its suffix.
    """

    labels: list[str]

    def __init__(self, path: Path, name: str) -> None:
        self.path = path
        self.name = name
        self.data = _read_bytes(path, name)
        self.units: dict[str, str] = {}

    def sha256(self) -> str:
        """Hash of the file's bytes."""
        return hashlib.sha256(self.data).hexdigest()

    @abstractmethod
    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """The columns at `indices` as floats of shape (n,), NaN where a cell is empty."""

    def row_name(self, row: int) -> str:
        """Name under which a user finds row `row` (from 0) of the columns in the file."""
        return f"row {row + 1}"


def _read_bytes(path: Path, name: str) -> bytes:
    if is_folder(path):
        raise InputError(f"{name}: is a folder, a CSV, Parquet or MAT file is wanted")
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise InputError(f"{shown_path(name)}: is no plain file; a CSV, Parquet or MAT file is wanted")
        if found.st_size > MOST_BYTES:
            raise InputError(
                f"{shown_path(name)}: is larger than {MOST_BYTES / 1024**3:g} GB; split it, or keep every n-th row"
            )
        data = path.read_bytes()
    except InputError:
        raise
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
