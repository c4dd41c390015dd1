"""Processes that answer the requests of a pool: started with the pool, or ahead of it.

A process uses one thread for linear algebra and ignores Ctrl-C: the process that started it ends it, and if that one
dies, it ends too.
"""

from __future__ import annotations

import contextlib
import gc
import io
import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Callable, Generator
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, Protocol

from stagecad import blas_threads
from stagecad.process_start import end_with_parent, interrupts_blocked, script_left_out

MAX_FORKED = 4
"""Largest number of forked processes: each has its own copy of the memory that it changes."""

_inside_worker = False


class Pool(Protocol):
    """What a process needs of its pool.

    Attributes:
        method: how its processes are started, `spawn` or `fork`.
    """

    @property
    def method(self) -> str: ...

    def apply(self, item: Any, late: bool) -> bytes:
        """The answer to a request."""
        ...


def inside_worker() -> bool:
    """Whether this process is one of a pool."""
    return _inside_worker


def started(method: str, serve: Any, sent: object, script: bool = False) -> tuple[Connection, BaseProcess]:
    """A process that runs `serve(pipe, sent, parent)`, and the pipe to it; `script`: whether it imports the script."""
    context: Any = multiprocessing.get_context(method)
    pipe, other_end = context.Pipe()
    process = context.Process(target=serve, args=(other_end, sent, os.getpid()), daemon=True)
    with interrupts_blocked(method), warnings.catch_warnings():
        # Python 3.12 warns of forks with threads; threads alive during `fork_map` hold no lock that a worker needs.
        warnings.simplefilter("ignore", DeprecationWarning)
        with contextlib.nullcontext() if script else script_left_out():
            process.start()
    other_end.close()
    return pipe, process


class Ahead:
    """A process that is started before it is known what it will compute, and loads libraries meanwhile; of
    `started_ahead`.

    Attributes:
        kind: of the items that it is for (`Order.ahead`).
        group: the same for all of `started_ahead`, which end together.
        waits: whether no pool has it, and it has not been ended.
    """

    def __init__(self, kind: str, group: object, pipe: Connection, process: BaseProcess | None) -> None:
        self.kind, self.group = kind, group
        self.waits = True
        self._pipe, self._process = pipe, process

    def given(self, pool: Pool) -> tuple[Connection, BaseProcess | ForkedProcess] | None:
        """The process and the pipe to it, for a pool; None where it could not be started."""
        self.waits = False
        process = self._process or ForkedProcess.connected(self._pipe)
        if process is None:
            self._pipe.close()
            return None
        # One that has ended is noticed where its answer is awaited.
        with contextlib.suppress(OSError):
            self._pipe.send(pool)
        return self._pipe, process

    def end(self) -> None:
        if self.waits:
            self.waits = False
            if self._process is not None:
                self._process.kill()
                self._process.join()
            # A forked process ends as its pipe is closed.
            self._pipe.close()


class ForkedProcess:
    """A process that one of `started_ahead` has forked, with the methods of `BaseProcess` that a pool calls.

    Attributes:
        pid: its number.
    """

    def __init__(self, pipe: Connection, pid: int) -> None:
        self._pipe, self.pid = pipe, pid

    @classmethod
    def connected(cls, pipe: Connection) -> ForkedProcess | None:
        """The process at the other end, which sends its number once it is there; None where it ended before."""
        try:
            return cls(pipe, pipe.recv())
        except (EOFError, OSError):
            return None

    def kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, signal.SIGKILL)

    def join(self) -> None:
        """Wait until it has ended, which closes its end of the pipe."""
        with contextlib.suppress(EOFError, OSError):
            while True:
                self._pipe.recv_bytes()


@contextlib.contextmanager
def started_ahead(load: Callable[[], Any], kind: str, count: int = 1) -> Generator[list[Ahead], None, None]:
    """Processes with libraries; at the end of the context, those that no pool has are ended.

    One process loads the libraries and then forks the others, which have them at once; they end with it. On systems
    other than Linux, where forking is not safe, it is the only one.

    Args:
        load: function of a module, without arguments; it starts no thread.
        kind: of the items that they are for.
        count: number of processes.
    """
    pairs = [multiprocessing.Pipe() for _ in range(min(count, MAX_FORKED) - 1)] if sys.platform == "linux" else []
    pipe, process = started("spawn", _serve_later, (load, [far for _, far in pairs]))
    for _, far in pairs:
        far.close()
    group = object()
    found = [Ahead(kind, group, pipe, process), *(Ahead(kind, group, near, None) for near, _ in pairs)]
    try:
        yield found
    finally:
        for one in found:
            one.end()


def _serve_later(
    pipe: Connection, sent: tuple[Callable[[], Any], list[Connection]], parent: int
) -> None:  # pragma: no cover - in a process of its own
    """Loop of a process of `started_ahead`, and of the processes that it forks.

    Args:
        pipe: to the process that started this one.
        sent: what loads the libraries, and the pipes of the processes to be forked.
        parent: number of the process that started this one.
    """
    load, pipes = sent
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)
    # What cannot be loaded is an error of the items that need it.
    with contextlib.suppress(Exception):
        load()
    # The forked processes share the memory of the loaded objects for as long as none collects garbage among them.
    gc.freeze()
    own = os.getpid()
    for number, other in enumerate(pipes):
        if os.fork() == 0:
            end_with_parent(own)
            for further in (pipe, *pipes[number + 1 :]):
                further.close()
            pipe, parent = other, own
            with contextlib.suppress(OSError):
                pipe.send(os.getpid())
            break
        other.close()
    with contextlib.suppress(EOFError, OSError):
        serve(pipe, pipe.recv(), parent)
    os._exit(0)


def serve(pipe: Connection, pool: Pool, parent: int) -> None:
    """Loop of a worker: answer requests until the pipe closes."""
    from threadpoolctl import threadpool_limits

    global _inside_worker
    _inside_worker = True
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)
    os.environ.update(dict.fromkeys(blas_threads.VARIABLES, "1"))
    threadpool_limits(1, user_api="blas")
    # Exclude the loaded objects from garbage collection and collect rarely: it would take a fifth of the time.
    gc.freeze()
    gc.set_threshold(100_000)
    if pool.method == "fork":
        # A thread of the parent process may have held the lock of a stream at the fork.
        sys.stdout = sys.stderr = io.StringIO()
    with contextlib.suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(pool.apply(*pipe.recv()))
    os._exit(0)
