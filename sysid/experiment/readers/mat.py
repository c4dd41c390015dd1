"""MATLAB files up to version 7: every vector of numbers in them, the ones inside structures by their path."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError


class MatColumns:
    """The content of a MAT file: variables and fields of structures are the columns.

    A field `position` of a structure `data` answers to `data.position`, and to `position` where that is unique. A
    structure `units` with a text per channel gives units where the experiment does not.
    """

    def __init__(self, data: bytes, name: str) -> None:
        # scipy.io takes 0.2 s to load: only a MAT file pays for it.
        from scipy.io import loadmat

        self.name = name
        self.units: dict[str, str] = {}
        if data[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in data[:128]:
            raise InputError(f"{name}: is a MAT file of version 7.3 (HDF5); save it with '-v7', or as CSV or Parquet")
        try:
            held = loadmat(io.BytesIO(data), squeeze_me=True, struct_as_record=False)
        except MemoryError:
            raise
        except Exception:  # scipy raises a dozen kinds on damaged bytes
            raise InputError(f"{name}: is no MAT file up to version 7, or a damaged one") from None
        variables = {key: value for key, value in held.items() if not key.startswith("__")}
        units = variables.pop("units", None)
        if hasattr(units, "_fieldnames"):
            self.units = {key: str(getattr(units, key)) for key in units._fieldnames}
        found = dict(_vectors(variables))
        if not found:
            raise InputError(f"{name}: holds no vector of numbers; wanted: time, position, ...")
        leaves = [path.rsplit(".", 1)[-1] for path in found]
        self.labels = []
        self.arrays: list[np.ndarray] = []
        for key, array in found.items():
            leaf = key.rsplit(".", 1)[-1]
            self.labels.append(leaf if leaves.count(leaf) == 1 else key)
            self.arrays.append(array)
        self.paths = list(found)

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """The columns at `indices` as floats."""
        arrays = [self.arrays[index] for index in indices]
        lengths = {array.size for array in arrays}
        if len(lengths) > 1:
            sizes = ", ".join(f"'{self.labels[index]}' {self.arrays[index].size}" for index in indices)
            raise InputError(f"{self.name}: variables differ in length: {sizes}")
        return arrays


def _vectors(variables: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for key, value in variables.items():
        path = f"{prefix}{key}"
        if hasattr(value, "_fieldnames"):
            yield from _vectors({name: getattr(value, name) for name in value._fieldnames}, f"{path}.")
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iufb" and value.size:
            yield path, value.astype(float)
