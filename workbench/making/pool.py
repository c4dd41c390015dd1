"""The tasks of `stagecad make` side by side: one pool of processes, in which each is begun once what it needs is there.

The processes fill the store; whoever needs a result then finds it there. A result that is there already is not made
again. One pool and not one for each kind of result, since a process needs seconds to load the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial

from drawings.artefacts.tasks import TIME_LIMIT
from stagecad.parallel import TimeLimit, parallel_map
from stagecad.parameters.errors import LostProcessError, PartError
from stagecad.schedule import Order
from stagecad.solids.artefacts.part import CRASHED
from stagecad.solids.modelling.registry import ASSEMBLY
from stagecad.worker_process import Ahead
from workbench.making.start import WITH_KERNEL
from workbench.making.tasks import (
    CONTACTS,
    LOADING,
    PART,
    RENDERING,
    SHAPES,
    SHEET,
    SIMULATION,
    VIEW,
    Making,
)

LONG = (PART, SHAPES, CONTACTS, VIEW, SHEET, RENDERING, SIMULATION)
"""Kinds of task for which processes are started; the others alone take less than their start."""


def is_long(task: str) -> bool:
    """Whether processes are started for a task."""
    return task.startswith(LONG)


def absent(making: Making) -> list[str]:
    """The tasks whose results the store lacks, and those that need one of these."""
    found: list[str] = []
    for task, needed in making.tasks.items():
        if not set(needed).isdisjoint(found) or not making.has(task):
            found.append(task)
    return found


WITH_DRAWINGS = "with the libraries of drawings, checks and figures"
"""Kind of the tasks that are not `WITH_KERNEL`."""


def _kind(task: str) -> str:
    """Kind of a task by the libraries that it loads, which takes a second.

    Solids and pictures need few besides the CAD kernel. The sheets of parts need the kernel and those of drawings,
    checks and figures; a process that is forked from one with the kernel has it
    (`stagecad.worker_process.started_ahead`).
    """
    return WITH_KERNEL if task.startswith((PART, SHAPES, CONTACTS, VIEW, RENDERING)) else WITH_DRAWINGS


def make_absent(
    making: Making,
    tasks: Collection[str],
    advance: Callable[[str], None] = lambda task: None,
    ahead: Sequence[Ahead] = (),
) -> None:
    """Make the results of tasks in several processes.

    Args:
        making: what is made.
        tasks: of `absent`.
        advance: called with each task that is completed.
        ahead: processes that have been started already (`workbench.making.start`).

    Raises:
        PartError: the CAD kernel makes no valid solid of a part, or ends its process.
    """
    making = replace(making)  # without the solids that it has loaded, which do not pickle
    requires = {task: [other for other in making.tasks[task] if other in tasks] for task in tasks}
    order = Order(requires, _kind, ahead)
    names = list(tasks)
    if len({_kind(task) for task in tasks}) > 1:
        names.insert(1, LOADING)

    def report(task: str) -> None:
        if task != LOADING:
            advance(task)

    limit = TimeLimit(TIME_LIMIT, fallback=partial(making.run, exact=False))
    try:
        parallel_map(making.run, names, progress=report, limit=limit, order=order, isolate=True)
    except LostProcessError as error:
        lost = str(error.item)
        if lost.startswith(f"{PART} "):
            raise PartError(lost.removeprefix(f"{PART} "), making.design, CRASHED) from None
        if lost in (SHAPES, CONTACTS):
            raise PartError(ASSEMBLY, making.design, CRASHED) from None
        raise
