"""The kernel is loaded without the modules of VTK that nothing calls; a crash of it ends the command in one line."""

import os
import shutil
from pathlib import Path

import pytest

from stagecad.parameters.errors import PartError
from stagecad.solids.artefacts.part import CRASHED
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import BuiltMachine, build_machine
from stagecad.solids.assembly.interference import build_interferences
from tests.process_state import PROGRAM, python

LOADED = """
import sys
from stagecad.solids.modelling.kernel import load_kernel
load_kernel()
assert "cadquery" in sys.modules and "vtk" not in sys.modules
assert "vtkmodules.vtkRenderingOpenGL2" not in sys.modules
import cadquery as cq
box = cq.Workplane().box(1, 2, 3).val()
assert abs(box.Volume() - 6.0) < 1e-9 and box.toVtkPolyData(0.1, 0.1).GetNumberOfPoints() > 0
import vtk
assert vtk.vtkSphereSource().GetRadius() == 0.5
load_kernel()
assert sys.modules["vtk"] is vtk
"""


def test_vtk_is_left_out_and_can_be_loaded_afterwards() -> None:
    python("-c", LOADED)


CRASH = """
import multiprocessing, os, sys, time
if "--multiprocessing-fork" in sys.argv or "spawn_main" in " ".join(sys.orig_argv):
    import stagecad.solids.artefacts.part as part
    import stagecad.solids.assembly.interference as interference
    import stagecad.solids.assembly.built_machine as machine
    crash = lambda *rest, **named: os.kill(os.getpid(), 11)
    machine.build_assembly = interference.find_interferences = crash
    build = lambda store, name, design, *files: crash() if name == "tip" else time.sleep(100.0)
    part.build_part = machine.build_part = lambda *one: part.find_part(*one) or build(*one)
"""


@pytest.fixture
def crashing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Processes started by `multiprocessing` crash in the construction of the tip and of the assembly.

    That of the other parts does not end, so that the part that is named does not depend on which process is first.
    """
    (tmp_path / "sitecustomize.py").write_text(CRASH)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(Path.cwd())]))
    return tmp_path


@pytest.mark.slow
def test_an_assembly_whose_construction_crashes_is_refused(crashing: Path, machine: BuiltMachine, store) -> None:
    own, design = ArtefactStore(crashing / "cache"), machine.design
    shutil.copytree(store.folder / "reads", own.folder / "reads", ignore=shutil.ignore_patterns(".*"))
    for part in machine.parts.values():
        shutil.copytree(part.entry.folder, own.folder / "entries" / part.entry.key, copy_function=os.link)
    for build in (lambda: build_machine(design, own), lambda: build_interferences(own, machine.parts, design)):
        with pytest.raises(PartError) as caught:
            build()
        assert (caught.value.part, caught.value.reason) == ("assembly", CRASHED)


def test_the_command_names_part_and_parameters(crashing: Path) -> None:
    words = [*PROGRAM, "parts", "tip", "--set", "tip.hub_diameter=23 mm"]
    changed = {"PYTHONPATH": os.environ["PYTHONPATH"], "STAGECAD_CACHE": str(crashing / "cache")}
    found = python(*words, folder=crashing, status=2, **changed)
    assert found.stderr.count("\n") == 1 and "no valid solid of 'tip'" in found.stderr
    assert "tip.hub_diameter = 23 mm (packaged: 22 mm)" in found.stderr and CRASHED in found.stderr
