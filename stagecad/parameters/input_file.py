"""A user's file that is read whole: a regular file, opened without waiting, of limited size."""

import errno
import os
import stat
from pathlib import Path

from stagecad.parameters.errors import InputError

LARGEST = 64_000_000
"""Largest size where the caller states none, bytes."""


def read_input(path: str | Path, largest: int = LARGEST) -> bytes:
    """The content of a file. A pipe or a device, of which a read may never end, is refused."""
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        mode = os.fstat(handle).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "is not a regular file", str(path))
        with open(handle, "rb", closefd=False) as stream:
            data = stream.read(largest + 1)
    finally:
        os.close(handle)
    if len(data) > largest:
        raise OSError(errno.EFBIG, f"is larger than {largest / 1e6:g} MB", str(path))
    return data


def read_named(path: Path) -> bytes:
    """`read_input` of a file that another one names: what is wrong with it is an `InputError`."""
    try:
        return read_input(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
