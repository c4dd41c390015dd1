"""Whether a file of some format is whole, as far as its end or its own statement of its size says."""

import csv
import json
import struct
import tomllib
from collections.abc import Callable
from pathlib import Path


def assert_whole(path: Path) -> None:
    """Fail if the file is cut off; formats without an end, such as Markdown, must not be empty."""
    data = path.read_bytes()
    assert data, f"{path} is empty"
    check = _CHECKS.get(path.suffix.lower())
    assert check is None or check(data), f"{path} is cut off"


def _json(data: bytes) -> bool:
    json.loads(data)
    return True


def _toml(data: bytes) -> bool:
    tomllib.loads(data.decode("utf-8"))
    return True


def _csv(data: bytes) -> bool:
    lengths = {len(row) for row in csv.reader(data.decode("utf-8-sig").splitlines())}
    return data.endswith(b"\n") and len(lengths) == 1


def _python(data: bytes) -> bool:
    compile(data, "file", "exec")
    return data.endswith(b"\n")


def _stl(data: bytes) -> bool:
    return len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0]


def _ends(end: bytes) -> Callable[[bytes], bool]:
    return lambda data: data.rstrip().endswith(end)


_CHECKS: dict[str, Callable[[bytes], bool]] = {
    ".json": _json, ".toml": _toml, ".csv": _csv, ".py": _python, ".stl": _stl,
    ".glb": lambda data: struct.unpack_from("<I", data, 8)[0] == len(data), ".html": _ends(b"</html>"),
    ".svg": _ends(b"</svg>"), ".pdf": _ends(b"%%EOF"), ".png": _ends(b"IEND\xaeB`\x82"),
    ".step": _ends(b"END-ISO-10303-21;"), ".dxf": _ends(b"EOF"), ".parquet": _ends(b"PAR1"),
}  # fmt: skip
