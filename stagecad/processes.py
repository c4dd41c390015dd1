"""Map a function over items in other processes, or on a cluster; the only place where this program starts processes.

`parallel_map` starts new interpreters (`spawn`), or uses the workers of a dask cluster: function, items and results are
pickled. `fork_map` forks: the function and what it refers to (closures, large arrays, compiled laws) are inherited,
only the results are pickled. The pool is pebble's: it ends a process whose task is cancelled or exceeds its time.

A worker uses one thread for linear algebra, ignores Ctrl-C, and ends with the process that started it. A call inside a
worker, of one item, or with one processor computes in the calling process.
"""

from __future__ import annotations

import contextlib
import fcntl
import gc
import io
import multiprocessing
import os
import pickle
import reprlib
import select
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import lru_cache, partial
from graphlib import TopologicalSorter
from multiprocessing import resource_tracker
from multiprocessing.context import BaseContext, ForkContext, ForkProcess, SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeVar

from stagecad import blas_threads
from stagecad.parameters.errors import InputError, LostProcessError

if TYPE_CHECKING:
    from pebble import ProcessPool

Item = TypeVar("Item")
Result = TypeVar("Result")
Submit = Callable[..., "Future[Any]"]
"""Begins an item, `submit(item, late=False)`; `late`: after it exceeded its time."""

OUT_OF_TIME = signal.SIGPROF
"""Signal by which the system ends a process at its limit of processor time, also while compiled code runs."""

MAX_FORKED = 4
"""Largest number of forked processes: each has its own copy of the memory that it changes."""
INTERVAL = 0.01
"""At which the pool looks at its processes, s: also the time that its end takes."""
ANSWER_TIME = 5.0
"""Longest time for the scheduler of a cluster to answer, s."""

_inside_worker = False


@dataclass(frozen=True)
class TimeLimit:
    """Limit for each item."""

    seconds: float  # processor time, which does not grow while others have the processor, s
    fallback: Callable[[Any], Any] | None = None  # applied, in a new process, to an item that exceeded the limit


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def inside_worker() -> bool:
    """Whether this process is one of a map, or may start none, as a worker of a dask cluster."""
    return _inside_worker or multiprocessing.current_process().daemon


def parallel_map(
    function: Callable[[Item], Result],  # of a module, or a `partial` of one; what it binds is sent to a worker once
    items: Sequence[Item],  # begun in this order where `requires` permits
    *,
    progress: Callable[[Item], None] = lambda item: None,  # called in this process with each item once it is completed
    workers: int | None = None,  # number of processes; default `processors()`
    limit: TimeLimit | None = None,  # for each item; not on a cluster
    requires: Mapping[Any, Collection[Any]] | None = None,  # items that must be completed before an item is begun
    scheduler: str | None = None,  # address of a dask cluster, like `tcp://127.0.0.1:8786`
    isolate: bool = False,  # in another process also where one is enough: compiled code may end it; not in a worker
) -> list[Result]:
    """`[function(item) for item in items]`, in new processes or on a cluster.

    Raises:
        TimeoutError: an item exceeded the limit, and with the fallback again.
        LostProcessError: two processes ended without a result of the same item (as after a segmentation fault).
        InputError: the cluster cannot be used.
        Exception: that of an item, with the traceback in its process as a note.
    """
    count = min(workers or processors(), len(items))
    alone = count <= 1 and limit is None and not isolate
    if scheduler is not None:
        with _on_cluster(scheduler, function) as submit:
            return _mapped(function, submit, items, len(items), requires, progress)
    if inside_worker() or alone:
        return _mapped(function, partial(_at_once, function), items, 1, requires, progress)
    sent = pickle.dumps((function, limit.fallback if limit else None))
    script = b"__main__" in sent or b"__main__" in pickle.dumps(list(items))
    with contextlib.ExitStack() as pools:

        def start() -> ProcessPool:
            method = _SpawnedWithScript() if script else _Spawned()
            return pools.enter_context(started_pool(count, method, _begin_map, (sent,)))

        pool = start()
        seconds = limit.seconds if limit else 0.0

        def submit(item: Item, late: bool = False) -> Future[Any]:
            nonlocal pool
            # The pool is lost where a process ended before the pool had read which item it computed.
            pool = pool if pool.active else start()
            return pool.schedule(_answer, (item, late, seconds))

        return _mapped(function, submit, items, count, requires, progress, limit)


def _mapped(
    function: Callable[[Any], Any],
    submit: Submit,
    items: Sequence[Any],
    count: int,
    requires: Mapping[Any, Collection[Any]] | None,
    progress: Callable[[Any], None],
    limit: TimeLimit | None = None,
) -> list[Any]:
    """Results in the order of the items, of which at most `count` are computed at a time. An item whose process ended,
    or that exceeded its time, is begun a second time. A result that cannot be sent is computed in this process."""
    from pebble import ProcessExpired

    order = TopologicalSorter(dict.fromkeys(range(len(items)), ()))
    for item, others in (requires or {}).items():
        order.add(items.index(item), *(items.index(other) for other in others))
    order.prepare()
    ready: list[int] = []
    running: dict[Future[Any], int] = {}
    results: dict[int, Any] = {}
    late, lost = set[int](), set[int]()

    def begin_again(index: int, failed: set[int]) -> None:
        if limit is not None and failed is late and (index in late or limit.fallback is None):
            raise TimeoutError(f"{reprlib.repr(items[index])} took more than {limit.seconds:g} s") from None
        if index in failed:
            message = f"{reprlib.repr(items[index])}: its process ended without a result, twice"
            raise LostProcessError(message, items[index]) from None
        failed.add(index)
        running[submit(items[index], late=index in late)] = index

    while order.is_active():
        ready = sorted([*ready, *order.get_ready()])
        while ready and len(running) < count:
            index = ready.pop(0)
            running[submit(items[index])] = index
        future = next(iter(wait(running, return_when=FIRST_COMPLETED).done))
        index = running.pop(future)
        try:
            answer = future.result()
        except ProcessExpired as error:
            begin_again(index, late if -error.exitcode == OUT_OF_TIME else lost)
        except BrokenProcessPool:
            # The pool does not know whose process ended, and may complete none of the others.
            ended = [index, *running.values()]
            running.clear()
            for other in ended:
                begin_again(other, lost)
        else:
            results[index] = _opened(answer, partial(function, items[index]))
            order.done(index)
            progress(items[index])
    return [results[index] for index in range(len(items))]


def _at_once(function: Callable[[Any], Any], item: Any) -> Future[Any]:
    future: Future[Any] = Future()
    future.set_result(function(item))
    return future


def fork_map(
    function: Callable[[Item], Result],  # any callable without side effects on objects of the caller
    items: Sequence[Item],  # begun in this order
    identical: Sequence[object] = (),  # objects of the caller that results refer to directly, not to a copy
    progress: Callable[[Item], None] = lambda item: None,  # called in this process with each item once it is completed
) -> list[Result]:
    """`[function(item) for item in items]`, in forked processes: function and items are inherited.

    Results that a worker cannot return (not picklable, or the worker ended) are computed in this process. All items
    are computed in this process if forking is not safe: on systems other than Linux, and outside the main thread.
    """
    count = min(MAX_FORKED, processors(), len(items))
    if inside_worker() or count <= 1 or not _may_fork():
        return _mapped(function, partial(_at_once, function), items, 1, None, progress)
    results: dict[int, Any] = {}
    inherited = (lambda index: function(items[index])), tuple(identical)
    with started_pool(count, _Forked(), _begin_forked, inherited) as pool:
        futures: dict[Any, int] = {pool.schedule(_answer, (index,)): index for index in range(len(items))}
        for future in as_completed(futures):
            index = futures[future]
            try:
                answer = future.result()
            except (OSError, BrokenProcessPool):  # the process ended, or no other one could be started
                answer = _Answer(None)
            results[index] = _opened(answer, partial(function, items[index]), identical)
            progress(items[index])
    return [results[index] for index in range(len(items))]


ALONE = 0.2
"""Time for which items are computed in this process before others are forked, s."""


def map_items(
    function: Callable[[Any], Any],
    items: Sequence[Any],
    identical: Sequence[object] = (),
    progress: Callable[[Any], None] = lambda item: None,
) -> list[Any]:
    """`fork_map`, the first items in this process: to fork it takes as long as `ALONE`."""
    found, began = [], perf_counter()
    for item in items:
        if perf_counter() - began > ALONE:
            break
        found.append(function(item))
        progress(item)
    return [*found, *fork_map(function, items[len(found) :], identical, progress)]


LONG = 5e-3
"""Time of an item, s, from which other threads compute the rest: their start takes 0.2 ms."""


def map_threads(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """`[function(item) for item in items]`; after the first item that takes longer than `LONG` the others are computed
    in several threads, in which compiled code runs at the same time."""
    results: list[Result] = []
    for k, item in enumerate(items):
        start = perf_counter()
        results.append(function(item))
        if perf_counter() - start > LONG and not _inside_worker:
            with ThreadPoolExecutor(processors()) as threads:
                return [*results, *threads.map(function, items[k + 1 :])]
    return results


def forked(function: Callable[[], Any]) -> BaseProcess | None:
    """A forked process that calls `function`, whose effect must be on the disk, while this one goes on; None where
    another one would not save time or is not safe."""
    if inside_worker() or processors() < 2 or not _may_fork():
        return None
    process = _Forked().Process(target=_call, args=(function,), daemon=True)
    process.start()
    return process


def _may_fork() -> bool:
    here = threading.current_thread() is threading.main_thread()
    return sys.platform == "linux" and here and not multiprocessing.current_process().daemon


def _call(function: Callable[[], Any]) -> None:
    _begin_forked(None, ())
    try:
        function()
    finally:
        os._exit(0)


# What a worker computes, and how its answers are sent.


@dataclass(frozen=True)
class _Answer:
    """Outcome of an item, pickled in the worker: success, and result or exception; None if it does not pickle."""

    content: bytes | None


_functions: tuple[Any, Any] = (None, None)
_sent = b""
_identical: tuple[object, ...] = ()


def begin_worker() -> None:
    """Prepare a process of a pool: it ignores Ctrl-C, and ends as soon as it is told, or with its parent."""
    end_with_parent()
    # pebble ends a process by SIGTERM, which its own handler would receive only after compiled code has returned.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(OUT_OF_TIME, signal.SIG_DFL)
    os.environ.update(dict.fromkeys(blas_threads.VARIABLES, "1"))
    # Collecting garbage among the many objects of a solid or a sheet would take a sixth of the time.
    gc.freeze()
    gc.set_threshold(100_000)


def _begin_map(sent: bytes) -> None:
    global _inside_worker, _sent
    begin_worker()
    _inside_worker, _sent = True, sent


def _begin_forked(function: Any, *identical: Any) -> None:
    from threadpoolctl import threadpool_limits

    global _inside_worker, _functions, _identical
    begin_worker()
    _inside_worker = True
    threadpool_limits(1, user_api="blas")
    _functions, _identical = (function, None), identical[0]
    # A thread of the parent process may have held the lock of a stream at the fork.
    sys.stdout = sys.stderr = io.StringIO()


def _answer(item: Any, late: bool = False, seconds: float = 0.0) -> _Answer:
    """Compute an item in a worker, within `seconds` of processor time where it is not 0."""
    global _functions
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        if _sent and _functions[0] is None:
            _functions = pickle.loads(_sent)
        content = True, _functions[1 if late else 0](item)
    except BaseException as error:
        error.add_note(traceback.format_exc())
        content = False, error
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    file = io.BytesIO()
    try:
        _Pickler(file, _identical).dump(content)
    except Exception:  # of any class that a result or its parts raise in pickling
        return _Answer(None)
    return _Answer(file.getvalue())


def _opened(answer: Any, here: Callable[[], Any], identical: Sequence[object] = ()) -> Any:
    """The result in `answer`; one that cannot be transferred is computed here, where its own error is raised."""
    if not isinstance(answer, _Answer):
        return answer
    try:
        succeeded, value = _Unpickler(io.BytesIO(answer.content or b""), identical).load()
    except Exception:  # of any class that the parts of a result raise in unpickling
        return here()
    if not succeeded:
        raise value
    return value


class _Pickler(pickle.Pickler):
    """Writes the index of an object in `identical` instead of the object."""

    def __init__(self, file: io.BytesIO, identical: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._places = {id(one): place for place, one in enumerate(identical)}

    def persistent_id(self, obj: Any) -> int | None:
        return self._places.get(id(obj))


class _Unpickler(pickle.Unpickler):
    """Reads the output of `_Pickler`."""

    def __init__(self, file: io.BytesIO, identical: Sequence[object]) -> None:
        super().__init__(file)
        self._identical = identical

    def persistent_load(self, pid: int) -> object:
        return self._identical[pid]


# How a process is started, and how it ends.


@contextlib.contextmanager
def started_pool(
    count: int,
    method: BaseContext | None = None,
    begin: Callable[..., None] | None = None,
    arguments: Sequence[Any] = (),
) -> Iterator[ProcessPool]:
    """A pool of new processes, all of which are ended with the context; `begin` is called in each first. The default
    `method` starts new interpreters without the script that runs."""
    import pebble
    from pebble.common.types import CONSTS

    CONSTS.sleep_unit = INTERVAL
    pool = pebble.ProcessPool(
        count, initializer=begin or begin_worker, initargs=arguments, context=method or _Spawned()
    )
    try:
        # The threads of the pool, which start processes in place of those that end, inherit the mask of signals.
        with _interrupts_blocked():
            assert pool.active
        yield pool
    finally:
        pool.stop()
        pool.join()


class _SpawnProcess(SpawnProcess):
    """A new interpreter.

    It does not import the script that runs, unless it needs its functions: a script that calls this package without
    `if __name__ == "__main__"` would run again in each process.
    """

    script = False

    def start(self) -> None:
        main = sys.modules["__main__"].__dict__
        with _starting:
            kept = {} if self.script else {name: main.pop(name, None) for name in ("__file__", "__spec__")}
            main.update({} if self.script else {"__spec__": None})
            try:
                super().start()
            finally:
                main.update({name: value for name, value in kept.items() if value is not None})


class _ScriptProcess(_SpawnProcess):
    script = True


class _Spawned(SpawnContext):
    Process = _SpawnProcess

    def __init__(self) -> None:
        super().__init__()
        self._locks: list[Any] = []

    def RLock(self) -> Any:  # noqa: N802
        # Kept until all processes have ended: the pool drops it before, and one that begins meanwhile needs it.
        lock = super().RLock()
        self._locks.append(lock)
        return lock


class _SpawnedWithScript(_Spawned):
    Process = _ScriptProcess


class _ForkProcess(ForkProcess):
    def start(self) -> None:
        with _starting, _interrupts_blocked(), warnings.catch_warnings():
            # Python 3.12 warns of forks with threads; those alive hold no lock that the process needs.
            warnings.simplefilter("ignore", DeprecationWarning)
            super().start()


class _Forked(ForkContext):
    Process = _ForkProcess


_starting = threading.Lock()


@contextlib.contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """SIGINT is blocked until the end of the block, and permanently in processes and threads started in it."""
    # Start this process of `multiprocessing` now: started with the first worker, it would unblock the signal.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent(pipe: int | None = None) -> None:
    """End this process when its parent ends in whatever way, also while compiled code runs. `pipe` reads from a pipe
    whose other end the parent has; default: that of `multiprocessing`."""
    parent = multiprocessing.parent_process()
    if pipe is None and parent is not None:
        pipe = parent.sentinel
    if pipe is None:
        return
    # The kernel sends SIGIO, which ends a process, as the other end is closed.
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(pipe, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([pipe], [], [], 0)[0]:
        os._exit(1)


# The workers of a cluster.


@contextlib.contextmanager
def _on_cluster(address: str, function: Callable[[Any], Any]) -> Iterator[Submit]:
    """What begins an item on a worker of a dask cluster, which needs the same packages; an InputError without them."""
    try:
        from distributed import Client
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise InputError(
            f"--scheduler {address}: needs the package 'distributed' (pip install 'stagecad[cluster]'); "
            "without --scheduler the local processors are used"
        ) from None
    try:
        client = Client(address, timeout=ANSWER_TIME)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no cluster answers there ({error})") from None
    with client:
        if not client.scheduler_info(n_workers=-1)["workers"]:
            raise InputError(f"--scheduler {address}: the cluster has no workers; start one: dask worker {address}")
        executor = client.get_executor(pure=False)
        try:
            # The function and its bound arguments are sent to each worker once.
            sent = client.scatter(pickle.dumps(function), broadcast=True, hash=False)
            yield lambda item: executor.submit(_apply_pickled, sent, item)
        except ModuleNotFoundError as error:
            raise InputError(f"--scheduler {address}: its workers lack a package: {error}") from None
        except KilledWorker as error:
            raise InputError(f"--scheduler {address}: a worker process died: {error}") from None
        finally:
            executor.shutdown(wait=False)


def _apply_pickled(function: bytes, item: Any) -> Any:
    return _loaded(function)(item)


@lru_cache(maxsize=1)
def _loaded(function: bytes) -> Callable[[Any], Any]:
    return pickle.loads(function)
