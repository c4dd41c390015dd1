"""Who waits at a terminal while the CAD kernel works is told that Ctrl-C waits too; damaged results are made again."""

from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rich.console import Console
from rich.progress import Progress

import stagecad.friction_stage.assembly.machine
import stagecad.solids.modelling.registry
from stagecad.solids.artefacts.outputs import DamagedError, write_stored
from stagecad.solids.artefacts.store import ArtefactStore
from workbench.machine.artefacts import built_machine, with_repair


@pytest.mark.parametrize(("cached", "terminal", "told"), [(False, True, 1), (False, False, 0), (True, True, 0)])
def test_the_wait_is_told_on_a_terminal_before_the_kernel_begins(monkeypatch, cached, terminal, told):
    found, made, notes = object(), object(), []
    monkeypatch.setattr(
        stagecad.friction_stage.assembly.machine, "find_machine", lambda design, store: found if cached else None
    )
    monkeypatch.setattr(stagecad.friction_stage.assembly.machine, "build_machine", lambda design, store, advance: made)
    monkeypatch.setattr(stagecad.solids.modelling.registry, "part_names", lambda design: ("tip",))
    run: Any = SimpleNamespace(
        design=None,
        note=notes.append,
        progress=lambda: Progress(console=Console(file=io.StringIO()), disable=not terminal),
    )
    assert built_machine(run) is (found if cached else made)
    assert ["Ctrl-C" in note for note in notes] == [True] * told


def test_every_damaged_artefact_is_made_again(tmp_path: Path) -> None:
    store, notes = ArtefactStore(tmp_path / "cache"), []
    run: Any = SimpleNamespace(note=notes.append)

    def write() -> list[str]:
        modules = ("stagecad.solids.modelling.frame",)
        entries = {
            f"{name}.txt": store.make(name, object(), modules, lambda _, folder, name=name: _text(folder, name))
            for name in ("one", "two", "three")
        }
        for name in damaged:
            entries[name].path(name).write_text("damaged")
        damaged.clear()
        return write_stored(tmp_path / "out", entries)

    damaged = ["one.txt", "three.txt"]
    with_repair(run, store, write)
    assert [(tmp_path / "out" / f"{name}.txt").read_text() for name in ("one", "two", "three")] == ["good"] * 3
    assert len(notes) == 2


def test_a_cache_that_never_keeps_what_it_stores_is_one_line(tmp_path: Path) -> None:
    entry: Any = SimpleNamespace(key="a")
    store: Any = SimpleNamespace(folder=tmp_path, drop=lambda entry: None)

    def write() -> None:
        raise DamagedError(entry)

    with pytest.raises(OSError, match="does not keep what is written to it"):
        with_repair(cast(Any, SimpleNamespace(note=print)), store, write)


def _text(folder: Path, name: str) -> None:
    (folder / f"{name}.txt").write_text("good")
