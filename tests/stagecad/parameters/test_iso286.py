"""Limit deviations of ISO 286-2, and their use as tolerance classes in a parameter file."""

import math
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.iso286 import FINE_UP_TO, GRADES, INTERFERENCE, UP_TO, deviations, is_class
from stagecad.parameters.load import design_from_text, load_design
from tests.reference.tables import cases


@pytest.mark.parametrize(
    ("size", "tolerance", "low", "high"),
    # ISO 286-2:2010, tables 5, 6, 8 and 17 to 21, um.
    cases("iso286", "deviations"),
)
def test_deviations_are_those_of_the_standard(size: float, tolerance: str, low: float, high: float) -> None:
    assert deviations(size, tolerance) == pytest.approx((low / 1000, high / 1000), abs=1e-9)


TRANSCRIPT = tomllib.loads((Path(__file__).parents[2] / "reference" / "iso286_transcript.toml").read_text())


def test_an_independent_transcript_of_the_tables_has_the_same_numbers() -> None:
    def agree(sizes: list[float], letter: str, grade: int, expected: list[float], end: int, sign: int = 1) -> int:
        known = [(size, value) for size, value in zip(sizes, expected, strict=True) if not math.isnan(value)]
        for size, value in known:
            found = deviations(size, f"{letter}{grade}")[end] * 1000
            assert found == pytest.approx(sign * value, abs=1e-6), (size, letter, grade)
        return len(known)

    ranges, fine = TRANSCRIPT["ranges"], TRANSCRIPT["fine_ranges"]
    count = 0
    for grade, row in TRANSCRIPT["grades"].items():
        count += agree(ranges, "H", int(grade), row, 1) + agree(ranges, "h", int(grade), row, 0, -1)
        for letter, above in TRANSCRIPT["holes_above"].items():
            count += agree(ranges, letter, int(grade), above, 0)
            count += agree(ranges, letter.lower(), int(grade), above, 1, -1)
        for letter, above in TRANSCRIPT["shafts_above"].items():
            if letter != "k" or int(grade) < 8:
                count += agree(fine, letter, int(grade), above, 0)
            # The rules of clause 4.3.2.5 hold from grade 9 (M) or 8 (P to ZC) on: a hole mirrors the shaft.
            if letter not in "kn" and int(grade) > (8 if letter == "m" else 7):
                count += agree(fine, letter.upper(), int(grade), above, 1, -1)
    for letter, table, end in (("j", "j_shafts", 0), ("J", "j_holes", 1)):
        for grade, row in TRANSCRIPT[table].items():
            count += agree(ranges, letter, int(grade), row, end)
    assert count > 4000


def _middle(low: float, high: float) -> float:
    """Geometric mean of a range of nominal sizes, for which the standard computes."""
    return math.sqrt(low * high)


def test_grades_follow_from_the_tolerance_unit() -> None:
    """ISO 286-1, annex: i = 0.45 D^(1/3) + 0.001 D um; IT5 to IT13 are 7 to 250 i, rounded: coarsely for small sizes,
    and so that five grades are a factor of ten."""
    units = dict(zip(range(5, 14), (7, 10, 16, 25, 40, 64, 100, 160, 250), strict=True))
    for column, (low, high) in enumerate(pairwise((1, *UP_TO))):
        middle = _middle(low, high)
        unit = 0.45 * middle ** (1 / 3) + 0.001 * middle
        for grade, factor in units.items():
            rounding = 0.16 if high <= 3 else 0.1 if high <= 10 else 0.04
            assert GRADES[grade][column] == pytest.approx(factor * unit, rel=rounding, abs=0.5), (grade, high)
        for grade in (6, 7, 8):
            # 80 um of IT11 up to 6 mm are rounded to 75.
            tens = 75 if (grade, high) == (6, 6) else 10 * GRADES[grade][column]
            assert GRADES[grade + 5][column] == tens


@pytest.mark.parametrize(
    ("letter", "factor", "power"), [("d", 16, 0.44), ("e", 11, 0.41), ("f", 5.5, 0.41), ("g", 2.5, 0.34)]
)
def test_clearances_follow_from_their_formulas(letter: str, factor: float, power: float) -> None:
    for low, high in pairwise((1, *UP_TO)):
        clearance = -1000 * deviations(high, f"{letter}7")[1]
        assert clearance == pytest.approx(factor * _middle(low, high) ** power, abs=1.05 if high <= 3 else 1.25)


@pytest.mark.parametrize(
    ("letter", "grade", "factor"),
    [
        ("s", 7, 0.4),
        ("t", 7, 0.63),
        ("u", 7, 1.0),
        ("v", 7, 1.25),
        ("x", 7, 1.6),
        ("y", 7, 2.0),
        ("z", 7, 2.5),
        ("za", 8, 3.15),
        ("zb", 9, 4.0),
        ("zc", 10, 5.0),
    ],
)
def test_interferences_follow_from_their_formulas(letter: str, grade: int, factor: float) -> None:
    """ISO 286-1, annex: IT + factor D, for s from 50 mm on, for the others from 24 mm on, rounded: to
    multiples of 2 um up to 300 um, then of 5, 10, 20 and 50 um."""
    steps = ((300, 2.5), (560, 5), (800, 10), (1000, 20), (math.inf, 50))
    for (low, high), value in zip(pairwise((1, *FINE_UP_TO)), INTERFERENCE[letter], strict=True):
        if low >= (50 if letter == "s" else 30) and value is not None:
            column = next(number for number, largest in enumerate(UP_TO) if high <= largest)
            exact = GRADES[grade][column] + factor * _middle(low, high)
            step = next(step for largest, step in steps if exact <= largest)
            assert value == pytest.approx(exact, abs=step / 2), (low, high)


def test_only_classes_of_the_table_are_accepted() -> None:
    assert [
        text for text in ("H7", "js6", "JS9", "H4", "h12", "Hg7", "k6", "zc8", "I7", "7H", "") if is_class(text)
    ] == ["H7", "js6", "JS9", "h12", "k6", "zc8"]
    with pytest.raises(ValueError, match="no tolerance class H7 for 260 mm"):
        deviations(260.0, "H7")


def test_the_pins_of_the_thesis_slide_in_their_bores() -> None:
    design = load_design()
    assert design.deviations("base.pin_2_bore") == pytest.approx((0.0, 0.018))
    assert design.deviations("height_pin_2.diameter") == pytest.approx((-0.017, -0.006))
    assert design.plus_minus("height_pin_2.diameter") == pytest.approx(0.0055)


def test_a_class_on_a_wrong_value_is_one_clear_line() -> None:
    for entry, words in (
        ('[stage]\nlength = {value = "300 mm", tolerance = "H7"}', "up to 250 mm, not for 300 mm"),
        ('[stage]\ndowel_diameter = {value = "5 mm", tolerance = "I7"}', "or a class of ISO 286 like H7 or g6"),
    ):
        with pytest.raises(InputError, match=words):
            design_from_text(f'extends = "thesis"\n{entry}\n', "mine.toml")
