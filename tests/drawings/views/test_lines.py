"""Centre lines, thin lines of threads, and coincident curves."""

import math
import random

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drawings.views import view
from drawings.views.centre_lines import BEYOND, axes_of, centre_lines
from drawings.views.line_cleaning import cleaned, joined, without
from drawings.views.projection import project
from drawings.views.segment_index import Line, SegmentIndex, line_meets_box
from drawings.views.thread_lines import ThreadedHole, thread_lines, without_mouths
from drawings.views.view import Segment

HOLE = ThreadedHole((10.0, 20.0, 5.0), (0.0, 0.0, -1.0), 8.0, 3.3, 4.0, blind=True)
SPACE = 40.0


def box_of(curves: tuple[view.Curve, ...]) -> view.Box2:
    return view.bounding_box([point for curve in curves for point in view.extreme_points(curve)])


def drilled() -> cq.Shape:
    shape = cq.Workplane().box(60, 40, 20).edges("|Z").fillet(6).faces(">Z").workplane().center(10, 5).hole(8).val()
    assert isinstance(shape, cq.Shape)
    return shape


def lines(direction: str, *, hidden: bool, scale: float = 1.0, symmetry: str = "") -> list[Segment]:
    shape = drilled().wrapped
    curves = project(shape, view.PROJECTIONS[direction], hidden=hidden)
    found: tuple[view.Curve, ...] = centre_lines(curves, axes_of(shape), view.PROJECTIONS[direction], scale, symmetry)
    return [line for line in found if isinstance(line, Segment)]


def test_centre_lines_of_holes_and_symmetry() -> None:
    found = lines("top", hidden=False)
    assert len(found) == 2
    assert box_of(found) == pytest.approx((10 - 4 - BEYOND, 5 - 4 - BEYOND, 10 + 4 + BEYOND, 5 + 4 + BEYOND))
    assert box_of(lines("top", hidden=False, scale=0.5))[0] == pytest.approx(10 - 4 - 2 * BEYOND)
    assert lines("front", hidden=False) == []
    (axis,) = lines("front", hidden=True)
    assert axis.start[0] == pytest.approx(10.0) and axis.end[0] == pytest.approx(10.0)
    assert sorted((axis.start[1], axis.end[1])) == pytest.approx([-10 - BEYOND, 10 + BEYOND])
    found = lines("front", hidden=False, symmetry="uv")
    assert box_of(found) == pytest.approx((-30 - BEYOND, -10 - BEYOND, 30 + BEYOND, 10 + BEYOND))


def test_lines_of_threads_from_the_end() -> None:
    drill: dict[view.Layer, tuple[view.Curve, ...]] = {"VISIBLE": (view.Arc((10.0, 20.0), 1.65),)}
    (arc,) = thread_lines(drill, [HOLE], view.PROJECTIONS["top"], None, 2.5)["THREAD"]
    assert isinstance(arc, view.Arc) and arc.radius == 2.0 and 225.0 <= arc.end_angle - arc.start_angle <= 290.0
    assert thread_lines({"VISIBLE": ()}, [HOLE], view.PROJECTIONS["top"], None, 1.0)["THREAD"] == ()
    assert thread_lines({}, [HOLE], view.PROJECTIONS["front"], None, 1.0)["THREAD"] == ()


def test_a_section_shows_the_thread_to_its_full_length_and_its_end() -> None:
    cut = view.Cut((0.0, 20.0, 0.0), (0.0, -1.0, 0.0), "A")
    lines = thread_lines({}, [HOLE], view.PROJECTIONS["front"], cut, 2.5)
    sides = sorted((line.start[0], line.start[1], line.end[1]) for line in lines["THREAD"] if isinstance(line, Segment))
    assert sides == [pytest.approx((8.0, 5.0, -3.0)), pytest.approx((12.0, 5.0, -3.0))]
    (end,) = lines["VISIBLE"]
    assert isinstance(end, Segment) and {end.start, end.end} == {(8.0, -3.0), (12.0, -3.0)}
    beside = view.Cut((0.0, 21.0, 0.0), (0.0, -1.0, 0.0), "A")
    assert thread_lines({}, [HOLE], view.PROJECTIONS["front"], beside, 1.0)["THREAD"] == ()


def test_thread_lines_are_apart_and_their_chamfer_is_omitted() -> None:
    """ISO 6410-1: an M3 at 1:2 would have its lines 0.13 mm apart."""
    hole = ThreadedHole((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 5.0, 2.5, 3.0, blind=True)
    drill: dict[view.Layer, tuple[view.Curve, ...]] = {"VISIBLE": (view.Arc((0.0, 0.0), 1.25),)}
    for scale in (0.5, 1.0, 2.0, 5.0):
        (arc,) = thread_lines(drill, [hole], view.PROJECTIONS["top"], None, scale)["THREAD"]
        assert isinstance(arc, view.Arc) and arc.radius == pytest.approx(max(1.5, 1.25 + 0.7 / scale))
    hole = ThreadedHole((10.0, 20.0, 5.0), (0.0, 0.0, -1.0), 8.0, 3.3, 4.0, blind=True, rim=1.95)
    bore, rim, drill = (view.Arc((10.0, 20.0), radius) for radius in (3.0, 1.95, 1.65))
    beside = view.Arc((30.0, 20.0), 1.95)
    assert without_mouths((bore, rim, drill, beside), [hole], view.PROJECTIONS["top"]) == (bore, drill, beside)
    assert without_mouths((rim,), [HOLE], view.PROJECTIONS["top"]) == (rim,)


def test_pieces_of_lines_and_arcs_are_joined_and_hidden_ones_left_out() -> None:
    visible, hidden = cleaned([Segment((0, 0), (5, 5)), Segment((9, 9), (4, 4)), Segment((0, 1), (5, 6))])
    assert hidden == ()
    lengths = [math.dist(line.start, line.end) for line in visible if isinstance(line, Segment)]
    assert lengths == pytest.approx([9 * math.sqrt(2), 5 * math.sqrt(2)], abs=1e-9)
    visible, hidden = cleaned([Segment((2, 0), (4, 0))], [Segment((6, 0), (0, 0)), Segment((3, 0), (5, 0))])
    assert len(visible) == 1
    ends = [(line.start, line.end) for line in hidden if isinstance(line, Segment)]
    assert ends == [((0.0, 0.0), (2.0, 0.0)), ((4.0, 0.0), (6.0, 0.0))]
    visible, _ = cleaned([Segment((0, 0), (5, 1e-7)), Segment((9, 0), (4, 1e-7))])
    assert len(visible) == 1
    visible, hidden = cleaned(
        [view.Arc((0, 0), 5, 10, 200), view.Arc((0, 0), 5, 190, 375)],
        [view.Arc((0, 0), 5), view.Arc((0, 0), 4, 350, 370)],
    )
    assert visible == (view.Arc((0, 0), 5, 0.0, 360.0),) and hidden == (view.Arc((0, 0), 4, 350.0, 370.0),)
    curve = view.Polyline(tuple((t / 10, math.sin(t / 10)) for t in range(60)))
    part = view.Polyline(curve.points[20:40])
    beyond = view.Polyline(tuple((t / 10, math.sin(t / 10)) for t in range(50, 80)))
    visible, hidden = cleaned([curve], [part, beyond])
    assert visible == (curve,)
    (rest,) = hidden
    assert isinstance(rest, view.Polyline) and rest.points == beyond.points[9:]


@settings(max_examples=50)
@given(st.integers(0, 10**6))
def test_the_result_is_independent_of_order_and_covers_the_input(seed: int) -> None:
    generator = random.Random(seed)
    ends = [(float(generator.randrange(9)), float(generator.randrange(9)), k // 8) for k in range(16)]
    lines = [Segment((a, float(y)), (b, float(y))) for a, b, y in ends if a != b]
    shown, dashed = lines[::2], lines[1::2]
    first = cleaned(shown, dashed)
    assert cleaned(generator.sample(shown, len(shown)), generator.sample(dashed, len(dashed))) == first

    def units(curves: object) -> set[tuple[float, float]]:
        return {
            (x, line.start[1])
            for line in curves  # type: ignore[attr-defined]
            for x in range(round(min(line.start[0], line.end[0])), round(max(line.start[0], line.end[0])))
        }

    assert units(first[0]) == units(shown) and units(first[1]) == units(dashed) - units(shown)


def test_spans_crossings_and_parallels_of_lines() -> None:
    assert joined([(3.0, 4.0), (0.0, 1.0), (1.0, 2.0)]) == [(0.0, 2.0), (3.0, 4.0)]
    assert without([(0.0, 10.0)], [(2.0, 3.0), (9.0, 12.0)]) == [(0.0, 2.0), (3.0, 9.0)]
    assert without([(0.0, 1.0)], [(0.0, 1.0)]) == []
    assert joined([(0.0, 1.0)]) == [(0.0, 1.0)] and pytest.approx(1.0) == joined([(0.0, 0.5), (0.5005, 1.0)])[0][1]
    lines = random_lines(1)
    index = SegmentIndex(lines)
    expected = [sum(cross(one, other) for other in lines) for one in random_lines(2)]
    assert [index.count_crossing(one) for one in random_lines(2)] == expected and max(expected) > 5
    lines = random_lines(3)
    index = SegmentIndex(lines)
    expected = [sum(beside(one, other, 1.5) for other in lines) for one in lines]
    assert [index.count_beside(1.5, one)[0] for one in lines] == expected and max(expected) > 1
    assert index.count_beside(1.5, (3.0, 3.0, 3.0, 3.0)) == (0, 0)


def random_lines(seed: int) -> list[Line]:
    """Lines in any direction, and some along the axes, which meet others in a point or lie on them."""
    generator = np.random.default_rng(seed)
    slanted = generator.uniform(0.0, SPACE, (40, 4))
    x, y, length = (generator.integers(0, 8, 40) * 5.0 for _ in range(3))
    along = [(a, b, a + c, b) if k % 2 else (a, b, a, b + c) for k, (a, b, c) in enumerate(zip(x, y, length + 5.0))]
    return [(a, b, c, d) for a, b, c, d in [*slanted.tolist(), *along]]


def ends(line: Line) -> tuple[complex, complex]:
    return complex(*line[:2]), complex(*line[2:])


def cross(one: Line, other: Line) -> bool:
    """The solution of a + s (b - a) = c + t (d - c) with s and t within 0 and 1."""
    (a, b), (c, d) = ends(one), ends(other)
    matrix = np.array([[(b - a).real, (c - d).real], [(b - a).imag, (c - d).imag]])
    if abs(np.linalg.det(matrix)) < 1e-9:
        return False
    s, t = np.linalg.solve(matrix, [(c - a).real, (c - a).imag])
    return bool(1e-6 < s < 1 - 1e-6 and 1e-6 < t < 1 - 1e-6)


def beside(one: Line, other: Line, distance: float) -> bool:
    """Whether the other line, in coordinates along the first, stays near it and shares more than a millimetre."""
    a, b = ends(one)
    turned = [(end - a) * abs(b - a) / (b - a) for end in ends(other)]
    low, high = sorted(point.real for point in turned)
    shared = min(high, abs(b - a)) - max(low, 0.0)
    return all(abs(point.imag) < distance - 1e-9 for point in turned) and shared > 1.0 + 1e-9


def test_lines_that_reach_into_a_box() -> None:
    index = SegmentIndex()
    assert index.count_in((0.0, 0.0, SPACE, SPACE)) == 0
    lines = random_lines(4)
    index.add(lines[:30])
    index.add(lines[30:])
    corners = np.random.default_rng(5).uniform(0.0, SPACE - 10.0, (30, 2)).tolist()
    boxes = [(x, y, x + 10.0, y + 4.0) for x, y in corners]
    expected = [sum(line_meets_box(line, box) for line in lines) for box in boxes]
    assert [index.count_in(box) for box in boxes] == expected and max(expected) > 5
    inside = index.near((10.0, 10.0, 20.0, 14.0))
    assert {line for line in lines if line_meets_box(line, (10.0, 10.0, 20.0, 14.0))} <= set(inside)
