"""The lint finds what is planted on a sheet that is clean without it; ambiguous leaders too."""

from dataclasses import replace
from itertools import pairwise

import pytest

from drawings.annotations.annotation import (
    Annotation,
    Callout,
    DatumSymbol,
    FeatureControlFrame,
    LinearDimension,
    Note,
    RadialDimension,
    SectionMark,
)
from drawings.lint import Hit, lint
from drawings.placement.lint_rules import CROSSES_LINE
from drawings.sheets.frame import TitleBlock
from drawings.sheets.sheet import Sheet
from drawings.views.view import PROJECTIONS, Arc, Curve, Segment, View

TITLE = TitleBlock(
    "block", "Stage", "THS_BLOCK", "Steel", "1 g", "1:2", 1, 1, "1", "0123", "Part drawing", "", (("X", "±0.1"),)
)
CORNERS = [(0.0, 0.0), (200.0, 0.0), (200.0, 100.0), (0.0, 100.0), (0.0, 0.0)]
EDGES = tuple(Segment(a, b) for a, b in pairwise(CORNERS))
VIEW = View("front", PROJECTIONS["front"], {"VISIBLE": EDGES}, scale=0.5, place=(100.0, 150.0))
LENGTH = LinearDimension("front", (0.0, 100.0), (200.0, 100.0), 0.0, (0.0, 210.0), "200", 200.0, ("length",))
HEIGHT = LinearDimension("front", (0.0, 0.0), (0.0, 100.0), 90.0, (90.0, 0.0), "100.0", 100.0, ("height",))
HOLE = Callout("front", (200.0, 50.0), (215.0, 190.0), ("4x ⌀5.0 {depth}12.0",), ("hole",))
CLEAN = Sheet("block", "block", "A3", 0.5, TITLE, (VIEW,), (LENGTH, HEIGHT, HOLE))
ALONG_THE_EDGE = "a leader runs along an edge of the part"
"""The view is at (100, 150) on the paper, at 1:2: its upper edge from (100, 200) to (200, 200)."""


def hits(sheet: Sheet, kind: str) -> list[Hit]:
    return [hit for hit in lint(sheet) if hit.kind == kind]


def test_a_clean_sheet_has_no_hits_and_a_text_over_another_one() -> None:
    assert lint(CLEAN) == []
    other = replace(HOLE, at=(200.0, 30.0), elbow=(216.0, 191.0), lines=("3x R2.0",))
    (hit,) = hits(replace(CLEAN, annotations=(*CLEAN.annotations, other)), "text")
    assert str(hit).startswith("'3x R2.0' is over") and hit.at == pytest.approx((227.4, 191.0), abs=0.5)


def test_texts_and_symbols_over_lines_of_the_part_are_found() -> None:
    inside = replace(LENGTH, line_at=(0.0, 197.5), text_at=(150.0, 200.0))
    assert hits(replace(CLEAN, annotations=(inside, HEIGHT)), "line")
    assert hits(replace(CLEAN, views=(VIEW, replace(VIEW, name="right", place=(222.0, 150.0)))), "line")
    over = FeatureControlFrame("front", (100.0, 100.0), (140.0, 200.5), "flatness", "0.01")
    assert hits(replace(CLEAN, annotations=(over,)), "line")
    off = replace(over, elbow=(140.0, 212.0))
    assert lint(replace(CLEAN, annotations=(off,))) == []
    over = replace(HOLE, at=(200.0, 50.0), elbow=(194.0, 190.0), lines=("{surface}",))
    assert hits(replace(CLEAN, annotations=(over,)), "line")
    off = replace(over, elbow=(210.0, 190.0))
    assert lint(replace(CLEAN, annotations=(off,))) == []
    assert hits(replace(CLEAN, notes=(Note((120.0, 148.5), ("Cut slots last.",)),)), "line")


@pytest.mark.parametrize("across", [240.0, 330.0])
def test_a_dimension_whose_lines_cross_another_view_is_found(across: float) -> None:
    """Also where its extension lines run along the edges of the aligned view."""
    other = replace(VIEW, name="right", place=(222.0, 150.0))
    far = replace(HEIGHT, first=(200.0, 0.0), second=(200.0, 100.0), line_at=(across, 150.0), text_at=(345.0, 260.0))
    assert hits(replace(CLEAN, views=(VIEW, other), annotations=(HEIGHT, far)), "view")
    near = replace(far, line_at=(211.0, 150.0))
    assert not hits(replace(CLEAN, views=(VIEW, other), annotations=(HEIGHT, near)), "view")


def test_holes_in_outlines_belong_to_the_view_and_texts_outside_the_frame_do_not() -> None:
    hole = tuple(Segment((x, 40.0), (x, 60.0)) for x in (90.0, 110.0))
    view = replace(VIEW, curves={"VISIBLE": (*EDGES, *hole)})
    inside = LinearDimension("front", (90.0, 50.0), (110.0, 50.0), 0.0, (0.0, 140.0), "20.0", 20.0, ("width",))
    assert not hits(replace(CLEAN, views=(view,), annotations=(inside,)), "view")
    assert hits(replace(CLEAN, annotations=(replace(HOLE, elbow=(405.0, 190.0)),)), "frame")
    assert hits(replace(CLEAN, views=(replace(VIEW, place=(280.0, 20.0)),), annotations=()), "title block")


def test_a_slanting_text_is_judged_by_its_own_shape() -> None:
    """A line through the upright box about a slanting text, but past the text itself, is not a hit."""
    slanting = LinearDimension(
        "front", (40.0, 20.0), (120.0, 100.0), 45.0, (140.0, 160.0), "113.1", 113.137085, ("slope",)
    )
    clear, through = Segment((102.0, 38.0), (104.0, 36.0)), Segment((96.0, 30.0), (96.0, 60.0))

    def with_line(line: Segment) -> Sheet:
        return Sheet(
            "block", "block", "A3", 0.5, TITLE, (replace(VIEW, curves={"VISIBLE": (*EDGES, line)}),), (slanting,)
        )

    assert hits(with_line(clear), "line") == [] and hits(with_line(through), "line")


def test_two_dimensions_on_one_line_are_found() -> None:
    part = LinearDimension(
        "front", (50.0, 100.0), (80.0, 100.0), 0.0, (0.0, 210.0), "30.0", 30.0, ("part",), (100.0, 218.0)
    )
    assert hits(replace(CLEAN, annotations=(LENGTH, part)), "dimensions")
    chain = [
        replace(LENGTH, second=(100.0, 100.0), text="100", measured=100.0),
        replace(LENGTH, first=(100.0, 100.0), text="100", measured=100.0),
    ]
    assert hits(replace(CLEAN, annotations=tuple(chain)), "dimensions") == []


def test_wordings_of_no_standard_and_leaders_beside_the_part_or_on_a_datum_are_found() -> None:
    assert [hit.kind for hit in lint(replace(CLEAN, annotations=(replace(HOLE, at=(140.0, 50.0)),)))] == ["leader"]
    datum = DatumSymbol("front", (150.0, 100.0), (175.0, 212.0), "A")
    leader = replace(HOLE, at=(152.0, 100.0), elbow=(215.0, 215.0), lines=("1.0x45°",))
    found = hits(replace(CLEAN, annotations=(datum, leader)), "leader")
    assert "a leader ends on the triangle of a datum" in [str(hit).split(",")[0] for hit in found]
    assert hits(replace(CLEAN, annotations=(datum, replace(leader, at=(190.0, 100.0)))), "leader") == []
    (hit,) = hits(replace(CLEAN, annotations=(replace(HOLE, lines=("7x 50.0 both ways",)),)), "callout")
    assert str(hit).startswith("'7x 50.0 both ways' is defined by no standard")


def faults(*annotations: Annotation, curves: tuple[Curve, ...] = ()) -> list[str]:
    view = replace(VIEW, curves={"VISIBLE": (*EDGES, *curves)})
    found = hits(replace(CLEAN, views=(view,), annotations=annotations), "leader")
    return [str(hit).split(", at x")[0] for hit in found]


def test_datums_and_leaders_across_lines_are_found() -> None:
    datum = DatumSymbol("front", (150.0, 100.0), (175.0, 222.0), "A")
    assert faults(LENGTH, datum) == [CROSSES_LINE] and faults(replace(LENGTH, line_at=(0.0, 230.0)), datum) == []
    mark = SectionMark("front", (150.0, 145.0), (150.0, 212.0), (1.0, 0.0), "A")
    across = Callout("front", (60.0, 100.0), (165.0, 214.0), ("1.0x45°",), ("chamfer",))
    assert faults(mark, across) == [CROSSES_LINE]
    sheet: Sheet = replace(CLEAN, annotations=(mark, replace(across, elbow=(120.0, 215.0), leftward=True)))
    assert hits(sheet, "leader") == []
    assert faults(LENGTH, DatumSymbol("front", (200.0, 120.0), (212.0, 210.0), "B")) == []
    along = Callout("front", (200.0, 20.0), (200.3, 185.0), ("1.0x45°",), ("chamfer",))
    assert ALONG_THE_EDGE in faults(along) and ALONG_THE_EDGE not in faults(replace(along, elbow=(225.0, 170.0)))


@pytest.mark.parametrize("elbow", [(215.0, 220.0), (130.0, 220.0)])
def test_a_leader_across_a_dimension_line_is_found(elbow: tuple[float, float]) -> None:
    leader = Callout("front", (150.0, 100.0), elbow, ("1.0x45°",), ("chamfer",), elbow[0] < 175.0)
    assert faults(LENGTH, leader) == [CROSSES_LINE] and faults(leader) == []


def test_leaders_on_arrows_beside_arcs_and_along_lines_are_found() -> None:
    """An inner dimension whose dimension line ends on the edge on which the leader ends too."""
    inner = LinearDimension("front", (0.0, 50.0), (200.0, 50.0), 0.0, (100.0, 175.0), "200", 200.0, ("length",))
    leader = replace(HOLE, at=(200.0, 50.0))
    assert any(fault.startswith("a leader ends on a dimension line") for fault in faults(inner, leader))
    assert faults(inner, replace(leader, at=(200.0, 70.0))) == []
    # The arc covers 40 to 140 degrees; a leader ends on it at 90 degrees, and 3 degrees past its end.
    arc = Arc((100.0, 50.0), 30.0, 40.0, 140.0)
    good = RadialDimension("front", "diameter", (100.0, 50.0), 30.0, 90.0, "⌀60", (170.0, 215.0), 60.0, ("hub",))
    assert faults(good, curves=(arc,)) == []
    past = replace(good, towards=37.0, text_at=(225.0, 215.0))
    assert "'hub': the leader of a diameter or radius ends beside its arc" in faults(past, curves=(arc,))
    # The upper extension line of the height is at y = 200, from x = 99 to the left.
    leader = Callout("front", (0.0, 60.0), (96.0, 200.4), ("⌀10.0",), ("hole",), True)
    assert "the line of a leader next to its text runs along another line" in faults(HEIGHT, leader)
    assert faults(HEIGHT, replace(leader, at=(0.0, 20.0), elbow=(80.0, 120.0))) == []


def test_leaders_that_meet_or_cross_are_found() -> None:
    other = replace(HOLE, elbow=(215.0, 160.0), lines=("R2.0",))
    assert faults(HOLE, other) == ["two leaders end at one point"]
    assert faults(HOLE, replace(other, at=(200.0, 44.0))) == []
    other = replace(HOLE, at=(200.0, 90.0), elbow=(215.0, 170.0), lines=("R2.0",))
    assert faults(HOLE, other) == ["two leaders cross, or one crosses a datum symbol"]
    datum = DatumSymbol("front", (100.0, 100.0), (150.0, 215.0), "A")
    through = Callout("front", (110.0, 100.0), (140.0, 206.0), ("1.0x45°",), ("chamfer",), True)
    assert faults(datum, through) == ["two leaders cross, or one crosses a datum symbol"]


def test_the_tolerance_of_an_axis_off_the_dimension_line_is_found() -> None:
    """A zone in the shape of a cylinder on a leader to the outline; in line with the diameter it is right."""
    off = FeatureControlFrame("front", (150.0, 100.0), (175.0, 225.0), "straightness", "⌀0.01")
    diameter = replace(LENGTH, text="⌀200")
    (fault,) = faults(replace(diameter, line_at=(0.0, 240.0)), off)
    assert fault.startswith(("the tolerance Ø0.01 of an axis", "the tolerance ⌀0.01 of an axis"))
    assert faults(diameter, replace(off, at=(200.0, 120.0), elbow=(215.0, 210.0))) == []
    assert faults(replace(diameter, line_at=(0.0, 240.0)), replace(off, tolerance="0.01")) == []
