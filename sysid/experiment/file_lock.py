"""A file lock between processes; the system releases it when the process ends for any reason."""

import errno
import os
import re
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stagecad.parameters.errors import InputError

_held: dict[Path, int] = {}
POLL_SECONDS = 0.05
LONGEST = 16
"""Bytes of a lock file that are read: a process number, padded."""


@contextmanager
def file_lock(path: Path, timeout: float, busy: str) -> Iterator[None]:
    """Hold the lock on `path`; reentrant within a process."""
    key = path.absolute()
    if _held.get(key, 0):
        _held[key] += 1
        try:
            yield
        finally:
            _held[key] -= 1
        return
    handle = _locked(path, time.monotonic() + timeout, busy)
    try:
        _held[key] = 1
        _write_holder(handle)
        yield
    finally:
        _held.pop(key, None)
        # Removed while it is held: whoever waits for it notices that its file has lost its name.
        with suppress(OSError):
            path.unlink()
        _release(handle)
        os.close(handle)


def _locked(path: Path, end: float, busy: str) -> int:
    while True:
        handle = _open(path)
        try:
            while not _try(handle):
                if time.monotonic() >= end:
                    found = re.fullmatch(rb"(\d+)\s*", _text(handle))
                    holder = found[1].decode() if found else "unknown"
                    raise InputError(
                        f"{busy}: another run is at work on it (process {holder}); try again when it is done"
                    )
                time.sleep(POLL_SECONDS)
            if _has_name(handle, path):
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _open(path: Path) -> int:
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise InputError(f"{path}: is a link; a lock file is required, so remove it") from None
        folder = next((one for one in path.parents if one.is_dir()), path.parent)
        raise InputError(f"{folder}: this folder cannot be written to: {error.strerror}") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise InputError(f"{path}: is not a regular file; a lock file is required, so remove it")
    return handle


def _has_name(handle: int, path: Path) -> bool:
    """Whether the open file still has its name; the holder before may have removed it."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except FileNotFoundError:
        return False


def _text(handle: int) -> bytes:
    os.lseek(handle, 0, os.SEEK_SET)
    return os.read(handle, LONGEST)


def _write_holder(handle: int) -> None:
    """Write this process's number, unless the file has other content or another name (a hard link)."""
    if os.fstat(handle).st_nlink == 1 and re.fullmatch(rb"\d*\s*", _text(handle)):
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, str(os.getpid()).ljust(LONGEST).encode())


if sys.platform == "win32":
    import msvcrt

    def _try(handle: int) -> bool:
        try:
            # A byte beyond the text is locked, so that the process number in the file remains readable.
            os.lseek(handle, 1 << 20, os.SEEK_SET)
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _release(handle: int) -> None:
        os.lseek(handle, 1 << 20, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _try(handle: int) -> bool:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def _release(handle: int) -> None:
        fcntl.flock(handle, fcntl.LOCK_UN)
