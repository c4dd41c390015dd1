"""Sections and details: what is cut, how it is hatched, what a circle keeps."""

import math
from itertools import pairwise

import cadquery as cq
import pytest

from drawings.pictures.picture import meshed
from drawings.views.detail import clipped
from drawings.views.section import HATCH_PITCH, cut_faces, cut_shape, hatch, hatch_lines, in_plane, without_changes
from drawings.views.view import PROJECTIONS, Arc, Curve, Cut, Polyline, Segment

FRONT = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")


def tube() -> cq.Shape:
    shape = cq.Workplane().circle(20).circle(12).extrude(30).val()
    assert isinstance(shape, cq.Shape)
    return shape


def test_half_is_left_behind_the_plane() -> None:
    left = cq.Shape.cast(cut_shape(tube().wrapped, FRONT))
    assert left.Volume() == pytest.approx(tube().Volume() / 2)
    assert left.BoundingBox().ymin == pytest.approx(0.0, abs=1e-6)


def test_a_part_far_from_the_point_of_the_plane_is_cut_too() -> None:
    far = cq.Shape.cast(cut_shape(tube().translate((300.0, 5.0, -400.0)).wrapped, FRONT))

    # Of the ring about y = 5, what is behind y = 0: half of it, and the segment of the ring between.
    def behind(radius: float) -> float:
        return radius**2 * math.acos(-5.0 / radius) + 5.0 * math.sqrt(radius**2 - 25.0)

    assert far.Volume() == pytest.approx(30.0 * (behind(20.0) - behind(12.0)))
    assert far.BoundingBox().ymin == pytest.approx(0.0, abs=1e-6)


def test_a_plane_that_misses_is_an_error() -> None:
    with pytest.raises(ValueError, match="does not cut"):
        cut_shape(tube().wrapped, Cut((0.0, 50.0, 0.0), (0.0, -1.0, 0.0), "A"))


def test_offset_half_and_aligned_sections_cut_where_their_planes_are() -> None:
    """A plate with two holes: planes through both, a quarter taken out, and the second hole turned into the plane."""
    plate = cq.Workplane().box(80, 60, 10).faces(">Z").workplane().pushPoints([(-20, -10), (20, 20)]).hole(8).val()
    assert isinstance(plate, cq.Shape)
    whole, (first, second), along = 80.0 * 60 * 10, ((-20.0, -10.0, 0.0), (20.0, 20.0, 0.0)), (1.0, 0.0, 0.0)
    offset = Cut(first, FRONT.normal, "A", (second,), way=along)
    left = cq.Shape.cast(cut_shape(plate.wrapped, offset))
    assert offset.changes == (0.0,) and offset.path == (first, (0.0, -10.0, 0.0), (0.0, 20.0, 0.0), second)
    assert left.Volume() == pytest.approx((40 * 40 + 40 * 10 - math.pi * 16) * 10.0)
    loops = sum(cq.Shape.cast(face).Area() for face in cut_faces(left.wrapped, offset))
    assert loops == pytest.approx(2 * 32 * 10)
    lines = [Segment((0.0, -5.0), (0.0, 5.0)), Segment((16.0, -5.0), (16.0, 5.0))]
    assert without_changes(lines, offset, PROJECTIONS["front"]) == (lines[1],)
    half = Cut((0.0, 0.0, 0.0), FRONT.normal, "B", kind="half", way=along)
    quarter = cq.Shape.cast(cut_shape(plate.wrapped, half)).Volume()
    assert quarter == pytest.approx(plate.Volume() - whole / 4)
    aligned = Cut((0.0, 0.0, 0.0), FRONT.normal, "C", (second,), kind="aligned", way=along)
    turned = cut_shape(plate.wrapped, aligned)
    walls = [cq.Shape.cast(face).BoundingBox() for face in cut_faces(turned, aligned)]
    edges = sorted(round(x, 3) for wall in walls for x in (wall.xmin, wall.xmax))
    # At the right the diagonal as far as the side of the plate, the hole at its distance from the middle.
    apart = math.hypot(20.0, 20.0)
    assert edges == pytest.approx([-40.0, 0.0, 0.0, apart - 4, apart + 4, math.hypot(30.0, 30.0)], abs=1e-3)


@pytest.mark.parametrize("scale", [1.0, 0.2])
def test_hatch_covers_the_cut_faces_and_nothing_else(scale: float) -> None:
    left = cut_shape(tube().wrapped, FRONT)
    lines = hatch(cut_faces(left, FRONT), PROJECTIONS["front"], scale)
    # Lines of pitch p cover an area with its value over p of length; two walls of 8 by 30.
    length = sum(math.dist(line.start, line.end) for line in lines)
    assert length * HATCH_PITCH / scale == pytest.approx(2 * 8 * 30, rel=0.02 / scale)
    for line in lines:
        for t in (0.02, 0.5, 0.98):
            x = line.start[0] + t * (line.end[0] - line.start[0])
            z = line.start[1] + t * (line.end[1] - line.start[1])
            assert 12.0 <= abs(x) <= 20.0 and 0.0 <= z <= 30.0


def test_hatch_leaves_out_holes_and_may_fall() -> None:
    square = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0)]
    hole = [(10.0, 10.0), (20.0, 10.0), (20.0, 20.0), (10.0, 20.0)]
    lines = hatch_lines([square, hole], 0.5)
    assert sum(math.dist(line.start, line.end) for line in lines) * 0.5 == pytest.approx(800.0, rel=0.01)
    falling = hatch_lines([square], 3.0, -45.0)
    assert all(line.end[1] < line.start[1] for line in falling)
    assert hatch_lines([], 1.0) == ()


def test_hatch_ends_where_a_piece_that_is_not_cut_covers_it() -> None:
    """A square pin in the tube's bore of 12 mm radius and its wall: from -15 to -1 across, from 5 to 25 up."""
    pin = cq.Workplane().box(14, 14, 20).translate((-8, 0, 15)).val()
    assert isinstance(pin, cq.Shape)
    mesh = meshed(pin.wrapped)
    outline = in_plane(mesh.vertices, mesh.triangles, FRONT, PROJECTIONS["front"])
    left = cut_shape(tube().wrapped, FRONT)
    lines = hatch(cut_faces(left, FRONT), PROJECTIONS["front"], 10.0, covers=[outline])
    length = sum(math.dist(line.start, line.end) for line in lines)
    # The two walls without the 3 by 20 that the pin covers of one.
    assert length * HATCH_PITCH / 10.0 == pytest.approx(2 * 8 * 30 - 3 * 20, rel=0.005)
    for line in lines:
        for x, z in (line.start, line.end, ((line.start[0] + line.end[0]) / 2, (line.start[1] + line.end[1]) / 2)):
            assert not (-14.99 < x < -1.0 and 5.01 < z < 24.99)


def lengths(curves: tuple[Curve, ...]) -> float:
    total = 0.0
    for curve in curves:
        if isinstance(curve, Segment):
            total += math.dist(curve.start, curve.end)
        elif isinstance(curve, Arc):
            total += curve.radius * math.radians(curve.end_angle - curve.start_angle)
        else:
            total += sum(math.dist(a, b) for a, b in pairwise(curve.points))
    return total


@pytest.mark.parametrize(
    "curve",
    [
        Segment((-10.0, 1.0), (10.0, 2.0)),
        Segment((-1.0, 0.0), (1.0, 0.5)),
        Segment((-10.0, 8.0), (10.0, 8.0)),
        Arc((3.0, 0.0), 4.0),
        Arc((0.0, 0.0), 2.0, 10.0, 100.0),
        Arc((4.0, 0.0), 3.0, 200.0, 500.0),
        Arc((0.0, 0.0), 9.0),
    ],
)
def test_a_circle_keeps_what_lies_inside(curve: Curve) -> None:
    centre, radius = (0.5, 0.3), 5.0
    if isinstance(curve, Segment):
        points = [
            tuple(a + t / 20000 * (b - a) for a, b in zip(curve.start, curve.end, strict=True)) for t in range(20001)
        ]
    else:
        assert isinstance(curve, Arc)
        turns = [
            math.radians(curve.start_angle + t / 20000 * (curve.end_angle - curve.start_angle)) for t in range(20001)
        ]
        points = [
            (curve.centre[0] + curve.radius * math.cos(a), curve.centre[1] + curve.radius * math.sin(a)) for a in turns
        ]
    inside = sum(math.dist(a, b) for a, b in pairwise(points) if math.dist(a, centre) < radius)
    assert lengths(clipped([curve], centre, radius)) == pytest.approx(inside, abs=5e-3)
    as_line = Polyline(tuple(points))  # type: ignore[arg-type]
    assert lengths(clipped([as_line], centre, radius)) == pytest.approx(inside, abs=5e-3)
