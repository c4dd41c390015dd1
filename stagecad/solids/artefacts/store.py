"""Cache of artefacts that are slow to make (solids, meshes, exported files, pictures), kept between runs.

The key of an artefact (`stagecad.solids.artefacts.key`) contains the parameters that were read, and which those are is
known only after it has been made once; so the store also keeps, for each name and source, the sets of access paths
recorded so far. Making is deterministic: designs with equal values at all paths of such a set give the same artefact.

Several runs may use one store: an artefact is a folder that appears by renaming, and the first to finish is kept. A
damaged one is repaired file by file, so that a run that has found it still finds its files. The least recently used
artefacts are removed once the store holds more than `STAGECAD_CACHE_MAX` bytes (default 1 GB).
"""

import json
import logging
import math
import os
import pickle
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.tracking import AccessPath, TrackedDesign, path_text, value_at
from stagecad.private import cache_root
from stagecad.solids.artefacts.key import artefact_key, root_key, sha256

LARGEST = 1_000_000_000
"""Default size limit of a store, bytes."""
MINIMUM_AGE = 600.0
"""Time for which an artefact is kept whatever the size of the store, since another run may be reading it, s."""
ABANDONED = 3600.0
"""Age at which an unfinished artefact is that of an aborted run, s."""
SETS_KEPT = 24
"""Number of sets of access paths kept for each name and source."""
MOST_READS = 2000
"""Number of files of such sets kept."""
RECORD, FILE = "entry.json", "object.pickle"

_verified: set[Path] = set()
"""Artefacts whose files this process has compared with their hashes."""
_added: dict[Path, float] = {}
"""Bytes added to each store by this process since it last searched it for artefacts to be removed."""


@dataclass(frozen=True)
class Artefact:
    """A stored result: its key, its folder, and the sha256 of each of its files."""

    key: str
    folder: Path
    hashes: Mapping[str, str]
    reads: tuple[str, ...]  # the access paths of the parameters that it depends on, as text

    @property
    def content(self) -> str:
        """Hash of all its files: equal for artefacts of equal contents, whatever parameters they were made from."""
        return sha256(json.dumps(sorted(self.hashes.items())).encode())

    def path(self, name: str) -> Path:
        return self.folder / name

    def data(self, name: str) -> bytes:
        return self.path(name).read_bytes()

    def document(self, name: str) -> Any:
        return json.loads(self.data(name))

    def object(self) -> Any:
        return pickle.loads(self.data(FILE))


Make = Callable[[Any, Path], None]
"""Writes the files of an artefact of a tracked design into a folder."""
Made = TypeVar("Made")


class ArtefactStore:
    """The artefacts in one folder: the user's cache folder when left out."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder if folder is not None else cache_root()

    def find(self, name: str, design: Any, modules: Sequence[str], depends: Iterable[str] = ()) -> Artefact | None:
        """The stored artefact of `design`, or None."""
        root = root_key(name, modules, depends)
        for paths in self._path_sets(root):
            values = {path: value_at(design, path) for path in paths}
            if None in values.values():
                continue
            entry = self._entry(artefact_key(root, values))  # type: ignore[arg-type]
            if entry is not None:
                return entry
        return None

    def make(self, name: str, design: Any, modules: Sequence[str], make: Make, depends: Iterable[str] = ()) -> Artefact:
        """The stored artefact, made by `make(tracked_design, folder)` if the store does not have it.

        `make` writes its files into `folder` and reads the design only through the tracked design.
        """
        depends = tuple(depends)
        entry = self.find(name, design, modules, depends)
        if entry is not None:
            return entry
        root = root_key(name, modules, depends)
        reads: dict[AccessPath, str] = {}
        entries = self.folder / "entries"
        entries.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=".making-", dir=entries))
        try:
            make(TrackedDesign(design, reads), folder)
            key = artefact_key(root, reads)
            hashes = {path.name: sha256(path.read_bytes()) for path in sorted(folder.iterdir())}
            record = {"name": name, "hashes": hashes, "reads": sorted(path_text(path) for path in reads)}
            (folder / RECORD).write_text(json.dumps(record, indent=1), "utf-8")
            target = entries / key
            try:
                folder.rename(target)
            except OSError:
                # Another run has made the same artefact meanwhile, or a damaged one has this name.
                if self._entry(key) is None:
                    # File by file, the record last: none of them is missing at any time.
                    target.mkdir(mode=0o700, exist_ok=True)
                    for path in sorted(folder.iterdir(), key=lambda path: path.name == RECORD):
                        path.replace(target / path.name)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        paths = tuple(sorted(reads, key=repr))
        sets = [paths, *(known for known in self._path_sets(root) if known != paths)][:SETS_KEPT]
        atomic_write_text(
            self.folder / "reads" / root, "".join(f"{json.dumps(known, default=repr)}\n" for known in sets)
        )
        if self._is_search_due(target):
            self._remove_oldest(keep=key)
        entry = self._entry(key)
        if entry is None:
            raise OSError(f"the cache in {self.folder} lost an artefact just written")
        return entry

    def computed(
        self, name: str, design: Any, modules: Sequence[str], make: Callable[[Any], Made], depends: Iterable[str] = ()
    ) -> Made:
        """The stored result of `make(tracked_design)`, computed now if the store lacks it or its file is damaged."""
        depends = tuple(depends)

        def write(tracked: Any, folder: Path) -> None:
            (folder / FILE).write_bytes(pickle.dumps(make(tracked), pickle.HIGHEST_PROTOCOL))

        for _ in range(2):
            entry = self.make(name, design, modules, write, depends)
            data = entry.data(FILE)
            if sha256(data) == entry.hashes[FILE]:
                return pickle.loads(data)
            self.drop(entry)
        raise OSError(f"the cache in {self.folder} does not keep what is written to it")

    def drop(self, entry: Artefact) -> None:
        """Have a damaged artefact made again by the next `make`; its files stay for runs that read them."""
        entry.path(RECORD).unlink(missing_ok=True)
        _verified.discard(entry.folder)

    def _entry(self, key: str) -> Artefact | None:
        folder = self.folder / "entries" / key
        try:
            record = json.loads((folder / RECORD).read_text("utf-8"))
            if folder not in _verified:
                # A result that the disk has changed is made again; each process looks once.
                if any(sha256((folder / name).read_bytes()) != digest for name, digest in record["hashes"].items()):
                    logging.getLogger("stagecad").warning("a stored result was damaged; it is made again")
                    return None
                _verified.add(folder)
            elif not all((folder / name).is_file() for name in record["hashes"]):
                return None
            os.utime(folder)
            return Artefact(key, folder, record["hashes"], tuple(record["reads"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def _path_sets(self, root: str) -> list[tuple[AccessPath, ...]]:
        try:
            lines = (self.folder / "reads" / root).read_text("utf-8").splitlines()
            return [_tuples(json.loads(line)) for line in lines]
        except (OSError, ValueError):
            return []

    def _discard(self, folder: Path) -> None:
        # Renamed first, so that no other run reads an incomplete artefact.
        with suppress(OSError):
            removed = Path(tempfile.mkdtemp(prefix=".removed-", dir=self.folder / "entries"))
            folder.rename(removed / folder.name)
            shutil.rmtree(removed, ignore_errors=True)

    def _is_search_due(self, made: Path) -> bool:
        """Whether this process has added a hundredth of the size limit since it last searched the store, or begins:
        a search reads the state of every file."""
        added = _added.get(self.folder, math.inf)
        with suppress(OSError):
            added += sum(path.stat().st_size for path in made.iterdir())
        due = added > _size_limit() / 100
        _added[self.folder] = 0 if due else added
        return due

    def _remove_oldest(self, keep: str) -> None:
        """Remove the least recently used artefacts beyond the size limit, and temporary folders of aborted runs."""
        largest = _size_limit()
        now = time.time()
        found: list[tuple[float, int, Path]] = []
        for folder in (self.folder / "entries").iterdir():
            with suppress(OSError):
                age = now - folder.stat().st_mtime
                if folder.name.startswith("."):
                    if age > ABANDONED:
                        shutil.rmtree(folder, ignore_errors=True)
                    continue
                found.append((age, sum(path.stat().st_size for path in folder.iterdir()), folder))
        total = sum(size for _, size, _ in found)
        for _, size, folder in sorted(found, reverse=True):
            if total <= largest:
                break
            # The age now: another run may have found the artefact since the ages were collected.
            if folder.name != keep and _age(folder) > MINIMUM_AGE:
                self._discard(folder)
                total -= size
        for path in sorted((self.folder / "reads").glob("*"), key=_age)[MOST_READS:]:
            path.unlink(missing_ok=True)


def _tuples(value: Any) -> Any:
    """JSON's lists, and those within them, as tuples."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _age(path: Path) -> float:
    """Time since the last use or change, s; 0 for what another run has just removed."""
    try:
        return time.time() - path.stat().st_mtime
    except OSError:
        return 0.0


def _size_limit() -> int:
    text = os.environ.get("STAGECAD_CACHE_MAX") or str(LARGEST)
    if not text.isdecimal() or len(text) > 18:
        raise InputError(f"STAGECAD_CACHE_MAX = '{text}' is not a number of bytes; write it like {LARGEST}")
    return int(text)


class DamagedError(Exception):
    """The files of an artefact differ from those that were stored, or are missing."""

    def __init__(self, entry: Artefact) -> None:
        super().__init__(entry.key)
        self.entry = entry


def write_stored(out: Path, files: Mapping[str, Artefact]) -> list[str]:
    """Copy files of artefacts into `out`, and return the names of those that were missing or different."""
    written: list[str] = []
    for name, entry in files.items():
        target = out / name
        if _digest(target) == entry.hashes[name]:
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
