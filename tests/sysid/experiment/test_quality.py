"""Clipped, frozen and dropped values are found and left out; signals without such faults are left alone."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.consistency import record_warnings
from sysid.experiment.experiment import load_experiment
from sysid.experiment.quality import BESIDE, begins_anew, faults_of, scale_warnings, without_faults
from sysid.experiment.record import load_records, load_whole_records
from sysid.signals import dilated
from tests.beside import beside
from tests.experiments import replace_in, write_rig

TIME = np.arange(4000) * 1e-3
UNITS = {"position": "m", "friction_force": "N"}


def _channels(noise: float = 0.01, quantum: float = 0.0, seed: int = 1) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    position = 0.05 * np.sin(2 * np.pi * 0.7 * TIME)
    velocity = np.gradient(position, TIME)
    force = 3.0 * np.sign(velocity) + 20.0 * velocity + noise * rng.standard_normal(TIME.size)
    force = np.round(force / quantum) * quantum if quantum else force
    return {"position": position, "friction_force": force}


def _faults(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {fault.kind: fault.rows for fault in faults_of(TIME, channels, UNITS, ["friction_force"])}


@pytest.mark.parametrize("limit", [3.5, 4.5, 7.0])
def test_clipped_values(limit: float) -> None:
    channels = _channels()
    over = np.abs(channels["friction_force"]) > limit
    channels["friction_force"] = np.clip(channels["friction_force"], -limit, limit)
    found = _faults(channels)
    assert set(found) == {"clipped"}
    assert np.mean(found["clipped"][over]) > 0.9 and not np.any(found["clipped"][~dilated(over, BESIDE)])


def test_frozen_values_and_records_of_another_scale_are_named() -> None:
    channels = _channels()
    channels["friction_force"][1000:1200] = channels["friction_force"][1000]
    found = _faults(channels)
    assert set(found) == {"frozen"}
    np.testing.assert_array_equal(np.flatnonzero(found["frozen"]), np.arange(1001, 1200))
    one, other = _channels(), _channels(seed=2)
    other["position"] = 1e3 * other["position"]
    lines = scale_warnings([("fit", one, UNITS), ("validate", other, UNITS)])
    assert len(lines) == 1 and "'position'" in lines[0] and "1e+03 times" in lines[0]
    assert not scale_warnings([("fit", one, UNITS), ("validate", _channels(seed=2), UNITS)])
    for channel, ratio, named in (("friction_force", 4.448, 1), ("position", 25.4, 1), ("position", 10.0, 0)):
        other = _channels(seed=2)
        other[channel] = other[channel] / ratio
        lines = scale_warnings([("fit", one, UNITS), ("validate", other, UNITS)])
        assert len(lines) == named and all(f"'{channel}'" in line for line in lines)


def test_a_time_in_another_unit_is_named(tmp_path: Path) -> None:
    one, other = ({"time": scale * TIME, **_channels(seed=seed)} for seed, scale in ((1, 1.0), (2, 1e3)))
    experiment = load_experiment(write_rig(tmp_path, "velocity-drive", {"fit": one, "validate": other}))
    (line,) = record_warnings(experiment, load_whole_records(experiment))
    assert line.startswith("rows are 1 s apart in 'validate' and 1 ms in 'fit', 1e+03 times")


def test_rows_between_the_samples_of_a_slower_sensor() -> None:
    channels = _channels()
    channels["friction_force"] = np.repeat(channels["friction_force"][3::10], 10)
    np.testing.assert_array_equal(_faults(channels)["held"], np.arange(TIME.size) % 10 != 0)
    ramp = {"position": TIME, "friction_force": np.round(np.abs(500.0 * TIME - 1000.0))}  # steps of one every two rows
    assert not _faults(ramp)


@pytest.mark.parametrize(("value", "rows"), [(0.0, [700]), (-9999.0, [100, 900, 2500, 2502])])
def test_dropped_values(value: float, rows: list[int]) -> None:
    channels = _channels()
    channels["friction_force"][rows] = value
    np.testing.assert_array_equal(np.flatnonzero(_faults(channels)["dropped"]), rows)


@pytest.mark.parametrize("rows", [[700, 701], [100, 101, 102, 900, 2600]])
def test_dropped_values_in_a_row_and_of_an_imposed_position(rows: list[int]) -> None:
    for channel in ("friction_force", "position"):
        channels = _channels()
        channels[channel] = channels[channel] + 0.2 * (channel == "position")
        channels[channel][rows] = 0.0
        np.testing.assert_array_equal(np.flatnonzero(_faults(channels)["dropped"]), rows)


@pytest.mark.parametrize("left", [0.0, 0.2, 1.0])
def test_friction_at_rest_is_left_out_where_the_drive_lets_go(left: float) -> None:
    """Of a force that is kept at rest, the rows are compared with the model."""
    rate = np.where(TIME % 1.0 < 0.5, 0.05 * np.sign(np.sin(np.pi * (TIME + 1e-9))), 0.0)
    before = np.repeat(np.sign(rate[::500]), 500)
    sliding = np.where(rate == 0.0, np.roll(before, 500), before)
    force = 3.0 * np.where(rate == 0.0, left, 1.0) * sliding + 0.01 * np.random.default_rng(1).standard_normal(4000)
    for motion in ({"velocity": rate}, {"position": np.cumsum(rate) * 1e-3}):
        units = {"velocity": "m/s", "position": "m", "friction_force": "N"}
        faults = faults_of(TIME, {**motion, "friction_force": force}, units, ["friction_force"])
        assert [fault.kind for fault in faults] == ["unloaded"] * (left < 0.5)
        for fault in faults:
            np.testing.assert_array_equal(fault.rows, rate == 0.0)
            assert "'friction_force' is released while the axis rests (2000 rows, the first at 0.5 s)" in fault.text


def test_a_friction_that_falls_with_the_velocity_is_kept_at_rest() -> None:
    wave = np.sin(np.pi * TIME)
    rate = 0.1 * (wave - np.clip(wave, -0.5, 0.5))
    side = np.sign(rate)[np.maximum.accumulate(np.where(rate != 0.0, np.arange(TIME.size), 0))]
    channels = {"velocity": rate, "friction_force": 0.5 * side + 60.0 * rate}
    assert not faults_of(TIME, channels, {"velocity": "m/s", "friction_force": "N"}, ["friction_force"])


def test_a_record_that_begins_at_rest_without_force_keeps_its_later_rests() -> None:
    rate = np.where((TIME > 3.0) & (TIME % 0.5 < 0.3), 0.05, 0.0)
    force = np.where(np.maximum.accumulate(rate != 0.0), 3.0, 0.0)
    channels = {"velocity": rate, "friction_force": force + 0.01 * np.random.default_rng(1).standard_normal(TIME.size)}
    assert not faults_of(TIME, channels, {"velocity": "m/s", "friction_force": "N"}, ["friction_force"])


@pytest.mark.parametrize("kind", ["frozen", "clipped"])
def test_a_position_that_stands_while_the_velocity_does_not(kind: str) -> None:
    channels = _channels()
    position = channels["position"] + 1e-6 * np.random.default_rng(3).standard_normal(TIME.size)
    velocity = np.gradient(channels["position"], TIME)
    position = np.minimum(position, 0.03) if kind == "clipped" else np.where(abs(TIME - 1.0) < 0.05, 0.04, position)
    for logged, kinds in ((velocity, {kind}), (np.zeros(TIME.size), set())):
        values = {"position": position, "velocity": logged}
        faults = faults_of(TIME, values, {"position": "m", "velocity": "m/s"}, ["position"])
        assert {fault.kind for fault in faults} == kinds


QUIET = {
    "turn of a sensor of coarse steps": {
        "position": np.sin(40.0 * TIME),
        "friction_force": np.round(700.0 * np.cos(4.4 * TIME) + 0.1 * np.sin(TIME * 9e4)),
    },
    "binary noise": _channels() | {"position": np.sign(np.sin(0.7 + np.cumsum(np.arange(4000.0) ** 1.3)))},
    "noise": _channels(),
    "no noise": _channels(0.0),
    "coarse counts": _channels(0.01, 0.2),
    "fine counts": _channels(0.05, 0.01),
    "plain Coulomb friction": _channels(0.0) | {"friction_force": np.sign(np.cos(4.4 * TIME))},
    "coarse steps that are printed with more digits": _channels(0.05, 0.2)
    | {
        "friction_force": np.round(0.471 * np.round(20.0 * np.cos(4.4 * TIME) + 0.2 * np.sin(9e4 * TIME)) + 4e-6, 5)
        + 1e-5 * (np.arange(4000) % 3)
    },
    "rests": _channels() | {"position": np.clip(0.05 * np.sin(4.4 * TIME), -0.03, 0.03)},
}


@pytest.mark.parametrize("name", QUIET)
def test_records_without_faults(name: str) -> None:
    assert not _faults(QUIET[name])


def test_rows_of_a_fault_are_gaps_and_what_is_kept_has_no_bias() -> None:
    channels = _channels()
    channels["friction_force"][700] = 0.0
    faults = faults_of(TIME, channels, UNITS, ["friction_force"])
    kept = without_faults(channels, faults)
    assert np.flatnonzero(np.isnan(kept["friction_force"])).tolist() == [700]
    said = "'friction_force' drops to 0 N for single rows (1 row, the first at 0.7 s); this row is left out"
    assert faults[0].text == said
    # Coulomb and viscous friction of the rows that are left, in standard deviations of the least-squares fit.
    errors = []
    for seed in range(40):
        channels = _channels(0.1, seed=seed)
        velocity = np.gradient(channels["position"], TIME)
        channels["friction_force"] = np.clip(channels["friction_force"], -5.5, 5.5)
        kept = without_faults(channels, faults_of(TIME, channels, UNITS, ["friction_force"]))["friction_force"]
        rows = np.isfinite(kept)
        columns = np.column_stack([np.sign(velocity), velocity])[rows]
        found = np.linalg.lstsq(columns, kept[rows], rcond=None)[0]
        errors.append((found - [3.0, 20.0]) / (0.1 * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))))
    assert np.all(np.abs(np.mean(errors, axis=0)) < 3.0 / np.sqrt(40.0))


def test_the_parts_of_a_record_have_one_warning_of_a_fault(tmp_path: Path) -> None:
    channels = _channels()
    channels["friction_force"][[700, -300]] = 0.0
    experiment = load_experiment(
        write_rig(tmp_path, "velocity-drive", {"log": {"time": TIME, **channels}}, ["coulomb"])
    )
    fit, held_out = load_records(experiment)
    assert fit.faults and held_out.faults
    (warning,) = [line for line in record_warnings(experiment, [fit, held_out]) if "drops to" in line]
    assert warning.startswith("log: ") and "2 rows" in warning


REPORTED = {
    "force_sensor_clips": "'friction_force' is clipped at -4.5 N and 4.5 N",
    "records_of_other_scale": "'position' ranges over 163 m in 'fit' and 211 mm in 'validate', 774 times",
    "time_stamps_rounded_60hz": "",
    "break_slow_sampling": "",
}


@pytest.mark.parametrize("name", REPORTED)
def test_what_is_wrong_in_reported_records(name: str) -> None:
    experiment = load_experiment(beside("failing", name))
    records = load_whole_records(experiment)
    found = record_warnings(experiment, records)
    assert any(REPORTED[name] in line for line in found) if REPORTED[name] else not found
    if name == "time_stamps_rounded_60hz":
        assert all(abs(60.0 * record.step - 1.0) < 1e-8 for record in records)


def test_a_counter_that_begins_anew_is_seen_and_a_motion_is_not() -> None:
    time, turn = 0.01 * np.arange(400), 2.0 * np.pi
    for angle in (3.0 * time, 10.0 * np.sin(time), 1.0 - 4.0 * time):
        rows, period = begins_anew(np.mod(angle, turn))
        np.testing.assert_array_equal(rows, np.flatnonzero(np.diff(np.floor(angle / turn))) + 1)
        assert rows.size and period == pytest.approx(turn, rel=0.01)
        assert not begins_anew(angle)[0].size
    noise = np.random.default_rng(3).standard_normal((20, 400))
    assert not any(begins_anew(one)[0].size for one in [*noise, np.sign(np.sin(5.0 * time)), np.full(400, np.nan)])


def test_an_angle_is_continued_by_its_period(tmp_path: Path) -> None:
    time = 0.01 * np.arange(300)
    angle = np.degrees(8.0 * np.sin(2.0 * time))
    columns = {"time [s]": time, "angle [deg]": np.mod(angle, 360.0), "torque [N*m]": np.sign(np.cos(2.0 * time))}
    columns["angle [deg]"][20] = np.nan
    channels = '[channels]\nfriction_force = "torque"\nposition = {column = "angle"}\n'
    write_rig(tmp_path, "velocity-drive", {"fit": columns}, rest=channels)
    wrapped = load_whole_records(load_experiment(tmp_path))[0]
    warned = scale_warnings([("fit", wrapped.channels, wrapped.units)])
    assert len(warned) == 1 and "begins anew after 6.28 rad" in warned[0]
    replace_in(tmp_path / "experiment.toml", '"angle"}', '"angle", period = 360}')
    whole = load_whole_records(load_experiment(tmp_path))[0]
    assert np.isnan(whole.channels["position"][20]) and scale_warnings([("fit", whole.channels, whole.units)]) == []
    found = np.delete(whole.channels["position"], 20)
    np.testing.assert_allclose(found, np.delete(np.radians(angle), 20), atol=1e-7)
