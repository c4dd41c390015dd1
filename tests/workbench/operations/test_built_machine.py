"""Who waits at a terminal while the CAD kernel works is told that Ctrl-C waits too; damaged results are made again."""

import io
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rich.console import Console
from rich.progress import Progress

from stagecad.solids.artefacts.outputs import DamagedError, write_stored
from stagecad.solids.artefacts.store import ArtefactStore
from workbench.cli.commands.parts import KERNEL
from workbench.cli.options import Run
from workbench.operations import parts


@pytest.mark.parametrize(("cached", "terminal", "notes"), [(False, True, 1), (False, False, 0), (True, True, 0)])
def test_the_wait_is_told_on_a_terminal_before_the_kernel_begins(monkeypatch, capsys, cached, terminal, notes):
    stored, made = object(), object()
    monkeypatch.setattr(parts, "find_machine", lambda design, store: stored if cached else None)
    monkeypatch.setattr(parts, "build_machine", lambda design, store, advance: made)
    monkeypatch.setattr(parts, "part_names", lambda design: ("tip",))
    bar = Progress(console=Console(file=io.StringIO()), disable=not terminal)
    monkeypatch.setattr(Run, "progress", lambda run: bar)
    with Run(None, (), Path("build"), None).reporting(note=KERNEL) as report:
        machine = parts.built_machine(cast(Any, None), None, report)
    assert machine is (stored if cached else made)
    assert capsys.readouterr().err.count("Ctrl-C") == notes


def test_every_damaged_artefact_is_made_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = ArtefactStore(tmp_path / "cache")

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
    parts.with_repair(store, write)
    assert [(tmp_path / "out" / f"{name}.txt").read_text() for name in ("one", "two", "three")] == ["good"] * 3
    assert caplog.messages == ["a stored result was damaged; it is made again"] * 2


def test_a_cache_that_never_keeps_what_it_stores_is_one_line(tmp_path: Path) -> None:
    entry: Any = SimpleNamespace(key="a")
    store: Any = SimpleNamespace(folder=tmp_path, drop=lambda entry: None)

    def write() -> None:
        raise DamagedError(entry)

    with pytest.raises(OSError, match="does not keep what is written to it"):
        parts.with_repair(store, write)


def _text(folder: Path, name: str) -> None:
    (folder / f"{name}.txt").write_text("good")
