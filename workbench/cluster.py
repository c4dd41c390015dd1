"""Many independent runs sent to a dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from stagecad.parameters.errors import InputError


def cluster_map(address: str, function: Callable[[Any], Any], values: Iterable[Any]) -> list[Any]:
    """`[function(v) for v in values]` on the workers of a cluster, in order.

    Args:
        address: of its scheduler, like `tcp://127.0.0.1:8786`.
        function: a module's function or a partial of one, so that it can be sent; the workers need the same packages.

    Raises:
        InputError: dask is not installed, or no scheduler answers at the address.
    """
    try:
        from distributed import Client  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError(
            f"--scheduler {address}: needs the package 'distributed' (pip install dask distributed); "
            "without --scheduler the local cores do the work"
        ) from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no cluster answers there ({error})") from None
    with client:
        return client.gather(client.map(function, list(values), pure=False))  # type: ignore[return-value]
