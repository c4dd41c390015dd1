"""A function run in a forked process that is killed, or whose disk fails, at some moment.

Python announces each file operation by an audit event before it makes it. At the n-th below a folder the process ends
without any clean-up, as by SIGKILL, or the operation raises an error of the system. `run_killed` kills at a time, too.
"""

import os
import select
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

KILLED, DONE, RAISED, FAILED = 9, 0, 3, 4
"""How the process ended: at the operation, after all of them, with an expected error, with another one."""

EVENTS = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.chmod", "os.truncate", "os.link", "os.symlink"}
LONGEST = 600.0
"""Time after which a process is taken to hang, s."""


def run_until(
    number: int, folder: Path, function: Callable[[], object], error: int | None = None, expected: tuple[Any, ...] = ()
) -> int:
    """Run `function` in a fork that ends at operation `number` (from 0) on files below `folder`, or, with the errno
    `error`, in which that operation and all later ones raise it; KILLED, DONE, RAISED (one of `expected`) or FAILED."""
    child = _fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

    def stop(seen: int, event: str) -> None:
        if seen >= number:
            if error is None:
                os._exit(KILLED)
            if event not in ("os.remove", "os.rmdir"):
                raise OSError(error, os.strerror(error))

    _count_operations(folder, stop)
    try:
        function()
    except expected:
        os._exit(RAISED)
    except BaseException:
        traceback.print_exc()
        os._exit(FAILED)
    os._exit(DONE)


@dataclass(frozen=True)
class Ended:
    """How a run ended."""

    status: int | None  # of the process; None if it was killed
    seconds: float
    operations: int  # on files; 0 if it was killed
    text: str  # on both of its streams
    group: int  # of its processes


def run_killed(
    function: Callable[[], int],
    working: Path,
    below: Path,
    log: Path,
    operation: int | None = None,
    seconds: float | None = None,
) -> Ended:
    """Run `function`, whose result is the exit status, in a fork in the folder `working`. It is killed at an operation
    (from 0) on files below `below`, or after a time, unless it ends before; its output is in `log`."""
    began, child = time.monotonic(), _fork()
    if not child:
        _run_in_group(function, working, below, log, operation)
    process = os.pidfd_open(child)
    try:
        if not select.select([process], [], [], seconds if seconds is not None else LONGEST)[0]:
            os.kill(child, signal.SIGKILL)
            assert seconds is not None, f"not at an end after {LONGEST:g} s"
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    finally:
        os.close(process)
    counted = log.with_suffix(".count")
    operations = int(counted.read_text()) if code >= 0 and counted.exists() else 0
    text = log.read_text("utf-8", "replace") if log.exists() else ""
    return Ended(code if code >= 0 else None, time.monotonic() - began, operations, text, child)


def _run_in_group(function: Callable[[], int], working: Path, below: Path, log: Path, operation: int | None) -> None:
    """In the forked process, which leads a group of its own."""
    os.setpgid(0, 0)
    os.chdir(working)
    sys.stdout = sys.stderr = log.open("w", encoding="utf-8")
    os.dup2(sys.stdout.fileno(), 1)
    os.dup2(sys.stdout.fileno(), 2)
    last = 0

    def stop(seen: int, event: str) -> None:
        nonlocal last
        last = seen + 1
        if operation is not None and seen >= operation:
            os.kill(os.getpid(), signal.SIGKILL)

    _count_operations(below, stop)
    try:
        status = function()
    except BaseException:
        traceback.print_exc()
        status = FAILED
    sys.stdout.flush()
    operations, operation = last, None
    log.with_suffix(".count").write_text(str(operations))
    os._exit(status)


def _fork() -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _count_operations(folder: Path, before: Callable[[int, str], None]) -> None:
    """Call `before` with the number of each operation on files below `folder`, and with its event."""
    seen, prefix = 0, str(folder.resolve())

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal seen
        if event not in EVENTS or not isinstance(arguments[0], str | bytes | os.PathLike):
            return
        if not os.path.abspath(os.fsdecode(arguments[0])).startswith(prefix):
            return
        if event == "open":
            mode, flags = arguments[1:3]
            if not (flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT) or set(str(mode)) & set("wax+")):
                return
        before(seen, event)
        seen += 1

    sys.addaudithook(hook)
