"""What the processes of the page do: one job after another, with what they have loaded before."""

import os
import traceback
from collections.abc import Callable
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from stagecad.parameters.errors import InputError
from stagecad.processes import begin_worker
from workbench.operations.result import without_options

Report = Callable[[str, int, int], None]
"""Called by a task with what it does, the steps done, and all steps (0: not known)."""

TASKS: dict[str, str] = dict.fromkeys(
    ("compare", "predict", "diagnose", "add", "undo", "suggest", "export"), "tasks.measurement"
)
TASKS |= dict.fromkeys(("solids", "drawings", "optimize", "simulate"), "tasks.machine")
"""Module of each task, of the function of the same name."""


_reports: Connection | None = None


def begin_jobs(reports: Connection, folder: str) -> None:
    """Prepare a process: `reports` is a pipe to the server, `folder` where it works."""
    global _reports
    begin_worker()
    _reports = reports
    os.environ.setdefault("MPLBACKEND", "Agg")
    os.chdir(folder)


def perform(number: int, task: str, arguments: dict[str, Any]) -> tuple[str, Any, tuple[str, int, int]]:
    """Run one task: `("result", document)`, `("refused", line)` for a fault of the input, or `("failure", text)`; and
    its last report, which may arrive after the result."""
    last = ("", 0, 0)

    def report(step: str, done: int, total: int) -> None:
        nonlocal last
        assert _reports is not None
        last = (step[:200], done, total)
        # A short message is written in one piece: several processes write to the pipe, and each may be ended.
        _reports.send((number, *last))

    try:
        report("", 0, 0)
        module = import_module(f"workbench.page.{TASKS[task]}")
        with without_options():
            return "result", getattr(module, task)(report=report, **arguments), last
    except InputError as error:
        return "refused", " ".join(str(error).split()), last
    except Exception as error:  # of any class: the page shows it, and the process serves the next job
        return "failure", f"{type(error).__name__}: {error}\n{traceback.format_exc()}", last
