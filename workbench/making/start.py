"""The process with the CAD kernel, started before it is known what `stagecad make` has to make.

The kernel takes longer to load than the design takes to read. Where nothing turns out to need it, the process is ended.
This module imports little, so that the process begins at once.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

from stagecad.parallel import Ahead, inside_worker, processors

WITH_KERNEL = "with the CAD kernel"
"""Kind of the tasks that the process is for."""


@contextmanager
def kernel_process() -> Iterator[list[Ahead]]:
    """The process as a list of one; of none where a second process saves no time or cannot be started."""
    if inside_worker() or multiprocessing.current_process().daemon or processors() < 2:
        yield []
        return
    with Ahead(_load, WITH_KERNEL) as ahead:
        yield [ahead]


def _load() -> None:
    from stagecad.solids.modelling.kernel import load_kernel

    load_kernel()
    import_module("workbench.making.tasks")
