"""How a process of `multiprocessing` is started and ended: without the script that runs, deaf to Ctrl-C, and ended with
its parent."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import wait

PR_SET_PDEATHSIG = 1
"""Option of prctl(2): the signal that the kernel sends to a process when its parent dies."""


def refers_to_script(sent: object) -> bool:
    """Whether what is sent to workers has a function or class of the script that runs."""
    try:
        return b"__main__" in pickle.dumps(sent)
    except Exception:  # of any class that the parts of an item raise in pickling
        return True


@contextlib.contextmanager
def script_left_out() -> Iterator[None]:
    """New processes started in the block do not import the script that runs: a script that calls this package without
    `if __name__ == "__main__"` would run again in each of them."""
    script = sys.modules["__main__"].__dict__
    kept = {name: script[name] for name in ("__file__", "__spec__") if name in script}
    script["__spec__"] = None
    script.pop("__file__", None)
    try:
        yield
    finally:
        script.update(kept)


@contextlib.contextmanager
def interrupts_blocked(method: str) -> Iterator[None]:
    """SIGINT is blocked until the end of the block, and permanently in processes started in it (inherited mask)."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    if method == "spawn":
        # Start this process of `multiprocessing` now: started with the first worker, it would unblock the signal.
        resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent(parent: int) -> None:
    """End this process when the parent dies, also while compiled code runs (on Linux) or with SIGKILL.

    Elsewhere than on Linux, only a process of `multiprocessing`.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
        return
    process = multiprocessing.parent_process()
    if process is None:
        return
    threading.Thread(target=lambda: (wait([process.sentinel]), os._exit(1)), daemon=True).start()
