"""Files of a command in its output folder: written whole or not at all, and only when they differ."""

from __future__ import annotations

import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.solids.artefacts.store import Artefact, sha256


class DamagedError(Exception):
    """A stored result does not have the contents it was stored with."""

    def __init__(self, entry: Artefact) -> None:
        super().__init__(entry.key)
        self.entry = entry


def write_stored(out: Path, files: Mapping[str, Artefact]) -> list[str]:
    """Copy files of stored results into `out`, and return the names of those that were not already there.

    Args:
        out: the folder; made when it is not there.
        files: the result that each file name comes from.

    Raises:
        DamagedError: a file in the cache is not what was put there; nothing wrong has been written.
    """
    written: list[str] = []
    # Hashing leaves the interpreter to other threads: the files are read side by side.
    with ThreadPoolExecutor() as pool:
        there = dict(zip(files, pool.map(_digest, (out / name for name in files)), strict=True))
    for name, entry in files.items():
        target = out / name
        if there[name] == entry.hashes[name]:
            continue
        data = entry.data(name)
        if sha256(data) != entry.hashes[name]:
            raise DamagedError(entry)
        atomic_write_bytes(target, data)
        written.append(name)
    return written


def write_text(path: Path, text: str) -> bool:
    """Write text unless the file has it already; whether it was written."""
    if _digest(path) == sha256(text.encode("utf-8")):
        return False
    atomic_write_text(path, text)
    return True


def write_manifest(path: Path, files: Mapping[str, str]) -> None:
    """List files with their sha256 in a JSON file, on top of those it lists already (of other parts)."""
    listed: dict[str, str] = {}
    try:
        document = json.loads(path.read_text("utf-8"))
        listed = {name: digest for name, digest in document["files"].items() if (path.parent / name).is_file()}
    except (OSError, ValueError, KeyError, AttributeError):
        pass
    listed.update(files)
    write_text(path, json.dumps({"schema": 1, "files": dict(sorted(listed.items()))}, indent=1) + "\n")


def _digest(path: Path) -> str | None:
    try:
        return sha256(path.read_bytes())
    except OSError:
        return None
