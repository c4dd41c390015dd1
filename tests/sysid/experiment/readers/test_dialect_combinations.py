"""Files in every combination of a logger's habits: each is read right, or refused with the place and the reason.

The table in docs/records.md is made by `python -m tests.sysid.experiment.readers.test_dialect_combinations`.
"""

import os
import random
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
from sysid.experiment.columns.units import column_unit
from sysid.experiment.readers.format import Format
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
    "minutes": lambda t, d: f"{int((59.8 + t) // 60)}:{(59.8 + t) % 60:06.3f}".replace(".", d),
}
LABELS = ("[{}]", "({})", "/{}", "in {}", "units below", "in the cells")
GAPS = ("", "NaN", "#N/A", "-1.#IND", "null", "OVER", "---")
ENDS = ("none", "cut off", "text", "blank lines", "comment")
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
    above: int
    encoding: str
    line_end: str

    @property
    def possible(self) -> bool:
        """Whether the file can have one meaning: its marks do not stand for two things."""
        text = TIMES[self.time](0.0, self.decimal)
        apart = self.decimal != self.delimiter or self.quoted
        groups = self.thousands not in (self.decimal, *(() if self.quoted else (self.delimiter,)))
        blanks = self.delimiter != " " or (
            " " not in text and self.label in ("[{}]", "({})") and self.gap != "" and self.thousands != " "
        )
        signs = all(sign.encode(self.encoding, "ignore") for sign in (self.sign, self.thousands or "-"))
        return apart and groups and blanks and signs and not (self.exponent and self.thousands)


def truth(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (n,) in s, position (n,) in mm and force (n,) in N."""
    rng = np.random.default_rng(seed)
    time = np.arange(ROWS) * 0.01
    return time, np.round(2500.0 * np.sin(9.0 * time + rng.uniform(0, 6)), 3), np.round(rng.normal(0.0, 3.0, ROWS), 4)


def number(value: float, digits: int, habit: Habit) -> str:
    """A number as the logger writes it."""
    if habit.exponent:
        text = f"{value:.6e}".replace("e", habit.exponent).replace(".", habit.decimal)
    else:
        groups = "," if habit.thousands else ""
        text = f"{value:{groups}.{digits}f}"
        text = text.replace(",", "\0").replace(".", habit.decimal).replace("\0", habit.thousands)
    return text.replace("-", habit.sign, 1) if text.startswith("-") else text


def written(habit: Habit, seed: int) -> bytes:
    """A file of the logger."""
    time, position, force = truth(seed)
    units = ("ms" if habit.time == "milliseconds" else "s", "mm", "N")
    stamped = habit.time not in ("seconds", "milliseconds")
    names = ["time", "position", "friction_force"]
    labels = names if habit.label in ("units below", "in the cells") else [
        name if stamped and name == "time" else f"{name} {habit.label.format(unit)}" for name, unit in zip(names, units)
    ]  # fmt: skip
    behind = " " + "{}" if habit.label == "in the cells" else ""

    def line(cells: list[str]) -> str:
        return habit.delimiter.join(f'"{cell}"' if habit.quoted else cell for cell in cells)

    lines = [f"Logger 3000, file {k + 1}" for k in range(habit.above)] + [line(list(labels))]
    if habit.label == "units below":
        lines.append(line(["" if stamped else units[0], *units[1:]]))
    for k in range(ROWS):
        at = TIMES[habit.time](float(time[k]), habit.decimal)
        at = at + behind.format(units[0]) if behind and not stamped else at
        cells = [number(position[k], 3, habit) + behind.format("mm"), number(force[k], 4, habit) + behind.format("N")]
        cells[1] = habit.gap if k in (7, 19) else cells[1]
        lines.append(line([at, *cells]))
    lines += {
        "none": [],
        "cut off": [line(["0" + habit.decimal + "30"])],
        "text": ["", "End of measurement"],
        "blank lines": ["", ""],
        "comment": ["# stopped by the operator"],
    }[habit.end]
    return habit.line_end.join([*lines, ""]).encode(habit.encoding, "replace")


def outcome(folder: Path, habit: Habit, seed: int) -> str:
    """`read`, or `refused: REASON`; AssertionError where something wrong is read, or no reason is given."""
    file = folder / "fit.csv"
    file.write_bytes(written(habit, seed))
    missing = tuple(gap for gap in ("OVER", "---") if gap == habit.gap)
    try:
        opened = open_record_file(file, "fit.csv", Format(missing=missing))
        columns = opened.columns([0, 1, 2])
    except InputError as error:
        reason = str(error)
        assert "\n" not in reason and reason.startswith("fit.csv")
        assert any(word in reason for word in ("row ", "[format]", "column '")), reason
        return f"refused: {reason}"
    time, position, force = truth(seed)
    factors = []
    for label, wanted in zip(opened.header.labels, ("s", "mm", "N"), strict=True):
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
    return "read"


HABITS = st.builds(
    Habit,
    delimiter=st.sampled_from([",", ";", "\t", "|", " "]),
    decimal=st.sampled_from([".", ","]),
    thousands=st.sampled_from(["", "", "", ",", ".", "'", " ", "\u00a0", "\u202f"]),
    exponent=st.sampled_from(["", "", "e", "E", "D", "d"]),
    sign=st.sampled_from(list(SIGNS.values())),
    quoted=st.booleans(),
    label=st.sampled_from(LABELS),
    time=st.sampled_from(list(TIMES)),
    gap=st.sampled_from(GAPS),
    end=st.sampled_from(ENDS),
    above=st.integers(0, 3),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
    line_end=st.sampled_from(["\n", "\r\n", "\r"]),
).filter(lambda habit: habit.possible)

SHARE = float(os.environ.get("STAGECAD_ROBUSTNESS", "1"))
FEW = settings(deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)


@settings(FEW, max_examples=300)
@given(habit=HABITS, seed=st.integers(0, 10_000))
def test_a_file_is_read_right_or_refused_with_a_reason(folder: Path, habit: Habit, seed: int) -> None:
    assert outcome(folder, habit, seed)


@pytest.mark.slow
@settings(FEW, max_examples=max(int(50_000 * SHARE), 100))
@given(habit=HABITS, seed=st.integers(0, 10_000))
def test_fifty_thousand_combinations(folder: Path, habit: Habit, seed: int) -> None:
    assert outcome(folder, habit, seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("dialects")


def test_the_table_of_the_documentation_names_every_habit() -> None:
    page = (Path(__file__).parents[4] / "docs" / "records.md").read_text(encoding="utf-8")
    for name in (*TIMES, *SIGNS, *ENDS):
        assert f"| {name} |" in page, name


def table(count: int = 2000) -> str:
    """Rows for docs/records.md: how many of the files with a habit were read, of `count` random combinations."""
    random_ = random.Random(1)
    choices = {
        "delimiter": {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "blanks": " "},
        "decimal": {"point": ".", "comma": ","},
        "thousands": {
            "none": "",
            "comma": ",",
            "point": ".",
            "apostrophe": "'",
            "blank": " ",
            "narrow blank": "\u202f",
        },
        "exponent": {"none": "", "E": "E", "Fortran D": "D"},
        "sign": SIGNS,
        "quoted": {"no": False, "yes": True},
        "label": {label: label for label in LABELS},
        "time": {time: time for time in TIMES},
        "gap": {gap or "empty": gap for gap in GAPS},
        "end": {end: end for end in ENDS},
        "above": {"no line": 0, "two lines": 2},
        "encoding": {name: name for name in ("utf-8", "utf-8-sig", "utf-16", "cp1252")},
        "line_end": {"LF": "\n", "CRLF": "\r\n", "CR": "\r"},
    }
    read: Counter[tuple[str, str]] = Counter()
    tried: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as name:
        while tried["all", "all"] < count:
            drawn = {key: random_.choice(list(values)) for key, values in choices.items()}
            habit = Habit(**{key: choices[key][word] for key, word in drawn.items()})
            if habit.possible:
                good = outcome(Path(name), habit, random_.randrange(10_000)) == "read"
                for entry in (("all", "all"), *drawn.items()):
                    tried[entry] += 1
                    read[entry] += good
    lines = ["| habit | value | read | of |", "| --- | --- | --- | --- |"]
    for key, word in (("all", "all"), *((key, word) for key, values in choices.items() for word in values)):
        shown = word.replace("|", "\\|")
        lines.append(f"| {key.replace('_', ' ')} | {shown} | {read[key, word]} | {tried[key, word]} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.stdout.write(table() + "\n")
