"""Rows whose state is unknown are left out; errors of simulation of true and of wrong models."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.compare import compare
from sysid.estimation.misfit import misfit
from sysid.prediction.model import predict, with_effect
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, load_problem
from sysid.prediction.simulation_error import HORIZONS, simulation_errors
from tests.experiments import replace_in, write_rig
from tests.sysid.slide import slipping_spring
from tests.sysid.tip import tip_record, write_tip

ROWS, STEP, NOISE = 4000, 1e-3, 0.01
TIME = STEP * np.arange(ROWS)
MASS, DRAG, SENSOR_NOISE = 2.0, 15.0, 1e-7
INTERVAL = 1e-3


def _problem(folder: Path, kind: str, columns: Any, known: Any = None, *effects: str) -> Problem:
    """Two records of the same columns."""
    log = {"time": TIME, **columns}
    return load_problem(write_rig(folder, kind, {"fit": log, "validate": log}, effects, known=known))


def _scored(record: PreparedRecord) -> int:
    """First scored row."""
    return int(np.argmax(next(iter(record.valid.values()))))


def _slide(folder: Path, position: np.ndarray) -> Problem:
    force = np.sign(np.gradient(position)) + NOISE * np.random.default_rng(1).standard_normal(ROWS)
    return _problem(folder, "velocity-drive", {"position": position, "friction_force": force})


def test_a_record_is_scored_from_its_first_reversal_within_a_tenth(tmp_path: Path) -> None:
    # Reversals at 0.1 s and every half second after that.
    position = 1e-3 * np.cos(2.0 * np.pi * (TIME - 0.1))
    assert _scored(_slide(tmp_path, position).fit_records[0]) == pytest.approx(100, abs=2)
    position = 1e-3 * np.cos(2.0 * np.pi * (TIME - 3.0) / 8.0)
    assert _scored(_slide(tmp_path, position).fit_records[0]) == ROWS // 10
    position = 1e-2 * TIME + 1e-4 * np.sin(TIME)
    assert _scored(_slide(tmp_path, position).fit_records[0]) == pytest.approx(0.05 * ROWS, abs=0.005 * ROWS)
    drive = np.where(TIME < 0.05, 0.0, 20.0 * np.sin(2.0 * np.pi * (TIME - 0.05) / 0.6))
    moved = 1e-7 * drive + 1e-10 * np.random.default_rng(2).standard_normal(ROWS)
    write_tip(tmp_path, {"fit": tip_record(TIME, (drive, drive), (moved, moved))})
    assert _scored(load_problem(tmp_path).fit_records[0]) == pytest.approx(200, abs=1)


@pytest.mark.parametrize("begin", [-1.0, -0.3, 0.6])
def test_the_state_of_bristles_before_the_first_row_does_not_count(tmp_path: Path, begin: float) -> None:
    """One ideal spring of 40 um, stretched by any part before the first row, on a motion that begins at full speed: the
    prediction, which begins in slip, differs before the first reversal only."""
    level, stretch = 2.0, 4e-5
    position = 3e-4 * np.sin(2.0 * np.pi * (TIME + 0.02) / 0.4)
    force = level * slipping_spring(position, stretch, begin)
    noisy = force + NOISE * np.random.default_rng(3).standard_normal(ROWS)
    problem = _problem(tmp_path, "velocity-drive", {"position": position, "friction_force": noisy})
    model = with_effect(problem.start, find("presliding"), problem.scales)
    model = model.at({"presliding.force": level, "presliding.stretch": stretch, "presliding.curvature": 1.0})
    record = problem.fit_records[0]
    wrong = np.abs(force - predict(record, model.effects, model.values)["friction_force"]) > 5.0 * NOISE
    assert wrong.any() and not wrong[record.settled_rows].any()
    assert misfit(model, problem.fit_records)["friction_force"].rms == pytest.approx(NOISE, rel=0.05)


def _mostly_at_rest(kind: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns of a log that rests in nineteen of twenty rows, and what is known of the rig."""
    rng, t = np.random.default_rng(4), np.clip(TIME - 1.0, 0.0, 0.2)
    position = 1e-3 * np.sin(2.0 * np.pi * t / 0.2) ** 3
    force = np.where((t > 0.0) & (t < 0.2), np.sign(np.gradient(position)), 0.0)
    quiet = {"position": position + 1e-9 * rng.standard_normal(ROWS)}
    if kind == "velocity-drive":
        # An imposed motion leaves the friction of the last motion.
        force = np.where(t >= 0.2, force[t < 0.2][-1], force)
        return {**quiet, "friction_force": force + 1e-3 * rng.standard_normal(ROWS)}, {}
    if kind == "force-drive":
        drive = force + 0.5 * np.gradient(np.gradient(position, STEP), STEP)
        return {**quiet, "drive_force": drive}, {"mass": "0.5 kg"}
    pull = position + force / 1e3
    spring = force + 1e-3 * rng.standard_normal(ROWS)
    known = {"mass": "0.01 kg", "pull_stiffness": "1000 N/m"}
    return {**quiet, "pull_position": pull, "spring_force": spring}, known


@pytest.mark.parametrize("kind", ["velocity-drive", "force-drive", "spring-pull"])
@pytest.mark.parametrize("frozen", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_log_at_rest_in_most_rows_is_evaluated(tmp_path: Path, kind: str, frozen: bool) -> None:
    """Protects fits and errors of records that rest in nineteen of twenty rows, with noise at rest and without."""
    columns, known = _mostly_at_rest(kind)
    if frozen:
        # A logger that repeats its last value at rest: no noise there at all.
        for values in columns.values():
            values[1300:] = values[1300]
            values[:900] = values[0]
    found = compare(_problem(tmp_path, kind, columns, known, "coulomb", "viscous"))
    for part in (found.fit, found.validate):
        assert all(np.isfinite([m.rms, m.over_noise]).all() for m in part.values())
    if not frozen:
        assert found.base.fitted.model.values["coulomb.force"] == pytest.approx(1.0, rel=0.05)


def _pushed(folder: Path, *effects: str) -> Problem:
    """A mass under a force held from row to row and viscous drag alone, exact from row to row."""
    time = INTERVAL * np.arange(6000)
    force = 8.0 * np.sin(2.0 * np.pi * 0.7 * time) + 4.0 * np.sin(2.0 * np.pi * 3.1 * time)
    decay, x, v = np.exp(-DRAG / MASS * INTERVAL), 0.0, 0.0
    position = np.zeros(time.size)
    for k in range(1, time.size):
        end = force[k - 1] / DRAG
        x += end * INTERVAL + (v - end) * (1.0 - decay) * MASS / DRAG
        v = end + (v - end) * decay
        position[k] = x
    noisy = position + SENSOR_NOISE * np.random.default_rng(1).standard_normal(time.size)
    records = {"a": {"time": time, "drive_force": force, "position": noisy}}
    known, start = {"mass": f"{MASS} kg"}, {"viscous.coefficient": f"{DRAG} N*s/m"}
    write_rig(folder, "force-drive", records, effects, known=known, noise={"position": SENSOR_NOISE}, parameters=start)
    return load_problem(folder)


def test_a_true_model_simulates_the_record_and_a_wrong_one_drifts(tmp_path: Path) -> None:
    problem = _pushed(tmp_path / "rig", "viscous")
    true = simulation_errors(problem, problem.start)
    wrong = simulation_errors(problem, problem.start.at({"viscous.coefficient": 1.05 * DRAG}))
    for part in ("fit", "validate"):
        # The velocity at the start is measured, to about SENSOR_NOISE / INTERVAL; the body coasts for MASS / DRAG.
        assert true.free_run[part]["position"].rms < SENSOR_NOISE / INTERVAL * MASS / DRAG
        assert true.free_run[part]["position"].fit_percent > 99.98
        assert wrong.free_run[part]["position"].rms > 100.0 * true.free_run[part]["position"].rms
        short, long = (wrong.horizon[name][part]["position"].rms for name in HORIZONS)
        assert true.horizon["0.1 s"][part]["position"].rms < 0.2 * SENSOR_NOISE / INTERVAL * 0.1
        assert short < 0.2 * long < wrong.free_run[part]["position"].rms


def test_models_that_cannot_be_simulated_and_short_records(tmp_path: Path) -> None:
    problem = _pushed(tmp_path / "rig", "coulomb", "viscous", "frictional_lag:relaxation")
    found = simulation_errors(problem, problem.start)
    assert found.free_run == {} and "frictional_lag:relaxation" in found.note
    problem = _pushed(tmp_path / "rig", "viscous")
    replace_in(tmp_path / "rig" / "experiment.toml", 'role = "fit"', 'role = "fit"\nto = "0.9 s"')
    found = simulation_errors(load_problem(tmp_path / "rig"), problem.start)
    assert found.horizon["1 s"]["fit"] == {}
    assert found.horizon["0.1 s"]["fit"]["position"].rms < 0.2 * SENSOR_NOISE / INTERVAL * 0.1
