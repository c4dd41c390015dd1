"""The process that runs jobs: it takes one after another, and keeps what it loaded (CAD kernel, compiled effects)."""

from __future__ import annotations

import contextlib
import os
import signal
import traceback
from collections.abc import Callable
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from stagecad import blas_threads
from stagecad.parameters.errors import InputError
from stagecad.process_start import end_with_parent

Report = Callable[[str, int, int], None]
"""Called by a task with what it does, the steps done, and all steps (0: not known)."""

TASKS = {
    "solids": "tasks.machine",
    "drawings": "tasks.machine",
    "optimize": "tasks.optimisation",
    "compare": "tasks.measurement",
    "predict": "tasks.measurement",
    "diagnose": "tasks.measurement",
    "add": "tasks.measurement",
    "undo": "tasks.measurement",
    "suggest": "tasks.measurement",
    "simulate": "tasks.simulation",
}
"""Module of each task, of the function of the same name."""


def serve(pipe: Connection, parent: int, folder: str) -> None:
    """Loop of a process: requests `(task, arguments)`, answers `(kind, content)`; ends with its parent.

    Args:
        pipe: to the server.
        parent: process id of the server.
        folder: working folder.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)
    os.environ.update(dict.fromkeys(blas_threads.VARIABLES, "1"))
    os.environ.setdefault("MPLBACKEND", "Agg")
    os.chdir(folder)
    with contextlib.suppress(EOFError, OSError):
        while True:
            task, arguments = pipe.recv()
            pipe.send(perform(task, arguments, lambda *step: pipe.send(("progress", step))))


def perform(task: str, arguments: dict[str, Any], report: Report) -> tuple[str, Any]:
    """Run one task: `("result", document)`, `("refused", line)` for a fault of the input, or `("failure", text)`."""
    try:
        module = import_module(f"workbench.page.{TASKS[task]}")
        return "result", getattr(module, task)(report=report, **arguments)
    except InputError as error:
        return "refused", " ".join(str(error).split())
    except Exception as error:  # of any class: the page shows it, and the process serves the next job
        return "failure", f"{type(error).__name__}: {error}\n{traceback.format_exc()}"
