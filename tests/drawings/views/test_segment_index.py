"""Counts of lines in a box, crossed, and parallel, against the same geometry in complex numbers, line by line."""

import numpy as np

from drawings.views.segment_index import Line, SegmentIndex, line_meets_box

SPACE = 40.0


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


def test_lines_crossed_by_a_line() -> None:
    lines = random_lines(1)
    index = SegmentIndex(lines)
    expected = [sum(cross(one, other) for other in lines) for one in random_lines(2)]
    assert [index.count_crossing(one) for one in random_lines(2)] == expected
    assert max(expected) > 5


def test_lines_parallel_to_a_line_and_near_it() -> None:
    lines = random_lines(3)
    index = SegmentIndex(lines)
    expected = [sum(beside(one, other, 1.5) for other in lines) for one in lines]
    assert [index.count_parallel(one, 1.5) for one in lines] == expected
    assert max(expected) > 1
    assert index.count_parallel((3.0, 3.0, 3.0, 3.0), 1.5) == 0


def test_lines_that_reach_into_a_box() -> None:
    index = SegmentIndex()
    assert index.count_in((0.0, 0.0, SPACE, SPACE)) == 0
    lines = random_lines(4)
    index.add(lines[:30])
    index.add(lines[30:])
    corners = np.random.default_rng(5).uniform(0.0, SPACE - 10.0, (30, 2)).tolist()
    boxes = [(x, y, x + 10.0, y + 4.0) for x, y in corners]
    expected = [sum(line_meets_box(line, box) for line in lines) for box in boxes]
    assert [index.count_in(box) for box in boxes] == expected
    assert max(expected) > 5
    inside = index.near((10.0, 10.0, 20.0, 14.0))
    assert {line for line in lines if line_meets_box(line, (10.0, 10.0, 20.0, 14.0))} <= set(inside)
