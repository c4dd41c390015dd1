"""Records as arrays: formats, units, signs, windows, gaps, rates, times of rows, and what is held out."""

from pathlib import Path

import numpy as np
import pytest

from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import Record, load_records
from sysid.experiment.time_stamps import sampled_times, stamp_rounding
from tests.experiments import record_text, state, write_rows
from tests.process_state import python

T = np.arange(100) * 0.005
X = 0.01 * np.sin(7.0 * T)
F = 2.0 * np.sign(np.cos(7.0 * T)) + 0.1 * T


def _load(folder: Path, *settings: str, file: str = "fit.csv", rest: str = "") -> list[Record]:
    return load_records(load_experiment(state(folder, record_text(file, *settings) + rest)))


def _csv(folder: Path, header: str, *columns: np.ndarray) -> None:
    write_rows(folder / "fit.csv", header, *columns)


def _whole(records: list[Record], channel: str) -> np.ndarray:
    return np.concatenate([record.channels[channel] for record in records])


def test_units_become_si_and_other_names_are_taken(tmp_path):
    _csv(tmp_path, "time [ms],velocity [mm/s],position [um],friction_force [mN],temperature [K]",
         1e3 * T, 1e3 * X, 1e6 * X, 1e3 * F, 293.15 + T)  # fmt: skip
    records = _load(tmp_path, "sign = {friction_force = -1}")
    assert np.allclose(np.concatenate([record.time for record in records]), T)
    assert np.allclose(_whole(records, "velocity"), X) and np.allclose(_whole(records, "position"), X)
    assert np.allclose(_whole(records, "friction_force"), -F)
    assert np.allclose(_whole(records, "temperature"), 20.0 + T) and records[0].units["friction_force"] == "N"
    assert records[0].step == pytest.approx(0.005) and records[0].uniform
    _csv(tmp_path, "time [s],x,force [kg],velocity [m/s],spare [m],force [kg]", T, 1e3 * X, F, X, X, X)
    columns = 'columns = {friction_force = "force", position = "x"}'
    record = _load(tmp_path, columns, 'units = {friction_force = "N", position = "mm"}')[0]
    assert np.allclose(record.channels["position"], X[: record.size])
    assert np.allclose(record.channels["friction_force"], F[: record.size])
    text = "\n".join(record.notes)
    assert "column 'force' is given 2 times" in text and "columns 'spare [m]', 'force [kg]' are not known" in text


def test_columns_that_are_not_used_are_one_note_each_kind(tmp_path):
    spare = [f"q.{k}" for k in range(10)]
    labels = ",".join(["time [s]", "velocity [m/s]", "friction_force [N]", "drive_force [N]", *spare])
    _csv(tmp_path, labels, T, X, F, F, *([X] * len(spare)))
    notes = [note for note in _load(tmp_path)[0].notes if note.endswith("left out")]
    assert notes == [
        "column 'drive_force [N]' is not used by this kind of rig; left out",
        "columns 'q.0', 'q.1', 'q.2', 'q.3', 'q.4', 'q.5' and 4 more are not known; left out",
    ]


def test_the_last_thirty_percent_in_time_is_held_out_and_said(tmp_path):
    time = np.concatenate([T[:50], 0.25 + 0.05 * np.arange(50)])
    _csv(tmp_path, "time [s],position [m],friction_force [N]", time, X, F)
    fit, held = _load(tmp_path)
    cut = time[0] + 0.7 * (time[-1] - time[0])
    assert (fit.role, held.role) == ("fit", "validate")
    assert fit.time[-1] <= cut < held.time[0] and fit.size + held.size == 100
    assert held.continues == fit.name and any("last 30% in time" in note for note in held.notes) and not fit.uniform


def test_gaps_stay_gaps_and_quoted_cells_do_not_hurt(tmp_path):
    gaps = F.copy()
    gaps[[3, 4, 70]] = np.nan
    _csv(tmp_path, "time [s],position [m],friction_force [N],temperature [degC]", T, X, gaps, np.full(100, np.nan))
    text = (tmp_path / "fit.csv").read_text().replace(",,\n", ", NaN ,\n", 1)
    (tmp_path / "fit.csv").write_text("\ufeff" + text.replace("\n", "\r\n"), encoding="utf-8", newline="")
    records = _load(tmp_path)
    assert np.allclose(_whole(records, "friction_force"), gaps, equal_nan=True)
    assert "temperature" not in records[0].channels
    notes = "\n".join(records[0].notes)
    assert "has 3 gaps in 100 rows" in notes and "'temperature [degC]' contains no numbers" in notes
    lines = [f'"{t!r}", {x!r} ,"wait, what",{f!r}' for t, x, f in zip(T.tolist(), X.tolist(), F.tolist())]
    (tmp_path / "fit.csv").write_text("time [s],position [m],remark,friction_force [N]\n" + "\n".join(lines))
    records = _load(tmp_path)
    assert np.allclose(_whole(records, "friction_force"), F) and np.allclose(_whole(records, "position"), X)


def test_reading_loads_no_pandas(tmp_path):
    _csv(tmp_path, "time [s],position [m],friction_force [N]", T, X, F)
    _load(tmp_path)
    code = (
        "import sys; from sysid.experiment.experiment import load_experiment\n"
        "from sysid.experiment.record import load_records\n"
        "load_records(load_experiment(sys.argv[1]))\n"
        "print([m for m in ('pandas', 'scipy.io', 'pydantic', 'tomlkit', 'numba') if m in sys.modules])"
    )
    assert python("-c", code, tmp_path).stdout.strip() == "[]"


@pytest.mark.parametrize("rate", [10.0, 30.0, 60.0, 70.0, 333.0, 1000.0, 10_000.0])
@pytest.mark.parametrize("digits", [6, 4, 3, 2])
def test_rows_sampled_evenly_are_even_whatever_the_rounding(rate: float, digits: int) -> None:
    time = np.arange(3000) / rate
    printed, notes = np.round(time, digits), []
    rounding = stamp_rounding(printed)
    found = sampled_times(printed, rounding, notes)
    # Stamps that are all equal to their neighbours are treated before, as repeated times.
    assert np.max(np.abs(np.diff(found) * rate - 1.0)) < 1e-3
    if 0.0 < rounding < 0.5 / rate:
        # The slope over 3000 rows has the error of the rounding over 3000^1.5.
        assert np.max(np.abs(np.diff(found) * rate - 1.0)) < 1e-9 + 10.0 * rounding * rate / 3000.0**1.5
    assert found[0] == printed[0]
    assert bool(notes) == (rounding > 0.01 / rate and np.max(np.abs(printed - time)) > 1e-4 * rounding)


STAMPS = {
    "minutes": lambda t: (60.0 * np.round(t / 60.0, 5), 60.0, 0.0),
    "hours": lambda t: (3600.0 * np.round(t / 3600.0, 6), 3600.0, 0.0),
    "days": lambda t: (86400.0 * (np.round(45000.5 + t / 86400.0, 8) - 45000.5), 86400.0, 86400.0 * 45000.5),
    "milliseconds": lambda t: (1e-3 * np.round(1e3 * t), 1e-3, 0.0),
    "single precision": lambda t: (np.float64(np.float32(5000.0 + t)) - 5000.0, 1.0, 5000.0),
    "single precision, nine digits": lambda t: (np.round(np.float64(np.float32(5000.0 + t)), 5), 1.0, 0.0),
    "single precision, a digit lost": lambda t: (
        np.array([float(f"{x:.9g}") for x in np.float32(9990.0 + t)]),
        1.0,
        0.0,
    ),
    "single precision, milliseconds": lambda t: (1e-3 * np.round(np.float64(np.float32(8e6 + 1e3 * t)), 2), 1e-3, 0.0),
}
"""Stamps of times (n,), s, with the unit of their column and their origin."""


@pytest.mark.parametrize("name", STAMPS)
def test_stamps_rounded_in_another_unit_are_even(name: str) -> None:
    printed, unit, origin = STAMPS[name](np.arange(2000) / 60.0)
    found = sampled_times(printed, stamp_rounding(printed, unit, origin), notes := [])
    assert np.max(np.abs(60.0 * np.diff(found) - 1.0)) < 1e-5 and "rounded" in notes[0]


def test_missing_rows_and_uneven_stamps_are_kept() -> None:
    time = np.delete(np.arange(500) / 60.0, [100, 101, 250])
    found = sampled_times(np.round(time, 6), 1e-6, [])
    assert np.abs(found - time).max() < 1e-6 and np.allclose(np.diff(found)[[99, 247]] * 60.0, [3.0, 2.0])
    time = np.cumsum(np.random.default_rng(1).uniform(0.8e-3, 1.2e-3, 500))
    assert np.array_equal(sampled_times(np.round(time, 6), 1e-6, []), np.round(time, 6))
