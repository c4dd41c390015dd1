"""Output files of a command: written atomically, and only if their contents change."""

import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.solids.artefacts.store import Artefact, sha256


class DamagedError(Exception):
    """The files of an artefact differ from those that were stored, or are missing."""

    def __init__(self, entry: Artefact) -> None:
        super().__init__(entry.key)
        self.entry = entry


def write_stored(out: Path, files: Mapping[str, Artefact]) -> list[str]:
    """Copy files of artefacts into `out`, and return the names of those that were missing or different."""
    written: list[str] = []
    # Hashing releases the interpreter lock: the files are read in parallel.
    with ThreadPoolExecutor() as pool:
        present = dict(zip(files, pool.map(_digest, (out / name for name in files)), strict=True))
    for name, entry in files.items():
        target = out / name
        if present[name] == entry.hashes[name]:
            continue
        try:
            data = entry.data(name)
        except FileNotFoundError:
            raise DamagedError(entry) from None
        if sha256(data) != entry.hashes[name]:
            raise DamagedError(entry)
        atomic_write_bytes(target, data)
        written.append(name)
    return written


def write_text(path: Path, text: str) -> bool:
    """Write text unless the file already contains it; returns whether it was written."""
    if _digest(path) == sha256(text.encode("utf-8")):
        return False
    atomic_write_text(path, text)
    return True


def write_manifest(path: Path, files: Mapping[str, str]) -> None:
    """Add files with their sha256 to the JSON file at `path`; files of other parts stay listed."""
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
