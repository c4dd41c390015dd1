"""Number of threads of the linear algebra: one in each process.

The matrices of this program are small, and its processes share the processors. The threads of several processes that
wait for one another by spinning made the checks four times as slow on two processors; and sums whose order depends on
the number of processors give other last digits on another machine.
"""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager

TYPE_CHECKING = False

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Environment variables that the libraries read as they are loaded."""


def use_one_thread(environment: MutableMapping[str, str]) -> None:
    """State one thread in an environment, unless its user has stated a number. Before NumPy is imported."""
    for name in VARIABLES:
        environment.setdefault(name, "1")


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread in the block, whatever the process has: for a function that a user's Python calls."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, user_api="blas"):
        yield
