"""Limit deviations of ISO 286-2, and their use as tolerance classes in a parameter file."""

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.iso286 import deviations, is_class
from stagecad.parameters.load import design_from_text, load_design


@pytest.mark.parametrize(
    ("size", "tolerance", "low", "high"),
    # ISO 286-2:2010, tables 5, 6, 8 and 17 to 21, um.
    [
        (5.0, "H7", 0, 12),
        (6.0, "H7", 0, 12),
        (10.0, "H8", 0, 22),
        (16.0, "H7", 0, 18),
        (20.0, "H8", 0, 33),
        (76.0, "H7", 0, 30),
        (16.0, "g6", -17, -6),
        (20.0, "f7", -41, -20),
        (76.0, "g6", -29, -10),
        (30.0, "h6", -13, 0),
        (25.0, "D10", 65, 149),
        (25.0, "G7", 7, 28),
        (40.0, "e8", -89, -50),
        (100.0, "js7", -17.5, 17.5),
        (3.0, "d9", -45, -20),
        (200.0, "F8", 50, 122),
        (25.0, "k6", 2, 15),
        (25.0, "k5", 2, 11),
        (6.0, "m6", 4, 12),
        (20.0, "n6", 15, 28),
        (50.0, "p6", 26, 42),
        (60.0, "s6", 53, 72),
        (25.0, "u6", 48, 61),
        (100.0, "j6", -9, 13),
        (50.0, "H13", 0, 390),
        (15.0, "K7", -12, 6),
        (15.0, "M7", -18, 0),
        (15.0, "N7", -23, -5),
        (15.0, "P7", -29, -11),
        (15.0, "P9", -61, -18),
        (25.0, "P6", -31, -18),
        (50.0, "K7", -18, 7),
        (20.0, "J7", -9, 12),
        (20.0, "N9", -52, 0),
        (90.0, "R7", -73, -38),
        (30.0, "S7", -48, -27),
        (25.0, "U7", -61, -40),
        (2.0, "K7", -10, 0),
        (2.0, "N9", -29, -4),
    ],
)
def test_deviations_are_those_of_the_standard(size: float, tolerance: str, low: float, high: float) -> None:
    assert deviations(size, tolerance) == pytest.approx((low / 1000, high / 1000), abs=1e-9)


def test_only_classes_of_the_table_are_accepted() -> None:
    assert [
        text for text in ("H7", "js6", "JS9", "H4", "h12", "Hg7", "k6", "zc8", "I7", "7H", "") if is_class(text)
    ] == [
        "H7",
        "js6",
        "JS9",
        "h12",
        "k6",
        "zc8",
    ]
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
