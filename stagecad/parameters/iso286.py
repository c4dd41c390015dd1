"""ISO 286 tolerance classes of holes and shafts: limit deviations by nominal size.

Source: ISO 286-1:2010, tables 1 (standard tolerance grades) and 2 to 5 (fundamental deviations); letters D to ZC for
holes, d to zc for shafts; grades 5 to 13; sizes up to 250 mm. The deviations of holes from K on follow from those of
shafts by the rules of clause 4.3.2.5: with the difference of the grade from the next finer one up to grade 8 (K, M, N)
or 7 (P to ZC).
"""

import re

UP_TO = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250)
"""Largest size of each range, mm."""
FINE_UP_TO = (3, 6, 10, 14, 18, 24, 30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250)
"""Largest size of each of the ranges that the letters from r on need, mm."""

GRADES: dict[int, tuple[int, ...]] = {
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460),
    13: (140, 180, 220, 270, 330, 390, 460, 540, 630, 720),
}
"""Width of the tolerance interval by grade and range, um."""

CLEARANCE: dict[str, tuple[int, ...]] = {
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100),
    "ef": (10, 14, 18, 23, 28, 35),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50),
    "fg": (4, 6, 8, 10, 12, 15),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15),
    "h": (0,) * 10,
}
"""Distance of the tolerance interval from the nominal size by letter and range, um: below it for shafts, above for
holes."""

TRANSITION: dict[str, tuple[int, ...]] = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50),
}
"""Lower deviation of shafts by letter and range, um; of k in grades 4 to 7."""

INTERFERENCE: dict[str, tuple[int | None, ...]] = {
    "r": (10, 15, 19, 23, 23, 28, 28, 34, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84),
    "s": (14, 19, 23, 28, 28, 35, 35, 43, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140),
    "t": (None,) * 6 + (41, 48, 54, 66, 75, 91, 104, 122, 134, 146, 166, 180, 196),
    "u": (18, 23, 28, 33, 33, 41, 48, 60, 70, 87, 102, 124, 144, 170, 190, 210, 236, 258, 284),
    "v": (None,) * 4 + (39, 47, 55, 68, 81, 102, 120, 146, 172, 202, 228, 252, 284, 310, 340),
    "x": (20, 28, 34, 40, 45, 54, 64, 80, 97, 122, 146, 178, 210, 248, 280, 310, 350, 385, 425),
    "y": (None,) * 5 + (63, 75, 94, 114, 144, 174, 214, 254, 300, 340, 380, 425, 470, 520),
    "z": (26, 35, 42, 50, 60, 73, 88, 112, 136, 172, 210, 258, 310, 365, 415, 465, 520, 575, 640),
    "za": (32, 42, 52, 64, 77, 98, 118, 148, 180, 226, 274, 335, 400, 470, 535, 600, 670, 740, 820),
    "zb": (40, 50, 67, 90, 108, 136, 160, 200, 242, 300, 360, 445, 525, 620, 700, 780, 880, 960, 1050),
    "zc": (60, 80, 97, 130, 150, 188, 218, 274, 325, 405, 480, 585, 690, 800, 900, 1000, 1150, 1250, 1350),
}
"""Lower deviation of shafts by letter and finer range, um; None where the standard has none."""

J_SHAFT = {
    5: (-2, -2, -2, -3, -4, -5, -7, -9, -11, -13),
    6: (-2, -2, -2, -3, -4, -5, -7, -9, -11, -13),
    7: (-4, -4, -5, -6, -8, -10, -12, -15, -18, -21),
}
"""Lower deviation of j by grade and range, um."""
J_HOLE = {
    6: (2, 5, 5, 6, 8, 10, 13, 16, 18, 22),
    7: (4, 6, 8, 10, 12, 14, 18, 22, 26, 30),
    8: (6, 10, 12, 15, 20, 24, 28, 34, 41, 47),
}
"""Upper deviation of J by grade and range, um."""

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


def _low_of_shaft(size: float, letter: str, grade: int, column: int) -> int | None:
    """Lower deviation of a shaft from j to zc, um; None where the standard has none."""
    if letter == "j":
        return J_SHAFT[grade][column] if grade in J_SHAFT else None
    if letter == "k" and grade > 7:
        return 0
    if letter in TRANSITION:
        return TRANSITION[letter][column]
    return INTERFERENCE[letter][next(number for number, largest in enumerate(FINE_UP_TO) if size <= largest)]


def _low_of_hole(size: float, letter: str, grade: int, column: int) -> int | None:
    """Lower deviation of a hole from J to ZC, um; None where the standard has none."""
    width = GRADES[grade][column]
    if letter == "J":
        return J_HOLE[grade][column] - width if grade in J_HOLE else None
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
