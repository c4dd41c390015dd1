"""Commands killed at random times: nothing is torn, nothing of them lives on, and the next run works."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.load import load_design
from sysid.experiment.experiment import load_experiment
from sysid.experiment.history import edited_by_hand, read_history
from tests.robustness.mutation import count
from tests.sysid.slide import SIGN, VELOCITY, slide

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs process groups")]
KILLS = count(30)
STAGE = '# mine\nextends = "thesis"\n[friction]\ncoulomb = {value = "1.2 N", origin = "assumed: a guess"}\n'


@dataclass(frozen=True)
class Case:
    """A command that writes, as words, and what must hold after any end of it."""

    words: tuple[str, ...]
    check: Callable[[Path], None]
    before: tuple[str, ...] = ()


def _experiment(folder: Path) -> None:
    now = load_experiment(folder / "rig")
    rungs = read_history(now)
    assert not edited_by_hand(now, rungs)
    assert not rungs or rungs[-1].effects == now.effects
    load_design(folder / "stage.toml")


def _files(folder: Path) -> None:
    """What has its final name is whole."""
    _experiment(folder)
    for path in folder.rglob("*.json"):
        if not path.name.startswith("."):
            json.loads(path.read_text("utf-8"))
    for path in folder.rglob("*.html"):
        assert path.read_text("utf-8").rstrip().endswith("</html>")


CASES = {
    "add": Case(("add", "rig", "viscous"), _experiment),
    "undo": Case(("add", "rig", "--undo"), _experiment, ("add", "rig", "viscous")),
    "write-back": Case(("add", "rig", "viscous", "--write-back", "friction.coulomb"), _experiment),
    "params": Case(("params", "--write", "new.toml", "--set", "stage.length=240 mm"), _files),
    "compare": Case(("compare", "rig", "--json", "out.json"), _files),
    "diagnose": Case(("diagnose", "rig", "--json", "out.json"), _files),
    "suggest": Case(("suggest", "rig"), _files),
    "simulate": Case(("simulate", "rig"), _files),
    "check": Case(("check", "--json", "out.json"), _files),
    "demo": Case(("demo",), _files),
    "parts": Case(("parts", "--json", "out.json"), _files),
    "make": Case(("make", "--no-simulations"), _files),
}


@pytest.mark.parametrize("name", CASES)
def test_killed_at_random_times(tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    case, random = CASES[name], np.random.default_rng(7)
    environment = {**os.environ, "PYTHONPATH": os.getcwd()}

    def begin(folder: Path, words: tuple[str, ...]) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-m", "workbench.cli", *words],
            cwd=folder,
            env=environment,
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def prepared(number: int) -> Path:
        folder = tmp_path / f"run_{number}"
        folder.mkdir()
        slide(folder / "rig", 1.5 * SIGN + 20.0 * VELOCITY, '"coulomb"', held_out=True)
        (folder / "stage.toml").write_text(STAGE)
        if case.before:
            preparing = begin(folder, case.before)
            error = preparing.communicate()[1]
            assert preparing.returncode == 0, error
        return folder

    began = time.monotonic()
    whole = begin(prepared(0), case.words)
    assert whole.communicate()[1] is not None and whole.returncode in (0, 1)
    seconds = time.monotonic() - began
    for number in range(1, KILLS + 1):
        folder = prepared(number)
        started = begin(folder, case.words)
        time.sleep(random.uniform(0.2, 1.0) * seconds)
        started.kill()
        error = started.communicate()[1]
        assert "Traceback" not in error
        assert _gone(started.pid)
        case.check(folder)
        again = begin(folder, case.words)
        error = again.communicate()[1]
        # What the killed run had completed is refused in one line the second time.
        assert again.returncode in (0, 1, 2) and "Traceback" not in error, error
        case.check(folder)
    with capsys.disabled():
        print(f"\n{name}: {KILLS} kills within {seconds:.1f} s")  # noqa: T201


def _gone(group: int) -> bool:
    """Whether all processes of the group end within some seconds."""
    deadline = time.monotonic() + 15.0
    while time.monotonic() < deadline:
        found = subprocess.run(["ps", "-eo", "pgid=,stat="], capture_output=True, text=True).stdout.split()
        if not any(int(one) == group and not state.startswith("Z") for one, state in zip(found[::2], found[1::2])):
            return True
        time.sleep(0.2)
    return False
