"""ISO 286 tolerance classes of holes and shafts: limit deviations by nominal size.

Source: ISO 286-1:2010, tables 1 (standard tolerance grades) and 2 to 5 (fundamental deviations), in `iso286.toml`;
letters D to ZC for holes, d to zc for shafts; grades 5 to 13; sizes up to 250 mm. The deviations of holes from K on
follow from those of shafts by the rules of clause 4.3.2.5: with the difference of the grade from the next finer one up
to grade 8 (K, M, N) or 7 (P to ZC).
"""

import re
import tomllib
from pathlib import Path

Row = tuple[int, ...]

_TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
UP_TO, FINE_UP_TO = tuple(_TABLES["up_to"]), tuple(_TABLES["fine_up_to"])
"""Largest size of each range, mm; and of each of the ranges that the letters from r on need."""
GRADES: dict[int, Row] = {int(grade): tuple(row) for grade, row in _TABLES["grades"].items()}
"""Width of the tolerance interval by grade and range, um."""
CLEARANCE: dict[str, Row] = _TABLES["clearance"]
"""Distance of the tolerance interval from the nominal size by letter and range, um: below it for shafts, above for
holes."""
INTERFERENCE: dict[str, tuple[int | None, ...]] = {
    letter: (*[None] * (len(FINE_UP_TO) - len(row)), *row) for letter, row in _TABLES["interference"].items()
}
"""Lower deviation of shafts by letter and finer range, um; None where the standard has none."""

_LETTERS = "ef|fg|js|za|zb|zc|[defghjkmnprstuvxyz]"
_CLASS = re.compile(rf"({_LETTERS}|{_LETTERS.upper()})(5|6|7|8|9|1[0-3])")


def is_class(text: str) -> bool:
    """Whether a text is a tolerance class of this table: `H7`, `g6`, `js9`, `k6`, `P7`."""
    return _CLASS.fullmatch(text) is not None


def in_range(size: float) -> bool:
    """Whether the table has the nominal size, mm."""
    return 0.0 < size <= UP_TO[-1]


def deviations(size: float, tolerance_class: str) -> tuple[float, float]:
    """Lower and upper limit deviation of a tolerance class, mm.

    Args:
        size: nominal size, mm, up to 250.
        tolerance_class: `H7`.

    Raises:
        ValueError: the class or the size is not in the table.
    """
    match = _CLASS.fullmatch(tolerance_class)
    if match is None or not in_range(size):
        raise ValueError(f"no tolerance class {tolerance_class} for {size:g} mm")
    letter, grade = match[1], int(match[2])
    column = next(number for number, largest in enumerate(UP_TO) if size <= largest)
    width = GRADES[grade][column]
    if letter.lower() == "js":
        return -width / 2000, width / 2000
    if letter.lower() in CLEARANCE:
        row = CLEARANCE[letter.lower()]
        if column >= len(row):
            raise ValueError(f"no tolerance class {tolerance_class} for {size:g} mm")
        low = row[column] if letter.isupper() else -row[column] - width
    else:
        low = (
            _low_of_hole(size, letter, grade, column)
            if letter.isupper()
            else _low_of_shaft(size, letter, grade, column)
        )
        if low is None:
            raise ValueError(f"no tolerance class {tolerance_class} for {size:g} mm")
    return low / 1000 + 0.0, (low + width) / 1000 + 0.0


def _of_j(table: str, grade: int, column: int) -> int | None:
    """Deviation of j or J, um; None where the standard has none."""
    row = _TABLES[table].get(str(grade))
    return None if row is None else row[column]


def _low_of_shaft(size: float, letter: str, grade: int, column: int) -> int | None:
    """Lower deviation of a shaft from j to zc, um; None where the standard has none."""
    if letter == "j":
        return _of_j("j_shaft", grade, column)
    if letter == "k" and grade > 7:
        return 0
    if letter in _TABLES["transition"]:
        return _TABLES["transition"][letter][column]
    return INTERFERENCE[letter][next(number for number, largest in enumerate(FINE_UP_TO) if size <= largest)]


def _low_of_hole(size: float, letter: str, grade: int, column: int) -> int | None:
    """Lower deviation of a hole from J to ZC, um; None where the standard has none."""
    width = GRADES[grade][column]
    if letter == "J":
        high = _of_j("j_hole", grade, column)
        return None if high is None else high - width
    small = column == 0
    if letter == "N" and grade > 8:
        return (-4 if small else 0) - width
    if letter == "K" and grade > 8:
        return -width if small else None
    away = _low_of_shaft(size, letter.lower(), 7 if letter == "K" else grade, column)
    if away is None:
        return None
    finest = 8 if letter in "KMN" else 7
    step = width - GRADES[grade - 1][column] if grade <= finest and not small else 0
    return -away + step - width
