"""The processes that load the CAD kernel while `stagecad make` reads the design."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from workbench.cli.options import Run
from workbench.making import start
from workbench.making.start import kernel_processes, note_made

RUN = Run(None, ("stage.thickness=12.5 mm",), Path("build"), None)


def test_no_process_with_one_processor_or_within_a_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(start, "processors", lambda: 1)
    with kernel_processes(RUN) as ahead:
        assert ahead == []
    monkeypatch.setattr(start, "processors", lambda: 2)
    monkeypatch.setattr(start, "inside_worker", lambda: True)
    with kernel_processes(RUN) as ahead:
        assert ahead == []


def test_no_process_for_the_design_that_was_made_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[str] = []

    @contextmanager
    def ahead(load: object, kind: str, count: int) -> Iterator[str]:
        started.append(kind)
        yield kind

    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path))
    monkeypatch.setattr(start, "processors", lambda: 2)
    monkeypatch.setattr(start, "inside_worker", lambda: False)
    monkeypatch.setattr(start, "started_ahead", ahead)
    file = tmp_path / "stage.toml"
    file.write_text("one")
    own = Run(file, (), Path("build"), None)
    for run in (RUN, own):
        with kernel_processes(run):
            assert started.pop()
        note_made(run)
        with kernel_processes(run) as found:
            assert found == [] == started
    file.write_text("other")
    for run in (RUN, own):
        with kernel_processes(run):
            assert started.pop()


def test_the_processes_make_the_tasks_with_the_kernel(tmp_path: Path) -> None:
    program = """
import sys
from pathlib import Path
from workbench.making import start
from workbench.cli.options import Run
start.processors = lambda: 2
with start.kernel_processes(Run(None, (), Path("."), None)) as ahead:
    from stagecad.parameters.load import load_design
    from workbench.operations.design import Design as StatedDesign
    from workbench.making.pool import make_absent
    from workbench.making.tasks import Making
    design = load_design()
    making = Making(Path(sys.argv[1]), design, design, StatedDesign(None, ()), simulations=True)
    make_absent(making, ["part buffer", "part magnet"], ahead=ahead)
    assert making.has("part buffer") and making.has("part magnet")
    assert not any(process.waits for process in ahead) and "cadquery" not in sys.modules
"""
    # In its own cache the design is not the one that was made last.
    environment = {**os.environ, "STAGECAD_CACHE": str(tmp_path / "cache")}
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "made")], check=True, env=environment)
