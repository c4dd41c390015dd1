"""Two runs on one experiment at once, and a run that is stopped: nothing is lost, and nothing is half done."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import sysid.ladder
from workbench.cli import run


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    folder = tmp_path / "rig"
    folder.mkdir()
    t = np.arange(2500) * 1e-3
    v = 0.02 * np.sin(2 * np.pi * t) + 0.01 * np.sin(2 * np.pi * 3.1 * t)
    force = 1.5 * np.sign(v) + 8.0 * v + 0.2 + np.random.default_rng(3).normal(0, 0.01, t.size)
    header = "time [s],position [m],velocity [m/s],friction_force [N]"
    table = np.column_stack([t, np.cumsum(v) * 1e-3, v, force])
    np.savetxt(folder / "log.csv", table, "%.8g", ",", header=header, comments="")
    (folder / "experiment.toml").write_text(
        '# Mine.\nschema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["coulomb"]  # so far\n'
        '[[record]]\nfile = "log.csv"\nrole = "fit"\n[noise]\nfriction_force = "10 mN"\n'
    )
    return folder


def test_of_two_runs_at_once_each_is_whole_or_did_nothing(rig: Path) -> None:
    runs = [
        subprocess.Popen(
            [sys.executable, "-m", "workbench.cli", "add", str(rig), effect],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for effect in ("viscous", "constant_bias")
    ]
    said = [one.communicate(timeout=300)[1] for one in runs]
    codes = [one.returncode for one in runs]

    assert set(codes) <= {0, 2}
    assert 0 in codes
    for code, error in zip(codes, said, strict=True):
        if code == 2:
            assert "changed while the fit ran; nothing was added, run again" in error
            assert len(error.strip().splitlines()) == 1
    rungs = sorted((rig / "ladder").glob("0*.json"))
    assert len(rungs) == 1 + codes.count(0)
    text = (rig / "experiment.toml").read_text()
    assert tomllib.loads(text)["model"]["effects"] == json.loads(rungs[-1].read_text())["effects"]
    assert "# Mine." in text
    assert "# so far" in text


def test_a_run_that_is_stopped_leaves_everything_as_it_was(rig: Path, monkeypatch, capsys) -> None:
    assert run(["add", str(rig), "viscous"]) == 0
    before = {path: path.read_bytes() for path in rig.rglob("*") if path.is_file()}

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sysid.ladder, "append_revision", interrupted)
    capsys.readouterr()
    assert run(["add", str(rig), "constant_bias"]) == 130
    assert capsys.readouterr().err.strip() == "stopped"
    assert {path: path.read_bytes() for path in rig.rglob("*") if path.is_file()} == before


def test_adding_after_undo_goes_on_from_the_rung_restored(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = (rig / "experiment.toml").read_bytes()
    assert run(["add", str(rig), "cable_spring"]) == 0
    assert run(["add", str(rig), "--undo"]) == 0
    assert (rig / "experiment.toml").read_bytes() == first
    assert run(["add", str(rig), "viscous"]) == 0
    assert run(["add", str(rig), "constant_bias"]) == 0
    capsys.readouterr()
    assert run(["ladder", str(rig), "--no-figures", "--json"]) == 0
    rungs = json.loads(capsys.readouterr().out)
    assert [r["effects"] for r in rungs] == [
        ["coulomb"],
        ["coulomb", "viscous"],
        ["coulomb", "viscous", "constant_bias"],
    ]
    assert [len(r["added"]) for r in rungs] == [0, 1, 1]
    assert len(list((rig / "ladder" / "undone").iterdir())) == 1
