"""Thin lines of threads by ISO 6410-1: three quarters of a circle from the end, two lines in a section."""

import pytest

from drawings.views.thread_lines import ThreadedHole, thread_lines, without_mouths
from drawings.views.view import PROJECTIONS, Arc, Curve, Cut, Layer, Segment

HOLE = ThreadedHole((10.0, 20.0, 5.0), (0.0, 0.0, -1.0), 8.0, 3.3, 4.0, blind=True)


def test_from_the_end_the_major_diameter_is_three_quarters_of_a_circle() -> None:
    drill: dict[Layer, tuple[Curve, ...]] = {"VISIBLE": (Arc((10.0, 20.0), 1.65),)}
    (arc,) = thread_lines(drill, [HOLE], PROJECTIONS["top"], None, 2.5)["THREAD"]
    assert isinstance(arc, Arc)
    assert arc.radius == 2.0
    assert 225.0 <= arc.end_angle - arc.start_angle <= 290.0


def test_a_hole_that_is_not_seen_has_no_thread_line() -> None:
    assert thread_lines({"VISIBLE": ()}, [HOLE], PROJECTIONS["top"], None, 1.0)["THREAD"] == ()
    assert thread_lines({}, [HOLE], PROJECTIONS["front"], None, 1.0)["THREAD"] == ()


def test_a_section_shows_the_thread_to_its_full_length_and_its_end() -> None:
    cut = Cut((0.0, 20.0, 0.0), (0.0, -1.0, 0.0), "A")
    lines = thread_lines({}, [HOLE], PROJECTIONS["front"], cut, 2.5)
    sides = sorted((line.start[0], line.start[1], line.end[1]) for line in lines["THREAD"] if isinstance(line, Segment))
    assert sides == [pytest.approx((8.0, 5.0, -3.0)), pytest.approx((12.0, 5.0, -3.0))]
    (end,) = lines["VISIBLE"]
    assert isinstance(end, Segment)
    assert {end.start, end.end} == {(8.0, -3.0), (12.0, -3.0)}
    beside = Cut((0.0, 21.0, 0.0), (0.0, -1.0, 0.0), "A")
    assert thread_lines({}, [HOLE], PROJECTIONS["front"], beside, 1.0)["THREAD"] == ()


def test_the_thin_line_is_at_least_0_7_mm_off_the_thick_one_on_the_paper() -> None:
    """ISO 6410-1: an M3 at 1:2 would have its lines 0.13 mm apart."""
    hole = ThreadedHole((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 5.0, 2.5, 3.0, blind=True)
    drill: dict[Layer, tuple[Curve, ...]] = {"VISIBLE": (Arc((0.0, 0.0), 1.25),)}
    for scale in (0.5, 1.0, 2.0, 5.0):
        (arc,) = thread_lines(drill, [hole], PROJECTIONS["top"], None, scale)["THREAD"]
        assert isinstance(arc, Arc)
        assert arc.radius == pytest.approx(max(1.5, 1.25 + 0.7 / scale))


def test_the_circle_of_the_chamfer_of_a_thread_is_omitted_and_no_other() -> None:
    hole = ThreadedHole((10.0, 20.0, 5.0), (0.0, 0.0, -1.0), 8.0, 3.3, 4.0, blind=True, rim=1.95)
    bore, rim, drill = (Arc((10.0, 20.0), radius) for radius in (3.0, 1.95, 1.65))
    beside = Arc((30.0, 20.0), 1.95)
    assert without_mouths((bore, rim, drill, beside), [hole], PROJECTIONS["top"]) == (bore, drill, beside)
    assert without_mouths((rim,), [HOLE], PROJECTIONS["top"]) == (rim,)
