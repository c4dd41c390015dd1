"""Errors of simulation: of a true model, of a wrong one, and where nothing can be simulated."""

import json
from pathlib import Path

import numpy as np
import pytest

from sysid.prediction.problem import Problem, load_problem
from sysid.prediction.simulation_error import HORIZONS, simulation_errors
from workbench.cli import run

MASS, DRAG, NOISE = 2.0, 15.0, 1e-7
STEP = 1e-3


def _pushed(folder: Path, effects: str = '"coulomb", "viscous"') -> Problem:
    """A mass under a force held from row to row and viscous drag alone, exact from row to row."""
    folder.mkdir()
    time = STEP * np.arange(6000)
    force = 8.0 * np.sin(2.0 * np.pi * 0.7 * time) + 4.0 * np.sin(2.0 * np.pi * 3.1 * time)
    decay, x, v = np.exp(-DRAG / MASS * STEP), 0.0, 0.0
    position = np.zeros(time.size)
    for k in range(1, time.size):
        end = force[k - 1] / DRAG
        x += end * STEP + (v - end) * (1.0 - decay) * MASS / DRAG
        v = end + (v - end) * decay
        position[k] = x
    noisy = position + NOISE * np.random.default_rng(1).standard_normal(time.size)
    table = np.column_stack([time, force, noisy])
    np.savetxt(folder / "a.csv", table, "%.12g", ",", header="time [s],drive_force [N],position [m]", comments="")
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "force-drive"\n[rig.known]\nmass = "{MASS} kg"\n[model]\neffects = [{effects}]\n'
        f'[model.parameters]\n"viscous.coefficient" = "{DRAG} N*s/m"\n'
        f'[[record]]\nfile = "a.csv"\nrole = "fit"\n[noise]\nposition = "{NOISE} m"\n'
    )
    return load_problem(folder)


def test_a_true_model_simulates_the_record_and_a_wrong_one_drifts(tmp_path: Path) -> None:
    problem = _pushed(tmp_path / "rig", '"viscous"')
    true = simulation_errors(problem, problem.start)
    wrong = simulation_errors(problem, problem.start.at({"viscous.coefficient": 1.05 * DRAG}))
    for part in ("fit", "validate"):
        # The velocity at the start is measured, to about NOISE / STEP; the body coasts for MASS / DRAG.
        assert true.free_run[part]["position"].rms < NOISE / STEP * MASS / DRAG
        assert true.free_run[part]["position"].fit_percent > 99.98
        assert wrong.free_run[part]["position"].rms > 100.0 * true.free_run[part]["position"].rms
        short, long = (wrong.horizon[name][part]["position"].rms for name in HORIZONS)
        assert true.horizon["0.1 s"][part]["position"].rms < 0.2 * NOISE / STEP * 0.1
        assert short < 0.2 * long < wrong.free_run[part]["position"].rms


def test_a_model_that_cannot_be_simulated_says_so(tmp_path: Path) -> None:
    problem = _pushed(tmp_path / "rig", '"coulomb", "viscous", "frictional_lag:relaxation"')
    found = simulation_errors(problem, problem.start)
    assert found.free_run == {}
    assert "frictional_lag:relaxation" in found.note


def test_a_record_shorter_than_a_horizon_has_none(tmp_path: Path) -> None:
    problem = _pushed(tmp_path / "rig", '"viscous"')
    text = (tmp_path / "rig" / "experiment.toml").read_text()
    (tmp_path / "rig" / "experiment.toml").write_text(text.replace('role = "fit"', 'role = "fit"\nto = "0.9 s"'))
    found = simulation_errors(load_problem(tmp_path / "rig"), problem.start)
    assert found.horizon["1 s"]["fit"] == {}
    assert found.horizon["0.1 s"]["fit"]["position"].rms < 0.2 * NOISE / STEP * 0.1


def test_the_documents_have_them_and_the_report_shows_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _pushed(tmp_path / "rig", '"viscous"')
    target = tmp_path / "found.json"
    assert run(["compare", str(tmp_path / "rig"), "--out", str(tmp_path / "out"), "--json", str(target)]) == 0
    document = json.loads(target.read_text())
    assert set(document["horizon"]) == {"0.1 s", "1 s"}
    for errors in (document["free_run"], *document["horizon"].values()):
        assert set(errors) == {"fit", "validate"}
        assert errors["fit"]["position"]["rms"]["unit"] == "m"
        assert 99.0 < errors["fit"]["position"]["fit_percent"] <= 100.0
    assert "Error of simulation" in (tmp_path / "out" / "rig" / "report.html").read_text()
    assert "Error of simulation" in capsys.readouterr().err
