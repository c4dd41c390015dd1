"""Text files as streams: compressed or not, in any encoding, with blanks between columns made single."""

import gzip
import io
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, cast

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MOST_BYTES, MOST_ROWS, shown_path
from sysid.experiment.readers.format import Format

HEAD = 1 << 18
"""Bytes at the start of a file in which its form is looked for."""

MOST_LINES = MOST_ROWS + 10_000
"""Largest number of lines of a file: its rows, and text above them."""
LONGEST_ROW = 16_000_000
"""Largest number of bytes of a row."""
_BLOCK = 1 << 22
_MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))


def is_gzip(path: Path) -> bool:
    """Whether the file begins as gzip does, whatever its name."""
    with path.open("rb") as file:
        return file.read(2) == b"\x1f\x8b"


def open_bytes(path: Path) -> BinaryIO:
    """The bytes of a file, decompressed."""
    return cast(BinaryIO, io.BufferedReader(_Limited(path), _BLOCK))


class _Limited(io.RawIOBase):
    """The content of a text file, decompressed; a small compressed one may hold a very large text."""

    def __init__(self, path: Path) -> None:
        self.file: Any = gzip.open(path, "rb") if is_gzip(path) else path.open("rb", buffering=0)  # noqa: SIM115
        self.name = shown_path(str(path))
        self.bytes = self.rows = self.row_bytes = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        count = self.file.readinto(buffer)
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


def need_few_rows(path: Path) -> None:
    """Refuse a text file that has too many rows, or too long ones, before it is loaded: a library whose thread reads a
    stream may wait for it for ever at the end of the program if the stream refuses."""
    if is_gzip(path) or path.stat().st_size > MOST_LINES:
        with open_bytes(path) as file:
            while file.read(_BLOCK):
                pass


def read_head(path: Path, name: str) -> tuple[bytes, bool]:
    """The first bytes of a file, decompressed, and whether it has more."""
    try:
        with open_bytes(path) as file:
            data = file.read(HEAD)
            more = bool(file.read(1))
    except (EOFError, gzip.BadGzipFile, zlib.error):
        raise InputError(f"{name}: is a damaged or incomplete gzip file") from None
    if data[:4] == b"PAR1":
        raise InputError(f"{name}: is a Parquet file; give it the suffix .parquet")
    if b"\x00" in data[:4096] and not data.startswith((b"\xff\xfe", b"\xfe\xff")) and not _is_utf_16(data):
        raise InputError(f"{name}: holds binary data, no CSV text")
    if more and b"\n" not in data and b"\r" not in data:
        raise InputError(f"{name}: its first row is longer than {HEAD // 1024} kB; is it a file with columns?")
    return data, more


def _is_utf_16(head: bytes) -> bool:
    """Whether a text without a byte order mark has the bytes of ASCII letters in UTF-16."""
    return len(head) > 1 and not any(head[1:200:2]) and all(head[0:200:2])


def encoding_of(head: bytes, settings: Format, name: str) -> str:
    """The encoding of a text by its first bytes: by its byte order mark, else UTF-8, else Windows-1252, whose numbers
    have the same bytes."""
    if settings.encoding is not None:
        try:
            head[: len(head) // 4 * 4 - 8 if len(head) == HEAD else None].decode(settings.encoding)
        except UnicodeError as error:
            raise InputError(
                f"{name}: byte {getattr(error, 'start', 0) + 1} is not {settings.encoding}; see [format] encoding"
            ) from None
        return settings.encoding
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    if _is_utf_16(head):
        return "utf-16-le"
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        # A character may be cut by the end of the head.
        if error.start < len(head) - 3 or len(head) < HEAD:
            return "cp1252"
    return "utf-8"


def lines_of(path: Path, encoding: str, name: str) -> Iterator[str]:
    """Every line of a file without its end."""
    with open_bytes(path) as file:
        # Bytes that cp1252 leaves undefined stand in no number.
        text = io.TextIOWrapper(file, encoding, errors="replace" if encoding == "cp1252" else "strict", newline=None)
        row = 0
        try:
            for line in text:
                row += 1
                yield line.rstrip("\n")
        except UnicodeError:
            raise InputError(
                f"{name}: near row {row + 1}: a byte is not {encoding.upper()}; name the encoding: "
                '[format] encoding = "..."'
            ) from None
        except (EOFError, gzip.BadGzipFile, zlib.error):
            raise InputError(f"{name}: is a damaged or incomplete gzip file") from None


class SingleBlanks(io.RawIOBase):
    """A stream in which each run of blanks and tabs is one blank, none at the ends of lines."""

    def __init__(self, source: BinaryIO) -> None:
        self.source = source
        self.rest = b""
        self.ready = b""

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        while not self.ready:
            block = self.source.read(_BLOCK)
            # A block is cut at the end of a line, so that no run of blanks is cut.
            whole, end, rest = (self.rest + block).rpartition(b"\n")
            self.rest = rest
            if not block:
                whole, end, self.rest = rest, b"", b""
                if not whole:
                    return 0
            singled = re.sub(rb"[ \t]+", b" ", whole + end)
            self.ready = re.sub(rb"(?m)^ +| +(?=\r?$)", b"", singled)
        count = min(len(buffer), len(self.ready))
        buffer[:count] = self.ready[:count]
        self.ready = self.ready[count:]
        return count
