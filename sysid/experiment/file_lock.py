"""A file lock between processes; the system releases it when the process ends for any reason."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from stagecad.parameters.errors import InputError

_held: dict[Path, int] = {}
POLL_SECONDS = 0.05


@contextmanager
def file_lock(path: Path, timeout: float, busy: str) -> Iterator[None]:
    """Hold the lock on `path`; reentrant within a process.

    Args:
        path: lock file, created if it does not exist, and not deleted.
        timeout: s to wait for another process.
        busy: name of the locked object in the message.

    Raises:
        InputError: another process still holds the lock after `timeout`, or the file cannot be created.
    """
    key = path.absolute()
    if _held.get(key, 0):
        _held[key] += 1
        try:
            yield
        finally:
            _held[key] -= 1
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = path.open("a+")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    with handle:
        end = time.monotonic() + timeout
        while not _try(handle):
            if time.monotonic() >= end:
                handle.seek(0)
                holder = handle.read(40).strip() or "unknown"
                raise InputError(f"{busy}: another run is at work on it (process {holder}); try again when it is done")
            time.sleep(POLL_SECONDS)
        _held[key] = 1
        try:
            handle.truncate(0)
            handle.write(str(os.getpid()))
            handle.flush()
            yield
        finally:
            _held.pop(key, None)
            _release(handle)


if sys.platform == "win32":
    import msvcrt

    def _try(handle: IO[str]) -> bool:
        try:
            # A byte beyond the text is locked, so that the process number in the file remains readable.
            handle.seek(1 << 20)
            msvcrt.locking(handle.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _release(handle: IO[str]) -> None:
        handle.seek(1 << 20)
        msvcrt.locking(handle.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _try(handle: IO[str]) -> bool:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def _release(handle: IO[str]) -> None:
        fcntl.flock(handle, fcntl.LOCK_UN)
