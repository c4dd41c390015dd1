"""The tasks of `stagecad make` side by side: one pool of processes, in which each is begun once what it needs is there.

The processes fill the store; whoever needs a result then finds it there. A result that is there already is not made
again. One pool and not one for each kind of result, since a process needs seconds to load the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial

from drawings.artefacts.tasks import TIME_LIMIT
from stagecad.parameters.errors import LostProcessError, PartError
from stagecad.processes import TimeLimit, parallel_map
from stagecad.solids.artefacts.part import CRASHED
from stagecad.solids.modelling.registry import ASSEMBLY
from workbench.making.tasks import (
    CONTACTS,
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


def make_absent(
    making: Making,
    tasks: Collection[str],
    advance: Callable[[str], None] = lambda task: None,
) -> None:
    """Make the results of tasks in several processes.

    Args:
        making: what is made.
        tasks: of `absent`.
        advance: called with each task that is completed.

    Raises:
        PartError: the CAD kernel makes no valid solid of a part, or ends its process.
    """
    making = replace(making)  # without the solids that it has loaded, which do not pickle
    requires = {task: [other for other in making.tasks[task] if other in tasks] for task in tasks}
    limit = TimeLimit(TIME_LIMIT, fallback=partial(making.run, exact=False))
    try:
        parallel_map(making.run, list(tasks), progress=advance, limit=limit, requires=requires, isolate=True)
    except LostProcessError as error:
        lost = str(error.item)
        if lost.startswith(f"{PART} "):
            raise PartError(lost.removeprefix(f"{PART} "), making.design, CRASHED) from None
        if lost in (SHAPES, CONTACTS):
            raise PartError(ASSEMBLY, making.design, CRASHED) from None
        raise
