"""A function run in a forked process that dies, or whose disk fails, at its n-th file operation.

Python announces each operation by an audit event before it makes it. At the n-th below a folder the process ends
without any clean-up, as by SIGKILL, or the operation raises an error of the system.
"""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

KILLED, DONE, RAISED, FAILED = 9, 0, 3, 4
"""How the process ended: at the operation, after all of them, with an expected error, with another one."""

EVENTS = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.chmod", "os.truncate", "os.link", "os.symlink"}


def run_until(
    number: int, folder: Path, function: Callable[[], object], error: int | None = None, expected: tuple[Any, ...] = ()
) -> int:
    """Run `function` in a fork that ends at operation `number` (from 0) on files below `folder`.

    Args:
        number: of the operation.
        folder: whose files count.
        function: what is run.
        error: an errno; the operation and all later ones raise it, and the process goes on.
        expected: exceptions of `function` that are a right answer to such an error.

    Returns:
        KILLED, DONE, RAISED or FAILED.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    seen, prefix = 0, str(folder.resolve())

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal seen
        if event not in EVENTS or not str(arguments[0]).startswith(prefix):
            return
        if event == "open" and not _writes(arguments):
            return
        if seen >= number:
            if error is None:
                os._exit(KILLED)
            if event not in ("os.remove", "os.rmdir"):
                raise OSError(error, os.strerror(error))
        seen += 1

    sys.addaudithook(hook)
    try:
        function()
    except expected:
        os._exit(RAISED)
    except BaseException:
        traceback.print_exc()
        os._exit(FAILED)
    os._exit(DONE)


def _writes(arguments: tuple[Any, ...]) -> bool:
    mode, flags = arguments[1], arguments[2]
    return bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)) or any(letter in str(mode) for letter in "wax+")
