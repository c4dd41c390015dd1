"""Numbers, times and rows as loggers write them: each is read with its one meaning, or refused with row and reason."""

import re
from datetime import datetime, timedelta
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import parse_quantity
from sysid.experiment.channels import conversion
from sysid.experiment.column_proposal import propose, read_numbers
from sysid.experiment.column_settings import column_unit
from sysid.experiment.experiment import load_experiment
from sysid.experiment.readers import csv
from sysid.experiment.readers.base import Format
from sysid.experiment.readers.numbers import NumberForm
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.record import Record, load_whole_records
from tests.experiments import replace_in
from tests.refusals import refused
from workbench.operations.measurement import new_experiment

ROWS = 40
TIME = np.arange(ROWS) * 0.01
POSITION = 8.4147 * np.sin(3.0 * TIME) - 1.5
FORCE = 3.2 * np.sign(np.cos(3.0 * TIME)) + 0.01 * np.cos(40.0 * TIME)
GROUPS = {".": ",", ",": ".", "'": ".", "’": ",", " ": ",", "\u00a0": ".", "\u202f": ","}.items()
GROUPED = {"us": ("time [s],x [um],F [N]", '{t:.2f},"{x:,.0f}",{f:.4f}', ","), "de": ("Zeit [s];x [um];F [N]", "", ".")}


def _write(folder: Path, rows: list[str], header: str = "time [s];position [mm];friction_force [N]") -> Path:
    file = folder / "fit.csv"
    file.write_text(("\n".join([header, *rows]) + "\n").partition("\0")[0], encoding="utf-8")
    return file


def _columns(file: Path, **settings) -> list[np.ndarray]:
    opened = open_record_file(file, file.name, Format(**settings))
    return [column.values for column in opened.columns([0, 1, 2])]


def _opened(folder: Path, rows: list[str], header: str = "time [s];position [mm];friction_force [N]"):
    """A file with these rows, and what is proposed for its columns."""
    opened = open_record_file(_write(folder, rows, header), "fit.csv")
    return opened, propose(opened, read_numbers(opened)).columns


def _made(folder: Path, rows: list[str], header: str, *answer: str) -> Record:
    """The record of the experiment that is proposed for such a file, with a question replaced by its answer."""
    folder.mkdir(exist_ok=True)
    new_experiment.propose([_write(folder, rows, header)]).write(folder / "made")
    if answer:
        replace_in(folder / "made" / "experiment.toml", *answer)
    return load_whole_records(load_experiment(folder / "made"))[0]


SPELLINGS = {
    "plus": lambda x: f"{x:+.4f}",
    "unit behind": lambda x: f"{x:.4f} mm",
    "unit without a blank": lambda x: f"{x:.4f}mm",
    "power of ten": lambda x: f"{x:.6e}".replace("e", "×10^"),
    "power of ten in ASCII": lambda x: f"{x:.6e}".replace("e", "*10^"),
    "negative in brackets": lambda x: f"({-x:.4f})" if x < 0.0 else f"{x:.4f}",
    "superscript minus": lambda x: f"{x:.4f}".replace("-", "⁻"),
    "Mathematica": lambda x: f"{x:.6e}".replace("e", "*^"),
    "apart from its exponent": lambda x: f"{x:.6E}".replace("E", " E"),
    "Arabic decimal sign": lambda x: f"{x:.4f}".replace(".", "٫"),
}
"""What `test_dialect_combinations.py` does not combine: signs, exponents, decimal commas, clocks are there."""


@pytest.mark.parametrize("name", SPELLINGS)
def test_spellings_of_a_number(tmp_path: Path, name: str) -> None:
    rows = [f"{t:.2f};{SPELLINGS[name](x)};{f:.4f}" for t, x, f in zip(TIME, POSITION, FORCE)]
    time, position, force = _columns(_write(tmp_path, rows))
    np.testing.assert_allclose(time, TIME, atol=1e-9)
    np.testing.assert_allclose(position, POSITION, atol=1e-4)
    np.testing.assert_allclose(force, FORCE, atol=1e-4)


@pytest.mark.parametrize(("mark", "decimal"), GROUPS)
def test_grouped_thousands_with_either_decimal_sign(tmp_path: Path, mark: str, decimal: str) -> None:

    def grouped(value: float) -> str:
        return f"{value:,.2f}".replace(",", "\0").replace(".", decimal).replace("\0", mark)

    rows = [f"{t:.2f};{grouped(1e3 * x)};{f:.4f}".replace(".", decimal) if decimal == "," and mark != "." else
            ";".join((f"{t:.2f}".replace(".", decimal), grouped(1e3 * x), f"{f:.4f}".replace(".", decimal)))
            for t, x, f in zip(TIME, POSITION, FORCE)]  # fmt: skip
    time, position, force = _columns(_write(tmp_path, rows))
    np.testing.assert_allclose(time, TIME, atol=1e-9)
    np.testing.assert_allclose(position, 1e3 * POSITION, atol=0.01)
    np.testing.assert_allclose(force, FORCE, atol=1e-4)


def test_marks_that_group_or_separate_decimals(tmp_path: Path) -> None:
    """1.234 is 1234 where the other column has decimal commas; else it has two readings."""
    whole = [f"{round(1000.0 * x):,}".replace(",", ".") for x in POSITION]
    forces = [f"{f:.4f}".replace(".", ",") for f in FORCE]
    rows = [f"{k};{x};{f}" for k, (x, f) in enumerate(zip(whole, forces))]
    position = _columns(_write(tmp_path, rows, "time [s];position [um];friction_force [N]"))[1]
    np.testing.assert_allclose(position, np.round(1000.0 * POSITION), atol=1e-9)
    rows = [f"{k},0;{1 + k % 3}.{100 + k};{k},5" for k in range(ROWS)]
    file = _write(tmp_path, rows)
    refused(r"'1\.100' is not a number; if '\.' groups thousands: \[format\] thousands", _columns, file, decimal=",")
    assert _columns(file, decimal=",", thousands=".")[1][0] == 1100.0


@pytest.mark.parametrize("encoding", ["utf-16-be", "utf-16-le", "utf-32", "utf-16"])
def test_encodings_with_and_without_a_mark(tmp_path: Path, encoding: str) -> None:
    file = _write(tmp_path, _plain())
    file.write_bytes(file.read_text().encode(encoding))
    np.testing.assert_allclose(_columns(file)[1], POSITION, atol=1e-4)


def test_numbers_states_and_units_that_are_none(tmp_path: Path) -> None:
    form = NumberForm(",", ".")
    for cell in ("1.23,4", "1,2,3", "--1", "1e", "0x1F", "1.2345,6", "12.34.567", "", "-", "1_000", "٣"):
        assert form.value(cell) is None or cell == "٣", cell
    assert NumberForm(thousands=",").value("1,23,456.5") == 123456.5
    assert [NumberForm().value(cell) for cell in ("1D-02", "3.25-", "0.5-102")] == [0.01, -3.25, 0.5e-102]
    for name, high in {"torque_enable": 1, "motor_dir": -1, "force gate": 255, "Couple actif": 2}.items():
        rows = [f"{row};{1 if k % 9 else high}" for k, row in enumerate(_plain())]
        column = _opened(tmp_path, rows, f"time [s];position [mm];speed [mm/s];{name}")[1][3]
        assert column.channel is None and "a state" in column.reason


MIDNIGHT = datetime(2024, 7, 30, 23, 59, 59, 800_000)
DATED = {
    "year of two digits": "%d.%m.%y %H:%M:%S.%f", "year of two digits, US": "%m/%d/%y %H:%M:%S.%f",
    "DB2": "%Y-%m-%d-%H.%M.%S.%f", "month first": "%b %d, %Y %I:%M:%S.%f %p", "asctime": "%a %b %d %H:%M:%S.%f %Y",
    "weekday, in brackets": "[%a %d-%m-%Y %H:%M:%S.%f]", "day of the year": "%Y-%jT%H:%M:%S.%f",
    "Oracle": "%d-%b-%y %I.%M.%S.%f %p", "time before the date": "%H:%M:%S.%f %d.%m.%Y",
    "digits alone": "%Y%m%d%H%M%S.%f", "US": "%m/%d/%Y %I:%M:%S.%f %p", "slashes, day first": "%d/%m/%Y %H:%M:%S.%f",
    "month by name": "%d-%b-%Y %H:%M:%S.%f", "German 12 hours": "%d.%m.%Y %I:%M:%S.%f %p",
    "year first": "%Y/%m/%d %H:%M:%S.%f", "ROS": "%Y/%m/%d/%H:%M:%S.%f",
    "milliseconds behind a colon": "%Y-%m-%d %H:%M:%S:%f",
    "two columns": "%Y-%m-%d;%H:%M:%S.%f", "two columns, US": "%m/%d/%Y;%I:%M:%S.%f %p",
    "two columns, day first": "%d.%m.%Y;%H:%M:%S,%f",
}  # fmt: skip


@pytest.mark.parametrize("name", DATED)
def test_dates_and_dates_beside_times(tmp_path: Path, name: str) -> None:
    """Over midnight, so that a date in a column of its own is needed, and over a day's pause."""
    time = np.where(TIME < 0.3, TIME, TIME + 2 * 86400.0)
    stamps = [(MIDNIGHT + timedelta(seconds=t)).strftime(DATED[name]) for t in time.tolist()]
    rows = [f"{stamp};{x:.4f};{f:.4f}" for stamp, x, f in zip(stamps, POSITION, FORCE)]
    split = ";" in DATED[name]
    opened, columns = _opened(tmp_path, rows, f"{'Date;' * split}Time;position [mm];friction_force [N]")
    np.testing.assert_allclose(opened.columns([int(split)])[0].values, time, atol=1e-8)
    channels = [one.channel for one in columns]
    assert channels == [None] * split + ["time", "position", "friction_force"]


DURATIONS = {
    "marked": lambda t: f"{int(t // 60)}m{t % 60:06.3f}s",
    "French": lambda t: f"0h{int(t // 60):02d}m{t % 60:06.3f}s",
    "ISO 8601": lambda t: f"PT{int(t // 60)}M{t % 60:.3f}S",
    "minutes from the first on": lambda t: f"{int(t // 60)}:{t % 60:06.3f}" if t >= 60.0 else f"{t:.3f}",
    "below zero": lambda t: f"{'-' * (t < 59.9)}00:00:{abs(t - 59.9):06.3f}",
    "minutes below zero": lambda t: f"{'-' * (t < 59.9)}0:{abs(t - 59.9):06.3f}",
    "primes": lambda t: f"{int(t // 60)}'{t % 60:06.3f}",
    "two primes": lambda t: f"{int(t // 60)}'{t % 60:06.3f}".replace(".", '"'),
    "points": lambda t: f"00.{int(t // 60):02d}.{t % 60:06.3f}",
}


@pytest.mark.parametrize("name", DURATIONS)
def test_durations(tmp_path: Path, name: str) -> None:
    rows = [f"{DURATIONS[name](t)};{x:.4f};{f:.4f}" for t, x, f in zip((TIME + 59.8).tolist(), POSITION, FORCE)]
    np.testing.assert_allclose(np.diff(_columns(_write(tmp_path, rows, "time;position [mm];force [N]"))[0]), 0.01)


HALVES = {
    "Spanish": "{clock}\u00a0{half[0]}.\u00a0m.", "narrow blank": "{clock}\u202f{half}", "Korean": "{other} {clock}",
    "a column of its own": "{clock};{half}", "dates and halves": "2024-07-30;{clock};{half}",
}  # fmt: skip


@pytest.mark.parametrize("name", HALVES)
def test_halves_of_the_day(tmp_path: Path, name: str) -> None:
    """Over noon, and from 12:59 to 1:00."""
    time = np.concatenate([TIME[:20], 3600.0 + TIME[20:]])
    rows = []
    for t, row in zip(time.tolist(), _plain()):
        at = datetime(2024, 7, 30, 11, 59, 59, 900_000) + timedelta(seconds=t)
        half, other = ("am", "오전") if at.hour < 12 else ("pm", "오후")
        stamp = HALVES[name].format(clock=at.strftime("%I:%M:%S.%f"), half=half, other=other)
        rows.append(f"{stamp};{row.partition(';')[2]}")
    names = ("time", "time;am or pm", "date;time;am or pm")[HALVES[name].count(";")]
    opened, columns = _opened(tmp_path, rows, f"{names};position [mm];friction_force [N]")
    channels = [column.channel for column in columns]
    assert [channel for channel in channels if channel] == ["time", "position", "friction_force"]
    np.testing.assert_allclose(opened.columns([channels.index("time")])[0].values, time, atol=1e-8)


def test_a_date_of_which_the_day_is_not_known_is_asked_for(tmp_path: Path) -> None:
    one_day = ["07/08/2024 10:00:00", "07/08/2024 10:00:01", "07/08/2024 10:00:02"]
    assert _columns(_write(tmp_path, [f"{stamp};{k};{k}" for k, stamp in enumerate(one_day)]))[0].tolist() == [0, 1, 2]
    two_days = [*one_day, "08/08/2024 10:00:03"]
    with pytest.raises(InputError, match="which of the numbers is the day"):
        _columns(_write(tmp_path, [f"{stamp};{k};{k}" for k, stamp in enumerate(two_days)]))


def _plain() -> list[str]:
    return [f"{t:.2f};{x:.4f};{f:.4f}" for t, x, f in zip(TIME, POSITION, FORCE)]


ODD_ROWS = {
    "cut off": ([*_plain(), "0.40;1.2"], "row 42 at the end is cut off"),
    "cut off in a number": ([*_plain(), "0.40;1.2345;-3.\0"], "the last row is cut off in its last number, '-3.'"),
    "text with delimiters": ([f"{row};a; b" if k % 3 == 0 else row for k, row in enumerate(_plain())], "beyond"),
    "row names from 0": ([f"{k};{row}" for k, row in enumerate(_plain())], ""),
    "footer": ([*_plain(), "End of test;;", "operator: A. B."], "rows 42 to 43 at the end hold no numbers"),
    "header again": ([*_plain()[:20], "time [s];position [mm];friction_force [N]", *_plain()[20:]], "1 row repeats"),
    "comment": ([*_plain()[:20], "# paused", *_plain()[20:]], ""),
    "line between": ([*_plain()[:20], "*** paused", *_plain()[20:]], "1 row of text between the numbers"),
    "comment of INI files": ([*_plain()[:20], "; paused", *_plain()[20:]], "1 row of text between the numbers"),
    "event": ([*_plain()[:20], "Event;trigger;", *_plain()[20:]], "1 row of text between the numbers"),
    "flags": ([f"{row};ok" for row in _plain()], ""),
}


@pytest.mark.parametrize("name", ODD_ROWS)
def test_odd_rows_are_left_out_with_a_note(tmp_path: Path, name: str) -> None:
    rows, note = ODD_ROWS[name]
    opened = open_record_file(_write(tmp_path, rows), "fit.csv")
    columns = opened.columns([k for k, label in enumerate(opened.header.labels) if label])
    assert [column.values.size for column in columns] == [ROWS] * 3
    np.testing.assert_allclose(columns[1].values, POSITION, atol=1e-4)
    assert any(note in text for text in columns[0].notes) if note else not columns[0].notes


def test_rows_of_another_width_are_named_or_refused(tmp_path: Path) -> None:
    rows = [*_plain()[:20], "0.20;1.0", *_plain()[20:]]
    refused("row 22: has 2 cells, the header has 3", _columns, _write(tmp_path, rows))
    # Most rows are of the other width: those above them are no preamble.
    rows = [*_plain()[:10], *(f"{row};1;2" for row in _plain()[10:])]
    with pytest.raises(InputError, match=r"row 12: has 5 cells, the rows above have 3; .*first_row = 12"):
        open_record_file(_write(tmp_path, rows), "fit.csv")
    # A date and a time of day under one name.
    clocks = [f"2024-07-30;10:00:00.{k:02d};{row.partition(';')[2]}" for k, row in enumerate(_plain())]
    file = _write(tmp_path, clocks, "time;position [mm];friction_force [N]")
    assert np.allclose(open_record_file(file, "fit.csv").columns([2])[0].values, POSITION, atol=1e-4)
    clocks = [f"{row};1" for row in clocks]
    with pytest.raises(InputError, match="row 2: has 5 cells, the header 4; name the columns by their numbers"):
        open_record_file(_write(tmp_path, clocks, "date;time;position [mm];friction_force [N]"), "fit.csv")
    with pytest.raises(InputError, match="row 2: has 4 cells, the header 3; name the columns by their numbers"):
        open_record_file(_write(tmp_path, [f"{row};1" for row in _plain()]), "fit.csv")
    commas = [row.replace(".", ",").replace(";", ",") for row in _plain()]
    with pytest.raises(InputError, match="row 2: has 6 cells, the header 3; is the decimal sign a comma"):
        open_record_file(_write(tmp_path, commas, "time [s],position [mm],friction_force [N]"), "fit.csv")


OTHERWISE = {
    "other order": (["time [s];friction_force [N];position [mm]"], str, "row 22: .* is another header"),
    "other unit": (["time [s];position [um];friction_force [N]"], str, "row 22: .* is another header"),
    "second table": (["", "frequency [Hz];gain [dB];phase [deg]"], str, "row 23: .* is another header"),
    "decimal comma": ([], lambda row: row.replace(".", ","), "row 22, column 'time .*a point is required as decimal"),
    "groups": ([], lambda row: f"1,{row.replace('0.', '000.', 1)}", "row 22, column 'time .*if ',' groups thousands"),
    "lost column": ([], lambda row: row.rpartition(";")[0], "row 22: has 2 cells"),
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_rows_that_mean_something_else_than_those_above_are_refused(tmp_path, monkeypatch, name: str) -> None:
    """Not left out as text, and not read as if they were of the columns above."""
    monkeypatch.setattr(csv, "HEAD", 400)
    between, change, message = OTHERWISE[name]
    below = map(change, _plain()[20:])
    refused(message, _columns, _write(tmp_path, [*_plain()[:20], *between, *below]))


def test_repeated_headers_and_units_in_brackets(tmp_path: Path) -> None:
    rows = [*_plain()[:20], "\ufefftime [s];position [mm];friction_force [N]", *_plain()[20:]]
    np.testing.assert_allclose(_columns(_write(tmp_path, rows))[1], POSITION, atol=1e-4)
    rows = [f"{t:10.4f}{1e3 + x:12.4f}{f:10.4f}" for t, x, f in zip(TIME, POSITION, FORCE)]
    rows[7] = f"{TIME[7]:10.4f}{'*' * 12}{FORCE[7]:10.4f}"
    file = _write(tmp_path, rows, "    time  position   force\n     [s]      [mm]     [N]")
    assert open_record_file(file, file.name).header.units == {"time": "s", "position": "mm", "force": "N"}
    assert read_numbers(open_record_file(file, file.name)).missing == ("*" * 12,)


@pytest.mark.parametrize("name", GROUPED)
def test_a_column_whose_numbers_may_all_be_grouped_is_asked_for(tmp_path: Path, name: str) -> None:
    header, row, mark = GROUPED[name]
    rows = [(row or "{t:.2f};{x:,.0f};{f:.4f}").format(t=t, x=11e3 + x, f=f) for t, x, f in zip(TIME, POSITION, FORCE)]
    rows = [one.translate({44: ".", 46: ","}) for one in rows] if name == "de" else rows
    message = rf"'1\d\{mark}\d\d\d' is not a number; if '\{mark}' groups thousands: \[format\] thousands"
    refused(message, _columns, _write(tmp_path, rows, header))
    found = _columns(_write(tmp_path, rows, header), thousands=mark, decimal="," if name == "de" else ".")
    np.testing.assert_allclose(found[1], 11e3 + POSITION, atol=0.51)


def test_whole_numbers_with_points_between_groups_are_not_taken_for_fractions(tmp_path: Path) -> None:
    rows = [f"{900 + 10 * k:,};{1e3 + 9.0 * x:,.0f};{100.0 * f:.0f}" for k, (x, f) in enumerate(zip(POSITION, FORCE))]
    rows = [row.replace(",", ".") for row in rows]
    refused(r"'1.000': is the point a decimal sign, or does it group thousands", _columns, _write(tmp_path, rows))
    found = _columns(_write(tmp_path, rows), thousands=".", decimal=",")[0]
    assert np.array_equal(found, 900 + 10 * np.arange(ROWS))
    # Fractions of three digits, some with a zero before the point, and whole numbers in another column, are as written.
    rows = [f"{k};{0.9 + 0.01 * k:.3f};{1e2 * f:.0f}" for k, f in enumerate(FORCE)]
    np.testing.assert_allclose(_columns(_write(tmp_path, rows))[1], 0.9 + 0.01 * np.arange(ROWS))


def test_marks_of_gaps_are_proposed_and_other_reasons_said(tmp_path: Path) -> None:
    marks = ["", "#N/A", "", "-1.#IND", "", "OVER", "---", ">5.0", "E201", "OL", "1.#R"] + [""] * ROWS
    rows = [row.rpartition(";")[0] + f";{mark}" if mark else row for row, mark in zip(_plain(), marks)]
    rows = [f"{row};{hexadecimal:04X}h" for hexadecimal, row in enumerate(rows)]
    opened = open_record_file(_write(tmp_path, rows, "time [s];position [mm];friction_force [N];count"), "fit.csv")
    numbers = read_numbers(opened)
    assert numbers.missing == ("OVER", "---", ">5.0", "E201", "OL", "1.#R")
    assert np.isnan(numbers.columns[2][[1, 3, 5, 6, 7, 8, 9, 10]]).all() and np.isfinite(numbers.columns[2][11:]).all()
    proposal = propose(opened, numbers)
    assert [column.channel for column in proposal.columns] == ["time", "position", "friction_force", None]
    assert "text" in proposal.columns[3].reason or "hexadecimal" in proposal.columns[3].reason


UNITS = {
    "oz*in": "ozf*in", "oz-in": "ozf*in", "kgf*cm": "kgf*cm", "kg.cm": "kgf*cm", "turn": "rev", "rev/s": "rev/s",
    "ozin": "ozf*in", "inlb": "in*lbf", "kgcm": "kgf*cm", "kg·m": "kgf*m", "cNm": "cN*m", "Nmm": "N*mm", "NM": "N*m",
    "nm": "nm", "MM": "mm", "MN": "MN", "RPM": "rpm", "KN": "kN", "PSI": "psi", "SEC": "s", "min⁻¹": "min^-1",
    "A rms": "A", "Arms": "A", "deg C": "degC", "‰": "permille", "0.1 %": "permille", "incr.": "count", "revs": "rev",
    "Rpm": "rpm", "Umdr.": "rev", "grams-force": "gf", "dyne": "dyn", "S": "s", "°F": "°F", "Fahrenheit": "degF",
    '"': "in", "lbs": "lbf", "n": None, "M": None,
}  # fmt: skip


@pytest.mark.parametrize("form", ["mm:ss.fff", "H:MM:SS", "m:s"])
def test_the_form_of_a_time_is_no_unit_of_it(tmp_path: Path, form: str) -> None:
    rows = [f"{k // 60:02d}:{k % 60:02d}.500;{1e3 * x:.4f};{f:.4f}" for k, (x, f) in enumerate(zip(POSITION, FORCE))]
    rows = [f"0:{row}" if form == "H:MM:SS" else row for row in rows]
    found = _columns(_write(tmp_path, rows, f"time [{form}];position [mm];friction_force [N]"))
    np.testing.assert_allclose(found[0] - found[0][0], np.arange(ROWS))


def test_degrees_fahrenheit_have_another_zero() -> None:
    factor, offset = conversion("°F", "degC")
    assert factor * 68.0 + offset == pytest.approx(20.0) and parse_quantity("9 degF", "K") == pytest.approx(5.0)


def test_units_of_data_sheets_multiples_and_parts_of_rated_values(tmp_path: Path) -> None:
    assert {text: column_unit(text) for text in UNITS} == UNITS
    assert column_unit("kgf") == "kgf" and column_unit("rpm") == "rpm"
    labels = "time [10 ms];position [0.1 mm];load cell [kg]"
    rows = [f"{k};{10.0 * x:.4f};{f:.4f}" for k, (x, f) in enumerate(zip(POSITION, FORCE), start=100)]
    record = _made(tmp_path, rows, labels)
    np.testing.assert_allclose(record.time - record.time[0], TIME, atol=1e-9)
    np.testing.assert_allclose(record.channels["position"], 1e-3 * POSITION, atol=1e-7)
    np.testing.assert_allclose(record.channels["friction_force"], 9.80665 * FORCE, atol=1e-3)
    record = _made(tmp_path / "parts", rows, "t [s];angle [deg];torque [‰]", '"? N*m"', '"5 N*m"')
    np.testing.assert_allclose(record.channels["friction_force"], 5e-3 * FORCE, atol=1e-6)


COUNTED = {
    "time": {"s": 1.722e9, "ms": 1.722e12, "us": 1.722e15, "ns": 1.722e18, "day": 739_100.0},
    "Date": {"day": 45_000.25},
}


@pytest.mark.parametrize(("name", "unit"), [(name, unit) for name in COUNTED for unit in COUNTED[name]])
def test_a_time_from_a_known_origin_has_the_unit_that_its_size_shows(tmp_path: Path, name: str, unit: str) -> None:
    step = {"s": 0.01, "ms": 10.0, "us": 1e4, "ns": 1e7, "day": 0.01 / 86400.0}[unit]
    first = COUNTED[name][unit]
    stamps = [
        f"{first + k * step:.12f}" if unit in ("s", "day") else f"{int(first) + k * int(step)}" for k in range(ROWS)
    ]
    rows = [f"{stamp};{x:.4f};{f:.4f}" for stamp, x, f in zip(stamps, POSITION, FORCE)]
    file = _write(tmp_path, rows, f"{name};position [mm];force [N]")
    taken = new_experiment.propose([file]).computed.columns[0]
    assert (taken.channel, taken.unit) == ("time", unit) and "by its numbers" in taken.question


LABELS = {
    "Sollweg [mm];Istweg [mm]": "Istweg",
    "pos_cmd [mm];pos_act [mm]": "pos_act",
    "Position setpoint [mm];Position feedback [mm]": "Position feedback",
    "consigne position [mm];position mesurée [mm]": "position mesurée",
    "posRef [mm];posEnc [mm]": "posEnc",
    "riferimento posizione [mm];posizione reale [mm]": "posizione reale",
    "PCMD [mm];PFB [mm]": "PFB",
    "Position error [mm];Position [mm]": "Position",
    "Regelabweichung [mm];Weg [mm]": "Weg",
    "planned position [mm];position [mm]": "position",
}


@pytest.mark.parametrize("labels", LABELS)
@pytest.mark.parametrize("reverse", [False, True])
def test_the_measured_value_is_taken_not_the_setpoint(tmp_path: Path, labels: str, reverse: bool) -> None:
    pair = labels.split(";")[:: -1 if reverse else 1]
    rows = [f"{t:.2f};{x:.4f};{x + 0.01:.4f};{f:.4f}" for t, x, f in zip(TIME, POSITION, FORCE)]
    columns = _opened(tmp_path, rows, f"time [s];{';'.join(pair)};Load Cell (lbf)")[1]
    taken = {column.channel: column for column in columns if column.channel}
    assert taken["position"].label == f"{LABELS[labels]} [mm]"
    assert not re.search(r"or is column", taken["position"].question)
    assert taken["friction_force"].label == "Load Cell (lbf)"


PLAIN = {
    "x_d [mm];x [mm];F [N]": ("position", "x [mm]"),
    "Położenie zadane [mm];Położenie [mm];F [N]": ("position", "Położenie [mm]"),
    "Target [mm];Measured position [mm];Controller output [V]": ("displacement", "Measured position [mm]"),
}


@pytest.mark.parametrize("labels", PLAIN)
def test_the_plain_or_measured_one_of_alike_columns_is_taken(tmp_path: Path, labels: str) -> None:
    rows = [f"{t:.2f};{x + 0.01:.4f};{x:.4f};{f:.4f}" for t, x, f in zip(TIME, POSITION, FORCE)]
    taken = {column.channel: column.label for column in _opened(tmp_path, rows, f"time [s];{labels}")[1]}
    channel, label = PLAIN[labels]
    assert taken[channel] == label


def test_many_unnamed_columns_end_in_seconds(tmp_path: Path) -> None:
    """Each column is compared with the derivative of each other one, also where 300 have no name."""
    waves = np.sin(np.outer(TIME, np.arange(1.0, 301.0)))
    waves[:, 1] = np.gradient(waves[:, 0], TIME)
    rows = [";".join([f"{t:.2f}", *(f"{x:.6f}" for x in row)]) for t, row in zip(TIME, waves)]
    opened = open_record_file(_write(tmp_path, rows, "time [s];" + ";".join(f"a{k}" for k in range(300))), "fit.csv")
    begun = process_time()
    taken = {column.channel: column.label for column in propose(opened, read_numbers(opened)).columns if column.channel}
    assert taken["position"] == "a0" and taken["velocity"] == "a1" and process_time() - begun < 10.0


FRACTIONS = {
    "Date;Time;Millisecond": ("%d.%m.%Y;%H:%M:%S", 1000),
    "Time;ms": ("%H:%M:%S", 1000),
    "sec;nanosec": ("%s", 1),
}


@pytest.mark.parametrize("labels", FRACTIONS)
def test_the_fraction_of_a_second_in_a_column_of_its_own(tmp_path: Path, labels: str) -> None:
    form, size = FRACTIONS[labels]
    stamps = [datetime(2024, 7, 30, 11, 59, 59, 800_000) + timedelta(seconds=t) for t in TIME.tolist()]
    parts = [at.microsecond // 1000 if size > 1 else 1000 * at.microsecond for at in stamps]
    rows = [f"{at.strftime(form)};{p};{x:.4f};{f:.4f}" for at, p, x, f in zip(stamps, parts, POSITION, FORCE)]
    record = _made(tmp_path, rows, f"{labels};position [mm];force [N]")
    np.testing.assert_allclose(record.time - record.time[0], TIME, atol=1e-9)
