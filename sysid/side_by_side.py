"""Independent pieces of a search on all processors: a forked process sees the records as they are, and answers.

Nothing is sent there, and only numbers come back. Where the system cannot fork, or an answer does not arrive, the work
is done here, one piece after the other: the result is the same.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")

MOST = 4
"""Processes at the most: each holds its own copy of what it changes."""
_inside = False


def processors() -> int:
    """Processes to share work among: 1 where forking is not to be had, or this is one of them."""
    if _inside or not sys.platform.startswith("linux") or threading.current_thread() is not threading.main_thread():
        return 1
    return min(MOST, len(os.sched_getaffinity(0)))


def elsewhere() -> bool:
    """Whether this is one of the processes that work for another: it shows nothing to anybody."""
    return _inside


def side_by_side(
    work: Callable[[Item], Answer],
    items: Sequence[Item],
    shared: Sequence[object] = (),
    begun: Callable[[Item], None] | None = None,
) -> list[Answer]:
    """What `work` gives for each item, in their order.

    Args:
        work: gives something that pickles, but for what is shared; it may not change anything that the caller needs.
        items: pieces of about the same size, or the largest first.
        shared: objects of the caller's that come back as themselves where an answer holds them, as effects do.
        begun: called here with each item, in their order, about when its work begins.
    """
    count = min(processors(), len(items))
    known = {id(thing): thing for thing in shared}
    children = [_begun(work, items[k::count], known) for k in range(1, count)]
    try:
        answers: dict[int, Answer] = {}
        for i in range(0, len(items), max(count, 1)):
            if begun is not None:
                for item in items[i : i + count]:
                    begun(item)
            answers[i] = work(items[i])
        for k, child in enumerate(children, start=1):
            found = _finished(*child, known) if child is not None else None
            own = range(k, len(items), count)
            answers |= dict(zip(own, found if found is not None else [work(items[i]) for i in own], strict=True))
    except BaseException:
        for child in children:
            if child is not None:
                with suppress(ProcessLookupError):
                    os.kill(child[0], signal.SIGKILL)
                _reaped(*child)
        raise
    return [answers[i] for i in range(len(items))]


class _Pickler(pickle.Pickler):
    """Writes what is known by its place in memory, the same after a fork."""

    def __init__(self, file: io.BytesIO, known: dict[int, object]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self._known = known

    def persistent_id(self, obj: Any) -> int | None:
        place = id(obj)
        return place if place in self._known else None


class _Unpickler(pickle.Unpickler):
    """Reads what `_Pickler` wrote."""

    def __init__(self, file: io.BytesIO, known: dict[int, object]) -> None:
        super().__init__(file)
        self._known = known

    def persistent_load(self, pid: Any) -> object:
        return self._known[pid]


def _begun(work: Callable[[Item], Answer], items: Sequence[Item], known: dict[int, object]) -> tuple[int, int] | None:
    """A process at work on some items: its number, and where its answers come out; none where there can be none."""
    out, into = os.pipe()
    try:
        number = os.fork()
    except OSError:
        os.close(out)
        os.close(into)
        return None
    if number:
        os.close(into)
        return number, out
    status = 1
    try:
        global _inside
        _inside = True
        os.close(out)
        answers = io.BytesIO()
        _Pickler(answers, known).dump([work(item) for item in items])
        with os.fdopen(into, "wb") as pipe:
            pipe.write(answers.getbuffer())
        status = 0
    finally:
        # Not one line of the caller's clean-up is this process's.
        os._exit(status)


def _finished(number: int, out: int, known: dict[int, object]) -> list[Any] | None:
    """The answers of a process, once it has ended; none where something went wrong."""
    with os.fdopen(out, "rb", closefd=False) as pipe:
        answers = pipe.read()
    status = _reaped(number, out)
    return _Unpickler(io.BytesIO(answers), known).load() if status == 0 else None


def _reaped(number: int, out: int) -> int:
    with suppress(OSError):
        os.close(out)
    try:
        return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
    except ChildProcessError:
        return 1
