"""A Python object in the store, pickled: the store is a folder that only this user can change."""

import pickle
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from stagecad.solids.artefacts.cache_key import sha256
from stagecad.solids.artefacts.store import ArtefactStore

FILE = "object.pickle"
Made = TypeVar("Made")


def stored_object(
    store: ArtefactStore,
    name: str,
    design: Any,
    modules: Sequence[str],
    compute: Callable[[Any], Made],
    depends: Iterable[str] = (),
) -> Made:
    """The stored result of `compute(tracked_design)`, computed now if the store lacks it or its file is damaged."""
    depends = tuple(depends)

    def make(tracked: Any, folder: Path) -> None:
        (folder / FILE).write_bytes(pickle.dumps(compute(tracked), pickle.HIGHEST_PROTOCOL))

    for _ in range(2):
        entry = store.make(name, design, modules, make, depends)
        data = entry.data(FILE)
        if sha256(data) == entry.hashes[FILE]:
            return pickle.loads(data)
        store.drop(entry)
    raise OSError(f"the cache in {store.folder} does not keep what is written to it")
