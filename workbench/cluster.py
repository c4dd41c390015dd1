"""Many independent runs of one function: on the local cores, or sent to a dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from stagecad.parameters.errors import InputError


def run_all(
    function: Callable[..., Any],
    values: Sequence[Any],
    scheduler: str | None = None,
    advance: Callable[[], None] = lambda: None,
    workers: int | None = None,
    common: Any = None,
) -> list[Any]:
    """`[function(v) for v in values]`, in order, the runs side by side.

    Args:
        function: of a module, or a partial of one, so that it can be sent to other processes.
        values: what it is run on; they must pickle.
        scheduler: address of a dask cluster; the local cores without it.
        advance: called after each run.
        workers: local processes; the number of processors when left out. With one, all runs in this process.
        common: what all runs share, where that is large: it is sent to each worker once, and `function(common, v)` run.

    Raises:
        InputError: the cluster cannot be had; or a run's own.
    """
    if scheduler is not None:
        return cluster_map(scheduler, function, values, advance, common)
    workers = min(workers or os.cpu_count() or 1, len(values))
    if workers <= 1:
        done = []
        for value in values:
            done.append(function(value) if common is None else function(common, value))
            advance()
        return done
    from concurrent.futures import as_completed

    with local_workers(workers, common) as submit:
        with interrupts_held():
            tasks = [submit(function, value) for value in values]
        for task in as_completed(tasks):
            task.result()
            advance()
        return [task.result() for task in tasks]


@contextmanager
def local_workers(count: int, common: Any = None) -> Iterator[Callable[..., Any]]:
    """Processes on this machine: `submit(function, value)` gives a future. Ended at once by a mistake or an interrupt.

    Tasks are first submitted within `interrupts_held()`, which is what keeps the workers clear of Ctrl-C.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    before = set(multiprocessing.active_children())
    # `spawn`: a forked process may hang on the threads that numerical libraries keep.
    settle = {} if common is None else {"initializer": _settle, "initargs": (common,)}
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), **settle)
    try:
        yield pool.submit if common is None else lambda function, value: pool.submit(_run_common, function, value)
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in set(multiprocessing.active_children()) - before:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Ctrl-C waits to the end of the block, and processes started in it never see it: it is this process's business."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_common: Any = None


def _settle(common: Any) -> None:
    global _common
    _common = common


def _run_common(function: Callable[..., Any], value: Any) -> Any:
    return function(_common, value)


def cluster_map(
    address: str,
    function: Callable[..., Any],
    values: Sequence[Any],
    advance: Callable[[], None] = lambda: None,
    common: Any = None,
) -> list[Any]:
    """`[function(v) for v in values]` on the workers of a cluster, in order.

    Args:
        address: of its scheduler, like `tcp://127.0.0.1:8786`.
        function: a module's function or a partial of one, so that it can be sent; the workers need the same packages.
        values: what it is run on.
        advance: called after each run.
        common: what all runs share, sent to each worker once; `function(common, v)` is run then.

    Raises:
        InputError: dask is not installed, no scheduler answers at the address, the cluster has no workers, or its
            workers lack this program; or a run's own.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise InputError(
            f"--scheduler {address}: needs the package 'distributed' (pip install 'stagecad[cluster]'); "
            "without --scheduler the local cores do the work"
        ) from None
    try:
        client = Client(address, timeout=5)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no cluster answers there ({error})") from None
    with client:
        if not client.scheduler_info(n_workers=-1)["workers"]:
            raise InputError(f"--scheduler {address}: the cluster has no workers; start one: dask worker {address}")
        tasks: Any = []
        try:
            if common is None:
                tasks = client.map(function, list(values), pure=False)
            else:
                sent = client.scatter(common, broadcast=True, hash=False)
                tasks = [client.submit(function, sent, value, pure=False) for value in values]
            for task in as_completed(tasks):
                task.result()
                advance()
            return client.gather(tasks)  # type: ignore[return-value]
        except ModuleNotFoundError as error:
            raise InputError(f"--scheduler {address}: its workers lack a package: {error}") from None
        except KilledWorker as error:
            raise InputError(f"--scheduler {address}: a worker died at its work: {error}") from None
        except BaseException:
            client.cancel(tasks)
            raise
