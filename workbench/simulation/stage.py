"""The stage's studies from the design: what `stagecad simulate stage` runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sim.experiments.stage import StageDrive

Tell = Callable[[int, int], None]
"""Told how many cases are done, and of how many."""


def run_studies(
    drive: StageDrive, names: Sequence[str], scheduler: str | None = None, tell: Tell = lambda done, total: None
) -> dict[str, Any]:
    """Studies by name, their cases side by side on the local cores, or on a cluster.

    Raises:
        InputError: no cluster at the address.
        SimulationError: a case that could not be carried on.
    """
    from sim.experiments.stage import STUDIES

    tally = _Tally(tell)
    if scheduler is not None:
        from workbench.cluster import cluster_map

        def on_cluster(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
            tally.expect(len(cases))
            return cluster_map(scheduler, function, cases, tally.advance)

        return {name: STUDIES[name](drive, on_cluster) for name in names}
    cores = os.cpu_count() or 1
    if cores == 1:

        def here(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
            tally.expect(len(cases))
            found = []
            for case in cases:
                found.append(function(case))
                tally.advance()
            return found

        return {name: STUDIES[name](drive, here) for name in names}
    return _on_cores(drive, names, cores, tally)


def _on_cores(drive: StageDrive, names: Sequence[str], cores: int, tally: _Tally) -> dict[str, Any]:
    """All studies at once, each waiting in a thread for its own cases in one pool of processes: no core is idle."""
    from concurrent.futures import ThreadPoolExecutor, as_completed

    from sim.experiments.stage import STUDIES
    from workbench.cluster import interrupts_held, local_workers

    # After a mistake or an interrupt the workers end, and with them what a thread waits for.
    with ThreadPoolExecutor(max(len(names), 1)) as threads, local_workers(cores) as submit:

        def side_by_side(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
            tally.expect(len(cases))
            with interrupts_held():
                tasks = [submit(function, case) for case in cases]
            for task in as_completed(tasks):
                task.result()
                tally.advance()
            return [task.result() for task in tasks]

        waiting = {name: threads.submit(STUDIES[name], drive, side_by_side) for name in names}
        for task in as_completed(waiting.values()):
            task.result()
        return {name: task.result() for name, task in waiting.items()}


class _Tally:
    """Cases done and expected."""

    def __init__(self, tell: Tell) -> None:
        self.tell, self.done, self.total = tell, 0, 0

    def expect(self, cases: int) -> None:
        self.total += cases
        self.tell(self.done, self.total)

    def advance(self) -> None:
        self.done += 1
        self.tell(self.done, self.total)
