"""Many independent runs of one function: on the local cores, or sent to a dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from stagecad.parameters.errors import InputError


def run_all(
    function: Callable[[Any], Any],
    values: Sequence[Any],
    scheduler: str | None = None,
    advance: Callable[[], None] = lambda: None,
    workers: int | None = None,
) -> list[Any]:
    """`[function(v) for v in values]`, in order, the runs side by side.

    Args:
        function: of a module, or a partial of one, so that it can be sent to other processes.
        values: what it is run on; they must pickle.
        scheduler: address of a dask cluster; the local cores without it.
        advance: called after each run.
        workers: local processes; the number of processors when left out. With one, all runs in this process.

    Raises:
        InputError: the cluster cannot be had; or a run's own.
    """
    if scheduler is not None:
        return cluster_map(scheduler, function, values, advance)
    workers = min(workers or os.cpu_count() or 1, len(values))
    if workers <= 1:
        done = []
        for value in values:
            done.append(function(value))
            advance()
        return done
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import get_context

    # `spawn`: a forked process may hang on the threads that numerical libraries keep.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        tasks = [pool.submit(function, value) for value in values]
        try:
            for task in as_completed(tasks):
                task.result()
                advance()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [task.result() for task in tasks]


def cluster_map(
    address: str,
    function: Callable[[Any], Any],
    values: Sequence[Any],
    advance: Callable[[], None] = lambda: None,
) -> list[Any]:
    """`[function(v) for v in values]` on the workers of a cluster, in order.

    Args:
        address: of its scheduler, like `tcp://127.0.0.1:8786`.
        function: a module's function or a partial of one, so that it can be sent; the workers need the same packages.
        values: what it is run on.
        advance: called after each run.

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
        tasks = client.map(function, list(values), pure=False)
        try:
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
