"""The processes with the CAD kernel, started before it is known what `stagecad make` has to make.

The kernel takes longer to load than the design takes to read; one process loads it for all. Where nothing turns out to
need it, they are ended; for the design that was made last they are not started. This module imports little, so that
they begin at once.
"""

from __future__ import annotations

import hashlib
import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import TYPE_CHECKING

from stagecad.parallel import processors
from stagecad.parameters.atomic import atomic_write_text
from stagecad.private import cache_root
from stagecad.worker_process import Ahead, inside_worker, started_ahead

if TYPE_CHECKING:
    from workbench.cli.options import Run

WITH_KERNEL = "with the CAD kernel"
"""Kind of the tasks that the processes are for."""


LAST = "last_make"
"""File of the cache with the key of the design that was made last."""


@contextmanager
def kernel_processes(run: Run) -> Iterator[list[Ahead]]:
    """The processes; none where they are not needed, save no time or cannot be started."""
    if inside_worker() or multiprocessing.current_process().daemon or processors() < 2 or _was_last(run):
        yield []
        return
    with started_ahead(_load, WITH_KERNEL, processors()) as ahead:
        yield ahead


def note_made(run: Run) -> None:
    """Note that all results of a design are in the store."""
    with suppress(OSError):
        atomic_write_text(cache_root() / LAST, _key(run))


def _was_last(run: Run) -> bool:
    """Whether a design is the one that was made last; its results may have been removed since."""
    with suppress(OSError):
        return (cache_root() / LAST).read_text("utf-8") == _key(run)
    return False


def _key(run: Run) -> str:
    design = run.design
    return hashlib.sha256(repr((design.text, design.overrides)).encode()).hexdigest()


def _load() -> None:
    from stagecad.solids.modelling.kernel import load_kernel

    load_kernel()
    import_module("workbench.making.tasks")
