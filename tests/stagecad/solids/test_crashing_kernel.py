"""A crash of the CAD kernel ends the process that builds the part, and the command in one line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stagecad.parameters.errors import PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import CRASHED, build_parts
from stagecad.solids.artefacts.store import ArtefactStore

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
CRASH = """
import multiprocessing, os, sys
if "--multiprocessing-fork" in sys.argv or "spawn_main" in " ".join(sys.orig_argv):
    import stagecad.solids.artefacts.part as part
    part.build_part = lambda *rest: os.kill(os.getpid(), 11)
"""


@pytest.fixture
def crashing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Processes started by `multiprocessing` crash in the construction of any part."""
    (tmp_path / "sitecustomize.py").write_text(CRASH)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(Path.cwd())]))
    return tmp_path


def test_one_part_whose_construction_crashes_is_refused(crashing: Path) -> None:
    design = load_design(None, ["tip.hub_diameter=23 mm"])
    with pytest.raises(PartError) as caught:
        build_parts(ArtefactStore(crashing / "cache"), ["tip"], design)
    assert (caught.value.part, caught.value.reason) == ("tip", CRASHED)


def test_the_command_names_part_and_parameters(crashing: Path) -> None:
    environment = {**os.environ, "STAGECAD_CACHE": str(crashing / "cache")}
    command = [sys.executable, "-m", "workbench.cli", "parts", "tip", "--set", "tip.hub_diameter=23 mm"]
    found = subprocess.run(command, env=environment, cwd=crashing, capture_output=True, text=True, timeout=120)
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1 and "no valid solid of 'tip'" in found.stderr
    assert "tip.hub_diameter = 23 mm (packaged: 22 mm)" in found.stderr and CRASHED in found.stderr
