"""Coincident curves: pieces joined, no hidden line under a visible one, independent of the order of the input."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drawings.views.line_cleaning import cleaned, joined, without
from drawings.views.view import Arc, Polyline, Segment


def test_pieces_of_one_line_become_one() -> None:
    visible, hidden = cleaned([Segment((0, 0), (5, 5)), Segment((9, 9), (4, 4)), Segment((0, 1), (5, 6))])
    assert hidden == ()
    assert [round(math.dist(line.start, line.end), 9) for line in visible if isinstance(line, Segment)] == [
        round(9 * math.sqrt(2), 9),
        round(5 * math.sqrt(2), 9),
    ]


def test_a_hidden_line_under_a_visible_one_is_left_out() -> None:
    visible, hidden = cleaned([Segment((2, 0), (4, 0))], [Segment((6, 0), (0, 0)), Segment((3, 0), (5, 0))])
    assert len(visible) == 1
    assert [(line.start, line.end) for line in hidden if isinstance(line, Segment)] == [
        ((0.0, 0.0), (2.0, 0.0)),
        ((4.0, 0.0), (6.0, 0.0)),
    ]


def test_lines_on_both_sides_of_half_a_turn_are_one_direction() -> None:
    visible, _ = cleaned([Segment((0, 0), (5, 1e-7)), Segment((9, 0), (4, 1e-7))])
    assert len(visible) == 1


def test_arcs_close_to_a_circle_over_the_end_of_the_turn() -> None:
    visible, hidden = cleaned(
        [Arc((0, 0), 5, 10, 200), Arc((0, 0), 5, 190, 375)], [Arc((0, 0), 5), Arc((0, 0), 4, 350, 370)]
    )
    assert visible == (Arc((0, 0), 5, 0.0, 360.0),)
    assert hidden == (Arc((0, 0), 4, 350.0, 370.0),)


def test_coincident_polylines_are_drawn_once() -> None:
    curve = Polyline(tuple((t / 10, math.sin(t / 10)) for t in range(60)))
    part = Polyline(curve.points[20:40])
    beyond = Polyline(tuple((t / 10, math.sin(t / 10)) for t in range(50, 80)))
    visible, hidden = cleaned([curve], [part, beyond])
    assert visible == (curve,)
    (rest,) = hidden
    assert isinstance(rest, Polyline)
    assert rest.points == beyond.points[9:]


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6))
def test_the_result_is_independent_of_order_and_covers_the_input(seed: int) -> None:
    generator = random.Random(seed)
    lines = [
        Segment((float(generator.randrange(9)), y), (float(generator.randrange(9)), y))
        for y in (0.0, 1.0)
        for _ in range(8)
    ]
    lines = [line for line in lines if line.start != line.end]
    shown, dashed = lines[::2], lines[1::2]
    first = cleaned(shown, dashed)
    assert cleaned(generator.sample(shown, len(shown)), generator.sample(dashed, len(dashed))) == first

    def units(curves: object) -> set[tuple[float, float]]:
        return {
            (x, line.start[1])
            for line in curves  # type: ignore[attr-defined]
            for x in range(round(min(line.start[0], line.end[0])), round(max(line.start[0], line.end[0])))
        }

    assert units(first[0]) == units(shown)
    assert units(first[1]) == units(dashed) - units(shown)


def test_spans() -> None:
    assert joined([(3.0, 4.0), (0.0, 1.0), (1.0, 2.0)]) == [(0.0, 2.0), (3.0, 4.0)]
    assert without([(0.0, 10.0)], [(2.0, 3.0), (9.0, 12.0)]) == [(0.0, 2.0), (3.0, 9.0)]
    assert without([(0.0, 1.0)], [(0.0, 1.0)]) == []
    assert joined([(0.0, 1.0)]) == [(0.0, 1.0)]
    assert pytest.approx(1.0) == joined([(0.0, 0.5), (0.5005, 1.0)])[0][1]
