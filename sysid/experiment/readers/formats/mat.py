"""MATLAB files up to version 7: every vector of numbers in them, the ones inside structures by their path.

A field `position` of a structure `data` answers to `data.position`, and to `position` where that is unique. A structure
`units` with a text per channel gives units where the experiment does not. Files of version 7.3 are HDF5.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.base import Column, Format, Header
from sysid.experiment.readers.formats import hdf5
from sysid.experiment.readers.formats.arrays import damaged, objects_of_matlab, reader_of, vectors
from sysid.experiment.readers.texts import as_texts


def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str], list[str]]:
    """Vectors (n,) by path, and units by name of the channel."""
    # scipy.io takes 0.2 s to load: only a MAT file pays for it.
    from scipy.io import loadmat
    from scipy.io.matlab import MatlabOpaque

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
    found = dict(_vectors(variables, units))
    objects_of_matlab([*found], ["T" for value in variables.values() if isinstance(value, MatlabOpaque)], name)
    return found, units, []


def _vectors(variables: Mapping[str, Any], units: dict[str, str], prefix: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """The vectors by path. A structure of dSPACE or Simulink holds the data, name and unit of one channel."""
    for key, value in variables.items():
        path = f"{prefix}{key}"
        if hasattr(value, "_fieldnames"):
            fields = {name: getattr(value, name) for name in value._fieldnames}
            lower = {name.lower(): item for name, item in fields.items()}
            data = lower.get("data", lower.get("values"))
            stated = [
                str(lower.get(one, lower.get(other, ""))) for one, other in (("name", "label"), ("unit", "units"))
            ]
            if isinstance(data, np.ndarray) and data.dtype != object and any(stated):
                path = f"{prefix}{stated[0]}" if stated[0] else path
                units |= {path: stated[1]} if stated[1] else {}
                fields = {name: item for name, item in fields.items() if item is not data}
                yield from vectors(data, path)
            yield from _vectors(fields, units, f"{path}.")
        elif isinstance(value, np.ndarray) and value.size > 1 and all(isinstance(item, str) for item in value.flat):
            yield path, as_texts(value.ravel().tolist())
        elif isinstance(value, np.ndarray) and value.dtype == object:
            inner = {str(k): item for k, item in enumerate(value.ravel(), start=1) if hasattr(item, "_fieldnames")}
            yield from _vectors(inner, units, f"{path}.")
        elif isinstance(value, np.ndarray):
            yield from vectors(value, path)


_read = reader_of(_load)


def read(path: Path, name: str, settings: Format, indices: Sequence[int]) -> tuple[Header, list[Column]]:
    """The header, and the columns at `indices`."""
    return (hdf5.read if hdf5.is_hdf5(path) else _read)(path, name, settings, indices)
