"""Work that a forked process does while this one goes on."""

from __future__ import annotations

import gc
import io
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from multiprocessing.process import BaseProcess
from typing import Any

from stagecad.parallel import processors
from stagecad.process_start import end_with_parent, interrupts_blocked
from stagecad.worker_process import inside_worker


def forked(function: Callable[[], Any]) -> BaseProcess | None:
    """A forked process that calls `function`, whose effect must be on the disk; it ends with this process.

    Returns:
        The process; None where another one would not save time or is not safe: with one processor, in a worker of a
        pool, outside the main thread, and on systems other than Linux.
    """
    elsewhere = inside_worker() or multiprocessing.current_process().daemon
    in_main_thread = threading.current_thread() is threading.main_thread()
    if sys.platform != "linux" or elsewhere or not in_main_thread or processors() < 2:
        return None
    process = multiprocessing.get_context("fork").Process(target=_call, args=(function, os.getpid()), daemon=True)
    with interrupts_blocked("fork"), warnings.catch_warnings():
        # Python 3.12 warns of forks with threads; those alive hold no lock that the process needs.
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()
    return process


def _call(function: Callable[[], Any], parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)
    # A thread of the parent process may have held the lock of a stream at the fork.
    sys.stdout = sys.stderr = io.StringIO()
    # As in the workers of a pool.
    gc.freeze()
    gc.set_threshold(100_000)
    try:
        function()
    finally:
        os._exit(0)
