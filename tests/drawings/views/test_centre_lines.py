"""Centre lines and centre marks: on round features and nowhere else."""

import cadquery as cq
import pytest

from drawings.views.centre_lines import BEYOND, axes_of, centre_lines
from drawings.views.projection import project
from drawings.views.view import PROJECTIONS, Box2, Curve, Segment, bounding_box, extreme_points


def box_of(curves: tuple[Curve, ...]) -> Box2:
    return bounding_box([point for curve in curves for point in extreme_points(curve)])


def drilled() -> cq.Shape:
    shape = cq.Workplane().box(60, 40, 20).edges("|Z").fillet(6).faces(">Z").workplane().center(10, 5).hole(8).val()
    assert isinstance(shape, cq.Shape)
    return shape


def lines(direction: str, *, hidden: bool, scale: float = 1.0, symmetry: str = "") -> list[Segment]:
    shape = drilled().wrapped
    curves = project(shape, PROJECTIONS[direction], hidden=hidden)
    found: tuple[Curve, ...] = centre_lines(curves, axes_of(shape), PROJECTIONS[direction], scale, symmetry)
    return [line for line in found if isinstance(line, Segment)]


def test_a_hole_gets_a_cross_and_a_rounded_corner_none() -> None:
    found = lines("top", hidden=False)
    assert len(found) == 2
    box = box_of(found)
    assert box == pytest.approx((10 - 4 - BEYOND, 5 - 4 - BEYOND, 10 + 4 + BEYOND, 5 + 4 + BEYOND))


def test_the_ends_are_measured_on_paper() -> None:
    assert box_of(lines("top", hidden=False, scale=0.5))[0] == pytest.approx(10 - 4 - 2 * BEYOND)


def test_from_the_side_only_where_its_edges_are_shown() -> None:
    assert lines("front", hidden=False) == []
    (axis,) = lines("front", hidden=True)
    assert axis.start[0] == pytest.approx(10.0) and axis.end[0] == pytest.approx(10.0)
    assert sorted((axis.start[1], axis.end[1])) == pytest.approx([-10 - BEYOND, 10 + BEYOND])


def test_lines_of_symmetry_cross_the_view() -> None:
    found = lines("front", hidden=False, symmetry="uv")
    assert box_of(found) == pytest.approx((-30 - BEYOND, -10 - BEYOND, 30 + BEYOND, 10 + BEYOND))
