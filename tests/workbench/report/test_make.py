"""`stagecad make` makes again what a change affects, and nothing else; the files are those of an empty cache."""

import hashlib
import json
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from stagecad.parameters.errors import LostProcessError, PartError
from stagecad.parameters.load import load_design
from stagecad.private import cache_root
from stagecad.solids.artefacts.key import ROOT, _file
from workbench.operations.design import Design as StatedDesign
from workbench.report import make as make_module
from workbench.report.make import Kind, Making, Task

CHANGES = {
    "stage.thickness=12.5 mm": {"stage", "assembly", "drawing of stage", "picture of stage"},
    "actuator.tip_height=20.5 mm": {"tip", "base", "drawing of tip", "drawing of base", "simulation tip"},
    "actuator.piezo_spacing=47 mm": {"tip", "holder", "drawing of tip", "drawing of holder", "simulation tip"},
    "bearing.dynamic_friction=0.055": {"checks", "figure travel"},
}
"""A change, and some of the results that it affects; of parts, drawings and simulations all."""


def making(folder: Path, *overrides: str) -> Making:
    design = load_design(overrides=overrides)
    return Making(folder, design, design, StatedDesign(None, overrides), simulations=True)


def test_tasks_and_what_an_empty_store_lacks(tmp_path: Path) -> None:
    tasks = making(tmp_path).tasks
    for needed in tasks.values():
        assert set(needed) <= set(tasks)
    known = {task for task, needed in tasks.items() if not needed}
    while len(known) < len(tasks):
        following = {task for task, needed in tasks.items() if set(needed) <= known}
        assert following > known, "tasks that need each other"
        known = following
    whole = making(tmp_path)
    assert whole.absent == list(whole.tasks)
    whole = making(tmp_path)
    whole.__dict__["parts"] = {}
    assert not whole.has(Task(Kind.SHAPES))


def test_stored_checks_depend_on_the_files_that_state_them() -> None:
    stating = (_file(name) for name in make_module.checked_by(load_design()))
    assert ROOT / "designcalc" / "friction_stage" / "checks.toml" in {
        path.with_suffix(".toml") for path in stating if path
    }


def test_only_what_a_change_affects_is_absent(tmp_path: Path) -> None:
    buffer = [Task(Kind.PART, "buffer"), Task(Kind.RENDERING, "buffer")]
    tip = Task(Kind.SIMULATION, "tip")
    done = [*buffer, Task(Kind.PART, "mirror"), Task(Kind.RENDERING, "mirror"), tip]
    first = making(tmp_path)
    for task in done:
        first.run(task)
    assert set(done).isdisjoint(first.absent)
    assert set(done).isdisjoint(making(tmp_path, "bearing.dynamic_friction=0.055").absent)
    wider = making(tmp_path, "buffer.height=3.5 mm").absent
    assert [task for task in done if task in wider] == buffer
    higher = making(tmp_path, "actuator.tip_height=20.5 mm").absent
    assert [task for task in done if task in higher] == [tip]


@pytest.mark.parametrize(
    "error", [PartError("buffer", None, "no solid"), LostProcessError("", Task(Kind.PART, "buffer"))]
)
def test_a_solid_that_cannot_be_made_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(make_module, "parallel_map", refuse)
    with pytest.raises(PartError, match="buffer"):
        making(tmp_path).make([Task(Kind.PART, "buffer")])


def entry_names(cache: Path) -> Counter[str]:
    """Names of the artefacts in a cache, with their numbers."""
    records = (json.loads(path.read_text()) for path in (cache / "entries").glob("*/entry.json"))
    return Counter(record["name"] for record in records)


def files_of(folder: Path) -> dict[str, str]:
    """Hash of each file by its path."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_result_after_a_change_is_that_of_an_empty_cache(tmp_path: Path, change: str) -> None:
    def make(cache: str, *overrides: str) -> dict[str, str]:
        words = [sys.executable, "-m", "workbench.cli", "make", "--out", str(tmp_path / "out"), *overrides]
        monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / cache))
        subprocess.run(words, check=True, capture_output=True)
        made = files_of(tmp_path / "out")
        shutil.rmtree(tmp_path / "out")
        return made

    for cache in ("one", "other"):
        shutil.copytree(cache_root() / "kernels", tmp_path / cache / "kernels")
    with pytest.MonkeyPatch.context() as monkeypatch:
        make("one")
        before, incremental = entry_names(tmp_path / "one"), make("one", "--set", change)
        again = entry_names(tmp_path / "one") - before
        whole = make("other", "--set", change)
    assert incremental == whole
    assert again[max(again, key=again.__getitem__)] >= 1
    affected = CHANGES[change]
    assert affected <= set(again)
    for prefix in ("drawing of ", "simulation "):
        parts = {name for name in again if name.startswith(prefix)} - {"drawing of assembly", "drawing of procedure"}
        assert parts == {name for name in affected if name.startswith(prefix)}
    assert all(number == 1 for name, number in again.items() if name != "reduced sheet")
