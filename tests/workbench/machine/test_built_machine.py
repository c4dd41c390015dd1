"""Who waits at a terminal while the CAD kernel works is told that Ctrl-C waits too; a script is not."""

from __future__ import annotations

import io
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console
from rich.progress import Progress

import stagecad.solids.assembly.machine
import stagecad.solids.modelling.registry
from workbench.machine.artefacts import built_machine


@pytest.mark.parametrize(("cached", "terminal", "told"), [(False, True, 1), (False, False, 0), (True, True, 0)])
def test_the_wait_is_told_on_a_terminal_before_the_kernel_begins(monkeypatch, cached, terminal, told):
    found, made, notes = object(), object(), []
    monkeypatch.setattr(
        stagecad.solids.assembly.machine, "find_machine", lambda design, store: found if cached else None
    )
    monkeypatch.setattr(stagecad.solids.assembly.machine, "build_machine", lambda design, store, advance: made)
    monkeypatch.setattr(stagecad.solids.modelling.registry, "part_names", lambda design: ("tip",))
    run: Any = SimpleNamespace(
        design=None,
        note=notes.append,
        progress=lambda: Progress(console=Console(file=io.StringIO()), disable=not terminal),
    )
    assert built_machine(run) is (found if cached else made)
    assert ["Ctrl-C" in note for note in notes] == [True] * told
