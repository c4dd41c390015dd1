"""MATLAB files up to version 7: every vector of numbers in them, the ones inside structures by their path."""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.base import Column, Header
from sysid.experiment.readers.format import Format
from sysid.experiment.readers.formats import hdf5
from sysid.experiment.readers.formats.arrays import columns_of, damaged, header_of, vectors


def read_header(path: Path, name: str, settings: Format) -> Header:
    """The labels of a MAT file: variables and fields of structures.

    A field `position` of a structure `data` answers to `data.position`, and to `position` where that is unique. A
    structure `units` with a text per channel gives units where the experiment does not.
    """
    if hdf5.is_hdf5(path):
        return hdf5.read_header(path, name, settings)
    found, units = load(path, name)
    return header_of(list(found), units, name)


def read_columns(path: Path, name: str, header: Header, indices: Sequence[int], settings: Format) -> list[Column]:
    """Columns of a MAT file; see `Reader`."""
    if hdf5.is_hdf5(path):
        return hdf5.read_columns(path, name, header, indices, settings)
    found = list(load(path, name)[0].values())
    return columns_of([found[index] for index in indices], name, header, indices)


@lru_cache(maxsize=1)
def load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Vectors (n,) by path, and units by name of the channel."""
    # scipy.io takes 0.2 s to load: only a MAT file pays for it.
    from scipy.io import loadmat

    try:
        held = loadmat(path, squeeze_me=True, struct_as_record=False)
    except MemoryError:
        raise
    except Exception:  # scipy raises a dozen kinds on damaged bytes
        raise damaged(name, "mat") from None
    variables = {key: value for key, value in held.items() if not key.startswith("__")}
    stated, units = variables.pop("units", None), {}
    if hasattr(stated, "_fieldnames"):
        units = {key: str(getattr(stated, key)) for key in stated._fieldnames}
    return dict(_vectors(variables)), units


def _vectors(variables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for key, value in variables.items():
        path = f"{prefix}{key}"
        if hasattr(value, "_fieldnames"):
            yield from _vectors({name: getattr(value, name) for name in value._fieldnames}, f"{path}.")
        elif isinstance(value, np.ndarray) and value.dtype == object:
            inner = {str(k): item for k, item in enumerate(value.ravel(), start=1) if hasattr(item, "_fieldnames")}
            yield from _vectors(inner, f"{path}.")
        elif isinstance(value, np.ndarray):
            yield from vectors(value, path)
