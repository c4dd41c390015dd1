"""What is printed: decimals as the class has them, or the tolerance spelled out; callouts that tell a whole hole."""

import pytest

from drawings.dimensions.text import callout, dimension_text, number
from stagecad.friction_stage.construction import part_definition
from stagecad.parameters.dimension import Dimension
from tests.drawings.drawn import thesis

ENDS = ((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("value", "tolerance", "text"),
    [
        (12.0, "X", "12"),
        (12.0, "X.X", "12.0"),
        (25.4, "X.XX", "25.40"),
        (0.1 + 0.2, "X.X", "0.3"),
        (7.9375, None, "7.938"),
        (5.0, None, "5"),
        # What the class would round off is printed, and its tolerance beside it.
        (230.7, "X", "230.7 ±0.1"),
        (4.646, "X.X", "4.646 ±0.1"),
        (14.2875, "X.X", "14.287 ±0.1"),
    ],
)
def test_decimals_are_the_class_or_the_tolerance_is_spelled_out(value: float, tolerance: str | None, text: str) -> None:
    assert number(value, tolerance, 0.1) == text


def declared(kind: str, name: str, value: float, **more: object) -> Dimension:
    points = ENDS if kind in ("depth", "linear", "pitch") else ENDS[:1]
    tolerance = more.pop("tolerance", "X.X")
    return Dimension(name, kind, value, "stage.length", points, (0.0, 0.0, -1.0), tolerance, **more)  # type: ignore[arg-type]


def test_text_of_single_dimensions() -> None:
    assert dimension_text(declared("diameter", "bore", 16.02, tolerance="X.XX", count=3), 0.01) == "3x ⌀16.02"
    assert dimension_text(declared("radius", "nose", 20.0, note="spherical; coated"), 0.1) == "SR20.0"
    assert dimension_text(declared("radius", "corner", 5.0, tolerance="X", count=4), 0.1) == "4x R5"
    assert dimension_text(declared("chamfer", "edge", 0.5), 0.1) == "0.5x45°"
    assert dimension_text(declared("slope", "wedge", 0.05, tolerance=None), 0.0) == "slope 1:20"
    assert dimension_text(declared("slope", "wedge", 0.053, tolerance=None), 0.0) == "slope 0.053"
    assert dimension_text(declared("angle", "neck", 85.0, tolerance="X", count=2), 0.1) == "2x 85°"


def test_a_tapped_hole_tells_thread_drill_and_both_depths() -> None:
    note = "3/8-16 UNC"
    hole = [
        declared("tap_drill", "way hole tap drill", 7.9375, tolerance=None, note=note, count=14, feature="way hole"),
        declared("thread_depth", "way hole thread depth", 15.0, note=note, count=14, feature="way hole"),
        declared("depth", "way hole drill depth", 18.0, note=note, count=14, feature="way hole"),
        declared("count", "way holes in a row", 7, tolerance=None, note="2 rows", feature="way hole"),
    ]
    assert callout(hole, [0.0, 0.1, 0.1, 0.0]) == (
        "14x 3/8-16 UNC {depth}15.0",
        "drill ⌀7.938 {depth}18.0",
        "7 in a row, 2 rows",
    )
    assert callout(hole[:1], [0.0]) == ("14x 3/8-16 UNC through", "drill ⌀7.938")


def test_a_counterbored_hole_tells_each_depth_with_its_diameter() -> None:
    hole = [
        declared("diameter", "clamp counterbore", 15.9, count=4, feature="clamp screw hole"),
        declared("depth", "clamp counterbore depth", 12.0, count=4, feature="clamp screw hole"),
        declared("diameter", "clamp clearance hole", 10.5, count=4, feature="clamp screw hole", note="to the gap slot"),
    ]
    assert callout(hole, [0.1] * 3) == ("4x {counterbore}⌀15.9 {depth}12.0", "⌀10.5 to the gap slot")


def test_the_depth_of_a_counterbore_is_not_that_of_the_hole_whose_name_begins_its_own() -> None:
    hole = [
        declared("diameter", "hole 1", 5.5, count=4, feature="hole 1", note="through"),
        declared("diameter", "hole 1 counterbore", 10.0, count=4, feature="hole 1"),
        declared("depth", "hole 1 counterbore depth", 5.5, count=4, feature="hole 1"),
    ]
    assert callout(hole, [0.1] * 3) == ("4x ⌀5.5 through", "{counterbore}⌀10.0 {depth}5.5")


def test_a_count_that_says_the_number_of_holes_is_not_said_twice() -> None:
    row = [
        declared("diameter", "screw hole", 10.5, count=7, note="through", feature="screw hole"),
        declared("count", "screw holes", 7, tolerance=None, feature="screw hole"),
    ]
    assert callout(row, [0.1, 0.0]) == ("7x ⌀10.5 through",)
    alone = [declared("count", "teeth in a group", 2, tolerance=None, count=2, feature="teeth")]
    assert callout(alone, [0.0]) == ("2x 2 teeth in a group",)


def test_a_theoretically_exact_value_is_in_a_frame_and_has_no_tolerance() -> None:
    assert dimension_text(declared("linear", "spacing", 46.0, tolerance="X.XX", exact=True), 0.01) == "{box:46}"
    pitch = declared("pitch", "pitch", 50.0, tolerance="X.X", count=3, exact=True)
    assert dimension_text(pitch, 0.1) == "3x {box:50} (=150)"
    assert dimension_text(declared("slope", "wedge", 0.05, tolerance=None, exact=True), 0.0) == "slope {box:1:20}"


def test_the_thread_of_a_stepped_hole_comes_in_the_order_of_its_steps() -> None:
    hole = [
        declared("diameter", "clamp counterbore", 15.9, tolerance=None, feature="hole"),
        declared("diameter", "clearance hole", 10.5, tolerance=None, feature="hole", note="to the slot"),
        declared("tap_drill", "thread", 7.938, tolerance=None, feature="hole", note="3/8-16 UNC"),
    ]
    assert callout(hole, [0.0] * 3) == (
        "{counterbore}\u230015.9",
        "\u230010.5 to the slot",
        "3/8-16 UNC through",
        "drill \u23007.938",
    )


def test_the_blind_thread_of_the_clamps_is_not_called_through() -> None:
    own = [one for one in part_definition("base").dimensions(thesis()) if one.feature == "clamp screw hole"]
    own = [one for one in own if one.view != "section"]
    lines = callout(own, [0.1] * len(own))
    assert "3/8-16 UNC" in lines and not any("through" in line for line in lines)
