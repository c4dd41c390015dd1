"""A user's file that is read whole, of limited size; TOML documents of bounded depth and 64-bit integers."""

import errno
import os
import stat
import tomllib
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError

LARGEST = 64_000_000
"""Largest size where the caller states none, bytes."""


def read_input(path: str | Path, largest: int = LARGEST) -> bytes:
    """The content of a file. A pipe or a device, of which a read may never end, is refused."""
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
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


def decoded(data: bytes, name: str, rows: str = "line") -> str:
    """UTF-8 text of a file, whose name and the line or row are in the message where it is none."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        number = data[: error.start].count(b"\n") + 1
        raise InputError(f"{name}: {rows} {number}: not UTF-8 text; save the file as UTF-8") from None


DEEPEST = 20
"""Largest depth of tables and lists."""
LARGEST_INTEGER = 2**63


def load_toml(text: str, name: str) -> dict[str, Any]:
    """The content of a TOML document; `name` is the file's name in messages."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise InputError(f"{name}: has tables nested too deeply; at most {DEEPEST} levels are read") from None
    except ValueError:
        # Python converts no integer of more than 4300 digits.
        raise InputError(f"{name}: has a whole number of thousands of digits; at most 64 bits are read") from None
    _check(document, name)
    return document


def _check(document: dict[str, Any], name: str) -> None:
    pending: list[tuple[str, Any, int]] = [("", document, 0)]
    while pending:
        place, value, depth = pending.pop()
        if depth > DEEPEST:
            raise InputError(f"{name}: {place}: is nested too deeply; at most {DEEPEST} levels are read")
        if isinstance(value, dict):
            pending += [(f"{place}.{key}".removeprefix("."), item, depth + 1) for key, item in value.items()]
        elif isinstance(value, list):
            pending += [(place, item, depth + 1) for item in value]
        elif isinstance(value, int) and not -LARGEST_INTEGER <= value < LARGEST_INTEGER:
            raise InputError(f"{name}: {place}: is a whole number of more than 64 bits; write it as 1e30")
