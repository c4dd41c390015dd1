"""Limit deviations of ISO 286-2, and their use as tolerance classes in a parameter file."""

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.iso286 import deviations, is_class
from stagecad.parameters.load import design_from_text, load_design
from tests.reference.tables import cases


@pytest.mark.parametrize(
    ("size", "tolerance", "low", "high"),
    # ISO 286-2:2010, tables 5, 6, 8 and 17 to 21, um.
    cases("iso286", "deviations"),
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
