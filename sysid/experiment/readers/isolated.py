"""Binary record files, read by another process: one that crashes, or that a small file makes large, harms nothing here.

The process opens the file and answers on its standard output with a line of JSON and the columns as raw 64-bit floats.
It has limits on memory and on time, and ends with the process that started it. Nothing that it answers is run
or unpickled.
"""

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError, require
from sysid.experiment.readers.base import MEMORY, MOST_BYTES, MOST_ROWS, Column, Format, Header
from sysid.experiment.readers.formats.arrays import damaged

SECONDS = 60
"""Limit of the processor time, s."""
WAITING = 300
"""Limit of the elapsed time, s: a file system may not answer."""


@dataclass(frozen=True)
class IsolatedReader:
    """A `Reader` that leaves the work to the function `read` of the `module` of a binary format in another process."""

    module: str

    def read_header(self, path: Path, name: str, settings: Format) -> Header:
        """The labels; see `Reader`."""
        state = path.stat()
        key = self.module, settings, state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns
        if key not in _known:
            stated = _ask(self.module, path, name, settings, [])[0]["header"]
            fields: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in stated.items()}
            _known[key] = Header(**fields)
        return _known[key]

    def read_columns(
        self, path: Path, name: str, header: Header, indices: Sequence[int], settings: Format
    ) -> list[Column]:
        """Columns; see `Reader`."""
        found, arrays = _ask(self.module, path, name, settings, list(indices))
        require(tuple(found["header"]["labels"]) == header.labels, f"{name}: changed while it was read; run again")
        return [Column(array, *rest) for array, rest in zip(arrays, found["origins"], strict=True)]


_known: dict[tuple[str | int | Format, ...], Header] = {}
"""Headers by format and state of a file, which is opened for its labels first, and for its columns later."""


def _ask(
    module: str, path: Path, name: str, settings: Format, indices: list[int]
) -> tuple[dict[str, Any], list[np.ndarray]]:
    """The header, and the columns at `indices`, from a new process."""
    from stagecad import blas_threads

    request = json.dumps([module, str(path.resolve()), name, asdict(settings), indices])
    environment = {
        **os.environ,
        **dict.fromkeys(blas_threads.VARIABLES, "1"),
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    environment["ARROW_DEFAULT_MEMORY_POOL"] = "system"
    # -P: nothing is imported from the working folder, which may be the experiment's.
    command = [sys.executable, "-P", "-c", f"from {__name__} import answer; answer()", request]
    # The process ends when this end of its standard input is closed.
    standard_input, kept_open = os.pipe()
    try:
        ended = subprocess.run(
            command, stdin=standard_input, capture_output=True, env=environment, check=False, timeout=WAITING
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{name}: is not read within {WAITING} s") from None
    finally:
        os.close(standard_input)
        os.close(kept_open)
    require(ended.returncode != -signal.SIGXCPU, f"{name}: is not read within {SECONDS} s")
    try:
        head, _, rest = ended.stdout.partition(b"\n")
        found = json.loads(head)
        if found["error"] is None:
            arrays = np.frombuffer(rest, dtype=np.float64).reshape(len(indices), found["rows"])
            return found, [*arrays]
    except (ValueError, KeyError, IndexError, TypeError):
        raise damaged(name, module) from None
    raise InputError(found["error"])


def answer() -> None:
    """Read a file in the separate process, and answer on standard output."""
    from stagecad.processes import end_with_parent

    module, path, name, settings, indices = json.loads(sys.argv[1])
    end_with_parent(sys.stdin.fileno())
    _limit(MEMORY + 2 * min(Path(path).stat().st_size, MOST_BYTES))
    try:
        head, columns = _read(module, Path(path), name, Format(**settings), indices)
    except InputError as error:
        head, columns = {"error": str(error)}, []
    except MemoryError:
        head, columns = {"error": f"{name}: takes more than {MEMORY / 1024**3:g} GB of memory to read"}, []
    out = sys.stdout.buffer
    out.write(json.dumps(head).encode() + b"\n")
    for column in columns:
        out.write(np.ascontiguousarray(column.values, dtype=np.float64).data)
    out.flush()


def _limit(memory: int) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    highest = resource.getrlimit(resource.RLIMIT_AS)[1]
    if sys.platform == "linux":
        memory = memory if highest == resource.RLIM_INFINITY else min(memory, highest)
        resource.setrlimit(resource.RLIMIT_AS, (memory, highest))


def _read(
    module: str, path: Path, name: str, settings: Format, indices: list[int]
) -> tuple[dict[str, Any], list[Column]]:
    from importlib import import_module

    header, columns = import_module(f"sysid.experiment.readers.formats.{module}").read(path, name, settings, indices)
    rows = columns[0].values.size if columns else 0
    if rows > MOST_ROWS:
        raise InputError(f"{name}: has {rows} rows; at most {MOST_ROWS} are read")
    origins = [[column.origin, column.said] for column in columns]
    return {"error": None, "header": vars(header), "origins": origins, "rows": rows}, columns
