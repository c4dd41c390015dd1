"""NumPy files: `.npz` with named arrays, and `.npy` with one."""

import zipfile
from pathlib import Path

import numpy as np

from sysid.experiment.readers.formats.arrays import damaged, readers_of, vectors


def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    try:
        held = np.load(path, allow_pickle=False)
        if isinstance(held, np.ndarray):
            return dict(vectors(held, "array")), {}
        with held:
            return {key: values for entry in held.files for key, values in vectors(held[entry], entry)}, {}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile):
        raise damaged(name, "npz") from None


read_header, read_columns = readers_of(_load)
