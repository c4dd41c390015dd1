"""Placement of annotations, views and leaders, on blocks with known good positions."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from drawings.annotations import annotation
from drawings.annotations.primitives import Text
from drawings.dimensions.specification import CalloutSpec, DimensionSpec, DistanceSpec, FrameSpec, RoundSpec
from drawings.placement.place import AnnotatedView, place_annotations
from drawings.placement.views import VIEW_SPACING, SheetArea, annotated_views, arrange, detached
from drawings.sheets.sheet import sheet_area
from drawings.views.segment_index import SegmentIndex, arc_points, boxes_overlap, line_meets_box
from drawings.views.view import PROJECTIONS, Arc, Curve, Cut, Point2, Segment, View

CORNERS = [(0.0, 0.0), (100.0, 0.0), (100.0, 60.0), (0.0, 60.0), (0.0, 0.0)]
EDGES = tuple(Segment(a, b) for a, b in pairwise(CORNERS))


def rectangle(width: float, height: float) -> tuple[Segment, ...]:
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)]
    return tuple(Segment(a, b) for a, b in pairwise(corners))


def block(name: str = "front", width: float = 200.0, height: float = 100.0, aligned_with: str = "") -> View:
    return View(name, PROJECTIONS[name], {"VISIBLE": rectangle(width, height)}, 0.5, aligned_with=aligned_with)


def distance(first: Point2, second: Point2, name: str, view: str = "front") -> DistanceSpec:
    angle = 0.0 if abs(second[0] - first[0]) > abs(second[1] - first[1]) else 90.0
    value = math.dist(first, second)
    return DistanceSpec(view, first, second, angle, f"{value:.1f}", value, (name,))


def lines_of(result: AnnotatedView) -> dict[str, annotation.LinearDimension]:
    return {a.names[0]: a for a in result.annotations if isinstance(a, annotation.LinearDimension)}


def test_dimension_lines_are_placed_outside_the_part_in_their_order() -> None:
    ends = {"length": ((0.0, 50.0), (200.0, 50.0)), "middle": ((50.0, 100.0), (150.0, 100.0))}
    ends["height"] = ((0.0, 0.0), (0.0, 100.0))
    result = place_annotations(block(), [distance(*both, name) for name, both in ends.items()])
    placed = lines_of(result)
    assert result.conflicts == 0
    away = {name: max(d.line_at[1] - 50.0, -d.line_at[1]) for name, d in placed.items() if d.angle == 0.0}
    assert away["middle"] >= 10.0 - 1e-9
    if (placed["middle"].line_at[1] > 25.0) == (placed["length"].line_at[1] > 25.0):
        assert away["length"] >= away["middle"] + 7.0
    assert not 0.0 < placed["height"].line_at[0] < 100.0
    # Declared at mid-height, the length is measured from the corners next to its dimension line.
    (length,) = lines_of(place_annotations(block(), [distance((0.0, 50.0), (200.0, 50.0), "length")])).values()
    level = 100.0 if length.line_at[1] > 50.0 else 0.0
    assert (length.first, length.second) == ((0.0, level), (200.0, level))
    (narrow,) = lines_of(place_annotations(block(), [distance((90.0, 100.0), (93.0, 100.0), "slot")])).values()
    assert not 45.0 < narrow.text_at[0] < 46.5


def test_conflicts_are_placed_again_and_taken_areas_stay_free() -> None:
    """Twenty steps side by side and ten callouts: every text is free, and the same again gives the same places."""
    asked: list[DimensionSpec] = [distance((10.0 * i, 100.0), (10.0 * i + 10.0, 100.0), f"step {i}") for i in range(20)]
    asked += [CalloutSpec("front", (20.0 * i + 10.0, 20.0), 2.0, (f"⌀{i}.0",), (f"hole {i}",)) for i in range(10)]
    result = place_annotations(block(), asked)
    assert result.conflicts == 0
    ink = [(a, list(a.primitives(result.view))) for a in result.annotations]
    boxes = [(a, annotation.text_box(item)) for a, items in ink for item in items if isinstance(item, Text)]
    for i, (one, box) in enumerate(boxes):
        for other, another in boxes[i + 1 :]:
            assert one is other or not boxes_overlap(box, another)
        for edge in result.view.curves["VISIBLE"]:
            assert isinstance(edge, Segment)
            assert not line_meets_box((*result.view.to_paper(edge.start), *result.view.to_paper(edge.end)), box)
    assert place_annotations(block(), asked).annotations == result.annotations
    # Nested and crossing spans on a part with a line close by on three sides.
    asked = [distance((20.0 * i, 50.0), (200.0 - 15.0 * i, 50.0), f"span {i}") for i in range(5)]
    assert place_annotations(block(), asked).conflicts == 0
    area = sheet_area("A3", ((0.0, 0.0, 260.0, 297.0),))
    result = arrange(annotated_views(VIEWS[:1], []), area)
    assert result.fits and result.views[0].place[0] >= 260.0


def test_dimensions_leave_the_side_of_a_face_to_its_tolerances() -> None:
    asked = [FrameSpec("front", (0.0, 100.0), (200.0, 100.0), 90.0, ("top",), "flatness", "0.01")]
    (above,) = place_annotations(block(), asked).annotations
    assert isinstance(above, annotation.FeatureControlFrame) and above.at[1] == pytest.approx(100.0)
    assert above.elbow[1] > 50.0 + 3.5
    found = placed([height(), frame(0.3), frame(0.5), frame(0.7)])
    (dimension,) = (one for one in found if isinstance(one, annotation.LinearDimension))
    assert dimension.line_at[0] < 0.0
    for one in found:
        if isinstance(one, annotation.FeatureControlFrame):
            leader = (*one.at, *one.elbow)
            x = dimension.line_at[0]
            assert not SegmentIndex([(x, 0.0, x, 60.0)]).count_crossing(leader)
    # Of a step at the lower edge, dimensioned above or below with as much space.
    low = [Segment((60.0, 0.0), (60.0, 30.0)), Segment((140.0, 0.0), (140.0, 30.0))]
    view = replace(block(), curves={"VISIBLE": (*rectangle(200.0, 100.0), *low)})
    (step,) = lines_of(place_annotations(view, [distance((60.0, 15.0), (140.0, 15.0), "step")])).values()
    assert step.line_at[1] < 0.0


def test_leaders_end_on_drawn_lines_clear_of_ends() -> None:
    """A datum and three frames on a face of 100 mm on the paper: each arrow 2.5 mm or more from the corners."""
    face = ("front", (0.0, 100.0), (200.0, 100.0), 90.0)
    asked = [FrameSpec(*face, (f"{k}",), "flatness", f"0.0{k}", at=0.98) for k in (1, 2, 3)]
    frames = [a for a in place_annotations(block(), asked).annotations if isinstance(a, annotation.FeatureControlFrame)]
    assert len(frames) == 3 and all(5.0 <= a.at[0] <= 195.0 for a in frames)
    asked = [CalloutSpec("front", (100.0, 60.0), 0.0, ("Ra 1",), ("texture",), ((100.0, 100.0),))]
    (callout,) = place_annotations(block(), asked).annotations
    assert isinstance(callout, annotation.Callout) and callout.at == pytest.approx((100.0, 100.0))
    box = callout.box(0)
    assert box[1] > 50.0 or box[0] > 100.0 or box[2] < 0.0
    # Of the circle only the part from 200 to 340 degrees is drawn.
    arc = Arc((50.0, 30.0), 12.0, 200.0, 340.0)
    spec = RoundSpec("front", "diameter", (50.0, 30.0), 12.0, 45.0, 180.0, "⌀24.0", 24.0, ("hub",))
    (found,) = placed([spec], arc)
    assert isinstance(found, annotation.RadialDimension) and 205.0 < found.towards % 360.0 < 335.0


VIEWS = (block("top"), block("front", aligned_with="top"), block("right", 80.0, aligned_with="front"))


def test_views_are_in_third_angle_projection_and_move_with_their_annotations() -> None:
    result = arrange(annotated_views(VIEWS, []), sheet_area("A3"))
    top, front, right = result.views
    assert result.fits
    assert top.place[0] == front.place[0] and top.place[1] > front.place[1] + 50.0
    assert right.place[1] == front.place[1] and right.place[0] > front.place[0] + 100.0 + VIEW_SPACING - 1e-6
    every = annotated_views(VIEWS, [distance((0.0, 100.0), (200.0, 100.0), "length", "front")])
    (before,) = every[1].annotations
    result = arrange(every, sheet_area("A3"))
    (after,) = result.annotations
    assert isinstance(before, annotation.LinearDimension) and isinstance(after, annotation.LinearDimension)
    front = result.views[1]
    moved = (after.line_at[0] - before.line_at[0], after.line_at[1] - before.line_at[1])
    assert moved == pytest.approx(front.place)
    assert (after.first, after.second) == (before.first, before.second)


def test_views_that_do_not_fit_are_reported_and_a_detached_view_is_labelled() -> None:
    tall = tuple(replace(view, scale=1.0) for view in (*VIEWS[:2], block("bottom", aligned_with="front")))
    every = annotated_views(tall, [])
    area = SheetArea((0.0, 0.0, 480.0, 240.0), ())
    assert not arrange(every, area).fits
    alone = arrange(detached(every, "bottom"), area)
    assert alone.fits and alone.views[2].label == "P"
    (arrow,) = (a for a in alone.annotations if isinstance(a, annotation.ReferenceArrow))
    assert arrow.letter == "P"
    assert alone.views[2].label_at is not None


def test_a_reference_arrow_is_beside_a_cutting_line() -> None:
    cut = Cut((100.0, 0.0, 0.0), (1.0, 0.0, 0.0), "A")
    section = replace(block("right", 80.0, aligned_with="front"), name="section A-A", cut=cut, label="A-A")
    bottom = block("bottom", aligned_with="front")
    marks = detached(annotated_views((block("front"), section, bottom), []), "bottom")[0].annotations
    (arrow,) = [a for a in marks if isinstance(a, annotation.ReferenceArrow)]
    (line,) = [a for a in marks if isinstance(a, annotation.SectionMark)]
    assert line.start[0] == line.end[0] and abs(arrow.tip[0] - line.start[0]) > 10.0


def test_lines_and_arcs_against_boxes() -> None:
    lines = SegmentIndex([(0.0, 0.0, 10.0, 10.0), (20.0, 0.0, 20.0, 10.0)])
    assert lines.count_in((4.0, 4.5, 6.0, 5.5)) == 1 and lines.count_in((6.0, 1.0, 9.0, 4.0)) == 0
    assert lines.count_in((0.0, 0.0, 30.0, 10.0)) == 2 and lines.count_crossing((0.0, 10.0, 10.0, 0.0)) == 1
    assert lines.collinear_run((20.0, 5.0), (0.0, 1.0)) == (-5.0, 5.0)
    assert lines.collinear_run((21.0, 5.0), (0.0, 1.0)) == (0.0, 0.0)
    assert lines.count_beside(1.5, (21.0, 2.0, 21.0, 8.0)) == (1, 1)
    points = arc_points(Arc((0.0, 0.0), 40.0, 10.0, 200.0), 2.0)
    middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pairwise(points)]
    assert max(40.0 - math.hypot(*middle) for middle in middles) * 2.0 < 0.05 + 1e-9
    assert points[0] == pytest.approx((40.0 * math.cos(math.radians(10.0)), 40.0 * math.sin(math.radians(10.0))))


def placed(specs: list[DimensionSpec], *curves: Curve) -> list:
    result = place_annotations(View("front", PROJECTIONS["front"], {"VISIBLE": (*EDGES, *curves)}, 1.0), specs)
    assert result.conflicts == 0
    return list(result.annotations)


def height() -> DistanceSpec:
    return DistanceSpec("front", (100.0, 0.0), (100.0, 60.0), 90.0, "60.0", 60.0, ("height",))


def frame(at: float) -> FrameSpec:
    return FrameSpec("front", (100.0, 0.0), (100.0, 60.0), 0.0, ("flat",), "flatness", "0.01", at=at)


def test_callouts_of_edges_and_equal_holes() -> None:
    words = ("crown", "coated", "3 pads")
    specs: list[DimensionSpec] = [CalloutSpec("front", (50.0, 60.0), 0.0, (text,), (text,)) for text in words]
    tips = [one.at for one in placed(specs) if isinstance(one, annotation.Callout)]
    assert all(tip[1] == pytest.approx(60.0) for tip in tips)
    assert min(math.dist(a, b) for i, a in enumerate(tips) for b in tips[:i]) > 0.8
    # The declared hole is in the middle of a row that is closed in by others.
    centres: list[Point2] = [(50.0, 30.0), (50.0, 45.0), (50.0, 15.0), (92.0, 30.0)]
    spec = CalloutSpec("front", centres[0], 3.0, ("4x ⌀6.0",), ("hole",), tuple(centres[1:]))
    (found,) = placed([spec], *(Arc(centre, 3.0) for centre in centres))
    assert isinstance(found, annotation.Callout) and math.dist(found.at, centres[3]) == pytest.approx(3.0)


@pytest.mark.parametrize("letter", ["", "D"])
def test_a_tolerance_of_an_axis_is_in_line_with_the_dimension_line_of_the_diameter(letter: str) -> None:
    """With the datum letter of the same axis, the control frame is at the other end."""
    bore = DistanceSpec("front", (0.0, 20.0), (0.0, 40.0), 90.0, "⌀20 H8 (+0.033/0)", 20.0, ("bore",))
    walls = [Segment((0.0, y), (70.0, y)) for y in (20.0, 40.0)]
    line = ((0.0, 40.0), (70.0, 40.0))
    axis = FrameSpec("front", *line, 90.0, ("straight",), "straightness", "⌀0.01", diameter=20.0)
    datum = [FrameSpec("front", *line, 90.0, ("datum",), letter=letter, diameter=20.0)] if letter else []
    found = placed([bore, *datum, axis], *walls)
    (dimension,) = (one for one in found if isinstance(one, annotation.LinearDimension))
    for one in found:
        if isinstance(one, annotation.FeatureControlFrame):
            assert one.at[0] == pytest.approx(dimension.line_at[0])
            assert one.elbow[0] == pytest.approx(dimension.line_at[0])
        if isinstance(one, annotation.DatumSymbol):
            assert one.frame_at[0] == pytest.approx(dimension.line_at[0])


def test_sections_are_marked_and_say_that_they_are_turned() -> None:
    """A section from the right is upright beside the front view; beside the top view it would be turned."""
    cut = Cut((50.0, 0.0, 0.0), (1.0, 0.0, 0.0), "A")
    section = View("section A-A", PROJECTIONS["right"], {"VISIBLE": EDGES}, 1.0, label="A-A", cut=cut)
    views = [View(name, PROJECTIONS[name], {"VISIBLE": EDGES}, 1.0) for name in ("top", "front")]
    top, front, cut_open = annotated_views([*views, section], [])
    assert cut_open.view.label == "A-A"
    assert not top.annotations
    assert [mark.letter for mark in front.annotations if isinstance(mark, annotation.SectionMark)] == ["A"]
    # A section from above whose cutting line only the right view can show: x is to the right instead of y.
    cut = Cut((0.0, 0.0, 20.0), (0.0, 0.0, 1.0), "A")
    section = View("section A-A", PROJECTIONS["top"], {"VISIBLE": EDGES}, 1.0, label="A-A", cut=cut)
    shown, turned = annotated_views([View("right", PROJECTIONS["right"], {"VISIBLE": EDGES}, 1.0), section], [])
    assert turned.view.label == "A-A, turned"
    assert [mark.letter for mark in shown.annotations if isinstance(mark, annotation.SectionMark)] == ["A"]


def test_a_cutting_line_ends_beyond_all_dimension_lines() -> None:
    ends = [30.0 * k for k in range(1, 13)]
    front = View("front", PROJECTIONS["front"], {"VISIBLE": rectangle(400.0, 40.0)}, 0.5)
    plane = Cut((10.0, 0.0, 0.0), (-1.0, 0.0, 0.0), "A")
    cut = View("section A-A", PROJECTIONS["left"], {"VISIBLE": rectangle(40.0, 40.0)}, 0.5, cut=plane)
    specs = [distance((0.0, y), (end, y), f"{end:g} {y}") for end in ends for y in (0.0, 40.0)]
    shown, _ = annotated_views([front, cut], specs)
    (mark,) = [a for a in shown.annotations if isinstance(a, annotation.SectionMark)]
    assert shown.conflicts == 0
    heights = [line.line_at[1] for line in lines_of(shown).values()]
    low, high = sorted((mark.start[1], mark.end[1]))
    assert low <= min(heights) - 6.0 and high >= max(heights) + 6.0
