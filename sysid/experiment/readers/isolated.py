"""Binary record files, read by another process: one that crashes, or that a small file makes large, harms nothing here.

The process reads the bytes of the file from its standard input and answers on its standard output with a line of JSON
and the columns as raw 64-bit floats. It has limits on memory and on processor time, and ends with the process that
started it. Nothing that it answers is run or unpickled.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MOST_ROWS, RecordFile, check_finite

MEMORY = 4 * 1024**3
"""Limit of the address space beyond the file's size, bytes."""
SECONDS = 60
"""Limit of the processor time, s."""
DAMAGED = {"MAT": "is no MAT file up to version 7, or a damaged one", "Parquet": "is no Parquet file, or a damaged one"}

Answer = tuple[dict[str, Any], list[np.ndarray]]


class IsolatedFile(RecordFile):
    """A record file of a binary format."""

    def __init__(self, path: Path, name: str, kind: str) -> None:
        super().__init__(path, name)
        self.kind = kind
        self.labels, self.units = _labels(kind, self.data, name)

    def columns(self, indices: Sequence[int]) -> list[np.ndarray]:
        """Columns as floats; see `RecordFile.columns`."""
        arrays = _ask(self.kind, self.data, self.name, list(indices))[1]
        for index, array in zip(indices, arrays, strict=True):
            check_finite(array, self.name, self.labels[index])
        return arrays


_known: dict[tuple[str, str], tuple[list[str], dict[str, str]]] = {}
"""Labels and units by format and sha256 of a file, which is opened for its labels first, and for its columns later."""


def _labels(kind: str, data: bytes, name: str) -> tuple[list[str], dict[str, str]]:
    key = kind, hashlib.sha256(data).hexdigest()
    if key not in _known:
        found = _ask(kind, data, name, None)[0]
        _known[key] = found["labels"], found["units"]
    return _known[key]


def _ask(kind: str, data: bytes, name: str, indices: list[int] | None) -> Answer:
    """Labels and units, and the columns at `indices`, from a new process.

    Raises:
        InputError: its own line, or that the file is damaged, or exceeds a limit.
    """
    from stagecad.parallel import THREAD_VARIABLES

    request = json.dumps([kind, name, indices, os.getpid()])
    environment = {
        **os.environ,
        **dict.fromkeys(THREAD_VARIABLES, "1"),
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    environment["ARROW_DEFAULT_MEMORY_POOL"] = "system"
    # -P: nothing is imported from the working folder, which may be the experiment's.
    command = [sys.executable, "-P", "-c", f"from {__name__} import answer; answer()", request]
    ended = subprocess.run(command, input=data, capture_output=True, env=environment, check=False)
    if ended.returncode == -getattr(signal, "SIGXCPU", 0):
        raise InputError(f"{name}: is not read within {SECONDS} s")
    try:
        head, _, rest = ended.stdout.partition(b"\n")
        found = json.loads(head)
        if found["error"] is None:
            arrays = np.frombuffer(rest, dtype=np.float64).reshape(-1 if indices else 0, found["rows"])
            return found, [arrays[place] for place in range(len(indices or ()))]
    except (ValueError, KeyError, IndexError, TypeError):
        raise InputError(f"{name}: {DAMAGED[kind]}") from None
    raise InputError(found["error"])


def answer() -> None:
    """In the process: read a file from standard input, answer on standard output."""
    from stagecad.parallel import end_with_parent

    kind, name, indices, parent = json.loads(sys.argv[1])
    end_with_parent(parent)
    data = sys.stdin.buffer.read()
    _limit(MEMORY + 2 * len(data))
    try:
        head, arrays = _read(kind, name, data, indices)
    except InputError as error:
        head, arrays = {"error": str(error)}, []
    except MemoryError:
        head, arrays = {"error": f"{name}: takes more than {MEMORY / 1024**3:g} GB of memory to read"}, []
    out = sys.stdout.buffer
    out.write(json.dumps(head).encode() + b"\n")
    for array in arrays:
        out.write(np.ascontiguousarray(array, dtype=np.float64).data)
    out.flush()


def _limit(memory: int) -> None:
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    highest = resource.getrlimit(resource.RLIMIT_AS)[1]
    if sys.platform == "linux":
        memory = memory if highest == resource.RLIM_INFINITY else min(memory, highest)
        resource.setrlimit(resource.RLIMIT_AS, (memory, highest))


def _read(kind: str, name: str, data: bytes, indices: list[int] | None) -> Answer:
    from sysid.experiment.readers.mat import MatColumns
    from sysid.experiment.readers.parquet import ParquetColumns

    reader = {"MAT": MatColumns, "Parquet": ParquetColumns}[kind](data, name)
    arrays = reader.columns(indices) if indices else []
    rows = arrays[0].size if arrays else 0
    if rows > MOST_ROWS:
        raise InputError(f"{name}: has {rows} rows; at most {MOST_ROWS} are read")
    return {"error": None, "labels": reader.labels, "units": reader.units, "rows": rows}, arrays
