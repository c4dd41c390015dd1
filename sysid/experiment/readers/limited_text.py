"""The bytes of a text file, decompressed, within the limits of size: refused while they are read."""

import gzip
import io
import zlib
from pathlib import Path
from typing import Any, BinaryIO, cast

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MOST_BYTES, MOST_ROWS, shown_path

MOST_LINES = MOST_ROWS + 10_000
"""Largest number of lines of a file: its rows, and text above them."""
LONGEST_ROW = 16_000_000
"""Largest number of bytes of a row."""
BLOCK = 1 << 22
"""Bytes that are read at a time."""


def is_gzip(path: Path) -> bool:
    """Whether the file begins as gzip does, whatever its name."""
    with path.open("rb") as file:
        return file.read(2) == b"\x1f\x8b"


def open_bytes(path: Path, name: str) -> BinaryIO:
    """The bytes of a file, decompressed. InputError, while they are read: a damaged file, or one too large."""
    return cast(BinaryIO, io.BufferedReader(_Limited(path, name), BLOCK))


class _Limited(io.RawIOBase):
    """The content of a text file, decompressed; a small compressed one may hold a very large text."""

    def __init__(self, path: Path, called: str) -> None:
        self.file: Any = gzip.open(path, "rb") if is_gzip(path) else path.open("rb", buffering=0)  # noqa: SIM115
        self.name, self.called = shown_path(str(path)), called
        self.bytes = self.rows = self.row_bytes = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        try:
            count = self.file.readinto(buffer)
        except (EOFError, gzip.BadGzipFile, zlib.error):
            raise InputError(f"{self.called}: is a damaged or incomplete gzip file") from None
        data = bytes(buffer[:count])
        self.bytes += count
        # Rows may end with either sign.
        rows = max(data.count(b"\n"), data.count(b"\r"))
        self.rows += rows
        self.row_bytes = 0 if rows else self.row_bytes + count
        if self.bytes > MOST_BYTES:
            raise InputError(f"{self.name}: is larger than {MOST_BYTES / 1024**3:g} GB decompressed")
        if self.rows > MOST_LINES:
            raise InputError(f"{self.name}: has more than {MOST_ROWS} rows; keep every n-th row")
        if self.row_bytes > LONGEST_ROW:
            raise InputError(f"{self.name}: near row {self.rows + 1}: a row is longer than {LONGEST_ROW / 1e6:g} MB")
        return count

    def close(self) -> None:
        self.file.close()
        super().close()


def need_few_rows(path: Path, name: str) -> None:
    """Refuse a text file that has too many rows, or too long ones, before it is loaded: a library whose thread reads a
    stream may wait for it for ever at the end of the program if the stream refuses."""
    if is_gzip(path) or path.stat().st_size > MOST_LINES:
        with open_bytes(path, name) as file:
            while file.read(BLOCK):
                pass
