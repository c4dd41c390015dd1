"""Degenerate records: without motion, of a few rows, with gaps in time, of different rates or units."""

from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.compare import compare
from sysid.diagnose import diagnose
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import load_problem
from tests.experiments import change_column, replace_in, write_rig
from tests.sysid.slide import NOISE, POSITION, SIGN, STEP, TIME, VELOCITY, slide
from tests.sysid.tip import tip_record, write_tip

FORCE = 1.5 * SIGN + 20.0 * VELOCITY


@pytest.mark.parametrize("column", [1, 2])
def test_record_without_motion_is_refused(tmp_path: Path, column: int) -> None:
    slide(tmp_path, FORCE, "coulomb", "viscous", held_out=True)
    change_column(tmp_path / "fit.csv", column, 0.01 if column == 1 else 0.0)
    with pytest.raises(InputError, match=r"^fit\.csv: nothing moves"):
        load_problem(tmp_path)


def test_records_at_one_speed_are_refused_and_at_several_speeds_are_not(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    noise = [random.normal(0.0, 0.01, (2, TIME.size)) for _ in range(3)]
    runs = {
        f"run{k}": {"time": TIME, "velocity [m/s]": speed + v, "friction_force [N]": 2.0 + 3.0 * speed + force}
        for k, (speed, (v, force)) in enumerate(zip((1.0, 2.0, 3.0), noise, strict=True))
    }
    with pytest.raises(InputError, match=r"one speed only: no change of velocity exceeds its noise; give records at"):
        load_problem(write_rig(tmp_path / "one", "velocity-drive", {"fit": runs["run0"]}, ["coulomb", "viscous"]))
    rig = write_rig(tmp_path / "all", "velocity-drive", {"fit": runs["run0"], "more": runs["run2"]}, ["coulomb"])
    load_problem(rig)


def test_a_force_that_never_changes_is_refused(tmp_path: Path) -> None:
    slide(tmp_path, FORCE, "coulomb", "viscous", held_out=True)
    change_column(tmp_path / "fit.csv", 3, 0.013)
    with pytest.raises(InputError, match=r"^fit\.csv: friction_force never changes; the sensor or the column is wrong"):
        load_problem(tmp_path)


def test_constant_voltages_are_refused_and_gaps_of_time_reported(tmp_path: Path) -> None:
    tip = 1e-6 * np.sin(TIME)
    write_tip(tmp_path, {"fit": tip_record(TIME, np.zeros((2, TIME.size)), (tip, -tip))})
    with pytest.raises(InputError, match=r"^fit\.csv: the voltages never change"):
        load_problem(tmp_path)
    slide(tmp_path, FORCE, "coulomb", held_out=True)
    change_column(tmp_path / "fit.csv", 0, np.where(TIME < 1.0, TIME, TIME + 1e7))
    said = r"^fit\.csv: no row between 0\.999 s and 10000001 s, at a usual step of 0\.001 s"
    with pytest.raises(InputError, match=said):
        load_problem(tmp_path)


def test_levels_and_commands_of_two_values_are_not_quantised(tmp_path: Path) -> None:
    speed = 0.02 * np.sin(2 * np.pi * 6.0 * TIME + 0.5)
    levels = 2.0 * np.sign(speed)
    slide(tmp_path, levels, "coulomb", held_out=True)
    for name in ("fit.csv", "validate.csv"):
        for column, values in ((1, np.cumsum(speed) * STEP), (2, speed), (3, levels)):
            change_column(tmp_path / name, column, values)
    replace_in(tmp_path / "experiment.toml", '[noise]\n"friction_force"', "[noise]\n#")
    found = diagnose(tmp_path)
    assert found.problem.noise["friction_force"].quantisation_step is None
    assert (found.verdict, found.effect) == ("adequate", None)
    force = np.where(np.sin(2 * np.pi * 6.0 * TIME) > 0.0, 2.0, -2.0)
    position = np.cumsum(np.cumsum(force)) * STEP**2
    position -= np.polyval(np.polyfit(TIME, position, 1), TIME)
    log = {"time": TIME, "position": position, "drive_force": force}
    write_rig(tmp_path, "force-drive", {"fit": log}, ["coulomb"], known={"mass": "1 kg"}, noise={"drive_force": 0.01})
    assert load_problem(tmp_path).noise["drive_force"].quantisation_step is None


def test_a_mass_at_its_bound_is_not_simulated(tmp_path: Path) -> None:
    position, velocity = np.sin(6.0 * TIME), 6.0 * np.cos(6.0 * TIME)
    force = 2.0 * np.sign(velocity) + 0.1 * 36.0 * position + np.random.default_rng(5).normal(0.0, 0.01, TIME.size)
    log = {"time": TIME, "position": position, "drive_force": force}
    found = compare(write_rig(tmp_path, "force-drive", {"fit": log}, ["coulomb"], noise={"position": 1e-6}))
    assert "rig.mass" in found.base.fitted.fit.at_bound
    assert found.simulation.note.startswith("rig.mass is at its bound") and not found.simulation.free_run


def test_an_estimated_noise_contains_the_rounding_and_nothing_is_missing(tmp_path: Path) -> None:
    slide(tmp_path, FORCE, "coulomb", "viscous", held_out=True)
    step = 10.0 * NOISE
    for name in ("fit.csv", "validate.csv"):
        change_column(tmp_path / name, 3, lambda force: step * np.round(force / step))
    replace_in(tmp_path / "experiment.toml", '[noise]\n"friction_force"', "[noise]\n#")
    estimated = diagnose(tmp_path)
    assert estimated.verdict == "adequate"
    floor = estimated.problem.noise["friction_force"].value
    assert floor == pytest.approx(np.hypot(NOISE, step / np.sqrt(12.0)), rel=0.15)


@pytest.mark.parametrize("rows", [12, 30, 100])
def test_held_out_record_of_a_few_rows_is_compared(tmp_path: Path, rows: int) -> None:
    slide(tmp_path, FORCE, "coulomb", "viscous", held_out=True)
    change_column(tmp_path / "validate.csv", 1, POSITION, rows)
    found = compare(tmp_path)
    assert found.validate["friction_force"].rms < 0.03
    assert {m.coordinate for m in found.maps} >= {"velocity", "position"}


DAMPING, MASS, FIRST = 40.0, 2.0, 1.5


def _driven(folder: Path, steps: dict[str, float], rows: dict[str, int]) -> None:
    """A mass driven to and fro through a Coulomb force and a drag: the drive force is what its motion needs."""
    records = {}
    w = 2 * np.pi * 0.7
    for name, step in steps.items():
        time = step * np.arange(rows[name])
        position, velocity = -np.cos(w * time) * 5e-3, 5e-3 * w * np.sin(w * time)
        force = MASS * 5e-3 * w * w * np.cos(w * time) + DAMPING * velocity + FIRST * np.sign(velocity)
        noisy = position + 1e-7 * np.random.default_rng(1).standard_normal(time.size)
        records[name] = {"time": time, "drive_force": force, "position": noisy}
    rig, known = {"kind": "force-drive", "input_hold": "linear"}, {"mass": f"{MASS} kg"}
    write_rig(folder, rig, records, ["coulomb", "viscous"], known=known, noise={"position": 1e-7})


def test_records_of_different_rates_share_one_filter(tmp_path) -> None:
    # A filter narrower than the rows of the slow record would pass no acceleration at all.
    _driven(tmp_path, {"fit": STEP, "validate": 32 * STEP}, {"fit": 6000, "validate": 400})
    problem = load_problem(tmp_path)
    widths = {
        r.full_filter.width
        for r in (*problem.fit_records, *problem.validate_records)
        if isinstance(r, ForceBalanceRecord) and r.full_filter is not None
    }
    assert len(widths) == 1 and min(widths) >= 32 * STEP
    found = compare(problem)
    assert found.base.fitted.model.values["viscous.coefficient"] == pytest.approx(DAMPING, rel=0.05)
    assert found.validate["drive_force"].rms < 0.25


@pytest.mark.parametrize("wrong", ["fit.csv", "validate.csv"])
def test_record_with_time_in_another_unit_is_detected(tmp_path: Path, wrong: str) -> None:
    _driven(tmp_path, {"fit": STEP, "validate": STEP}, {"fit": 3000, "validate": 3000})
    change_column(tmp_path / wrong, 0, 1e3 * STEP * np.arange(3000))
    with pytest.raises(InputError, match=r"too short for the filter of .*time is in one unit"):
        load_problem(tmp_path)


def test_a_force_in_every_tenth_row_of_a_driven_mass_is_named(tmp_path: Path) -> None:
    force = np.where(np.arange(TIME.size) % 10 == 0, np.sign(VELOCITY), np.nan)
    columns = {"time": TIME, "position": POSITION, "drive_force": force}
    folder = write_rig(tmp_path, "force-drive", {"log": columns}, ["coulomb"], known={"mass": "1 kg"})
    with pytest.raises(InputError, match=r"no row is left to score .* \(most are in 'drive_force', 90% of its rows\)"):
        load_problem(folder)
