"""Columns of channels: `[channels]` for all records, units of instruments, scales, sums, windows, repeated times."""

from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.column_settings import column_unit
from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import Record, load_records
from tests.experiments import record_text, state, write_rows
from tests.reference.tables import cases
from tests.refusals import refused

ROWS = 60
TIME = 0.01 * np.arange(ROWS)
ANGLE = np.sin(10.0 * TIME)
CURRENT = 0.5 * np.cos(10.0 * TIME)
TURN = 2.0 * np.pi
SUMMED = 'position = {{pitch = "1 um"}}\ntime = {{column = "{}", unit = "s", increments = true}}'
COAST = 'drive_force = {value = "0 N*m"}\n'


def _write(folder: Path, name: str, labels: str, *columns: np.ndarray) -> None:
    write_rows(folder / name, labels, *columns)


def _load(folder: Path, rest: str, kind: str = "velocity-drive") -> list[Record]:
    return load_records(load_experiment(state(folder, rest, kind)))


DRIVEN = "force-drive"
ONE = record_text("a.csv")
BOTH = ONE + record_text("b.csv", role="validate")
MOTOR = '[channels]\ntime = "t"\nposition = {column = "angle", unit = "deg"}\n'
MOTOR += 'drive_force = {column = 3, unit = "mA", scale = "0.113 N*m/A", sign = -1}\n'


def test_channels_hold_for_all_records_and_a_record_overrides_what_it_names(tmp_path):
    for name in ("a.csv", "b.csv"):
        _write(tmp_path, name, "t [s],angle,current", TIME, np.degrees(ANGLE), 1e3 * CURRENT)
    for record in _load(tmp_path, MOTOR + BOTH, DRIVEN):
        assert record.rotary and record.units == {"position": "rad", "drive_force": "N*m"}
        assert np.allclose(record.channels["position"], ANGLE)
        assert np.allclose(record.channels["drive_force"], -0.113 * CURRENT)
    _write(tmp_path, "a.csv", "t [s],angle,current", TIME, np.degrees(ANGLE), 1e3 * CURRENT)
    _write(tmp_path, "b.csv", "t [s],angle,spare,i", TIME, ANGLE, TIME, CURRENT)
    own = 'channels = {position = {unit = "rad"}, drive_force = {column = "i", unit = "A"}}\nsign = {drive_force = 1}\n'
    record = _load(tmp_path, MOTOR + BOTH + own, DRIVEN)[1]
    assert np.allclose(record.channels["position"], ANGLE)
    assert np.allclose(record.channels["drive_force"], 0.113 * CURRENT)
    old = 'columns = {drive_force = "i"}\nunits = {position = "rad", drive_force = "A"}\n'
    assert np.allclose(_load(tmp_path, MOTOR + BOTH + old, DRIVEN)[1].channels["drive_force"], -0.113 * CURRENT)


def test_percent_of_rated_values_and_uncertainties_of_scales(tmp_path):
    for name in ("a.csv", "b.csv"):
        _write(tmp_path, name, "time [s],position [rad],drive_force [%]", TIME, ANGLE, 100.0 * CURRENT / 2.4)
    known = '[rig.known]\nrated_drive_force = "2.4 N*m"\n'
    for record in _load(tmp_path, known + BOTH, DRIVEN):
        assert record.units["drive_force"] == "N*m" and np.allclose(record.channels["drive_force"], CURRENT)
    refused(r"is in percent; state its rated value .*rated_drive_force = ", _load, tmp_path, BOTH, DRIVEN)
    _write(tmp_path, "a.csv", "time [s],position [rad],current [A]", TIME, ANGLE, CURRENT)
    for scale, deviation in (("0.113 +- 0.002 N*m/A", 0.002 / 0.113), ("fit N*m/A", np.inf), ("0.113 N*m/A", 0.0)):
        _load(tmp_path, f'[channels]\ndrive_force = {{column = "current", scale = "{scale}"}}\n{ONE}', DRIVEN)
        (term,) = load_experiment(tmp_path).records[0].sources["drive_force"].terms
        assert term.deviation == pytest.approx(deviation)


def test_names_in_other_letters_and_jitter_are_reported(tmp_path):
    _write(tmp_path, "a.csv", "Time (ms),Position_mm,Friction-Force (N),VELOCITY_mm_per_s",
           1e3 * TIME, 1e3 * ANGLE, CURRENT, 1e3 * ANGLE)  # fmt: skip
    record = _load(tmp_path, ONE)[0]
    assert np.allclose(record.time, TIME[: record.size])
    assert np.allclose(record.channels["position"], ANGLE[: record.size])
    assert np.allclose(record.channels["velocity"], ANGLE[: record.size])
    assert "column 'Position_mm' is taken as 'position'" in record.notes
    time = TIME + 2e-3 * np.sin(np.arange(ROWS))
    _write(tmp_path, "a.csv", "time [s],position [m],friction_force [N]", time, ANGLE, CURRENT)
    notes = _load(tmp_path, ONE)[0].notes
    assert any(note.startswith("rows are unevenly spaced in time: 8.09 ms to 11.9 ms (99 %), median") for note in notes)


def test_a_window_may_be_relative_to_the_first_row(tmp_path):
    _write(tmp_path, "a.csv", "time [s],position [m],friction_force [N]", 12.0 + TIME, ANGLE, CURRENT)
    _write(tmp_path, "b.csv", "time [s],position [m],friction_force [N]", 1554239502.0 + TIME, ANGLE, CURRENT)
    early = record_text("a.csv", 'from = "+100 ms"', 'to = "12.305 s"')
    late = record_text("b.csv", 'from = "1554239502.095 s"', 'to = "+0.305 s"', role="validate")
    first, second = _load(tmp_path, early + late)
    assert first.time[0] == pytest.approx(12.1) and first.time[-1] == pytest.approx(12.3)
    assert second.time[0] == pytest.approx(0.1) and second.time[-1] == pytest.approx(0.3)
    with pytest.raises(InputError, match=r"runs from 0 s to 0.59 s, counted from its first row"):
        _load(tmp_path, record_text("b.csv", 'from = "+9 s"'))


def test_repeated_times_need_a_setting_unless_the_rows_are_the_same(tmp_path):
    time = np.repeat(np.round(TIME[::3], 2), 3)
    _write(tmp_path, "a.csv", "time [s],position [m],friction_force [N]", time, ANGLE, CURRENT)
    refused(r'row 3, .* \[format\] repeated_time = "first", "mean" or "spread"', _load, tmp_path, ONE)

    def position(setting: str) -> tuple[np.ndarray, np.ndarray]:
        parts = _load(tmp_path, f'[format]\nrepeated_time = "{setting}"\n{ONE}')
        return np.concatenate([p.time for p in parts]), np.concatenate([p.channels["position"] for p in parts])

    for setting, expected in (("first", ANGLE[::3]), ("mean", ANGLE.reshape(-1, 3).mean(axis=1))):
        found = position(setting)
        assert np.allclose(found[0], TIME[::3]) and np.allclose(found[1], expected)
    found = position("spread")
    assert np.allclose(found[0], TIME) and np.allclose(found[1], ANGLE)
    twice = [np.repeat(values, 2) for values in (TIME, ANGLE, CURRENT)]
    _write(tmp_path, "a.csv", "time [s],position [m],friction_force [N]", *twice)
    records = _load(tmp_path, ONE)
    assert sum(r.size for r in records) == ROWS
    assert "60 rows with the time of the row before and the same values left out" in records[0].notes


def test_intervals_between_pulses_give_time_and_angle(tmp_path):
    """One column without a header, as a counter writes it; drive torque zero, since the wheel coasts."""
    # A wheel that slows down, angle 12 t - 0.4 t^2, has turned by whole thirds of a turn.
    instants = (12.0 - np.sqrt(144.0 - 1.6 * TURN / 3.0 * np.arange(41))) / 0.8
    (tmp_path / "a.csv").write_text("\n".join(repr(float(step)) for step in np.diff(instants)) + "\n")
    channels = '[channels]\ntime = {column = 1, unit = "s", increments = true}\n' + COAST
    both = record_text("a.csv", 'from = "1 s"') + record_text("a.csv", role="validate")
    for position in ("pulses_per_turn = 3", 'pitch = "120 deg"'):
        cut, record = _load(tmp_path, f"{channels}position = {{{position}, sign = -1}}\n{both}", DRIVEN)
        assert record.rotary and record.units == {"position": "rad", "drive_force": "N*m"}
        np.testing.assert_allclose(record.time, instants[1:] - instants[0], rtol=1e-13)
        angle = 12.0 * record.time - 0.4 * record.time**2
        np.testing.assert_allclose(record.channels["position"], -angle, rtol=1e-12)
        assert not record.channels["drive_force"].any()
        assert cut.time[0] == record.time[np.searchsorted(record.time, 1.0)]
        assert cut.channels["position"][0] == record.channels["position"][record.size - cut.size]
        assert "'time' is the sum of the increments in column 'column 1'" in record.notes


def test_increments_of_a_scale_and_times_of_pulses(tmp_path):
    """A logger that clears its counter in each row; and a scale with a line each 20 um, whose instants are logged."""
    counts = np.round(1e4 * np.diff(ANGLE, prepend=0.0))
    _write(tmp_path, "a.csv", "time [ms],count,friction_force [N]", 1e3 * TIME, counts, CURRENT)
    channels = '[channels]\nposition = {column = "count", scale = "0.5 um", increments = true}\n'
    record = _load(tmp_path, channels + ONE)[0]
    assert np.allclose(record.channels["position"], 0.5e-6 * np.cumsum(counts)[: record.size], atol=1e-15)
    record = _load(tmp_path, '[channels]\nposition = {pitch = "20 um"}\n' + ONE)[0]
    assert np.allclose(record.channels["position"], 2e-5 * np.arange(1, record.size + 1))
    assert "'position' moves by 20 um from row to row" in record.notes


@pytest.mark.parametrize(
    "channels, message",
    [
        *cases("mistakes", "channels"),
        (SUMMED.format("count"), "row 4, column 'count': is empty; 'time' is the sum"),
        (SUMMED.format("back"), "row 5, column 'back': time .* falls below the row"),
    ],
)
def test_a_wrong_pulse_or_interval_is_one_line(tmp_path, channels, message):
    count, back = np.full(ROWS, 0.01), np.full(ROWS, 0.01)
    count[2], back[3] = np.nan, -0.01
    _write(tmp_path, "a.csv", "time [s],count,back,friction_force [N]", TIME, count, back, CURRENT)
    with pytest.raises(InputError, match=message) as caught:
        _load(tmp_path, f"[channels]\n{channels}\n{ONE}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "written, unit",
    [("Nm", "N*m"), ("mNm", "mN*m"), ("sec", "s"), ("m/s2", "m/s^2"), ("m/s²", "m/s²"), ("U/min", "rpm"),
     ("counts", "count"), ("degrees", "deg"), ("N m", "N*m"), ("kg.m2", "kg*m^2"), ("°", "°"), ("rad/sec", "rad/s"),
     ("bar", "bar"), ("zone", None), ("", None), ("Nx", None)],
)  # fmt: skip
def test_units_as_instruments_write_them(written, unit):
    assert column_unit(written) == unit
