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
from dataclasses import dataclass
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
    answers: dict[int, Answer] = {}
    waited_for: dict[int, _Child] = {}
    try:
        for k in range(1, count):
            child = _begun(work, items[k::count], known)
            if child is not None:
                waited_for[k] = child
        for i in range(0, len(items), max(count, 1)):
            if begun is not None:
                for item in items[i : i + count]:
                    begun(item)
            answers[i] = work(items[i])
        for k in range(1, count):
            found = _finished(waited_for.pop(k), known) if k in waited_for else None
            own = range(k, len(items), count)
            answers |= dict(zip(own, found if found is not None else [work(items[i]) for i in own], strict=True))
    except BaseException:
        for child in waited_for.values():
            os.kill(child.number, signal.SIGKILL)
            _reaped(child)
        raise
    return [answers[i] for i in range(len(items))]


@dataclass(frozen=True)
class _Child:
    """A process at work: its number, and the end of the pipe where its answers come out."""

    number: int
    out: int


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


def _begun(work: Callable[[Item], Answer], items: Sequence[Item], known: dict[int, object]) -> _Child | None:
    """A process at work on some items; none where there can be none."""
    global _inside
    out, into = os.pipe()
    try:
        number = os.fork()
    except OSError:
        os.close(out)
        os.close(into)
        return None
    if number:
        os.close(into)
        return _Child(number, out)
    status = 1
    try:
        _inside = True
        os.close(out)
        # A thread of the caller's that shows progress may have held the lock of what it writes to, and is not here.
        sys.stdout = sys.stderr = io.StringIO()
        answers = io.BytesIO()
        _Pickler(answers, known).dump([work(item) for item in items])
        with os.fdopen(into, "wb") as pipe:
            pipe.write(answers.getbuffer())
        status = 0
    finally:
        # Not one line of the caller's clean-up is this process's.
        os._exit(status)


def _finished(child: _Child, known: dict[int, object]) -> list[Any] | None:
    """The answers of a process, once it has ended; none where something went wrong."""
    try:
        with os.fdopen(child.out, "rb", closefd=False) as pipe:
            answers = pipe.read()
    except BaseException:
        os.kill(child.number, signal.SIGKILL)
        _reaped(child)
        raise
    return _Unpickler(io.BytesIO(answers), known).load() if _reaped(child) == 0 else None


def _reaped(child: _Child) -> int:
    """How a process ended, once it has."""
    os.close(child.out)
    try:
        return os.waitstatus_to_exitcode(os.waitpid(child.number, 0)[1])
    except ChildProcessError:
        # Someone else has waited for it.
        return 1
