"""Every command that writes, killed at random times and at random file operations: no file is torn or lost, no process
lives on, and the next run works.

The command runs in a fork of this process, which has loaded its modules: a run takes what its work takes.
"""

import shutil
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.load import load_design
from stagecad.private import cache_root
from sysid.experiment.experiment import load_experiment
from sysid.experiment.ladder import edited_by_hand, read_history
from tests.experiments import thin
from tests.process_state import group_runs, wait_until
from tests.robustness.crashing import Ended, run_killed
from tests.robustness.mutation import count
from tests.robustness.whole_files import assert_whole
from tests.sysid.slide import SIGN, VELOCITY, slide
from workbench.cli import run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="needs process groups and descriptors of processes"),
]
KILLS = count(30)
QUICK = 0.5
"""A command that takes less is run to its end after each kill; another after every `TOGETHER` kills, s."""
TOGETHER = 10
STAGE = '# mine\nextends = "thesis"\n[friction]\ncoulomb = {value = "1.2 N", origin = "assumed: a guess"}\n'
OWN = "my own"
"""Content of files that no command may touch."""


@dataclass(frozen=True)
class Case:
    """A command that writes."""

    words: str  # `{n:03d}` becomes another number in each group of kills
    before: str = ""  # another command that is run first
    may_change: tuple[str, ...] = ()  # files of the user that the command writes
    may_refuse: bool = False  # whether a run after one that was complete is refused


MODEL = ("rig/experiment.toml",)
CASES = {
    "new experiment": Case("new experiment other rig/fit.csv --kind velocity-drive", may_refuse=True),
    "new machine": Case("new machine other", may_refuse=True),
    "new effect": Case("new effect other", may_refuse=True),
    "params": Case("params --write new.toml --set stage.length=240.{n:03d}mm", may_refuse=True),
    "look": Case("look rig --json out.json"),
    "compare": Case("compare rig --json out.json"),
    "diagnose": Case("diagnose rig --json out.json"),
    "suggest": Case("suggest rig --json out.json"),
    "add": Case("add rig viscous", may_change=MODEL, may_refuse=True),
    "undo": Case("add rig --undo", "add rig viscous", may_change=MODEL, may_refuse=True),
    "write-back": Case(
        "add rig viscous --write-back friction.coulomb", may_change=(*MODEL, "stage.toml"), may_refuse=True
    ),
    "ladder": Case("ladder rig --json out.json", "add rig viscous"),
    "simulate": Case("simulate tip --format both --json out.json"),
    "simulate experiment": Case("simulate rig --json out.json"),
    "check": Case("check --no-solids --json out.json --set friction.coulomb=1.{n:03d}N"),
    "optimize": Case("optimize --no-solids --no-figures --budget 20 --evaluations 50 --write new.toml --json out.json"),
    "demo": Case("demo --json out.json"),
    "parts": Case("parts --json out.json --set magnet.edge_chamfer=0.3{n:03d}mm"),
    "drawings": Case("drawings magnet --json out.json --set magnet.edge_chamfer=0.4{n:03d}mm"),
    "make": Case("make --no-simulations --json out.json --set magnet.edge_chamfer=0.2{n:03d}mm"),
}


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cache of its own, which begins with the compiled kernels of the user's."""
    folder = tmp_path_factory.mktemp("kills") / "cache"
    shutil.copytree(cache_root() / "kernels", folder / "kernels")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STAGECAD_CACHE", str(folder))
        yield


@pytest.mark.parametrize("name", CASES)
def test_killed_at_random_moments(tmp_path, name: str, capfd: pytest.CaptureFixture[str], monkeypatch) -> None:
    case, random, found = CASES[name], np.random.default_rng([7, KILLS]), Counter[str]()
    template = _template(tmp_path, case)
    # Once in this process, which loads the modules that the forks inherit.
    shutil.copytree(template, tmp_path / "loading")
    monkeypatch.chdir(tmp_path / "loading")
    assert run(case.words.format(n=98).split()) in (0, 1)
    whole = _begin(tmp_path, template, "reference", case, 99)()
    assert whole.status in (0, 1), whole.text
    names, group = _names(tmp_path / "reference"), 0
    while found["kills"] < KILLS:
        group += 1
        again, longest, together = _begin(tmp_path, template, f"run_{group}", case, group), whole.seconds, 0
        folder = tmp_path / f"run_{group}"
        while found["kills"] < KILLS:
            if random.random() < 0.5:
                ended = again(seconds=longest * random.random())
            else:
                ended = again(operation=int(random.integers(max(whole.operations, 1))))
            _sound(folder, case, ended, names)
            if ended.status is not None:
                # Its work was in the cache, or the command had been completed before.
                found["ended before"] += 1
                break
            found["kills"], together = found["kills"] + 1, together + 1
            if whole.seconds < QUICK or together == TOGETHER:
                break
        ended = again()
        found["complete runs"] += 1
        _sound(folder, case, ended, names)
        assert ended.status == whole.status or (case.may_refuse and ended.status == 2), ended.text
        assert _has_all(folder, names)
        shutil.rmtree(folder)
    with capfd.disabled():
        print(f"\n{name}: {dict(found)}, {whole.operations} operations in {whole.seconds:.1f} s")  # noqa: T201


def _template(tmp_path: Path, case: Case) -> Path:
    folder = tmp_path / "template"
    slide(folder / "rig", 1.3 * SIGN + 20.0 * VELOCITY, "coulomb", held_out=True)
    # What a run takes is the number of kills that can be afforded.
    thin(folder / "rig", 10)
    (folder / "stage.toml").write_text(STAGE)
    for place in ("build/notes.txt", "build/demo/experiment.toml", "rig/notes.txt", "checks.txt"):
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_text(OWN)
    if case.before:
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            assert run(case.before.split()) == 0
    return folder


def _begin(tmp_path: Path, template: Path, name: str, case: Case, number: int) -> Callable[..., Ended]:
    """A function that runs the command in a new copy of the template, in a fork."""
    folder = tmp_path / name
    shutil.copytree(template, folder)
    words = case.words.format(n=number).split()
    return partial(run_killed, partial(run, words), folder, tmp_path, tmp_path / "log.txt")


def _has_all(folder: Path, names: set[str]) -> bool:
    """Whether a run has left all files of a complete one. A demonstration that finds its folder in another state than
    it left it, as after a kill between the addition of an effect and the note of it, begins the next folder."""
    found, places = _names(folder), {path.name for path in folder.glob("build/demo_*")} | {"demo_2"}
    return any({name.replace("build/demo_2/", f"build/{place}/") for name in names} <= found for place in places)


def _names(folder: Path) -> set[str]:
    """Files with their final names; the name of a file of parameters ends with the hash of the parameters."""
    every = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file() and path.suffix != ".lock")
    return {
        str(path) for path in every if not any(part.startswith(".") for part in path.parts) and "_" not in path.stem
    }


def _sound(folder: Path, case: Case, ended: Ended, names: set[str]) -> None:
    """What holds after any end: no traceback, no orphan, files whole, the user's own as they were."""
    assert "Traceback" not in ended.text, ended.text
    wait_until(lambda: not group_runs(ended.group))
    template = folder.parent / "template"
    for path in template.rglob("*"):
        own = str(path.relative_to(template))
        if path.is_file() and own not in case.may_change and not own.startswith("rig/ladder"):
            assert (folder / own).read_bytes() == path.read_bytes(), own
    for path in folder.rglob("*"):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if path.is_file() and not hidden and path.suffix != ".lock" and path.read_bytes() != OWN.encode():
            assert_whole(path)
    now = load_experiment(folder / "rig")
    rungs = read_history(now)
    assert not edited_by_hand(now, rungs)
    assert not rungs or rungs[-1].effects == now.effects
    load_design(folder / "stage.toml")
