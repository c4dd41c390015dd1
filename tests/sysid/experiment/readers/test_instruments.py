"""Files of instruments and loggers give the record, from the proposal of an experiment on, or a line that says why."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import Record, load_whole_records
from sysid.experiment.time_stamps import counter_range
from tests.refusals import refused
from workbench.operations.measurement.new_experiment import experiment_text, inspect

ROWS = 60
TIME = 0.01 * np.arange(ROWS)
POSITION = np.round(1e-3 * np.sin(20.0 * TIME), 7)
FORCE = np.round(2.0 * np.sign(np.cos(20.0 * TIME)) + 0.123 * TIME, 6)


def _rows(first: int = 0, last: int = ROWS, line: str = "{t:.2f}\t{x:.4f}\t{f:.6f}") -> str:
    cells = zip(range(first, last), TIME[first:last], 1e3 * POSITION[first:last], FORCE[first:last])
    return "".join(line.format(k=k, t=t, x=x, f=f) + "\n" for k, t, x, f in cells)


def _segment(first: int, last: int, line: str) -> str:
    """A segment of a measurement file of LabVIEW with its head."""
    return (
        "Channels\t2\t\t\nSamples\t30\t30\t\nDate\t2024/03/01\t2024/03/01\t\nTime\t10:11:12.12\t10:11:12.12\t\n"
        "Y_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.01\t0.01\t\n"
        f"***End_of_Header***\t\t\t\nX_Value\tPosition\tForce\tComment\n{_rows(first, last, line)}"
    )


LABVIEW = "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2024/03/01\n***End_of_Header***\t\n\t\n"
SI_PREFIX = [f"{1e3 * x:.4f} mm" if abs(x) > 5e-4 else f"{1e6 * x:.1f} µm" for x in POSITION]
TABLE = "{t:.2f},{x:.4f},{f:.6f}"
READ = {
    "LabVIEW, segments": LABVIEW + "\n".join(_segment(k, k + 30, "{t:.2f}\t{x:.4f}\t{f:.6f}\t") for k in (0, 30)),
    "one name, several units": "Time,Value,Value\ns,mm,N\n" + _rows(line=TABLE),
    "a unit below no name": "Sampling period:;10.0\n;Position actual value;Force actual value\nms;mm;N\n"
    + _rows(line="{k}0.000;{x:.4f};{f:.6f}"),
    "prefix of the unit by number": "time,position,force\n"
    + "".join(f"{t:.2f} s,{x},{f:.6f} N\n" for t, x, f in zip(TIME, SI_PREFIX, FORCE)),
    "torque of an axis 'Pos'": "t [s];PosAxis.ActualPosition [mm];PosAxis.ActualForce [N]\n"
    + _rows(line=TABLE.replace(",", ";")),
    "ticks of 32 bits": "tick_us,position_mm,force_N\n"
    + "".join(f"{(2**32 - 300_000 + 10_000 * k) % 2**32},{_rows(k, k + 1, '{x:.4f},{f:.6f}')}" for k in range(ROWS)),
    "seconds and nanoseconds of ROS": "header.stamp.secs,header.stamp.nsecs,position_mm,force_N\n"
    + "".join(f"{1709287872 + k // 100},{k % 100}{_rows(k, k + 1, '0000000,{x:.4f},{f:.6f}')}" for k in range(ROWS)),
}


def _experiment(folder: Path, file: str, edit: Callable[[str], str] = lambda text: text) -> list[Record]:
    """The records of the experiment that is proposed for a file, its questions answered by `edit`."""
    opened, proposal = inspect([folder / file], None)
    (folder / "experiment.toml").write_text(edit(experiment_text(folder, opened, proposal)))
    return load_whole_records(load_experiment(folder))


def _check(record: Record) -> None:
    np.testing.assert_allclose(record.time - record.time[0], TIME, atol=1e-6)
    np.testing.assert_allclose(record.channels["position"], POSITION, atol=1e-7)
    np.testing.assert_allclose(record.channels["friction_force"], FORCE, atol=1e-6)


@pytest.mark.parametrize("name", READ)
def test_a_file_of_an_instrument_is_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "log.lvm").write_text(READ[name])
    (record,) = _experiment(tmp_path, "log.lvm")
    _check(record)


TWINCAT = (
    "Name\tscope\nStarttime of export\t132959733843760000\tMonday\n\n"
    "Name\tAxis.ActPos\tAxis.ActForce\nSymbolComment\t\t\nData-Type\tREAL64\tREAL64\nSampleTime[ms]\t10\t10\n"
    "SymbolName\tMAIN.x\tMAIN.f\nPort\t851\t851\nScaleFactor\t1\t1\nBitMask\t0xff\t0xff\n"
    "Unit\tmm (Position)\tN (Force)\nUnit ScaleFactor\t1\t1\nUnit Offset\t0\t0\n\n"
)


@pytest.mark.parametrize("unit", ["N (Force)", "(None)"])
def test_the_words_in_front_of_the_rows_of_a_head_are_its_keys(tmp_path: Path, unit: str) -> None:
    (tmp_path / "log.csv").write_text(TWINCAT.replace("N (Force)", unit) + _rows(line="{k}0\t{x:.4f}\t{f:.6f}"))
    answers = {
        '"Name", unit = "?"': '"Name", unit = "ms"',
        '"Axis.ActForce", unit = "?"': '"Axis.ActForce", unit = "N"',
    }

    def answered(text: str) -> str:
        for question, answer in answers.items():
            text = text.replace(question, answer)
        return text

    (record,) = _experiment(tmp_path, "log.csv", answered)
    _check(record)


def test_labview_without_a_time_needs_a_rate(tmp_path: Path) -> None:
    line, runs = "\t{x:.4f}\t{f:.6f}\t", 5
    (tmp_path / "log.lvm").write_text(LABVIEW + _segment(0, ROWS, line) + (runs - 1) * _rows(line=line))
    refused(r"no column 'time', .* without one: .format. sample_rate", _experiment, tmp_path, "log.lvm")
    rate = '[format]\nsample_rate = "100 Hz"\n[model]'
    (record,) = _experiment(tmp_path, "log.lvm", lambda text: text.replace("[model]", rate, 1))
    np.testing.assert_allclose(record.channels["friction_force"], np.tile(FORCE, runs), atol=1e-6)
    np.testing.assert_allclose(record.time, 0.01 * np.arange(runs * ROWS), atol=1e-9)


def test_a_counter_begins_anew_only_where_the_step_over_its_end_is_usual() -> None:
    ticks = np.array([65516.0, 65526.0, 0.0, 10.0])
    assert counter_range(ticks) == 2.0**16
    # A second run, steps that are no ticks, and a longer step.
    for other in ([0.0, 10.0, 20.0, 0.0, 10.0], ticks + 0.5, [65516.0, 65526.0, 20.0, 30.0]):
        assert counter_range(np.array(other)) == 0.0


def test_a_torque_on_a_sliding_axis_is_asked_its_scale(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time [s],position [mm],torque [Nm]\n" + _rows(line=TABLE))
    refused(r"friction_force.scale: '\? 1/m' is still a question", _experiment, tmp_path, "log.csv")
    (record,) = _experiment(tmp_path, "log.csv", lambda text: text.replace("? 1/m", "1 1/m"))
    _check(record)


def test_channels_in_rows_of_their_own_are_one_line(tmp_path: Path) -> None:
    lines = _rows(line=TABLE).splitlines()
    split = [re.sub(",[^,]*$" if k % 2 else ",[^,]*,", "," if k % 2 else ",,", line) for k, line in enumerate(lines)]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],position [mm],force [N]", *split]))
    refused("no row holds 'position' and 'friction_force' together; bring them", _experiment, tmp_path, "log.csv")


def test_a_clock_that_is_set_is_a_note(tmp_path: Path) -> None:
    stamps = [f"2024-03-31T{'01:59:5' if k < 30 else '03:00:0'}{(t + 9.7) % 10:.2f}" for k, t in enumerate(TIME)]
    rows = "".join(f"{s},{1e3 * x:.4f},{f:.6f}\n" for s, x, f in zip(stamps, POSITION, FORCE))
    (tmp_path / "log.csv").write_text("time,position [mm],force [N]\n" + rows)
    (record,) = _experiment(tmp_path, "log.csv")
    assert any("row 31 is 3600.01 s after the row before" in note and "summer time" in note for note in record.notes)


def test_units_beside_values_in_lines_of_json(tmp_path: Path) -> None:
    rows = [
        {"time [s]": t, "axis": {"pos": {"value": 1e3 * x, "unit": "mm"}, "force": {"value": f, "unit": "N"}}}
        for t, x, f in zip(TIME.tolist(), POSITION.tolist(), FORCE.tolist())
    ]
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)))
    (record,) = _experiment(tmp_path, "log.jsonl")
    _check(record)


def test_tdms_of_two_rates_has_the_time_of_most_channels(tmp_path: Path) -> None:
    nptdms = pytest.importorskip("nptdms")
    fast = {"wf_increment": 0.01, "wf_start_offset": 0.5}
    channels = [("temp", TIME[::10], "degC", {"wf_increment": 0.1}), ("position", POSITION, "m", fast)]
    channels.append(("friction_force", FORCE, "N", fast))
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as writer:
        for name, values, unit, rest in channels:
            writer.write_segment([nptdms.ChannelObject("log", name, values, {"unit_string": unit, **rest})])
    (record,) = _experiment(tmp_path, "log.tdms")
    _check(record)
    assert record.time[0] == 0.5 and "temperature" not in record.channels


def test_a_timetable_of_matlab_is_one_line_and_beside_vectors_a_note(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.create_dataset("TT", data=np.array([[0xDD000000, 2, 1, 1, 1, 1]])).attrs["MATLAB_object_decode"] = 3
    refused(r"'TT' is an object of MATLAB.*table2struct", _experiment, tmp_path, "log.h5")
    with h5py.File(tmp_path / "log.h5", "a") as file:
        for label, values in (("time [s]", TIME), ("position [m]", POSITION), ("friction_force [N]", FORCE)):
            file[label] = values
    (record,) = _experiment(tmp_path, "log.h5")
    _check(record)
    assert any("'TT' is an object of MATLAB" in note for note in record.notes)
