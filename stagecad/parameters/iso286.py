"""ISO 286 tolerance classes of holes and shafts: limit deviations by nominal size.

Source: ISO 286-1:2010, tables 1 (standard tolerance grades) and 2 to 7 (fundamental deviations); letters D to H, JS for
holes, d to h, js for shafts; grades 5 to 11; sizes up to 250 mm.
"""

from __future__ import annotations

import re

UP_TO = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250)
"""Largest size of each range, mm."""

GRADES: dict[int, tuple[int, ...]] = {
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290),
}
"""Width of the tolerance interval by grade and range, um."""

FUNDAMENTAL: dict[str, tuple[int, ...]] = {
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15),
    "h": (0,) * 10,
}
"""Distance of the tolerance interval from the nominal size by letter and range, um: below it for shafts, above for
holes."""

_CLASS = re.compile(r"(js|[d-h]|JS|[D-H])(5|6|7|8|9|10|11)")


def is_class(text: str) -> bool:
    """Whether a text is a tolerance class of this table: `H7`, `g6`, `js9`."""
    return _CLASS.fullmatch(text) is not None


def in_range(size: float) -> bool:
    """Whether the table has the nominal size, mm."""
    return 0.0 < size <= UP_TO[-1]


def deviations(size: float, tolerance_class: str) -> tuple[float, float]:
    """Lower and upper limit deviation of a tolerance class, mm.

    Args:
        size: nominal size, mm, up to 250.
        tolerance_class: `H7`.
    """
    match = _CLASS.fullmatch(tolerance_class)
    if match is None or not in_range(size):
        raise ValueError(f"no tolerance class {tolerance_class} for {size:g} mm")
    letter, grade = match[1], int(match[2])
    column = next(number for number, largest in enumerate(UP_TO) if size <= largest)
    width = GRADES[grade][column] / 1000
    if letter.lower() == "js":
        return -width / 2, width / 2
    away = FUNDAMENTAL[letter.lower()][column] / 1000
    low, high = (away, away + width) if letter.isupper() else (-away - width, -away)
    return low + 0.0, high + 0.0
