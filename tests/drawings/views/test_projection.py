"""Projections and sections of solids."""

import math
import random
from itertools import pairwise

import cadquery as cq
import pytest

from drawings.pictures.picture import meshed
from drawings.views import section
from drawings.views.detail import clipped
from drawings.views.projection import hidden_lines, project, with_simple_curves
from drawings.views.segment_index import curve_points
from drawings.views.view import PROJECTIONS, Arc, Curve, Cut, Point2, Polyline, Projection, Segment
from stagecad.solids.modelling.kernel import occ

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
FRONT = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")


def solid_of(boxes: list[Box]) -> cq.Shape:
    pieces = [cq.Solid.makeBox(*(b - a for a, b in zip(low, high)), cq.Vector(*low)) for low, high in boxes]
    return pieces[0].fuse(*pieces[1:]).clean() if len(pieces) > 1 else pieces[0]


def heaps(seed: int) -> list[Box]:
    """Boxes that reach into one another at random, with no two faces in one plane."""
    generator = random.Random(seed)
    boxes = []
    for _ in range(5):
        low = [generator.uniform(0, 30) for _ in range(3)]
        boxes.append((tuple(low), tuple(at + generator.uniform(8, 25) for at in low)))
    return boxes  # type: ignore[return-value]


def covered(boxes: list[Box], projection: Projection, point: Point2) -> list[tuple[float, float]]:
    """From where to where, towards the eye, the line of sight through a point of the view is in material."""
    eye = projection.towards_eye
    start = [u * point[0] + v * point[1] for u, v in zip(projection.right, projection.up, strict=True)]
    spans = []
    for low, high in boxes:
        near, far = -math.inf, math.inf
        for a, b, at, along in zip(low, high, start, eye, strict=True):
            if abs(along) < 1e-12:
                if not a < at < b:
                    near, far = 1.0, 0.0
                continue
            ends = sorted(((a - at) / along, (b - at) / along))
            near, far = max(near, ends[0]), min(far, ends[1])
        if far > near:
            spans.append((near, far))
    return spans


def points_beside(curve: Curve, by: float = 0.02) -> tuple[Point2, Point2]:
    """A point on either side of the middle of a segment."""
    assert isinstance(curve, Segment)
    (x, y), (p, q) = curve.start, curve.end
    length = math.hypot(p - x, q - y)
    n = (-(q - y) / length * by, (p - x) / length * by)
    middle = ((x + p) / 2, (y + q) / 2)
    return (middle[0] + n[0], middle[1] + n[1]), (middle[0] - n[0], middle[1] - n[1])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("direction", ["front", "top", "right", "iso"])
def test_another_face_is_in_front_on_the_other_side_of_a_visible_line(seed: int, direction: str) -> None:
    boxes, projection = heaps(seed), PROJECTIONS[direction]
    curves = project(solid_of(boxes).wrapped, projection)
    assert len(curves["VISIBLE"]) > 3
    for curve in curves["VISIBLE"]:
        one, other = (front_face(boxes, projection, point) for point in points_beside(curve))
        assert one != other


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("direction", ["front", "iso"])
def test_where_another_face_comes_to_the_front_there_is_a_line(seed: int, direction: str) -> None:
    boxes, projection = heaps(seed), PROJECTIONS[direction]
    lines = [c for c in project(solid_of(boxes).wrapped, projection)["VISIBLE"] if isinstance(c, Segment)]
    step, changes = 0.3, 0
    for v in (5.03, 11.41, 17.77, 30.19):
        row = [(-10.0 + step * i, v) for i in range(240)]
        faces = [front_face(boxes, projection, point) for point in row]
        for one, other, first, second in zip(faces, faces[1:], row, row[1:]):
            if one != other:
                changes += 1
                assert any(crosses(line, first, second) for line in lines)
    assert changes > 5


def crosses(line: Segment, first: Point2, second: Point2) -> bool:
    """Whether a segment meets the level stretch between two points, or ends within a hair of it."""
    (x, y), (p, q) = line.start, line.end
    if max(y, q) < first[1] - 1e-6 or min(y, q) > first[1] + 1e-6:
        return False
    if abs(q - y) < 1e-9:
        return min(x, p) <= second[0] and max(x, p) >= first[0]
    at = x + (first[1] - y) / (q - y) * (p - x)
    return first[0] - 1e-6 <= at <= second[0] + 1e-6


def front_face(boxes: list[Box], projection: Projection, point: Point2) -> tuple[int, float] | None:
    """Axis and place of the face that is nearest to the eye there."""
    spans = covered(boxes, projection, point)
    if not spans:
        return None
    depth = max(far for _, far in spans)
    eye = projection.towards_eye
    place = [u * point[0] + v * point[1] + depth * w for u, v, w in zip(projection.right, projection.up, eye)]
    for low, high in boxes:
        for axis in range(3):
            for plane in (low[axis], high[axis]):
                inside = all(low[k] - 1e-9 <= place[k] <= high[k] + 1e-9 for k in range(3) if k != axis)
                if inside and abs(place[axis] - plane) < 1e-9:
                    return (axis, plane)
    return None


@pytest.mark.parametrize("seed", range(4))
def test_hidden_lines_lie_behind_material(seed: int) -> None:
    boxes = heaps(seed)
    curves = project(solid_of(boxes).wrapped, PROJECTIONS["front"])
    assert curves["HIDDEN"]
    for curve in curves["HIDDEN"]:
        assert any(covered(boxes, PROJECTIONS["front"], point) for point in points_beside(curve))


def test_circles_dashes_and_crossings_of_bores() -> None:
    plate = cq.Workplane().box(40, 30, 10).faces(">Z").workplane().hole(8).val()
    assert isinstance(plate, cq.Shape)
    top = project(plate.wrapped, PROJECTIONS["top"])
    assert Arc((0.0, 0.0), pytest.approx(4.0)) in [  # type: ignore[arg-type]
        Arc(curve.centre, curve.radius) for curve in top["VISIBLE"] if isinstance(curve, Arc)
    ]
    assert top["HIDDEN"] == ()
    front = project(plate.wrapped, PROJECTIONS["front"])
    assert [round(abs(curve.start[0]), 6) for curve in front["HIDDEN"] if isinstance(curve, Segment)] == [4.0, 4.0]
    assert len(front["VISIBLE"]) == 4
    assert project(plate.wrapped, PROJECTIONS["front"], hidden=False)["HIDDEN"] == ()
    rounded = cq.Workplane().box(40, 30, 10).edges("|Z").fillet(5).val()
    assert isinstance(rounded, cq.Shape)
    front = project(rounded.wrapped, PROJECTIONS["front"])
    assert len(front["VISIBLE"]) == 4
    assert len(project(rounded.wrapped, PROJECTIONS["top"])["VISIBLE"]) == 8
    upright = cq.Solid.makeCylinder(8.0, 60.0, cq.Vector(0, 0, -30))
    level = cq.Solid.makeCylinder(6.0, 60.0, cq.Vector(-30, 0, 0), cq.Vector(1, 0, 0))
    block = cq.Workplane().box(40, 40, 40).val().cut(upright, level)  # type: ignore[union-attr]
    before, simple = block.Volume(), with_simple_curves(block.wrapped)
    assert block.Volume() == before
    edges = [edge for edge in cq.Shape.cast(simple).Edges() if edge.geomType() == "BSPLINE"]
    assert edges
    for edge in edges:
        for at in range(21):
            x, y, z = edge.positionAt(at / 20).toTuple()
            assert math.hypot(x, y) == pytest.approx(8.0, abs=0.01)
            assert math.hypot(y, z) == pytest.approx(6.0, abs=0.01)
    boxes = heaps(1)
    exact = project(solid_of(boxes).wrapped, PROJECTIONS["top"])["VISIBLE"]
    coarse = project(solid_of(boxes).wrapped, PROJECTIONS["top"], exact=False)["VISIBLE"]

    def length(curves: tuple[Curve, ...]) -> float:
        return sum(math.dist(c.start, c.end) for c in curves if isinstance(c, Segment))

    assert not any(isinstance(curve, Polyline) for curve in exact)
    assert length(coarse) == pytest.approx(length(exact), rel=1e-3)


def test_shapes_hide_one_another_and_hatches_leave_out_holes() -> None:
    near = cq.Solid.makeBox(10, 10, 10)
    behind = cq.Solid.makeBox(4, 4, 4, cq.Vector(3, 20, 3))
    lines = hidden_lines([near.wrapped, None, behind.wrapped], PROJECTIONS["front"])
    assert [len(found) for found in lines] == [4, 0, 0]
    lines = hidden_lines([near.wrapped, behind.wrapped], PROJECTIONS["back"])
    assert [len(found) for found in lines] == [4, 4]
    square = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0)]
    lines = section.hatch_lines([square, [(10.0, 10.0), (20.0, 10.0), (20.0, 20.0), (10.0, 20.0)]], 0.5)
    assert sum(math.dist(line.start, line.end) for line in lines) * 0.5 == pytest.approx(800.0, rel=0.01)
    falling = section.hatch_lines([square], 3.0, -45.0)
    assert all(line.end[1] < line.start[1] for line in falling)
    assert section.hatch_lines([], 1.0) == ()


def test_a_coil_is_drawn_from_triangles_and_as_large_as_it_is() -> None:
    path = cq.Workplane(cq.Wire.makeHelix(6, 30, 12))
    coil = cq.Workplane("XZ").center(12, 0).circle(1).sweep(path, isFrenet=True).solids().val()
    visible = project(coil.wrapped, PROJECTIONS["front"], hidden=False)["VISIBLE"]
    assert len(visible) > 500
    points = [point for curve in visible for point in curve_points(curve)]
    assert max(u for u, _ in points) == pytest.approx(13.0, abs=0.03)
    assert min(u for u, _ in points) == pytest.approx(-13.0, abs=0.03)
    assert max(v for _, v in points) - min(v for _, v in points) == pytest.approx(32.0, abs=0.05)


def tube() -> cq.Shape:
    shape = cq.Workplane().circle(20).circle(12).extrude(30).val()
    assert isinstance(shape, cq.Shape)
    return shape


def test_planes_leave_half_or_miss() -> None:
    left = cq.Shape.cast(section.cut_shape(tube().wrapped, FRONT))
    assert left.Volume() == pytest.approx(tube().Volume() / 2)
    assert left.BoundingBox().ymin == pytest.approx(0.0, abs=1e-6)
    far = cq.Shape.cast(section.cut_shape(tube().translate((300.0, 5.0, -400.0)).wrapped, FRONT))

    # Of the ring about y = 5, what is behind y = 0: half of it, and the segment of the ring between.
    def behind(radius: float) -> float:
        return radius**2 * math.acos(-5.0 / radius) + 5.0 * math.sqrt(radius**2 - 25.0)

    assert far.Volume() == pytest.approx(30.0 * (behind(20.0) - behind(12.0)))
    assert far.BoundingBox().ymin == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(ValueError, match="does not cut"):
        section.cut_shape(tube().wrapped, Cut((0.0, 50.0, 0.0), (0.0, -1.0, 0.0), "A"))


def test_offset_half_and_aligned_sections_cut_where_their_planes_are() -> None:
    """A plate with two holes: planes through both, a quarter taken out, and the second hole turned into the plane."""
    plate = cq.Workplane().box(80, 60, 10).faces(">Z").workplane().pushPoints([(-20, -10), (20, 20)]).hole(8).val()
    assert isinstance(plate, cq.Shape)
    whole, (first, second), along = 80.0 * 60 * 10, ((-20.0, -10.0, 0.0), (20.0, 20.0, 0.0)), (1.0, 0.0, 0.0)
    offset = Cut(first, FRONT.normal, "A", (second,), way=along)
    left = cq.Shape.cast(section.cut_shape(plate.wrapped, offset))
    assert offset.changes == (0.0,) and offset.path == (first, (0.0, -10.0, 0.0), (0.0, 20.0, 0.0), second)
    assert left.Volume() == pytest.approx((40 * 40 + 40 * 10 - math.pi * 16) * 10.0)
    loops = sum(cq.Shape.cast(face).Area() for face in section.cut_faces(left.wrapped, offset))
    assert loops == pytest.approx(2 * 32 * 10)
    lines = [Segment((0.0, -5.0), (0.0, 5.0)), Segment((16.0, -5.0), (16.0, 5.0))]
    assert section.without_changes(lines, offset, PROJECTIONS["front"]) == (lines[1],)
    half = Cut((0.0, 0.0, 0.0), FRONT.normal, "B", kind="half", way=along)
    quarter = cq.Shape.cast(section.cut_shape(plate.wrapped, half)).Volume()
    assert quarter == pytest.approx(plate.Volume() - whole / 4)
    aligned = Cut((0.0, 0.0, 0.0), FRONT.normal, "C", (second,), kind="aligned", way=along)
    turned = section.cut_shape(plate.wrapped, aligned)
    walls = [cq.Shape.cast(face).BoundingBox() for face in section.cut_faces(turned, aligned)]
    edges = sorted(round(x, 3) for wall in walls for x in (wall.xmin, wall.xmax))
    # At the right the diagonal as far as the side of the plate, the hole at its distance from the middle.
    apart = math.hypot(20.0, 20.0)
    assert edges == pytest.approx([-40.0, 0.0, 0.0, apart - 4, apart + 4, math.hypot(30.0, 30.0)], abs=1e-3)


@pytest.mark.parametrize("scale", [1.0, 0.2])
def test_hatch_covers_the_cut_faces_and_nothing_else(scale: float) -> None:
    lines = section.hatch(
        section.cut_faces(section.cut_shape(tube().wrapped, FRONT), FRONT), PROJECTIONS["front"], scale
    )
    # Lines of pitch p cover an area with its value over p of length; two walls of 8 by 30.
    length = sum(math.dist(line.start, line.end) for line in lines)
    assert length * section.HATCH_PITCH / scale == pytest.approx(2 * 8 * 30, rel=0.02 / scale)
    for line in lines:
        for t in (0.02, 0.5, 0.98):
            x = line.start[0] + t * (line.end[0] - line.start[0])
            z = line.start[1] + t * (line.end[1] - line.start[1])
            assert 12.0 <= abs(x) <= 20.0 and 0.0 <= z <= 30.0


def test_hatch_ends_where_a_piece_that_is_not_cut_covers_it() -> None:
    """A square pin in the tube's bore of 12 mm radius and its wall: from -15 to -1 across, from 5 to 25 up."""
    pin = cq.Workplane().box(14, 14, 20).translate((-8, 0, 15)).val()
    assert isinstance(pin, cq.Shape)
    mesh = meshed(pin.wrapped)
    outline = section.in_plane(mesh.vertices, mesh.triangles, FRONT, PROJECTIONS["front"])
    left = section.cut_shape(tube().wrapped, FRONT)
    lines = section.hatch(section.cut_faces(left, FRONT), PROJECTIONS["front"], 10.0, covers=[outline])
    length = sum(math.dist(line.start, line.end) for line in lines)
    # The two walls without the 3 by 20 that the pin covers of one.
    assert length * section.HATCH_PITCH / 10.0 == pytest.approx(2 * 8 * 30 - 3 * 20, rel=0.005)
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


@pytest.mark.parametrize("curve", [
    Segment((-10.0, 1.0), (10.0, 2.0)), Segment((-1.0, 0.0), (1.0, 0.5)), Segment((-10.0, 8.0), (10.0, 8.0)),
    Arc((3.0, 0.0), 4.0), Arc((0.0, 0.0), 2.0, 10.0, 100.0), Arc((4.0, 0.0), 3.0, 200.0, 500.0),
    Arc((0.0, 0.0), 9.0),
])  # fmt: skip
def test_a_circle_keeps_what_lies_inside(curve: Curve) -> None:
    centre, radius = (0.5, 0.3), 5.0
    if isinstance(curve, Segment):
        points = [tuple(a + t / 20000 * (b - a) for a, b in zip(curve.start, curve.end)) for t in range(20001)]
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


def test_a_rib_that_is_cut_lengthwise_is_recognised_and_a_tongue_is_not() -> None:
    outline = cq.Workplane("XZ").polyline([(0, 0), (60, 0), (60, 8), (8, 8), (8, 60), (0, 60)]).close()
    angle = outline.extrude(20, both=True)
    rib = cq.Workplane("XZ").polyline([(8, 8), (40, 8), (8, 40)]).close().extrude(3, both=True)
    tongue = cq.Workplane(origin=(60, 0, 4)).box(40, 6, 8, centered=(False, True, True))
    ((wall, edges),) = section.ribs(
        angle.union(rib).union(tongue).val().wrapped, Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
    )
    assert wall.Area() == pytest.approx(512) and len(edges) == 2


def test_lines_are_those_of_triangles_where_the_exact_algorithm_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    box = cq.Workplane().box(30, 20, 10).edges("|Z").fillet(3).val().wrapped
    meshed_lines = project(box, PROJECTIONS["front"], exact=False)

    def fail(*_: object) -> None:
        raise occ.Standard_Failure("Unable to calculate normal")

    monkeypatch.setattr("drawings.views.projection._exactly", fail)
    assert project(box, PROJECTIONS["front"]) == meshed_lines
    monkeypatch.setattr("drawings.views.projection._exactly", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        project(box, PROJECTIONS["front"])
