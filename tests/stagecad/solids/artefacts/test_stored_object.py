"""Objects in the store are kept, and computed again where they are damaged."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.artefacts.stored_object import FILE, stored_object

MODULES = ("stagecad.solids.modelling.frame",)


@dataclass(frozen=True)
class Plate:
    length: float = 3.0
    width: float = 4.0


def lengths(store: ArtefactStore, plate: Plate, computed: list[float]) -> tuple[float, ...]:
    def compute(tracked: Any) -> tuple[float, ...]:
        computed.append(tracked.length)
        return tracked.length, 2 * tracked.length

    return stored_object(store, "lengths", plate, MODULES, compute)


def test_computed_once_for_the_values_read(tmp_path: Path) -> None:
    store, computed = ArtefactStore(tmp_path), []
    assert lengths(store, Plate(), computed) == (3.0, 6.0)
    assert lengths(store, Plate(width=5.0), computed) == (3.0, 6.0)
    assert lengths(store, Plate(length=4.0), computed) == (4.0, 8.0)
    assert computed == [3.0, 4.0]


def test_damaged_is_computed_again(tmp_path: Path) -> None:
    store, computed = ArtefactStore(tmp_path), []
    lengths(store, Plate(), computed)
    (file,) = tmp_path.glob(f"entries/*/{FILE}")
    file.write_bytes(b"cos\nsystem\n(S'exit 1'\ntR.")
    assert lengths(store, Plate(), computed) == (3.0, 6.0)
    assert computed == [3.0, 3.0]
    assert lengths(store, Plate(), computed) == (3.0, 6.0)
    assert computed == [3.0, 3.0]


def test_a_store_that_does_not_keep_what_is_written_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stagecad.solids.artefacts.stored_object.sha256", lambda data: "another")
    with pytest.raises(OSError, match="does not keep"):
        lengths(ArtefactStore(tmp_path), Plate(), [])
