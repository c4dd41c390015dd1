"""The stage's studies from the design: what `stagecad simulate stage` runs."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sim.experiments.stage import StageDrive
    from stagecad.parameters.design import Design

Tell = Callable[[int, int], None]
"""Told how many cases are done, and of how many."""


def stage_drive(design: Design) -> StageDrive:
    """Machines and drive of the design, weighed on its solids (made where the cache lacks them)."""
    from sim.experiments.stage import StageDrive
    from workbench.stage_inputs import driven_alone, driven_by_three, stage_machine
    from workbench.weighing import weigh

    weighed = weigh(design)
    machine = stage_machine(design, weighed.moving, weighed.tip)
    return StageDrive(
        single=driven_alone(design, machine),
        triple=driven_by_three(design, machine),
        amplitude=min(design.si("actuator.stroke_amplitude"), 0.5 * machine.piezo.stroke),
        phase=design.si("actuator.phase"),
        frequency=design.si("actuator.frequency"),
    )


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
    """All studies at once, each waiting in a thread for its own cases in one pool of processes: no core stands idle."""
    from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
    from multiprocessing import get_context

    from sim.experiments.stage import STUDIES

    # `spawn`: a forked process may hang on the threads that numerical libraries keep.
    pool = ProcessPoolExecutor(cores, mp_context=get_context("spawn"), initializer=_leave_interrupts_alone)

    def side_by_side(function: Callable[[Any], Any], cases: Sequence[Any]) -> list[Any]:
        tally.expect(len(cases))
        tasks = [pool.submit(function, case) for case in cases]
        for task in as_completed(tasks):
            task.result()
            tally.advance()
        return [task.result() for task in tasks]

    with ThreadPoolExecutor(max(len(names), 1)) as threads:
        try:
            waiting = {name: threads.submit(STUDIES[name], drive, side_by_side) for name in names}
            for task in as_completed(waiting.values()):
                task.result()
            return {name: task.result() for name, task in waiting.items()}
        finally:
            # After a mistake or an interrupt the cases not yet begun are dropped, and no thread waits for them.
            pool.shutdown(wait=False, cancel_futures=True)


def _leave_interrupts_alone() -> None:
    """A worker: Ctrl-C is the parent's business, which drops what has not begun."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


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
