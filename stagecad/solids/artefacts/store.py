"""ArtefactStore of what is slow to make (solids, meshes, exported files, pictures), kept between runs.

The key of a result is the sha256 of its name, the source of the modules that make it, the versions of the CAD kernel,
the keys of the results it is made from, and the parameters it read, with their values. Which parameters those are is
known only after it was made once: so beside the results the store keeps, for each name and source, the sets of reads
met so far. Making is deterministic: a design with the same values at all places of such a set gives the same result.

Several runs may use one store: a result is a folder that appears by renaming, and the first to finish wins. The store
forgets what was used longest ago once it holds more than `STAGECAD_CACHE_MAX` bytes (default 1 GB).
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
import time
from ast import literal_eval
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.tracking import AccessPath, TrackedDesign, path_text, value_at
from stagecad.solids.artefacts.source_digest import source_digest, versions

KERNEL = ("cadquery", "cadquery-ocp")
LARGEST = 1_000_000_000
YOUNGEST = 600.0
"""Seconds a result stays whatever the size of the store, since another run may be reading it."""
SETS_KEPT = 24
RECORD = "entry.json"


@dataclass(frozen=True)
class Artefact:
    """A stored result: its key, its folder, and the sha256 of each of its files."""

    key: str
    folder: Path
    hashes: Mapping[str, str]
    reads: tuple[str, ...]
    """The parameters it was made from, as a person would write them."""

    def path(self, name: str) -> Path:
        return self.folder / name

    def data(self, name: str) -> bytes:
        return self.path(name).read_bytes()

    def document(self, name: str) -> Any:
        return json.loads(self.data(name))


def cache_folder() -> Path:
    """Folder of the store: ``STAGECAD_CACHE``, else ``XDG_CACHE_HOME/stagecad``, else ``~/.cache/stagecad``."""
    own = os.environ.get("STAGECAD_CACHE")
    if own:
        return Path(own)
    shared = os.environ.get("XDG_CACHE_HOME")
    return (Path(shared) if shared else Path.home() / ".cache") / "stagecad"


class ArtefactStore:
    """The results below one folder.

    Args:
        folder: where they are kept; the user's cache folder when left out.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder if folder is not None else cache_folder()

    def find(self, name: str, design: Any, modules: Sequence[str], depends: Iterable[str] = ()) -> Artefact | None:
        """The stored result that `design` would give, or None.

        Args:
            name: of the result.
            design: the design, as it is (not a `TrackedDesign`).
            modules: dotted names of the modules that make it; what they import of this project counts as well.
            depends: keys of the results it is made from.
        """
        root = self._root(name, modules, depends)
        for steps in self._read_sets(root):
            values = {place: value_at(design, place) for place in steps}
            if None in values.values():
                continue
            entry = self._entry(self._key(root, values))  # type: ignore[arg-type]
            if entry is not None:
                return entry
        return None

    def make(
        self,
        name: str,
        design: Any,
        modules: Sequence[str],
        make: Callable[[Any, Path], None],
        depends: Iterable[str] = (),
    ) -> Artefact:
        """The stored result, made by `make(reading, folder)` when the store has none.

        `make` writes its files into `folder` and reads the design only through `reading`.
        """
        depends = tuple(depends)
        entry = self.find(name, design, modules, depends)
        if entry is not None:
            return entry
        root = self._root(name, modules, depends)
        notes: dict[AccessPath, str] = {}
        entries = self.folder / "entries"
        entries.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=".making-", dir=entries))
        try:
            make(TrackedDesign(design, notes), folder)
            key = self._key(root, notes)
            hashes = {path.name: sha256(path.read_bytes()) for path in sorted(folder.iterdir())}
            record = {"name": name, "hashes": hashes, "reads": sorted(path_text(steps) for steps in notes)}
            (folder / RECORD).write_text(json.dumps(record, indent=1), "utf-8")
            target = entries / key
            try:
                folder.rename(target)
            except OSError:
                # Another run made the same in the meantime, or a damaged one stands in the way.
                if self._entry(key) is None:
                    self._discard(target)
                    folder.rename(target)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        self._note_reads(root, tuple(sorted(notes, key=repr)))
        self._forget(keep=key)
        entry = self._entry(key)
        if entry is None:
            raise OSError(f"the cache in {self.folder} lost a result just written")
        return entry

    def drop(self, entry: Artefact) -> None:
        """Remove a result that turned out to be damaged."""
        self._discard(entry.folder)

    @staticmethod
    def _root(name: str, modules: Sequence[str], depends: Iterable[str]) -> str:
        words = [name, source_digest(tuple(modules)), versions(KERNEL), sorted(depends)]
        return sha256(json.dumps(words, sort_keys=True).encode())

    @staticmethod
    def _key(root: str, values: Mapping[AccessPath, str]) -> str:
        words = [root, sorted((repr(steps), value) for steps, value in values.items())]
        return sha256(json.dumps(words).encode())

    def _entry(self, key: str) -> Artefact | None:
        folder = self.folder / "entries" / key
        try:
            record = json.loads((folder / RECORD).read_text("utf-8"))
            if not all((folder / name).is_file() for name in record["hashes"]):
                return None
            os.utime(folder)
            return Artefact(key, folder, record["hashes"], tuple(record["reads"]))
        except (OSError, ValueError, KeyError):
            return None

    def _read_sets(self, root: str) -> list[tuple[AccessPath, ...]]:
        try:
            lines = (self.folder / "reads" / root).read_text("utf-8").splitlines()
            return [literal_eval(line) for line in lines]
        except (OSError, ValueError, SyntaxError):
            return []

    def _note_reads(self, root: str, steps: tuple[AccessPath, ...]) -> None:
        sets = [steps, *(known for known in self._read_sets(root) if known != steps)][:SETS_KEPT]
        atomic_write_text(self.folder / "reads" / root, "".join(f"{known!r}\n" for known in sets))

    def _discard(self, folder: Path) -> None:
        # Renamed first, so that no other run sees half a result.
        with suppress(OSError):
            grave = Path(tempfile.mkdtemp(prefix=".gone-", dir=self.folder / "entries"))
            folder.rename(grave / folder.name)
            shutil.rmtree(grave, ignore_errors=True)

    def _forget(self, keep: str) -> None:
        """Remove what was used longest ago until the store is within its size; leftovers of stopped runs as well."""
        largest = int(os.environ.get("STAGECAD_CACHE_MAX") or LARGEST)
        now = time.time()
        found: list[tuple[float, int, Path]] = []
        for folder in (self.folder / "entries").iterdir():
            with suppress(OSError):
                age = now - folder.stat().st_mtime
                if folder.name.startswith("."):
                    if age > 24 * 3600:
                        shutil.rmtree(folder, ignore_errors=True)
                    continue
                found.append((age, sum(path.stat().st_size for path in folder.iterdir()), folder))
        total = sum(size for _, size, _ in found)
        for age, size, folder in sorted(found, reverse=True):
            if total <= largest:
                break
            if age > YOUNGEST and folder.name != keep:
                self._discard(folder)
                total -= size
        reads = sorted((path for path in (self.folder / "reads").glob("*")), key=lambda path: path.stat().st_mtime)
        for path in reads[: max(0, len(reads) - 2000)]:
            path.unlink(missing_ok=True)


def sha256(data: bytes) -> str:
    """Hexadecimal sha256 of `data`."""
    return hashlib.sha256(data).hexdigest()
