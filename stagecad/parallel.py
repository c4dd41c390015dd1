"""Map a function over items in several processes: one pool for the whole program.

`parallel_map` starts new interpreters (`spawn`), or uses the workers of a dask cluster: function, items and results are
pickled. `fork_map` forks: the function and what it refers to (closures, large arrays, compiled laws) are inherited,
only the results are pickled.

A worker uses one thread for linear algebra and ignores Ctrl-C: the calling process ends its workers, and if it dies
itself, they end too. A call inside a worker, of one item, or with one processor computes in the calling process.
"""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import reprlib
import sys
import threading
import time
import traceback
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, TypeVar

from stagecad.cluster import map_on_cluster
from stagecad.index_pickle import IndexPickler, IndexUnpickler
from stagecad.parameters.errors import LostProcessError
from stagecad.process_start import refers_to_script
from stagecad.schedule import Order, Schedule
from stagecad.worker_process import MAX_FORKED, Ahead, inside_worker, serve, started

Item = TypeVar("Item")
Result = TypeVar("Result")
Completed = Generator[tuple[int, Any], None, None]
"""Index and result of each item in the order of completion; closing it ends the workers."""

POLL = 0.5
"""Interval at which the processor time of the workers is read, s."""


@dataclass(frozen=True)
class TimeLimit:
    """Limit for each item.

    Args:
        seconds: processor time (elapsed time where the system does not report that of another process).
        fallback: applied, in a new process, to an item that exceeded the limit.
    """

    seconds: float
    fallback: Callable[[Any], Any] | None = None


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def parallel_map(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    progress: Callable[[Item], None] = lambda item: None,
    workers: int | None = None,
    limit: TimeLimit | None = None,
    order: Order | None = None,
    scheduler: str | None = None,
    isolate: bool = False,
) -> list[Result]:
    """`[function(item) for item in items]`, in new processes or on a cluster.

    Args:
        function: of a module, or a `partial` of one; its bound arguments are sent to each worker once.
        items: begun in this order.
        progress: called in this process with each item once it is completed.
        workers: number of processes; default `processors()`.
        limit: for each item; not on a cluster.
        order: restrictions on it; not on a cluster.
        scheduler: address of a dask cluster, like `tcp://127.0.0.1:8786`.
        isolate: in another process also where one is enough, since compiled code may end it; not inside a worker, and
            not where the system lets this process start none.

    Raises:
        TimeoutError: an item exceeded the limit, and with the fallback again.
        LostProcessError: two processes ended without a result of the same item (as after a segmentation fault).
        InputError: the cluster cannot be used.
        Exception: that of an item, with the traceback in its process as a note.
    """
    if scheduler is not None:
        return map_on_cluster(scheduler, function, items, progress)
    schedule = Schedule(items, order or Order())
    count = min(workers or processors(), len(items))
    alone = count <= 1 and limit is None and not (isolate and not multiprocessing.current_process().daemon)
    if inside_worker() or alone:
        completed = _completed_here(function, items, schedule)
    else:
        completed = _Pool("spawn", count, function, limit).completed(items, schedule)
    return _in_order(completed, items, progress)


def fork_map(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    identical: Sequence[object] = (),
    progress: Callable[[Item], None] = lambda item: None,
) -> list[Result]:
    """`[function(item) for item in items]`, in forked processes: function and items are inherited.

    Results that a worker cannot return (not picklable, or the worker ended) are computed in this process. All items
    are computed in this process if forking is not safe: on systems other than Linux, and outside the main thread.

    Args:
        function: any callable without side effects on objects of the caller.
        items: begun in this order.
        identical: objects of the caller that results refer to directly, not to a copy.
        progress: called in this process with each item once it is completed.
    """
    count = min(MAX_FORKED, processors(), len(items))
    forking = sys.platform == "linux" and threading.current_thread() is threading.main_thread()
    if inside_worker() or count <= 1 or not forking:
        completed = _completed_here(function, items, Schedule(items, Order()))
    else:
        # Items need not pickle: their indices are sent.
        pool = _Pool("fork", count, lambda index: function(items[index]), identical=tuple(identical))
        completed = pool.completed(range(len(items)), Schedule(items, Order()))
    return _in_order(completed, items, progress)


def _in_order(completed: Completed, items: Sequence[Any], progress: Callable[[Any], None]) -> list[Any]:
    results: dict[int, Any] = {}
    with contextlib.closing(completed):
        for index, result in completed:
            results[index] = result
            progress(items[index])
    return [results[index] for index in range(len(items))]


def _completed_here(function: Callable[[Any], Any], items: Sequence[Any], schedule: Schedule) -> Completed:
    waiting, done = list(range(len(items))), set[int]()
    while (place := schedule.choice(waiting, done, schedule.kinds, ())) is not None:
        index = waiting.pop(place)
        yield index, function(items[index])
        done.add(index)


@dataclass(frozen=True)
class _Task:
    """One attempt at an item: its index, whether it exceeded the limit before, whether its process ended before."""

    index: int
    late: bool = False
    lost: bool = False


@dataclass(frozen=True)
class _Pool:
    """Start arguments of the workers.

    Args:
        method: how processes are started, `spawn` or `fork`.
        count: largest number of processes.
        function: applied to each item.
        limit: for each item.
        identical: objects that results refer to without a copy being sent.
    """

    method: str
    count: int
    function: Callable[[Any], Any]
    limit: TimeLimit | None = None
    identical: tuple[object, ...] = ()

    def completed(self, items: Sequence[Any], schedule: Schedule) -> Completed:
        waiting = [_Task(index) for index in range(len(items))]
        done: set[int] = set()
        workers: list[_Worker] = []
        script = self.method == "spawn" and refers_to_script((self.function, self.limit, list(items)))
        try:
            while len(done) < len(items):
                idle = [worker for worker in workers if worker.task is None]
                for worker in (*idle, *[None] * (self.count - len(workers))):
                    others = {kind for other in workers if other is not worker for kind in other.kinds}
                    indices = [task.index for task in waiting]
                    place = schedule.choice(indices, done, worker.kinds if worker else (), others)
                    if place is not None:
                        task = waiting.pop(place)
                        kind = schedule.kinds[task.index]
                        if worker is None:
                            # One of another kind need not be started, and has its own kind's libraries.
                            free = sorted((one for one in schedule.ahead if one.waits), key=lambda a: a.kind != kind)
                            workers.append(worker := _Worker(self, script, next(iter(free), None)))
                        worker.kinds.add(kind)
                        worker.begin(task, items[task.index])
                busy = [(worker, worker.task) for worker in workers if worker.task is not None]
                answering = wait([worker.pipe for worker, _ in busy], timeout=POLL if self.limit else None)
                for worker, task in busy:
                    if worker not in workers:
                        continue
                    in_time = worker.pipe in answering
                    if not in_time and not worker.is_late():
                        continue
                    answer, worker.task = worker.answer() if in_time else None, None
                    if answer is None and self.method == "spawn":
                        waiting[:0] = _end_with_group(worker, workers)
                        waiting.insert(0, self._second_attempt(task, items[task.index], late=not in_time))
                    else:
                        done.add(task.index)
                        yield task.index, self._result(answer or b"", items[task.index])
        finally:
            for worker in workers:
                worker.end()

    def _second_attempt(self, task: _Task, item: Any, late: bool) -> _Task:
        if late:
            assert self.limit is not None
            if task.late or self.limit.fallback is None:
                raise TimeoutError(f"{reprlib.repr(item)} took more than {self.limit.seconds:g} s")
            return replace(task, late=True)
        if task.lost:
            raise LostProcessError(f"{reprlib.repr(item)}: its process ended without a result, twice", item)
        return replace(task, lost=True)

    def apply(self, item: Any, late: bool) -> bytes:
        """Outcome of an item, pickled in the worker: success, and result or exception; empty if it does not pickle."""
        function = self.limit.fallback if late and self.limit and self.limit.fallback else self.function
        try:
            answer = True, function(item)
        except BaseException as error:
            error.add_note(traceback.format_exc())
            answer = False, error
        file = io.BytesIO()
        try:
            IndexPickler(file, self.identical).dump(answer)
        except Exception:  # of any class that a result or its parts raise in pickling
            return b""
        return file.getvalue()

    def _result(self, answer: bytes, item: Any) -> Any:
        """The result in `answer`; one that cannot be transferred is computed here, where its own error is raised."""
        try:
            succeeded, value = IndexUnpickler(io.BytesIO(answer), self.identical).load()
        except Exception:  # of any class that the parts of a result raise in unpickling
            return self.function(item)
        if not succeeded:
            raise value
        return value


class _Worker:
    """A process and the pipe to it; `script` is whether it needs the script that runs, which it then imports.

    Attributes:
        task: that it computes; None while it is idle.
        kinds: of the items that it has begun.
        group: the same for all processes that end together (`Ahead.group`).
    """

    def __init__(self, pool: _Pool, script: bool, ahead: Ahead | None = None) -> None:
        self.task: _Task | None = None
        self.kinds: set[str] = set()
        given = ahead.given(pool) if ahead is not None else None
        self.group: object = ahead.group if ahead is not None and given is not None else self
        self.pipe, self._process = given or started(pool.method, serve, pool, script)
        self._limit = pool.limit

    def begin(self, task: _Task, item: Any) -> None:
        self.task, self.began = task, self._clock()
        # A process that ended while it was idle is noticed where its answer is awaited.
        with contextlib.suppress(OSError):
            self.pipe.send((item, task.late))

    def answer(self) -> bytes | None:
        """Outcome of `_Pool.apply`; None if the process ended."""
        try:
            return self.pipe.recv_bytes()
        except (EOFError, OSError):
            return None

    def is_late(self) -> bool:
        return self._limit is not None and self._clock() - self.began > self._limit.seconds

    def _clock(self) -> float:
        """Processor time of the process, s, which does not grow while others have the processor; else elapsed time."""
        try:
            fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return time.monotonic()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _end_with_group(worker: _Worker, workers: list[_Worker]) -> list[_Task]:
    """End a worker and those that end with it, take them out of the list, and return the tasks that the others had:
    a process that is about to end takes no further task."""
    ended = [other for other in workers if other.group is worker.group]
    for other in ended:
        other.end()
        workers.remove(other)
    return [other.task for other in ended if other.task is not None]
