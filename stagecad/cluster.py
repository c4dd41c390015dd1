"""Map a function over items on the workers of a dask cluster."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, TypeVar

from stagecad.parameters.errors import InputError

Item = TypeVar("Item")
Result = TypeVar("Result")

ANSWER_TIME = 5.0
"""Longest time for the scheduler to answer, s."""


def map_on_cluster(
    address: str, function: Callable[[Item], Result], items: Sequence[Item], progress: Callable[[Item], None]
) -> list[Result]:
    """`[function(item) for item in items]`, on the workers of a dask cluster, which need the same packages.

    Args:
        address: of the scheduler, like `tcp://127.0.0.1:8786`.
        function: of a module, or a `partial` of one; its bound arguments are sent to each worker once.
        items: begun in this order.
        progress: called in this process with each item as it is completed.

    Raises:
        InputError: the package `distributed`, the cluster or its workers are not available, or a worker died.
        Exception: that of an item.
    """
    try:
        from distributed import Client, as_completed
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
        tasks: Any = {}
        try:
            # The function and its bound arguments are sent to each worker once.
            sent = client.scatter(pickle.dumps(function), broadcast=True, hash=False)
            tasks = {client.submit(_apply_pickled, sent, item, pure=False): item for item in items}
            for task in as_completed(tasks):
                task.result()
                progress(tasks[task])
            return client.gather(list(tasks))  # type: ignore[return-value]
        except ModuleNotFoundError as error:
            raise InputError(f"--scheduler {address}: its workers lack a package: {error}") from None
        except KilledWorker as error:
            raise InputError(f"--scheduler {address}: a worker process died: {error}") from None
        except BaseException:
            client.cancel(list(tasks))
            raise


def _apply_pickled(function: bytes, item: Any) -> Any:
    return _loaded(function)(item)


@lru_cache(maxsize=1)
def _loaded(function: bytes) -> Callable[[Any], Any]:
    return pickle.loads(function)
