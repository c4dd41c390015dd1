"""Leaders find unambiguous places: clear of dimension lines, of each other, on the feature that they name."""

import math
from itertools import pairwise

import pytest

from drawings.annotations.annotation import (
    Callout,
    DatumSymbol,
    FeatureControlFrame,
    LinearDimension,
    RadialDimension,
    SectionMark,
)
from drawings.dimensions.specification import CalloutSpec, DimensionSpec, DistanceSpec, FrameSpec, RoundSpec
from drawings.placement.place import place_annotations
from drawings.placement.views import annotated_views
from drawings.views.segment_index import SegmentIndex
from drawings.views.view import PROJECTIONS, Arc, Curve, Cut, Point2, Segment, View

CORNERS = [(0.0, 0.0), (100.0, 0.0), (100.0, 60.0), (0.0, 60.0), (0.0, 0.0)]
EDGES = tuple(Segment(a, b) for a, b in pairwise(CORNERS))


def placed(specs: list[DimensionSpec], *curves: Curve) -> list:
    view = View("front", PROJECTIONS["front"], {"VISIBLE": (*EDGES, *curves)}, 1.0)
    result = place_annotations(view, specs)
    assert result.conflicts == 0
    return list(result.annotations)


def height() -> DistanceSpec:
    return DistanceSpec("front", (100.0, 0.0), (100.0, 60.0), 90.0, "60.0", 60.0, ("height",))


def frame(at: float) -> FrameSpec:
    return FrameSpec("front", (100.0, 0.0), (100.0, 60.0), 0.0, ("flat",), "flatness", "0.01", at=at)


def test_a_dimension_leaves_the_side_of_a_face_to_the_leaders_of_its_tolerances() -> None:
    found = placed([height(), frame(0.3), frame(0.5), frame(0.7)])
    (dimension,) = (one for one in found if isinstance(one, LinearDimension))
    assert dimension.line_at[0] < 0.0
    for one in found:
        if isinstance(one, FeatureControlFrame):
            leader = (*one.at, *one.elbow)
            x = dimension.line_at[0]
            assert not SegmentIndex([(x, 0.0, x, 60.0)]).count_crossing(leader)


def test_callouts_of_one_point_of_an_edge_end_apart_on_it() -> None:
    specs: list[DimensionSpec] = [
        CalloutSpec("front", (50.0, 60.0), 0.0, (text,), (text,)) for text in ("crown", "coated", "3 pads")
    ]
    tips = [one.at for one in placed(specs) if isinstance(one, Callout)]
    assert all(tip[1] == pytest.approx(60.0) for tip in tips)
    assert min(math.dist(a, b) for i, a in enumerate(tips) for b in tips[:i]) > 0.8


def test_the_leader_of_a_diameter_ends_where_its_circle_is_drawn() -> None:
    """Of the circle only the part from 200 to 340 degrees is drawn."""
    arc = Arc((50.0, 30.0), 12.0, 200.0, 340.0)
    spec = RoundSpec("front", "diameter", (50.0, 30.0), 12.0, 45.0, 180.0, "⌀24.0", 24.0, ("hub",))
    (found,) = placed([spec], arc)
    assert isinstance(found, RadialDimension)
    assert 205.0 < found.towards % 360.0 < 335.0


@pytest.mark.parametrize("letter", ["", "D"])
def test_a_tolerance_of_an_axis_is_in_line_with_the_dimension_line_of_the_diameter(letter: str) -> None:
    """With the datum letter of the same axis, the control frame is at the other end."""
    bore = DistanceSpec("front", (0.0, 20.0), (0.0, 40.0), 90.0, "⌀20 H8 (+0.033/0)", 20.0, ("bore",))
    walls = [Segment((0.0, y), (70.0, y)) for y in (20.0, 40.0)]
    line = ((0.0, 40.0), (70.0, 40.0))
    axis = FrameSpec("front", *line, 90.0, ("straight",), "straightness", "⌀0.01", diameter=20.0)
    datum = [FrameSpec("front", *line, 90.0, ("datum",), letter=letter, diameter=20.0)] if letter else []
    found = placed([bore, *datum, axis], *walls)
    (dimension,) = (one for one in found if isinstance(one, LinearDimension))
    for one in found:
        if isinstance(one, FeatureControlFrame):
            assert one.at[0] == pytest.approx(dimension.line_at[0])
            assert one.elbow[0] == pytest.approx(dimension.line_at[0])
        if isinstance(one, DatumSymbol):
            assert one.frame_at[0] == pytest.approx(dimension.line_at[0])


def test_a_callout_is_at_the_equal_hole_that_is_nearest_to_free_paper() -> None:
    """The declared hole is in the middle of a row that is closed in by others."""
    centres: list[Point2] = [(50.0, 30.0), (50.0, 45.0), (50.0, 15.0), (92.0, 30.0)]
    spec = CalloutSpec("front", centres[0], 3.0, ("4x ⌀6.0",), ("hole",), tuple(centres[1:]))
    (found,) = placed([spec], *(Arc(centre, 3.0) for centre in centres))
    assert isinstance(found, Callout)
    assert math.dist(found.at, centres[3]) == pytest.approx(3.0)


def test_the_cutting_line_is_in_the_view_beside_which_the_section_is_not_turned() -> None:
    """A section from the right is upright beside the front view; beside the top view it would be turned."""
    cut = Cut((50.0, 0.0, 0.0), (1.0, 0.0, 0.0), "A")
    section = View("section A-A", PROJECTIONS["right"], {"VISIBLE": EDGES}, 1.0, label="A-A", cut=cut)
    views = [View(name, PROJECTIONS[name], {"VISIBLE": EDGES}, 1.0) for name in ("top", "front")]
    top, front, cut_open = annotated_views([*views, section], [])
    assert cut_open.view.label == "A-A"
    assert not top.annotations
    assert [mark.letter for mark in front.annotations if isinstance(mark, SectionMark)] == ["A"]


def test_the_label_of_a_section_says_that_it_is_turned() -> None:
    """A section from above whose cutting line only the right view can show: x is to the right instead of y."""
    cut = Cut((0.0, 0.0, 20.0), (0.0, 0.0, 1.0), "A")
    section = View("section A-A", PROJECTIONS["top"], {"VISIBLE": EDGES}, 1.0, label="A-A", cut=cut)
    right = View("right", PROJECTIONS["right"], {"VISIBLE": EDGES}, 1.0)
    shown, turned = annotated_views([right, section], [])
    assert turned.view.label == "A-A, turned"
    assert [mark.letter for mark in shown.annotations if isinstance(mark, SectionMark)] == ["A"]
