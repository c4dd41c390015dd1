"""Binary formats give the record that the arrays were; files that crash their reader or are too large, one line."""

import json
import resource
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime, timedelta
from decimal import Decimal
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow
import pytest
from pyarrow import parquet
from scipy.io import savemat

from stagecad.parameters.errors import InputError
from sysid.experiment.column_proposal import read_numbers
from sysid.experiment.experiment import load_experiment
from sysid.experiment.readers import base, isolated
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.record import load_records
from tests.experiments import record_text, state
from tests.process_state import python
from tests.refusals import refused
from workbench.operations.measurement import new_experiment
from workbench.operations.measurement.experiment import columns_of

TIME = 0.001 * np.arange(80)
POSITION = 1e-3 * np.sin(90.0 * TIME)
FORCE = np.cos(90.0 * TIME)
UNITS = '[channels]\ntime = {unit = "s"}\nposition = {unit = "m"}\nfriction_force = {unit = "N"}\n'
NUMBERED = "[channels]\n" + "".join(
    f'{name} = {{column = {k}, unit = "{unit}"}}\n'
    for k, name, unit in ((1, "time", "s"), (2, "position", "m"), (3, "friction_force", "N"))
)
T = np.arange(200) * 0.01


def _check(folder: Path, name: str, rest: str = "") -> list[str]:
    records = load_records(load_experiment(state(folder, rest + record_text(name))))
    for key, expected in (("position", POSITION), ("friction_force", FORCE)):
        assert np.array_equal(np.concatenate([record.channels[key] for record in records]), expected)
    assert np.allclose(np.concatenate([record.time for record in records]), TIME, rtol=0.0, atol=1e-12)
    return list(records[0].notes)


def test_hdf5_with_units_and_packed_values(tmp_path: Path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "fit.h5", "w") as file:
        group = file.create_group("run/1")
        for name, values, unit in (("time", TIME, "s"), ("position", POSITION, "m"), ("friction_force", FORCE, b"N")):
            group.create_dataset(name, data=values).attrs["unit"] = unit
    _check(tmp_path, "fit.h5")
    # CF conventions, section 8.1, as netCDF and xarray write them.
    counts = np.array([[-9999, 100, 250]], dtype="i2")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        packed = file.create_dataset("position", data=counts)
        packed.attrs.update({"_FillValue": np.int16(-9999), "scale_factor": 0.01, "add_offset": 2.0, "units": "mm"})
    found = open_record_file(tmp_path / "a.h5", "a.h5").columns([0])[0].values
    np.testing.assert_allclose(found, [np.nan, 3.0, 4.5])


def test_mat_7_3_and_compound_data_sets(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "fit.mat", "w", userblock_size=512) as file:
        for name, values in (("time", TIME), ("position", POSITION)):
            file.create_dataset(f"data/{name}", data=values[None, :])
        file.create_dataset("data/friction_force", data=FORCE[:, None])
        note = file.create_dataset("note", data=np.frombuffer(b"hello", np.uint8))
        note.attrs["MATLAB_class"] = np.bytes_("char")
    assert open_record_file(tmp_path / "fit.mat", "fit.mat").header.labels == ("friction_force", "position", "time")
    _check(tmp_path, "fit.mat", UNITS)
    table = np.rec.fromarrays([TIME, POSITION, FORCE], names="time,position,friction_force")
    with h5py.File(tmp_path / "fit.hdf5", "w") as file:
        file["log"] = table
    _check(tmp_path, "fit.hdf5", UNITS)


def test_mat_5_with_matrices_and_structures_of_dspace_and_simulink(tmp_path):
    savemat(tmp_path / "fit.mat", {"data": np.column_stack([TIME, POSITION, FORCE])})
    assert open_record_file(tmp_path / "fit.mat", "fit.mat").header.labels == ("data.1", "data.2", "data.3")
    _check(tmp_path, "fit.mat", NUMBERED)
    signals = np.empty(2, dtype=object)
    signals[:] = [{"values": POSITION}, {"values": FORCE}]
    savemat(tmp_path / "fit.mat", {"out": {"time": TIME, "signals": signals}})
    names = UNITS.replace("position = {", 'position = {column = "out.signals.1.values", ')
    names = names.replace("force = {", 'force = {column = "out.signals.2.values", ')
    _check(tmp_path, "fit.mat", names)

    def captured(*channels):
        return np.array([*channels], dtype=[("Name", object), ("Unit", object), ("Data", object)])

    time = np.arange(50) * 0.01
    position, force = np.sin(time), np.cos(time)
    rows = captured(("Model/position", "mm", position), ("Model/force", "N", force))
    savemat(tmp_path / "d.mat", {"rec": {"X": captured(("time", "s", time)), "Y": rows, "Gains": np.ones(3)}})
    opened = open_record_file(tmp_path / "d.mat", "d.mat")
    numbers = read_numbers(opened)
    assert opened.header.labels[:3] == ("time", "Model/position", "Model/force")
    assert dict(opened.header.units) == {"time": "s", "Model/position": "mm", "Model/force": "N"}
    assert set(numbers.columns) == {0, 1, 2} and "has 3 values, others 50" in numbers.reasons[3]
    assert np.array_equal(numbers.columns[1], position)


def test_numpy_files(tmp_path):
    np.savez(tmp_path / "fit.npz", time=TIME, position=POSITION, friction_force=FORCE, name="run 1")
    _check(tmp_path, "fit.npz", UNITS)
    np.save(tmp_path / "fit.npy", np.vstack([TIME, POSITION, FORCE]))
    _check(tmp_path, "fit.npy", NUMBERED)
    np.save(tmp_path / "fit.npy", np.array([{}, {}]), allow_pickle=True)
    refused("is not a NumPy file of numbers, or is damaged", _check, tmp_path, "fit.npy")


def test_tdms_with_a_waveform_step(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    rest = {"wf_increment": 0.001, "wf_start_offset": 0.0, "wf_samples": TIME.size}
    position = nptdms.ChannelObject("log", "position", POSITION, {"unit_string": "m", **rest})
    force = nptdms.ChannelObject("log", "friction_force", FORCE, {"unit_string": "N", **rest})
    with nptdms.TdmsWriter(tmp_path / "fit.tdms") as writer:
        writer.write_segment([position, force])
    assert "read as: time from the file's step of 0.001 s" in _check(tmp_path, "fit.tdms")
    whole = (tmp_path / "fit.tdms").read_bytes()
    (tmp_path / "part.tdms").write_bytes(whole[: len(whole) // 2])
    assert "the file is cut off" in open_record_file(tmp_path / "part.tdms", "part.tdms").header.remarks


def test_parquet_with_stamps_durations_decimals_and_large_counts(tmp_path: Path):
    stamps = np.datetime64("2024-03-01T12:00:00", "ns") + (1e9 * TIME).round().astype("timedelta64[ns]")
    columns = {"time": pyarrow.array(stamps), "position [m]": POSITION, "friction_force [N]": FORCE, "who": ["me"] * 80}
    _parquet(tmp_path / "fit.parquet", **columns)
    assert "read as: time stamps in 'time'" in _check(tmp_path, "fit.parquet")
    seconds = pd.to_timedelta(np.arange(5) * 0.01, unit="s")
    clock = (pd.Timestamp("2024-03-01 12:00") + seconds).time
    exact = pyarrow.array([Decimal(f"0.{k}5") for k in range(5)])
    _parquet(tmp_path / "a.parquet", **{"t": pyarrow.array(seconds), "clock": clock, "x [mm]": exact})
    opened = open_record_file(tmp_path / "a.parquet", "a.parquet")
    duration, of_day, position = (column.values for column in opened.columns([0, 1, 2]))
    np.testing.assert_allclose([duration, of_day], [np.arange(5) * 0.01] * 2, atol=1e-12)
    np.testing.assert_allclose(position, np.arange(5) / 10.0 + 0.05, atol=1e-15)
    counts = 1_709_820_358_500_000_001 + 100 * np.arange(50)
    _parquet(tmp_path / "a.parquet", **{"time [ns]": counts, "x [m]": counts % 7})
    time = open_record_file(tmp_path / "a.parquet", "a.parquet").columns([0])[0]
    assert np.array_equal(time.values, 100.0 * np.arange(50)) and time.origin == float(counts[0])


@pytest.mark.parametrize("name, what", [("a.h5", "HDF5"), ("a.tdms", "TDMS"), ("a.npz", "NumPy"), ("a.json", "JSON")])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, name, what):
    pytest.importorskip({"HDF5": "h5py", "TDMS": "nptdms"}.get(what, "numpy"))
    (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\nPK\x03\x04" + bytes(200))
    refused(f"{name}: is not an? {what} file", open_record_file, tmp_path / name, name)


def test_a_long_file_is_not_hashed_for_its_labels(tmp_path, monkeypatch):
    monkeypatch.setattr("hashlib.file_digest", lambda *_: pytest.fail("the whole file is read"))
    path = tmp_path / "a.jsonl"
    for label in ("first", "other"):
        path.write_text("".join(json.dumps({"t [s]": k, label: k}) + "\n" for k in range(3)))
        assert open_record_file(path, "a.jsonl").header.labels == ("t [s]", label)


def test_gaps_of_nested_rows_of_numbers_in_json(tmp_path: Path) -> None:
    runs = [{"kind": "drop", "drive": [0.0, None, 1.0], "angle": [1.0, 2.0, 3.0]}]
    (tmp_path / "a.json").write_text(json.dumps({"rate": 50, "runs": runs}))
    opened = open_record_file(tmp_path / "a.json", "a.json")
    assert {"drive", "angle"} <= {*opened.header.labels}
    drive = opened.columns([opened.header.labels.index("drive")])[0].values
    np.testing.assert_array_equal(drive, [0.0, np.nan, 1.0])


def test_json_of_texts(tmp_path: Path) -> None:
    """Loggers write numbers and times as texts."""
    stamps = [(datetime(2024, 3, 7, 14, 5, 59, 990_000) + timedelta(seconds=t)).isoformat() for t in TIME.tolist()]
    rows = [{"time": s, "x": f"{x!r}", "note": "a"} for s, x in zip(stamps, POSITION.tolist())]
    (tmp_path / "a.jsonl").write_text("".join(json.dumps(row) + "\n" for row in [*rows[:-1], {**rows[-1], "x": None}]))
    opened = open_record_file(tmp_path / "a.jsonl", "a.jsonl")
    assert opened.header.labels == ("time", "x", "note") and opened.header.units == {"time": "s"}
    assert opened.header.texts == {"note": "a"}
    time, x = (column.values for column in opened.columns([0, 1]))
    np.testing.assert_allclose(time, TIME, atol=1e-9)
    assert np.array_equal(x[:-1], POSITION[:-1]) and np.isnan(x[-1])


TEXTS: dict[str, Callable[[Path, dict], object]] = {
    "a.json": lambda path, columns: path.write_text(json.dumps(columns)),
    "a.jsonl": lambda path, columns: path.write_text(
        "\n".join(json.dumps(dict(zip(columns, row))) for row in zip(*columns.values())) + '\n{"time": "0.'
    ),
    "a.parquet": lambda path, columns: parquet.write_table(pyarrow.table(columns), path),
    "a.npz": lambda path, columns: np.savez(path, **columns, objects=np.array([None, {}])),
    "memory": lambda path, columns: MemoryTable("memory", columns_of(pd.DataFrame(columns), "memory")),
}


@pytest.mark.parametrize("name", TEXTS)
def test_columns_of_texts_are_read_as_those_of_a_text_file(tmp_path: Path, name: str) -> None:
    """Decimal commas, grouped thousands, units, marks of gaps, dates apart, words; more rows than are looked at."""
    time = np.arange(1200) * 0.01
    stamps = [datetime(2024, 7, 30, 23, 59, 58) + timedelta(seconds=t) for t in time.tolist()]
    grouped = [f"{x:,.2f}".translate({44: ".", 46: ","}) for x in 5e3 * np.sin(time)]
    force = [f"{f:.3f} N".replace(".", ",") for f in np.cos(time)]
    columns = {"date": [f"{s:%d.%m.%Y}" for s in stamps], "time": [f"{s:%H:%M:%S.%f}" for s in stamps]}
    columns |= {"x [um]": grouped, "force": ["OVER", *force[1:]], "note": ["a", "b"] * 600}
    made = TEXTS[name](tmp_path / name, columns)
    opened = open_record_file(made if isinstance(made, MemoryTable) else tmp_path / name, name)
    numbers = read_numbers(opened)
    assert numbers.missing == ("OVER",) and opened.header.units["force"] == "N"
    assert numbers.reasons[0] == "read with the time of day in another column"
    assert "holds text, such as" in numbers.reasons[4]
    np.testing.assert_allclose(numbers.columns[1], time, atol=1e-8)
    np.testing.assert_allclose(numbers.columns[2], 5e3 * np.sin(time), atol=0.01)
    np.testing.assert_allclose(numbers.columns[3][1:], np.cos(time[1:]), atol=1e-3)
    remarks = {"a.jsonl": "row 1201 at the end is cut off", "a.npz": "'objects' holds objects of Python"}
    assert not opened.header.remarks or remarks[name] in opened.header.remarks[0]
    refused(r"row 1, column 'force': 'OVER' is not a number.*missing = \[\"OVER\"\]", opened.columns, [3])


@pytest.mark.parametrize("name", ["a.mat", "a.h5", "a.tdms"])
def test_texts_of_other_formats_are_read_or_named(tmp_path: Path, name: str) -> None:
    texts = [f"{f:.4f}" for f in FORCE]
    if name == "a.mat":
        savemat(tmp_path / name, {"time": TIME, "force": np.array(texts, dtype=object)})
        assert np.allclose(read_numbers(open_record_file(tmp_path / name, name)).columns[1], FORCE, atol=1e-4)
        return
    if name == "a.h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / name, "w") as file:
            file["time"], file["force"] = TIME, texts
    else:
        nptdms = pytest.importorskip("nptdms")
        with nptdms.TdmsWriter(tmp_path / name) as file:
            file.write_segment([nptdms.ChannelObject("g", k, v) for k, v in {"time": TIME, "force": texts}.items()])
    assert "force holds text, not numbers: left out" in open_record_file(tmp_path / name, name).header.remarks[0]


def test_keys_that_the_first_row_lacks(tmp_path: Path) -> None:
    rows = [{"event": "start"}, *({"time [s]": k, "x [m]": k / 2} for k in range(3))]
    (tmp_path / "a.jsonl").write_text("\n".join(map(json.dumps, rows)))
    opened = open_record_file(tmp_path / "a.jsonl", "a.jsonl")
    assert opened.header.labels == ("event", "time [s]", "x [m]")
    np.testing.assert_array_equal(opened.columns([2])[0].values, [np.nan, 0.0, 0.5, 1.0])


@pytest.mark.parametrize("rows, message", [(0, "no rows of numbers"), (1, "has 1 row of numbers")])
def test_files_without_rows(tmp_path: Path, rows: int, message: str) -> None:
    _parquet(tmp_path / "a.parquet", **{"time [s]": TIME[:rows], "x [m]": TIME[:rows]})
    refused(f"a.parquet: .*{message}", new_experiment.propose, [tmp_path / "a.parquet"])


OTHER_FORMATS = {
    "a.csv": (b"PK\x03\x04\x14" + bytes(99), "save the sheet as CSV"),
    "a.xlsx": (b"PK", "save the sheet as CSV"),
    "b.csv": (b"\x89HDF\r\n\x1a\n" + bytes(99), "give it the suffix .h5"),
    "a.dat": (b"MDF     3.30    " + bytes(99), "export it as CSV or MAT"),
    "b.dat": (b"[key]; [value]\r\nVersion; 0x03050000\r\n", "a trace of CODESYS, with the variables one below"),
    "a.feather": (b"ARROW1", "save it as Parquet"),
    "a.pkl": (b"\x80\x04", "may hold code; save the arrays"),
    "a.tdm": (b"<?xml", "save it as TDMS or CSV"),
    "noext": (b"t,x", "a name without a suffix is not a record format"),
}


@pytest.mark.parametrize("name", OTHER_FORMATS)
def test_other_formats_are_refused_with_what_to_do(tmp_path: Path, name: str) -> None:
    content, message = OTHER_FORMATS[name]
    (tmp_path / name).write_bytes(content)
    refused(message, open_record_file, tmp_path / name, name)


def _mat(path: Path, **given: np.ndarray) -> bytes:
    savemat(path, given, do_compression=True)
    return path.read_bytes()


def _parquet(path: Path, **given) -> bytes:
    parquet.write_table(pyarrow.table(given), path)
    return path.read_bytes()


def _run_instead(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    """Let the process that reads a file run other code."""
    real = isolated.subprocess.run
    other = lambda command, **given: real([*command[:3], code, *command[4:]], **given)  # noqa: E731
    monkeypatch.setattr(isolated.subprocess, "run", other)


def test_a_reader_that_crashes_is_a_damaged_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _mat(tmp_path / "fit.mat", time=T)
    _run_instead(monkeypatch, "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(InputError, match=r"fit\.mat: is not a MAT file up to version 7\.3, or is damaged"):
        open_record_file(tmp_path / "fit.mat", "fit.mat")


def test_a_small_file_of_many_gigabytes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(_mat(tmp_path / "fit.mat", time=T, zeros=np.zeros(30_000_000))) < 400_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    code = f"import {isolated.__name__}; {isolated.__name__}.MEMORY = 500 * 1024**2; {isolated.__name__}.answer()"
    _run_instead(monkeypatch, code)
    refused(r"fit\.mat: takes more than 0\.\d+ GB of memory", open_record_file, tmp_path / "fit.mat", "fit.mat")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 100_000


def test_only_the_columns_asked_for_are_read_whatever_their_names(tmp_path: Path) -> None:
    _parquet(tmp_path / "fit.parquet", time=T, text=np.array(["a" * 100] * T.size), force=-T)
    opened = open_record_file(tmp_path / "fit.parquet", "fit.parquet")
    assert opened.header.labels == ("time", "text", "force")
    found = [column.values for column in opened.columns([2, 0, 0])]
    assert np.array_equal(found, [-T, T, T])
    refused(r"column 'text': holds text, such as 'aaa.*, numbers are required", opened.columns, [1])
    parquet.write_table(pyarrow.Table.from_arrays([pyarrow.array(T), pyarrow.array(-T)], ["a", "a"]), tmp_path / "f.pq")
    found = open_record_file(tmp_path / "f.pq", "f.pq").columns([1, 0])
    assert np.array_equal([column.values for column in found], [-T, T])


@pytest.mark.parametrize("kind", ["mat", "parquet"])
def test_damaged_bytes_never_end_in_a_traceback(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"fit.{kind}"
    data = {"mat": _mat, "parquet": _parquet}[kind](path, time=T, position=np.sin(T), force=np.cos(T))
    random = np.random.default_rng(5)
    for _ in range(6):
        damaged = bytearray(data)
        for place in random.integers(0, len(data), 4):
            damaged[place] = random.integers(256)
        path.write_bytes(damaged)
        # Any other exception fails the test.
        with suppress(InputError):
            opened = open_record_file(path, path.name)
            opened.columns(range(len(opened.header.labels)))


def test_the_reader_imports_nothing_from_the_working_folder(tmp_path: Path) -> None:
    _mat(tmp_path / "fit.mat", time=T)
    for module in ("json", "numpy", "scipy", "sysid", "signal"):
        (tmp_path / f"{module}.py").write_text("open('flag', 'w').close()\n")
    code = (
        "from pathlib import Path; from sysid.experiment.readers.open import open_record_file;"
        "print(open_record_file(Path('fit.mat'), 'fit.mat').header.labels)"
    )
    assert python("-P", "-c", code, folder=tmp_path).stdout == "('time',)\n" and not (tmp_path / "flag").exists()


def test_what_is_no_plain_or_too_large_a_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fit.csv").symlink_to("/dev/zero")
    refused(r"fit\.csv: is not a regular file", open_record_file, tmp_path / "fit.csv", "fit.csv")
    (tmp_path / "wide.csv").write_text(",".join(f"c{n} [m]" for n in range(base.MOST_COLUMNS + 1)) + "\n")
    with pytest.raises(InputError, match=r"wide\.csv: has 10001 columns; at most 10000 are read"):
        open_record_file(tmp_path / "wide.csv", "wide.csv")
    monkeypatch.setattr(base, "MOST_BYTES", 100)
    refused(r"wide\.csv: is larger than", open_record_file, tmp_path / "wide.csv", "wide.csv")
