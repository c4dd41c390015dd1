"""Text files as instruments, spreadsheets and public reports write them give the same record."""

import gzip
import io
import re
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from sysid.experiment.column_settings import column_unit
from sysid.experiment.experiment import load_experiment
from sysid.experiment.readers.csv import SingleBlanks
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.record import Record, load_records
from tests.experiments import record_text, state
from tests.refusals import refused
from workbench.operations.measurement import new_experiment

ROWS = 40
TIME = 0.01 * np.arange(ROWS)
POSITION = np.round(1e-3 * np.sin(20.0 * TIME), 7)
FORCE = np.round(2.0 * np.sign(np.cos(20.0 * TIME)) + 0.123 * TIME, 6)
START = datetime(2024, 3, 1, 23, 59, 59, 850_000)
NUMBERED = '[channels]\ntime = {column = 1, unit = "s"}\nposition = {column = 2, unit = "mm"}\n'
NUMBERED += 'friction_force = {column = 3, unit = "N"}\n'
COLUMNS = ("time [s]", "position [mm]", "friction_force [N]")
UNLABELLED = ("time", *COLUMNS[1:])
LINES = list(zip(TIME.tolist(), (1e3 * POSITION).tolist(), FORCE.tolist()))


def _rows(between: str = ",", decimal: str = ".", time: Callable[[float], str] = "{:.2f}".format) -> str:
    cells = [(time(t), f"{x:.7g}", f"{f:.6f}") for t, x, f in LINES]
    return "".join(between.join(cell.replace(".", decimal) for cell in row) + "\n" for row in cells)


def _table(between: str = ",", decimal: str = ".", labels: tuple[str, ...] = COLUMNS, **rest) -> str:
    return between.join(labels) + "\n" + _rows(between, decimal, **rest)


def _stamp(t: float, form: str = "%Y-%m-%dT%H:%M:%S.%f") -> str:
    return (START + timedelta(seconds=t)).strftime(form)


def _load(folder: Path, name: str, content: str | bytes, rest: str = "") -> list[Record]:
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return load_records(load_experiment(state(folder, record_text(name) + rest)))


def _check(records: list[Record], origin: float = 0.0) -> None:
    assert np.allclose(np.concatenate([record.time for record in records]) - origin, TIME, rtol=0.0, atol=1e-9)
    for channel, expected in (("position", POSITION), ("friction_force", FORCE)):
        found = np.concatenate([record.channels[channel] for record in records])
        # One rounding more than numpy's own conversion of the same digits.
        assert np.allclose(found, expected, rtol=1e-14, atol=0.0), channel


DIALECTS: dict[str, tuple[str | bytes, str | None]] = {
    "plain": (_table(), None),
    "semicolons": (_table(";"), "semicolon"),
    "decimal comma": (_table(";", ","), "semicolon, decimal comma"),
    "tabs and decimal comma": (_table("\t", ","), "tab, decimal comma"),
    "bars": (_table("|"), "bar"),
    "blanks": (
        "   time   position  friction_force\n      s         mm               N\n" + _rows("    "),
        "blanks, units in row 2",
    ),
    "names before the numbers": (
        "".join(f"time={t}s position={x:.7g}mm friction_force={f:.6f}N\n" for t, x, f in LINES),
        "blanks, names before the numbers, units behind the numbers: N, mm, s",
    ),
    "fixed width, names that touch": (
        "     Time[s]Position[mm]Friction force[N]\n" + "".join(f"{t:12.2f}{x:12.7f}{f:17.6f}\n" for t, x, f in LINES),
        "blanks",
    ),
    "units in the second row": ("time,position,friction_force\n[s],[mm],[N]\n" + _rows(), "units in row 2"),
    "lines above the header": ("Instrument,XYZ 12\nDate,2024-03-01\nRate,100\n\n" + _table(), "header in row 5"),
    "header in a comment": ("# rig 7\n# time_s position_mm friction_force_N\n" + _rows(" "), "blanks, header in row 2"),
    "other names": (_table(labels=("Time (s)", "POSITION/mm", "friction force in N")), None),
    "compressed": (gzip.compress(_table(";").encode()), "gzip, semicolon"),
    "UTF-16": (_table("\t").encode("utf-16"), "tab, UTF-16"),
    "byte order mark, CR LF": (b"\xef\xbb\xbf" + _table().replace("\n", "\r\n").encode(), None),
    "delimiter at the end": (
        "time [s],position [mm],friction_force [N]\n" + _rows().replace("\n", ",\n"),
        "a delimiter at the end of each row",
    ),
    "quoted, decimal comma": (_table('","', ",").replace("\n", '"\n"').join(('"', ""))[:-1], "decimal comma"),
    "ISO time stamps": (_table(labels=UNLABELLED, time=_stamp), "time stamps in 'time'"),
    "ISO time stamps with a zone": (
        _table(";", ",", labels=UNLABELLED, time=lambda t: _stamp(t).replace("T", " ") + "+01:00"),
        "semicolon, decimal comma, time stamps in 'time'",
    ),
    "clock times over midnight": (
        _table(labels=UNLABELLED, time=lambda t: _stamp(t).partition("T")[2]),
        "time stamps in 'time'",
    ),
    "Unix time": (_table(time=lambda t: f"{1554239502.265 + t:.3f}"), None),
    "Unix time in nanoseconds": (
        _table(labels=("time [ns]", *COLUMNS[1:]), time=lambda t: str(1554239502265000123 + round(1e9 * t))),
        None,
    ),
}
NAMES = {"tabs and decimal comma": "fit.txt", "names before the numbers": "fit.txt", "compressed": "fit.csv.gz"}
NAMES |= {"fixed width, names that touch": "fit.txt", "header in a comment": "fit.dat"}
NAMES |= dict.fromkeys(("bars", "blanks"), "fit.dat")


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects_are_read_without_an_option(tmp_path, name):
    content, said = DIALECTS[name]
    records = _load(tmp_path, NAMES.get(name, "fit.csv"), content)
    _check(records)
    read_as = [note for note in records[0].notes if note.startswith("read as")]
    assert read_as == ([f"read as: {said}"] if said else [])


UNTIMED = "position [mm],friction_force [N]\n" + "\n".join(row.partition(",")[2] for row in _rows().splitlines())

NAMED_SETTINGS: dict[str, tuple[str, str, str]] = {
    "no header": (_rows(), '[channels] time = {column = 1, unit = "s"}, position =', NUMBERED),
    "no header, decimal comma": (_rows(";", ","), '[channels] time = {column = 1, unit = "s"}', NUMBERED),
    "own time stamps": (
        _table(labels=UNLABELLED, time=lambda t: _stamp(t, "%m/%d/%Y %H:%M:%S.%f")),
        '[format] time_format = "%d.%m.%Y %H:%M:%S.%f"',
        '[format]\ntime_format = "%m/%d/%Y %H:%M:%S.%f"\n[channels]\ntime = {unit = "s"}',
    ),
    "no time": (UNTIMED, '[format] sample_rate = "1 kHz"', '[format]\nsample_rate = "100 Hz"'),
    "no unit": (
        _table(labels=UNLABELLED),
        '[channels] time = {column = "time", unit = "s"}',
        '[channels]\ntime = {column = "time", unit = "s"}',
    ),
}


@pytest.mark.parametrize("name", NAMED_SETTINGS)
def test_others_are_read_with_the_one_setting_that_the_message_names(tmp_path, name):
    content, named, setting = NAMED_SETTINGS[name]
    refused(re.escape(named), _load, tmp_path, "fit.csv", content)
    _check(_load(tmp_path, "fit.csv", content, setting))


def test_exact_time_stamps_and_stated_headers(tmp_path):
    steps = np.arange(20) * 1e-6
    rows = "\n".join(f"2024-03-01T12:00:00.{round(1e9 * t):09d},{k},1" for k, t in enumerate(steps))
    records = _load(tmp_path, "fit.csv", f"time,position [m],friction_force [N]\n{rows}".encode())
    assert np.array_equal(np.concatenate([record.time for record in records]), np.arange(20) * 1000 / 1e9)
    assert "'time' is counted from its first row, 2024-03-01T12:00:00.000000000" in records[0].notes
    unix = "\n".join(f"1554239502.{round(1e9 * t):09d},{k},1" for k, t in enumerate(steps))
    records = _load(tmp_path, "fit.csv", f"time [s],position [m],friction_force [N]\n{unix}".encode())
    assert np.allclose(np.concatenate([record.time for record in records]), steps, rtol=0.0, atol=1e-12)
    content = "names\ntime [s],position [mm],friction_force [N]\nfloat,float,float\n" + _rows()
    _check(_load(tmp_path, "fit.csv", content))
    records = _load(tmp_path, "fit.csv", content, "[format]\nheader = 2\nfirst_row = 4")
    _check(records)
    assert "read as: header in row 2, numbers from row 4" in records[0].notes
    other = "time,position,friction_force\nzone 1,zone 2,zone 3\ns,mm,N\n" + _rows()
    _check(_load(tmp_path, "fit.csv", other.encode(), "[format]\nheader = 1\nunits_row = 3"))


LVM = (
    "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
    "Date\t2024/07/30\t2024/07/30\t\n"
    "Y_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\nDelta_X\t0.01\t0.01\t\n***End_of_Header***\t\t\t\n"
    "X_Value\tposition\tfriction_force\tComment\n"
)
HEADS = {
    "LVM of LabVIEW": ("\t", LVM),
    "TOA5 of Campbell": (",", '"TOA5","CR1000","1"\n"TS","x","F"\n"s","mm","N"\n"","Smp","Smp"\n'),
    "Keysight": (",", "x-axis,1,2\nsecond,Millimeter,Newton\n"),
    "Tektronix": (",", "Model,MSO64\nHorizontal Units,s,\nVertical Units,mm,N\nLabel,x,F\nTIME,CH1,CH2\n"),
    "catman": (";", "Zeit;Weg;Kraft\ns;mm;N\nKanal 0;Kanal 1;Kanal 2\n"),
    "types below the names": (";", "t;x;F\nLREAL;LREAL;LREAL\ns;mm;N\n"),
    "types below the units": (";", "t;x;F\ns;mm;N\nreal64;real64;int16\n"),
    "other delimiter in the header": ("\t", "time [s],position [mm],friction_force [N]\n"),
    "line below the header": (",", "time [s],position [mm],friction_force [N]\n--------\n"),
    "table of Markdown": ("|", "time [s]|position [mm]|friction_force [N]\n---|---|---\n"),
    "first row cut off": (",", "time [s],position [mm],friction_force [N]\n17.2,0.5\n"),
}


@pytest.mark.parametrize("name", HEADS)
def test_what_stands_above_the_numbers(tmp_path: Path, name: str) -> None:
    between, head = HEADS[name]
    (tmp_path / "fit.csv").write_text(head + _rows(between))
    opened = open_record_file(tmp_path / "fit.csv", "fit.csv")
    columns = [column.values for column in opened.columns([0, 1, 2])]
    for found, expected in zip(columns, (TIME, 1e3 * POSITION, FORCE)):
        np.testing.assert_allclose(found, expected, atol=1e-9)
    stated = [column_unit(opened.header.units.get(label, "")) for label in opened.header.labels]
    if opened.header.units:
        assert stated[1:] == ["mm", "N"] and (name == "LVM of LabVIEW" or stated[0] == "s")
    else:
        assert opened.header.labels[0] == "time [s]"


def test_row_names_in_front_of_the_columns(tmp_path: Path) -> None:
    rows = [f'"{k + 1}" {line}' for k, line in enumerate(_rows(" ").splitlines())]
    (tmp_path / "r.txt").write_text("\n".join(['"time" "position" "friction_force"', *rows]))
    assert open_record_file(tmp_path / "r.txt", "r.txt").header.labels == ("", "time", "position", "friction_force")
    (tmp_path / "pandas.csv").write_text("\n".join(["," + _table().splitlines()[0], *(
        f"{k},{line}" for k, line in enumerate(_rows().splitlines()))]))  # fmt: skip
    proposal = new_experiment.propose([tmp_path / "pandas.csv"])
    proposal.write(tmp_path / "pandas")
    assert [column["first"][0] for column in proposal.columns] == [TIME[0], 1e3 * POSITION[0], FORCE[0]]


def test_faults_are_named_by_row_and_damaged_files_refused(tmp_path):
    content = "made by me\n\n" + _table(";").replace(f"{FORCE[7]:.6f}", "off", 1)
    row = content.splitlines().index(next(line for line in content.splitlines() if "off" in line)) + 1
    said = rf"fit\.csv\.gz: row {row}, column 'friction_force \[N\]': 'off' is not a number"
    refused(said, _load, tmp_path, "fit.csv.gz", gzip.compress(content.encode()))
    packed = gzip.compress(_table().encode())
    _load(tmp_path, "fit.csv.gz", packed)
    (tmp_path / "fit.csv.gz").write_bytes(packed[: len(packed) // 2])
    refused("is a damaged or incomplete gzip file", lambda: load_records(load_experiment(tmp_path)))


def test_runs_of_blanks_are_single_across_blocks(monkeypatch):
    monkeypatch.setattr("sysid.experiment.readers.csv.BLOCK", 7)
    source = b"  1.0   \t 2.0\t\r\n   3 4  \n\n 5      6"
    assert io.BufferedReader(SingleBlanks(io.BytesIO(source))).read() == b"1.0 2.0\r\n3 4\n\n5 6"
