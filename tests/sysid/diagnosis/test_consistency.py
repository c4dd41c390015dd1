"""Contradictions in the records, or with a known mass, scale or stiffness, are one line each; others give none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sysid.compare import compare
from sysid.diagnosis.consistency import consistency_warnings, contradicted_known, record_warnings
from sysid.documents import comparison_json
from sysid.estimation.misfit import ChannelMisfit
from sysid.experiment.record import Record
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import replace_in, write_rig
from tests.sysid.slide import NOISE, SIGN, TIME, VELOCITY, slide

FORCE = 1.5 * SIGN


def _with_records(problem: Problem, *channels: dict[str, np.ndarray]) -> Problem:
    """The problem with other logged channels (n,) in its first records; what is prepared stays."""
    changed = [
        replace(record, channels=own, units=dict.fromkeys(own, "SI")) for record, own in zip(problem.records, channels)
    ]
    return replace(problem, records=tuple(changed), fit_records=(), validate_records=())


def _errors(over_noise: float) -> dict[str, ChannelMisfit]:
    return {"friction_force": ChannelMisfit(NOISE, over_noise, 99.0, 2500)}


def test_records_that_repeat_or_fall_below_their_noise_are_warned_of(tmp_path: Path) -> None:
    assert compare(slide(tmp_path, FORCE, "coulomb", held_out=True)).warnings == ()
    problem = slide(tmp_path, FORCE, "coulomb", held_out=True)
    assert consistency_warnings(problem, _errors(1.0)) == []
    (line,) = consistency_warnings(problem, _errors(0.3))
    assert "0.3 of the stated noise" in line
    slide(tmp_path, FORCE, "coulomb", held_out=True)
    (tmp_path / "validate.csv").write_bytes((tmp_path / "fit.csv").read_bytes())
    problem = load_problem(tmp_path)
    (line,) = consistency_warnings(problem, _errors(1.0))
    assert "'validate' contains the same rows as 'fit'" in line
    # Two windows of one file that do not overlap are two records.
    replace_in(tmp_path / "experiment.toml", 'role = "fit"', 'role = "fit"\nto = "1.2 s"')
    replace_in(tmp_path / "experiment.toml", 'role = "validate"', 'role = "validate"\nfrom = "1.21 s"')
    assert consistency_warnings(load_problem(tmp_path), _errors(1.0)) == []
    # So are two runs in columns of their own.
    rows = [line.split(",") for line in (tmp_path / "fit.csv").read_text().splitlines()]
    force = rows[0].index("friction_force [N]")
    cells = ["second force [N]", *(f"{1.01 * float(row[force])!r}" for row in rows[1:])]
    both = "".join(f"{','.join(row)},{cell}\n" for row, cell in zip(rows, cells, strict=True))
    for name in ("fit.csv", "validate.csv"):
        (tmp_path / name).write_text(both)
    replace_in(tmp_path / "experiment.toml", 'role = "fit"\nto = "1.2 s"', 'role = "fit"')
    own = 'channels = {friction_force = "second force [N]"}'
    replace_in(tmp_path / "experiment.toml", 'role = "validate"\nfrom = "1.21 s"', f'role = "validate"\n{own}')
    assert consistency_warnings(load_problem(tmp_path), _errors(1.0)) == []
    problem = slide(tmp_path, FORCE, "coulomb")
    assert problem.records[0].sha256 == problem.records[1].sha256
    assert consistency_warnings(problem, _errors(1.0)) == []
    problem = slide(tmp_path, FORCE, "coulomb", held_out=True)
    record = problem.records[0]
    held = {**record.channels, "friction_force": np.full(record.size, 0.25)}
    (line,) = consistency_warnings(_with_records(problem, held), {})
    assert "'friction_force' is 0.25 SI in every row" in line


@pytest.mark.parametrize(
    "rows,warned",
    [([700], True), ([700, 1500], True), (list(range(700, 720)), False), (list(range(700, 2500, 72)), True)],
)
def test_outliers_by_orders_of_magnitude(tmp_path: Path, rows: list[int], warned: bool) -> None:
    problem = slide(tmp_path, FORCE, "coulomb", held_out=True)
    force = problem.records[0].channels["friction_force"].copy()
    force[rows] = 1e4
    found = consistency_warnings(_with_records(problem, {**problem.records[0].channels, "friction_force": force}), {})
    # Twenty rows in a row are an event, no outlier.
    assert len(found) == int(warned)
    assert not warned or "first 1e+04 SI at 0.7 s" in found[0]


def _record(channels: dict[str, np.ndarray]) -> Record:
    units = dict.fromkeys(channels, "SI")
    return Record("fit", "fit", "fit.csv", TIME, channels, units, False, (), "0", 1e-3, True)


def test_exchanged_columns_are_named(tmp_path: Path) -> None:
    problem = replace(slide(tmp_path, FORCE, "coulomb"), fit_records=(), validate_records=())

    def lines(channels: dict[str, np.ndarray]) -> list[str]:
        return consistency_warnings(replace(problem, records=(_record(channels),)), {})

    one, two = 50.0 + 40.0 * np.sin(20.0 * TIME), 50.0 + 40.0 * np.sin(20.0 * TIME + 1.1)
    voltages = {"voltage_1": one, "voltage_2": two}
    assert lines({**voltages, "tip_x": 1e-8 * (two - one), "tip_y": 1e-8 * (one + two)}) == []
    assert "exchanged" in lines({**voltages, "tip_y": 1e-8 * (two - one), "tip_x": 1e-8 * (one + two)})[0]

    pull, body = 0.01 * TIME, 0.01 * TIME - 1e-4 * np.sin(9.0 * TIME) ** 2
    force = 5000.0 * (pull - body)
    assert lines({"pull_position": pull, "position": body, "spring_force": force}) == []
    assert "exchanged" in lines({"pull_position": body, "position": pull, "spring_force": force})[0]
    assert lines({"position": pull, "normal_load": 2.0 * np.sin(TIME)}) == []
    assert "write sign = {normal_load = -1}" in lines({"position": pull, "normal_load": np.sin(TIME) - 2.0})[0]
    problem = slide(tmp_path, FORCE + 20.0 * VELOCITY, "coulomb", "viscous", held_out=True)
    right = dict(problem.records[0].channels)
    assert consistency_warnings(_with_records(problem, right), {}) == []
    wrong = {**right, "velocity": right["friction_force"], "friction_force": right["velocity"]}
    found = consistency_warnings(_with_records(problem, wrong), {})
    assert any("'position' is the integral of 'friction_force', not of 'velocity'" in line for line in found)
    found = compare(slide(tmp_path / "wrong", -FORCE, "coulomb", held_out=True))
    lines = list(found.warnings)
    assert comparison_json(found)["warnings"] == lines
    assert all("sign opposite to the velocity" in line for line in lines) and len(lines) == 2
    # A spring that is only released, and Stribeck friction in one direction, are no contradictions.
    released = {"velocity": -0.01 * (2.0 + np.sin(9.0 * TIME)), "position": 0.05 - 0.01 * np.cumsum(TIME**0) * 1e-3}
    for force in (200.0 * released["position"], -1.0 - 0.5 * np.exp(released["velocity"] / 0.01)):
        problem = slide(tmp_path / "right", FORCE, "coulomb", held_out=True)
        assert consistency_warnings(_with_records(problem, {**released, "friction_force": force}), {}) == []


@pytest.mark.parametrize(("frequency", "warned"), [(70.0, True), (30.0, True), (20.0, False), (0.7, False)])
def test_a_motion_above_half_the_sampling_rate(tmp_path: Path, frequency: float, warned: bool) -> None:
    """Sampled at 100 Hz; a motion of 70 Hz is recorded as one of 30 Hz."""
    problem = slide(tmp_path, FORCE, "coulomb")
    time = np.arange(2000) * 0.01
    noise = 1e-6 * np.random.default_rng(2).standard_normal(time.size)
    position = 1e-3 * np.sin(2.0 * np.pi * frequency * time) + noise
    record = replace(_record({"position": position, "friction_force": noise}), time=time, step=0.01)
    found = record_warnings(problem.experiment, [record])
    assert len(found) == warned and all("30 Hz; one at 70 Hz would look the same" in line for line in found)


@pytest.mark.parametrize(("rate", "warned"), [(60.0, True), (45.0, True), (400.0, False)])
def test_hum_above_half_the_sampling_rate(tmp_path: Path, rate: float, warned: bool) -> None:
    problem = slide(tmp_path, FORCE, "coulomb")
    time, random = np.arange(int(60 * rate)) / rate, np.random.default_rng(3)
    position = 5e-3 * np.sin(2.0 * np.pi * 0.31 * time)
    force = 0.1 * random.standard_normal(time.size) + 0.3 * np.sin(2.0 * np.pi * 50.03 * time + 1.0)
    record = replace(_record({"position": position, "friction_force": force}), time=time, step=1.0 / rate)
    found = record_warnings(problem.experiment, [record])
    assert len(found) == warned and all("hum of the mains at 50" in line for line in found)


LONG_STEP, LONG_ROWS = 2e-3, 6000
LONG_TIME = LONG_STEP * np.arange(LONG_ROWS)


def _driven_mass(folder: Path, mass: str, scale: float = 1.0, hertz: float = 1.0) -> Path:
    """A mass of 2 kg with Coulomb and viscous friction and a spring that the model lacks."""
    random = np.random.default_rng(4)
    angle = 2.0 * np.pi * hertz * np.outer((0.7, 1.1, 1.9), LONG_TIME) + random.uniform(0.0, 6.0, (3, 1))
    rates = 2.0 * np.pi * hertz * np.array([[0.7], [1.1], [1.9]])
    position = 0.02 * np.sin(angle).sum(axis=0)
    velocity, acceleration = 0.02 * (rates * np.cos(angle)).sum(axis=0), -0.02 * (rates**2 * np.sin(angle)).sum(axis=0)
    force = 2.0 * acceleration + 1.5 * np.sign(velocity) + 4.0 * velocity + 30.0 * position
    position += 1e-6 * random.standard_normal(LONG_ROWS)
    drive = scale * (force + 0.02 * random.standard_normal(LONG_ROWS))
    log = {"time": LONG_TIME, "position": position, "drive_force": drive}
    rig = {"kind": "force-drive", "input_hold": "linear"}
    return write_rig(folder, rig, {"fit": log}, ["coulomb", "viscous"], known={"mass": mass})


@pytest.mark.parametrize("mass", ["2 kg", "2.1 kg", "1.9 +- 0.1 kg"])
def test_a_right_mass(tmp_path: Path, mass: str) -> None:
    assert not contradicted_known(load_problem(_driven_mass(tmp_path, mass)))


@pytest.mark.parametrize(
    ("mass", "scale", "shown"), [("3 kg", 1.0, "2 kg"), ("0.2 kg", 1.0, "2 kg"), ("2 kg", 1.6, "3.2")]
)
def test_a_wrong_mass_or_scale(tmp_path: Path, mass: str, scale: float, shown: str) -> None:
    (line,) = contradicted_known(load_problem(_driven_mass(tmp_path, mass, scale)))
    assert f"the records show {shown}" in line and "the scale of 'drive_force' is" in line


def test_a_drive_that_is_only_noise_shows_no_mass(tmp_path: Path) -> None:
    """A mass that coasts over ripples, with the current of its idle amplifier."""
    random = np.random.default_rng(5)
    position = 6.0 * LONG_TIME - 0.2 * LONG_TIME**2 + 1e-3 * np.sin(40.0 * LONG_TIME)
    log = {"time": LONG_TIME, "position": position + 1e-5 * random.standard_normal(LONG_ROWS)}
    log["drive_force"] = 1e-3 * random.standard_normal(LONG_ROWS)
    folder = write_rig(tmp_path, "force-drive", {"fit": log}, ["coulomb", "viscous"], known={"mass": "2 kg"})
    assert not contradicted_known(load_problem(folder))


def test_a_motion_too_slow_to_show_the_mass(tmp_path: Path) -> None:
    assert not contradicted_known(load_problem(_driven_mass(tmp_path, "3 kg", hertz=0.02)))


@pytest.mark.parametrize(("stated", "wrong"), [("5000 N/m", False), ("50 N/mm", True)])
def test_the_stiffness_of_a_pulling_spring(tmp_path: Path, stated: str, wrong: bool) -> None:
    random = np.random.default_rng(5)
    pull = 0.02 * np.sin(2.0 * np.pi * 0.5 * LONG_TIME)
    stretch = 5e-4 * np.sign(np.cos(2.0 * np.pi * 0.5 * LONG_TIME))
    force = 5000.0 * stretch + 0.1 + 0.02 * random.standard_normal(LONG_ROWS)
    position = pull - stretch + 1e-6 * random.standard_normal(LONG_ROWS)
    log = {"time": LONG_TIME, "pull_position": pull, "position": position, "spring_force": force}
    known = {"mass": "2 kg", "pull_stiffness": stated}
    write_rig(tmp_path, "spring-pull", {"fit": log}, ["coulomb"], known=known)
    found = [line for line in contradicted_known(load_problem(tmp_path)) if "pull_stiffness" in line]
    assert bool(found) == wrong


def test_lost_motion_is_no_other_stiffness(tmp_path: Path) -> None:
    """By a straight line through force and extension the spring is a quarter softer."""
    random, wave = np.random.default_rng(5), np.sin(2.0 * np.pi * 0.5 * LONG_TIME)
    force = 2.0 * wave + 0.02 * random.standard_normal(LONG_ROWS)
    extension = force / 5000.0 + 1e-4 * np.sign(wave)
    log = {"time": LONG_TIME, "pull_position": 0.02 * wave, "spring_force": force}
    log["position"] = log["pull_position"] - extension + 1e-6 * random.standard_normal(LONG_ROWS)
    known = {"mass": "2 kg", "pull_stiffness": "5000 N/m"}
    write_rig(tmp_path, "spring-pull", {"fit": log}, ["coulomb"], known=known)
    assert not [line for line in contradicted_known(load_problem(tmp_path)) if "pull_stiffness" in line]


@pytest.mark.parametrize(("factor", "warned"), [(1.2, False), (4.0, True)])
def test_speeds_beyond_those_of_the_fit(tmp_path: Path, factor: float, warned: bool) -> None:
    speeds, rows = {"fit": VELOCITY, "validate": factor * VELOCITY}, {}
    for name, v in speeds.items():
        force = FORCE + NOISE * np.random.default_rng(5).standard_normal(v.size)
        rows[name] = {"time": TIME, "velocity": v, "friction_force": force}
    found = compare(write_rig(tmp_path, "velocity-drive", rows, ["coulomb"])).warnings
    assert len(found) == warned and all(" 27 mm/s" in line for line in found), found
