"""Files in every combination of a logger's habits: each is read right, or refused with the place and the reason.

The table in docs/records.md is made by `python -m tests.sysid.experiment.readers.test_dialect_combinations`.
"""

import os
import random
import re
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stagecad.parameters.errors import InputError
from sysid.experiment.channels import parse_label
from sysid.experiment.column_settings import column_unit
from sysid.experiment.readers.base import Format
from sysid.experiment.readers.open import open_record_file

ROWS = 30
START = datetime(2024, 7, 30, 11, 59, 59, 800_000)
TIMES = {
    "seconds": lambda t, d: f"{t:.3f}".replace(".", d),
    "milliseconds": lambda t, d: f"{1e3 * t:.0f}",
    "ISO 8601": lambda t, d: (START + timedelta(seconds=t)).isoformat(timespec="microseconds"),
    "day.month.year": lambda t, d: (START + timedelta(seconds=t)).strftime("%d.%m.%Y %H:%M:%S.%f"),
    "24-hour clock": lambda t, d: (START + timedelta(seconds=t)).strftime("%H:%M:%S.%f").replace(".", d),
    "12-hour clock": lambda t, d: (START + timedelta(seconds=t)).strftime("%I:%M:%S.%f %p"),
    "date and time apart": lambda t, d: (START + timedelta(seconds=t)).strftime("%d.%m.%Y@%H:%M:%S.%f"),
    "month/day/year": lambda t, d: (START + timedelta(seconds=t)).strftime("%m/%d/%Y %I:%M:%S.%f %p"),
    "minutes": lambda t, d: f"{int((59.8 + t) // 60)}:{(59.8 + t) % 60:06.3f}".replace(".", d),
}
LABELS = ("[{}]", "({})", "/{}", "in {}", "units below", "in the cells")
GAPS = ("", "NaN", "#N/A", "-1.#IND", "null", "OVER", "---")
ENDS = ("none", "cut off", "text", "blank lines", "comment", "statistics")
BEYOND = ("nothing", "text", "number")
SIGNS = {"hyphen": "-", "U+2212": "−", "en dash": "–"}


@dataclass(frozen=True)
class Habit:
    """How a logger writes its files."""

    delimiter: str
    decimal: str
    thousands: str
    exponent: str
    sign: str
    quoted: bool
    label: str
    time: str
    gap: str
    end: str
    beyond: str
    above: int
    encoding: str
    line_end: str

    @property
    def possible(self) -> bool:
        """Whether the file can have one meaning: its marks do not stand for two things."""
        text = TIMES[self.time](0.0, self.decimal).replace("@", "")
        apart = self.decimal != self.delimiter or self.quoted
        groups = self.thousands not in (self.decimal, *(() if self.quoted else (self.delimiter,)))
        labelled = self.label in ("[{}]", "({})") and self.gap != "" and self.thousands != " "
        blanks = self.delimiter != " " or (" " not in text and labelled)
        signs = all(sign.encode(self.encoding, "ignore") for sign in (self.sign, self.thousands or "-"))
        numbers = not (self.exponent and self.thousands) and not (self.hexadecimal and self.label == "in the cells")
        return apart and groups and blanks and signs and numbers

    @property
    def hexadecimal(self) -> bool:
        """Whether counts are written in hexadecimal digits."""
        return self.exponent == "hexadecimal"

    @property
    def readable(self) -> bool:
        """Whether the meaning of the file can be known: else it is to be refused."""
        return not self.hexadecimal and self.beyond != "number"


def truth(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (n,) in s, position (n,) in mm and force (n,) in N."""
    rng = np.random.default_rng(seed)
    time = np.arange(ROWS) * 0.01
    return time, np.round(2500.0 * np.sin(9.0 * time + rng.uniform(0, 6)), 3), np.round(rng.normal(0.0, 3.0, ROWS), 4)


def number(value: float, digits: int, habit: Habit) -> str:
    if habit.hexadecimal:
        return hex(round(abs(1000.0 * value)))
    if habit.exponent:
        text = f"{value:.6e}".replace("e", habit.exponent).replace(".", habit.decimal)
    else:
        groups = "," if habit.thousands else ""
        text = f"{value:{groups}.{digits}f}"
        text = text.replace(",", "\0").replace(".", habit.decimal).replace("\0", habit.thousands)
    return text.replace("-", habit.sign, 1) if text.startswith("-") else text


def written(habit: Habit, seed: int) -> bytes:
    time, position, force = truth(seed)
    units = ("ms" if habit.time == "milliseconds" else "s", "mm", "N")
    stamped = habit.time not in ("seconds", "milliseconds")
    names = ["Date@time" if "@" in TIMES[habit.time](0.0, ".") else "time", "position", "friction_force"]
    labels = names if habit.label in ("units below", "in the cells") else [
        name if stamped and k == 0 else f"{name} {habit.label.format(units[k])}" for k, name in enumerate(names)
    ]  # fmt: skip
    behind = " " + "{}" if habit.label == "in the cells" else ""

    def line(cells: list[str], beyond: bool = False) -> str:
        cells = [part for cell in cells for part in cell.split("@")]
        cells += {"nothing": [], "text": ["ok"], "number": ["17"]}[habit.beyond] if beyond else []
        return habit.delimiter.join(f'"{cell}"' if habit.quoted else cell for cell in cells)

    lines = [f"Logger 3000, file {k + 1}" for k in range(habit.above)] + [line(list(labels))]
    if habit.label == "units below":
        lines.append(line(["@" * ("@" in names[0]) if stamped else units[0], *units[1:]]))
    for k in range(ROWS):
        at = TIMES[habit.time](float(time[k]), habit.decimal)
        at = at + behind.format(units[0]) if behind and not stamped else at
        cells = [number(position[k], 3, habit) + behind.format("mm"), number(force[k], 4, habit) + behind.format("N")]
        cells[1] = habit.gap if k in (7, 19) else cells[1]
        lines.append(line([at, *cells], beyond=True))
    lines += {
        "none": [],
        "cut off": [line(["0" + habit.decimal + "30"])],
        "text": ["", "End of measurement"],
        "blank lines": ["", ""],
        "comment": ["# stopped by the operator"],
        "statistics": [line(["Mean", number(1.5, 3, habit), number(0.5, 4, habit)])],
    }[habit.end]
    return habit.line_end.join([*lines, ""]).encode(habit.encoding, "replace")


def outcome(folder: Path, habit: Habit, seed: int) -> str:
    """`read`, `read with a setting` that the reason names, or `refused`.

    AssertionError where something wrong is read, no reason is given, or a file is refused that has one meaning.
    """
    file = folder / "fit.csv"
    file.write_bytes(written(habit, seed))
    apart = int("@" in TIMES[habit.time](0.0, "."))
    settings, result = Format(), "read"
    while True:
        try:
            opened = open_record_file(file, "fit.csv", settings)
            if len(opened.header.labels) < apart + 3 and not habit.readable:
                return "refused"
            columns = opened.columns([apart, apart + 1, apart + 2])
            break
        except InputError as error:
            reason = str(error)
            assert "\n" not in reason and reason.startswith("fit.csv")
            assert any(word in reason for word in ("row ", "[format]", "column '")), reason
            named = re.search(r'\[format\] missing = \["(.*)"\]', reason)
            if named is None or named[1] not in ("OVER", "---") or settings.missing:
                assert not habit.readable, reason
                return "refused"
            settings, result = Format(missing=(named[1],)), "read with a setting"
    assert habit.readable
    time, position, force = truth(seed)
    factors = []
    for label, wanted in zip(opened.header.labels[apart : apart + 3], ("s", "mm", "N"), strict=True):
        unit = opened.header.units.get(label) or parse_label(0, label).unit
        assert unit is not None and column_unit(unit) is not None, label
        factors.append(1e-3 if column_unit(unit) == "ms" else 1.0)
        assert column_unit(unit) in (wanted, "ms")
    assert columns[0].values.size == ROWS, columns[0].notes
    np.testing.assert_allclose((columns[0].values - columns[0].values[0]) * factors[0], time, atol=1e-6)
    np.testing.assert_allclose(columns[1].values, position, rtol=1e-6, atol=1e-3)
    gaps = np.isin(np.arange(ROWS), (7, 19))
    assert np.isnan(columns[2].values[gaps]).all()
    np.testing.assert_allclose(columns[2].values[~gaps], force[~gaps], rtol=1e-6, atol=1e-4)
    return result


HABITS = st.builds(
    Habit,
    delimiter=st.sampled_from([",", ";", "\t", "|", " "]),
    decimal=st.sampled_from([".", ","]),
    thousands=st.sampled_from(["", "", "", ",", ".", "'", " ", "\u00a0", "\u202f"]),
    exponent=st.sampled_from([*["", "", "e", "E", "D", "d"] * 2, "hexadecimal"]),
    sign=st.sampled_from(list(SIGNS.values())),
    quoted=st.booleans(),
    label=st.sampled_from(LABELS),
    time=st.sampled_from(list(TIMES)),
    gap=st.sampled_from(GAPS),
    end=st.sampled_from(ENDS),
    beyond=st.sampled_from([*BEYOND[:2] * 4, "number"]),
    above=st.integers(0, 3),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
    line_end=st.sampled_from(["\n", "\r\n", "\r"]),
).filter(lambda habit: habit.possible)

SHARE = float(os.environ.get("STAGECAD_ROBUSTNESS", "1"))
FEW = settings(suppress_health_check=list(HealthCheck), derandomize=True)


@settings(FEW, max_examples=300)
@given(habit=HABITS, seed=st.integers(0, 10_000))
def test_a_file_is_read_right_or_refused_with_a_reason(folder: Path, habit: Habit, seed: int) -> None:
    """Protects habits of loggers together; the tests of dialects and spellings try one at a time."""
    assert outcome(folder, habit, seed)


@pytest.mark.slow
@settings(FEW, max_examples=max(int(50_000 * SHARE), 100))
@given(habit=HABITS, seed=st.integers(0, 10_000))
def test_fifty_thousand_combinations(folder: Path, habit: Habit, seed: int) -> None:
    assert outcome(folder, habit, seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("dialects")


PAGE = Path(__file__).parents[4] / "docs" / "records.md"


@pytest.mark.slow
def test_the_table_of_the_documentation_is_the_one_made_here() -> None:
    assert table() in PAGE.read_text(encoding="utf-8")


def test_the_table_of_the_documentation_names_every_habit() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name in (*TIMES, *SIGNS, *ENDS, *BEYOND):
        assert f"| {name} |" in page, name


def table(count: int = 2000) -> str:
    """Rows for docs/records.md: what becomes of the files with a habit, of `count` random combinations."""
    random_, marks = random.Random(1), {"none": "", "comma": ",", "point": ".", "apostrophe": "'", "blank": " "}
    choices = {
        "delimiter": {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "blanks": " "},
        "decimal": {"point": ".", "comma": ","},
        "thousands": {**marks, "narrow blank": "\u202f"},
        "exponent": {"none": "", "E": "E", "Fortran D": "D", "hexadecimal": "hexadecimal"},
        "sign": SIGNS,
        "quoted": {"no": False, "yes": True},
        "label": {label: label for label in LABELS},
        "time": {time: time for time in TIMES},
        "gap": {gap or "empty": gap for gap in GAPS},
        "end": {end: end for end in ENDS},
        "beyond": {cell: cell for cell in BEYOND},
        "above": {"no line": 0, "two lines": 2},
        "encoding": {name: name for name in ("utf-8", "utf-8-sig", "utf-16", "cp1252")},
        "line_end": {"LF": "\n", "CRLF": "\r\n", "CR": "\r"},
    }
    tried: Counter[tuple[str, str]] = Counter()
    became: Counter[tuple[tuple[str, str], str]] = Counter()
    with tempfile.TemporaryDirectory() as name:
        while tried["all", "all"] < count:
            drawn = {}
            for key, values in choices.items():
                weights = [0.05 if word in ("hexadecimal", "number") else 1 for word in values]
                drawn[key] = random_.choices([*values], weights)[0]
            habit = Habit(**{key: choices[key][word] for key, word in drawn.items()})
            if habit.possible:
                result = outcome(Path(name), habit, random_.randrange(10_000))
                for entry in (("all", "all"), *drawn.items()):
                    tried[entry] += 1
                    became[entry, result] += 1
    results = ("read", "read with a setting", "refused")
    lines = [f"| habit | value | {' | '.join(results)} | of |", "| --- | --- | --- | --- | --- | --- |"]
    for key, word in (("all", "all"), *((key, word) for key, values in choices.items() for word in values)):
        shown = word.replace("|", "\\|")
        counts = " | ".join(str(became[(key, word), result]) for result in results)
        lines.append(f"| {key.replace('_', ' ')} | {shown} | {counts} | {tried[key, word]} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.stdout.write(table() + "\n")
