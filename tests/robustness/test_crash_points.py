"""Killed, or with a full disk, at every file operation of every function that writes a user's files: old or new."""

import errno
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design, write_values
from stagecad.solids.artefacts.store import ArtefactStore, write_stored
from sysid.experiment.experiment import find_experiment, load_experiment
from sysid.experiment.ladder import append_revision, edited_by_hand, read_history, undo
from tests.experiments import write_csv
from tests.robustness.crashing import DONE, KILLED, RAISED, run_until
from workbench.operations.templates import free_folder, fresh_copy
from workbench.page.machine_session import MachineSession
from workbench.page.project import Project

pytestmark = pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="needs fork")

TEXT = """# mine
schema = 1
[rig]
kind = "velocity-drive"
[model]
effects = ["coulomb"]  # so far
[[record]]
file = "fit.csv"
role = "fit"
"""
Action = Callable[[], object]
MOST = 60
"""More operations than any of the functions makes."""


def every_point(
    folder: Path, prepare: Action, act: Action, check: Callable[[int], None], step: int = 1, full: bool = False
) -> int:
    """Kill `act` at each of its operations in turn, and check what is left; the number of points."""
    for number in range(0, MOST, step):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        prepare()
        ended = run_until(number, folder, act, errno.ENOSPC if full else None, (OSError, InputError) if full else ())
        assert ended in (RAISED if full else KILLED, DONE)
        check(number)
        if ended == DONE:
            return number
    raise AssertionError("the function never ended")


full_disk = partial(every_point, step=3, full=True)
"""The same with a disk that is full from each third operation on."""


def _prepare(rig: Path) -> None:
    t = np.arange(50) * 0.01
    write_csv(rig / "fit.csv", {"time": t, "position": 0.01 * np.sin(t), "friction_force": np.cos(t)})
    (rig / "experiment.toml").write_text(TEXT)


def _add(rig: Path, effect: str) -> None:
    experiment = load_experiment(rig)
    starts = {"coulomb.force": (1.3, "N")}
    append_revision(experiment, (*experiment.effects, effect), starts, {"parameters": {}}, {"parameters": {}}, {})


def _consistent(rig: Path, *allowed: tuple[str, ...]) -> None:
    """Experiment and ladder agree, comments are kept, and the next run works."""
    now = load_experiment(rig)
    assert now.effects in allowed
    assert "# mine" in now.text and "# so far" in now.text
    rungs = read_history(now)
    assert not edited_by_hand(now, rungs)
    assert not rungs or rungs[-1].effects == now.effects
    _add(rig, "quadratic_drag")
    again = load_experiment(rig)
    assert again.effects == (*now.effects, "quadratic_drag")
    assert len(read_history(again)) == max(len(rungs), 1) + 1


@pytest.mark.parametrize("way", [every_point, full_disk])
@pytest.mark.parametrize("undone", [False, True])
def test_an_addition_and_an_undo(tmp_path: Path, way: Callable[..., int], undone: bool) -> None:
    rig = tmp_path / "rig"

    def prepare() -> None:
        _prepare(rig)
        if undone:
            _add(rig, "viscous")

    def check(number: int) -> None:
        assert not undone or len(list(rig.rglob("001*.json"))) == 1
        _consistent(rig, ("coulomb",), ("coulomb", "viscous"))

    act = (lambda: undo(find_experiment(rig))) if undone else (lambda: _add(rig, "viscous"))
    assert way(rig, prepare, act, check) >= (6 if undone else 8)


@pytest.mark.parametrize("way", [every_point, full_disk])
def test_values_written_back(tmp_path: Path, way: Callable[..., int]) -> None:
    folder = tmp_path / "design"
    file = folder / "stage.toml"
    text = '# mine\nextends = "thesis"\n[friction]\ncoulomb = {value = "1.2 N", origin = "assumed: a guess"}\n'

    def check(number: int) -> None:
        assert load_design(file).si("friction.coulomb") in (1.2, 1.3)
        assert file.read_text().startswith("# mine\n")

    changes = {"friction.coulomb": ("1.3 N", "measured: rig")}
    assert way(folder, lambda: file.write_text(text), lambda: write_values(file, changes), check) >= 3


@pytest.mark.parametrize("way", [every_point, full_disk])
def test_a_file(tmp_path: Path, way: Callable[..., int]) -> None:
    folder = tmp_path / "out"

    def check(number: int) -> None:
        assert (folder / "a.txt").read_text() in ("old", "new")

    old, new = lambda: (folder / "a.txt").write_text("old"), lambda: atomic_write_text(folder / "a.txt", "new")
    assert way(folder, old, new, check) >= 3


def test_a_demonstration_leaves_what_it_did_not_make(tmp_path: Path) -> None:
    folder = tmp_path / "out"

    def prepare() -> None:
        (folder / "demo").mkdir()
        (folder / "demo" / "experiment.toml").write_text("my own")

    def check(number: int) -> None:
        assert (folder / "demo" / "experiment.toml").read_text() == "my own"
        load_experiment(fresh_copy(free_folder(folder / "demo")))

    assert every_point(folder, prepare, lambda: fresh_copy(free_folder(folder / "demo")), check) >= 5


@pytest.mark.parametrize("way", [pytest.param(every_point, marks=pytest.mark.slow), full_disk])
def test_a_commit_and_a_save_of_the_page(tmp_path: Path, way: Callable[..., int]) -> None:
    """The next server has the changes before or after, and the file is whole or not there."""
    folder = tmp_path / "project"
    steps = [{}, {"stage.thickness": "13 mm"}, {"stage.thickness": "14 mm"}]

    def act() -> None:
        session = MachineSession(Project(folder, Path("build")))
        session.commit(steps[2])
        session.save("mine")

    def check(number: int) -> None:
        session = MachineSession(Project(folder, Path("build")))
        assert session.changes in (steps[0] if session.file else steps[1], steps[2])
        if (folder / "mine.toml").exists():
            assert load_design(folder / "mine.toml", rules=False).entry("stage.thickness").text == "14 mm"
        else:
            session.commit(steps[2])
            assert session.save("mine") == "mine.toml"

    prepare = lambda: MachineSession(Project(folder, Path("build"))).commit(steps[1])  # noqa: E731
    assert way(folder, prepare, act, check) >= 6


def test_the_cache_gives_whole_artefacts(tmp_path: Path) -> None:
    folder = tmp_path / "store"

    def make(design: object, made: Path) -> None:
        (made / "a.bin").write_bytes(b"1" * 1000)
        (made / "b.bin").write_bytes(b"2" * 1000)

    def act() -> None:
        entry = ArtefactStore(folder / "cache").make("part", object(), ("stagecad.solids.modelling.frame",), make)
        write_stored(folder / "out", {"a.bin": entry, "b.bin": entry})

    def check(number: int) -> None:
        for path in (folder / "out").glob("[!.]*.bin"):
            assert path.stat().st_size == 1000
        act()
        assert sorted(path.name for path in (folder / "out").glob("[!.]*.bin")) == ["a.bin", "b.bin"]

    assert every_point(folder, lambda: None, act, check) >= 8
