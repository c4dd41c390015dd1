"""NumPy files: `.npz` with named arrays, and `.npy` with one."""

import zipfile
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import require
from sysid.experiment.readers.formats.arrays import damaged, reader_of, vectors


def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str], list[str]]:
    found: dict[str, np.ndarray] = {}
    remarks: list[str] = []
    try:
        held = np.load(path, allow_pickle=False)
        if isinstance(held, np.ndarray):
            return dict(vectors(held, "array")), {}, []
        with held:
            for entry in held.files:
                try:
                    array = held[entry]
                except ValueError:
                    remarks.append(
                        f"'{entry}' holds objects of Python, not numbers: left out; save {entry}.astype(float)"
                    )
                    continue
                found |= {entry: array} if array.dtype.kind == "U" and array.ndim == 1 else dict(vectors(array, entry))
    except (ValueError, OSError, EOFError, zipfile.BadZipFile):
        raise damaged(name, "npz") from None
    require(found or not remarks, f"{name}: {'; '.join(remarks)}")
    return found, {}, remarks


read = reader_of(_load)
