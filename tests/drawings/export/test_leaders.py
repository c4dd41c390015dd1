"""Ambiguous leaders planted on a sheet that is clean without them are found."""

from dataclasses import replace

import pytest
from test_lint import CLEAN, EDGES, HEIGHT, HOLE, LENGTH, VIEW, hits

from drawings.annotations.annotation import (
    Annotation,
    Callout,
    DatumSymbol,
    FeatureControlFrame,
    LinearDimension,
    RadialDimension,
    SectionMark,
)
from drawings.placement.occupancy import CROSSES_LINE
from drawings.sheets.sheet import Sheet
from drawings.views.view import Arc, Curve

ALONG_THE_EDGE = "a leader runs along an edge of the part"
"""The view is at (100, 150) on the paper, at 1:2: its upper edge from (100, 200) to (200, 200)."""


def faults(*annotations: Annotation, curves: tuple[Curve, ...] = ()) -> list[str]:
    view = replace(VIEW, curves={"VISIBLE": (*EDGES, *curves)})
    found = hits(replace(CLEAN, views=(view,), annotations=annotations), "leader")
    return [str(hit).split(", at x")[0] for hit in found]


def test_the_sheet_is_clean_without_a_planted_fault() -> None:
    assert faults(LENGTH, HEIGHT, HOLE) == []


def test_the_stem_of_a_datum_across_a_dimension_line_is_found() -> None:
    datum = DatumSymbol("front", (150.0, 100.0), (175.0, 222.0), "A")
    assert faults(LENGTH, datum) == [CROSSES_LINE]
    assert faults(replace(LENGTH, line_at=(0.0, 230.0)), datum) == []


@pytest.mark.parametrize("elbow", [(215.0, 220.0), (130.0, 220.0)])
def test_a_leader_across_a_dimension_line_is_found(elbow: tuple[float, float]) -> None:
    leader = Callout("front", (150.0, 100.0), elbow, ("1.0x45°",), ("chamfer",), elbow[0] < 175.0)
    assert faults(LENGTH, leader) == [CROSSES_LINE]
    assert faults(leader) == []


def test_a_leader_on_an_arrow_of_a_dimension_is_found() -> None:
    """An inner dimension whose dimension line ends on the edge on which the leader ends too."""
    inner = LinearDimension("front", (0.0, 50.0), (200.0, 50.0), 0.0, (100.0, 175.0), "200", 200.0, ("length",))
    leader = replace(HOLE, at=(200.0, 50.0))
    assert any(fault.startswith("a leader ends on a dimension line") for fault in faults(inner, leader))
    assert faults(inner, replace(leader, at=(200.0, 70.0))) == []


def test_a_datum_in_line_with_the_dimension_of_its_feature_is_no_fault() -> None:
    assert faults(LENGTH, DatumSymbol("front", (200.0, 120.0), (212.0, 210.0), "B")) == []


def test_two_leaders_to_one_point_are_found() -> None:
    other = replace(HOLE, elbow=(215.0, 160.0), lines=("R2.0",))
    assert faults(HOLE, other) == ["two leaders end at one point"]
    assert faults(HOLE, replace(other, at=(200.0, 44.0))) == []


def test_leaders_that_cross_are_found() -> None:
    other = replace(HOLE, at=(200.0, 90.0), elbow=(215.0, 170.0), lines=("R2.0",))
    assert faults(HOLE, other) == ["two leaders cross, or one crosses a datum symbol"]


def test_a_leader_through_a_datum_symbol_is_found() -> None:
    datum = DatumSymbol("front", (100.0, 100.0), (150.0, 215.0), "A")
    through = Callout("front", (110.0, 100.0), (140.0, 206.0), ("1.0x45°",), ("chamfer",), True)
    assert faults(datum, through) == ["two leaders cross, or one crosses a datum symbol"]


def test_the_leader_of_a_radius_beside_its_arc_is_found() -> None:
    """The arc covers 40 to 140 degrees; a leader ends on it at 90 degrees, and 3 degrees past its end."""
    arc = Arc((100.0, 50.0), 30.0, 40.0, 140.0)
    good = RadialDimension("front", "diameter", (100.0, 50.0), 30.0, 90.0, "⌀60", (170.0, 215.0), 60.0, ("hub",))
    assert faults(good, curves=(arc,)) == []
    past = replace(good, towards=37.0, text_at=(225.0, 215.0))
    assert "the leader of a diameter or radius ends beside its arc" in faults(past, curves=(arc,))


def test_a_line_under_a_text_along_an_extension_line_is_found() -> None:
    """The upper extension line of the height is at y = 200, from x = 99 to the left."""
    leader = Callout("front", (0.0, 60.0), (96.0, 200.4), ("⌀10.0",), ("hole",), True)
    found = faults(HEIGHT, leader)
    assert "the line of a leader next to its text runs along another line" in found
    assert faults(HEIGHT, replace(leader, at=(0.0, 20.0), elbow=(80.0, 120.0))) == []


def test_a_leader_along_an_edge_is_found() -> None:
    along = Callout("front", (200.0, 20.0), (200.3, 185.0), ("1.0x45°",), ("chamfer",))
    assert ALONG_THE_EDGE in faults(along)
    assert ALONG_THE_EDGE not in faults(replace(along, elbow=(225.0, 170.0)))


def test_the_tolerance_of_an_axis_off_the_dimension_line_is_found() -> None:
    """A zone in the shape of a cylinder on a leader to the outline; in line with the diameter it is right."""
    off = FeatureControlFrame("front", (150.0, 100.0), (175.0, 225.0), "straightness", "⌀0.01")
    diameter = replace(LENGTH, text="⌀200")
    (fault,) = faults(replace(diameter, line_at=(0.0, 240.0)), off)
    assert fault.startswith(("the tolerance Ø0.01 of an axis", "the tolerance ⌀0.01 of an axis"))
    assert faults(diameter, replace(off, at=(200.0, 120.0), elbow=(215.0, 210.0))) == []
    assert faults(replace(diameter, line_at=(0.0, 240.0)), replace(off, tolerance="0.01")) == []


def test_a_leader_across_a_cutting_line_is_found() -> None:
    mark = SectionMark("front", (150.0, 145.0), (150.0, 212.0), (1.0, 0.0), "A")
    across = Callout("front", (60.0, 100.0), (165.0, 214.0), ("1.0x45°",), ("chamfer",))
    assert faults(mark, across) == [CROSSES_LINE]
    sheet: Sheet = replace(CLEAN, annotations=(mark, replace(across, elbow=(120.0, 215.0), leftward=True)))
    assert hits(sheet, "leader") == []
