"""Tasks shared by a few processes, with a time limit for each: hidden-line removal can hang, and cannot be interrupted.

A task that exceeds the limit loses its process and is given once more, marked as late, so that it can take a way that
is sure to end.
"""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

LIMIT = 120.0
"""Seconds of processor time a task may take; the longest takes some ten."""
LOOK = 0.5
"""How often those who work are looked at, s."""

Work = Callable[[str, bool], Any]
"""What is done: the task's name, and whether it is late; it must pickle."""


def run_tasks(
    names: Sequence[str],
    work: Work,
    advance: Callable[[str], None] = lambda name: None,
    *,
    workers: int | None = None,
    limit: float = LIMIT,
    needs: Mapping[str, Collection[str]] | None = None,
) -> dict[str, Any]:
    """What `work` gives for each name.

    Args:
        names: of the tasks, begun in this order, except where one has to wait for others.
        work: done in another process.
        advance: called with each name as it is done.
        workers: processes; the number of processors when left out.
        limit: seconds of processor time a task may take.
        needs: tasks that have to be done before one is begun, by its name; no ring of them.

    Raises:
        TimeoutError: a task that was given once more as late exceeded the limit again.
        Exception: what a task raised.
    """
    crew = [_Worker(work) for _ in range(min(workers or os.cpu_count() or 1, len(names)))]
    waiting = [(name, False) for name in names]
    done: dict[str, Any] = {}
    try:
        while len(done) < len(names):
            for worker in crew:
                free = next((task for task in waiting if done.keys() >= set((needs or {}).get(task[0], ()))), None)
                if worker.task is None and free is not None:
                    waiting.remove(free)
                    worker.give(*free)
            busy = [worker for worker in crew if worker.task is not None]
            ready = wait([worker.pipe for worker in busy], timeout=LOOK)
            for worker in busy:
                assert worker.task is not None
                name, late = worker.task
                if worker.pipe in ready:
                    done[name] = worker.take()
                    advance(name)
                elif worker.spent() > limit:
                    if late:
                        raise TimeoutError(f"drawing '{name}' took more than {limit:g} s")
                    worker.stop()
                    crew[crew.index(worker)] = _Worker(work)
                    waiting.insert(0, (name, True))
    finally:
        for worker in crew:
            worker.stop()
    return {name: done[name] for name in names}


class _Worker:
    """One process and the pipe to it."""

    def __init__(self, work: Work) -> None:
        # `spawn`: a forked kernel with running threads may hang.
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process: BaseProcess = context.Process(target=_serve, args=(theirs, work), daemon=True)
        self._process.start()
        theirs.close()
        self.task: tuple[str, bool] | None = None
        self.started = 0.0

    def give(self, name: str, late: bool) -> None:
        self.task, self.started = (name, late), self._clock()
        self.pipe.send((name, late))

    def take(self) -> Any:
        assert self.task is not None
        name, _ = self.task
        self.task = None
        try:
            result = self.pipe.recv()
        except EOFError:
            raise RuntimeError(f"drawing '{name}': its process ended without a result") from None
        if isinstance(result, BaseException):
            raise result
        return result

    def spent(self) -> float:
        """Seconds its task has taken."""
        return self._clock() - self.started

    def _clock(self) -> float:
        """Processor time of the process, s; where the system does not tell, time of day.

        A machine that is busy with other things makes a task slow, but does not make it hang.
        """
        try:
            fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return time.monotonic()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self) -> None:
        self._process.terminate()
        self._process.join()
        self.pipe.close()


def _serve(pipe: Connection, work: Work) -> None:
    """Do what comes through the pipe until it closes.

    Garbage is not collected: a worker lives for some seconds, and looking through what it holds takes a fifth of them.
    """
    gc.disable()
    while True:
        try:
            name, late = pipe.recv()
        except (EOFError, OSError, KeyboardInterrupt):
            return
        try:
            result = work(name, late)
        except Exception as error:
            result = error
        try:
            pipe.send(result)
        except (TypeError, AttributeError, ValueError):
            pipe.send(RuntimeError(f"{type(result).__name__}: {result}"))
