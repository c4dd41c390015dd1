"""Independent pieces of a search on all processors: a forked process sees the records as they are, and answers.

Nothing is sent there, and only numbers come back. Where the system cannot fork, or an answer does not arrive, the work
is done here, one piece after the other: the result is the same.
"""

from __future__ import annotations

import contextlib
import io
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Answer = TypeVar("Answer")

MOST = 4
"""Processes at the most: each holds its own copy of what it changes."""
AT_ONCE = 1 << 20
"""Bytes of an answer that a pipe holds, where the system allows it."""

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
        items: pieces, the largest first if that is known.
        shared: objects of the caller's that come back as themselves where an answer holds them, as effects do.
        begun: called here with each item, in their order, about when its work begins.
    """
    count = min(processors(), len(items))
    known = {id(thing): thing for thing in shared}
    turns = _Turns(len(items))
    answers: dict[int, Answer] = {}
    waited_for: list[_Child] = []
    # A process for every processor: threads of linear algebra on top of them would wait for one another.
    one_thread = threadpool_limits(1, user_api="blas") if count > 1 else None
    try:
        for _ in range(1, count):
            child = _begun(work, items, turns, known)
            if child is not None:
                waited_for.append(child)
        told = 0
        for i in turns:
            # Whoever took the pieces before this one has begun them.
            _each(begun, items[told : i + 1])
            told = i + 1
            answers[i] = work(items[i])
        _each(begun, items[told:])
        while waited_for:
            answers |= _finished(waited_for.pop(), known)
    except BaseException:
        for child in waited_for:
            os.kill(child.number, signal.SIGKILL)
            _reaped(child)
        raise
    finally:
        turns.close()
        if one_thread is not None:
            one_thread.restore_original_limits()
    return [answers[i] if i in answers else work(items[i]) for i in range(len(items))]


def _each(begun: Callable[[Item], None] | None, items: Sequence[Item]) -> None:
    if begun is not None:
        for item in items:
            begun(item)


class _Turns:
    """Numbers from 0 on, each to be had by one process alone: the pieces go to whoever is free."""

    SIZE = 4

    def __init__(self, count: int) -> None:
        self._out, into = os.pipe()
        os.set_blocking(into, False)
        try:
            os.write(into, b"".join(i.to_bytes(self.SIZE, "little") for i in range(count)))
        finally:
            os.close(into)

    def __iter__(self) -> Iterator[int]:
        while number := os.read(self._out, self.SIZE):
            yield int.from_bytes(number, "little")

    def close(self) -> None:
        os.close(self._out)


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


def _begun(
    work: Callable[[Item], Answer], items: Sequence[Item], turns: _Turns, known: dict[int, object]
) -> _Child | None:
    """A process at work on the items whose turns it takes; none where there can be none."""
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
        _widen(out)
        return _Child(number, out)
    status = 1
    try:
        _inside = True
        os.close(out)
        # A thread of the caller's that shows progress may have held the lock of what it writes to, and is not here.
        sys.stdout = sys.stderr = io.StringIO()
        answers = io.BytesIO()
        _Pickler(answers, known).dump({i: work(items[i]) for i in turns})
        with os.fdopen(into, "wb") as pipe:
            pipe.write(answers.getbuffer())
        status = 0
    finally:
        # Not one line of the caller's clean-up is this process's.
        os._exit(status)


def _widen(pipe: int) -> None:
    """Let a pipe hold as much as an answer takes, or what the system allows: else it is read in a thousand pieces."""
    # Not to be had where nothing is forked.
    import fcntl

    with contextlib.suppress(OSError):
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, AT_ONCE)


def _finished(child: _Child, known: dict[int, object]) -> dict[int, Any]:
    """The answers of a process by their items' numbers, once it has ended; none where something went wrong."""
    try:
        with os.fdopen(child.out, "rb", closefd=False) as pipe:
            answers = pipe.read()
    except BaseException:
        os.kill(child.number, signal.SIGKILL)
        _reaped(child)
        raise
    return _Unpickler(io.BytesIO(answers), known).load() if _reaped(child) == 0 else {}


def _reaped(child: _Child) -> int:
    """How a process ended, once it has."""
    os.close(child.out)
    try:
        return os.waitstatus_to_exitcode(os.waitpid(child.number, 0)[1])
    except ChildProcessError:
        # Someone else has waited for it.
        return 1
