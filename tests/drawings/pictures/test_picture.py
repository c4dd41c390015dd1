"""Pictures of assemblies: pieces hide one another; neighbours in a section have other hatches."""

from itertools import combinations

import cadquery as cq
import numpy as np
import pytest

from drawings.pictures.picture import (
    FINE,
    MANY_FACES,
    Picture,
    Piece,
    faces_of_view,
    faces_of_views,
    meshed,
    picture,
    visible_faces,
)
from drawings.views.projection import hidden_lines, project
from drawings.views.section import HATCHES, different_hatches
from drawings.views.segment_index import SegmentIndex, curve_points, polyline_lines
from drawings.views.view import PROJECTIONS, Curve, extreme_points
from stagecad.solids.export.mesh import triangulated
from stagecad.solids.modelling.frame import UNMOVED, Box, Frame, near
from stagecad.solids.modelling.kernel import moved
from tests.process_state import python

ISO = PROJECTIONS["iso"]
BOLT = cq.Workplane().circle(4).extrude(6).faces(">Z").workplane().polygon(6, 4.2).cutBlind(-3).val()
PLATE = cq.Workplane().box(40, 40, 4).val()
# On the plate, above it, beside it, and half behind it.
PLACES = ((10.0, 10.0, 2.0), (-10.0, -10.0, 30.0), (60.0, -20.0, 0.0), (-25.0, 0.0, -3.0))


@pytest.fixture(scope="module")
def pieces() -> list[Piece]:
    assert isinstance(BOLT, cq.Shape) and isinstance(PLATE, cq.Shape)
    bolt, plate = meshed(BOLT.wrapped), meshed(PLATE.wrapped)
    return [*(Piece("bolt", bolt, Frame(shift=place)) for place in PLACES), Piece("plate", plate, UNMOVED)]


@pytest.fixture(scope="module")
def shown(pieces: list[Piece]) -> Picture:
    return picture("iso", ISO, pieces)


def numbers(curves: tuple[Curve, ...]) -> np.ndarray:
    """Points along some curves, in one order."""
    return np.array(sorted(tuple(np.round(point, 4) + 0.0) for curve in curves for point in extreme_points(curve)))


@pytest.mark.parametrize("number", [1, 2])
def test_a_piece_that_nothing_hides_is_drawn_as_by_itself(shown: Picture, number: int) -> None:
    assert isinstance(BOLT, cq.Shape)
    (alone,) = hidden_lines([moved(BOLT.wrapped, Frame(shift=PLACES[number]))], ISO, chord=0.03)
    lines = numbers(shown.pieces[number][1])
    assert lines.shape == numbers(alone).shape and lines == pytest.approx(numbers(alone), abs=2e-4)


def test_hidden_pieces_have_fewer_lines_and_no_faces(shown: Picture) -> None:
    lengths = [len(numbers(lines)) for part, lines in shown.pieces if part == "bolt"]
    assert lengths[3] < lengths[2] and all(lengths)
    assert isinstance(BOLT, cq.Shape) and isinstance(PLATE, cq.Shape)
    bolt, plate = meshed(BOLT.wrapped), meshed(PLATE.wrapped)
    below = visible_faces([(bolt, Frame(shift=(0.0, 0.0, -20.0))), (plate, UNMOVED)], PROJECTIONS["top"])
    assert below[0] is None and below[1] is not None


def test_invisible_faces_are_left_out_and_change_no_line(pieces: list[Piece], shown: Picture) -> None:
    faces = visible_faces([(piece.shape, piece.frame) for piece in pieces], ISO)
    counts = [len(cq.Shape.cast(shape).Faces()) for shape in faces if shape is not None]
    assert len(counts) == len(pieces) and counts[-1] == 3
    every = hidden_lines([moved(piece.shape.shape, piece.frame) for piece in pieces], ISO, chord=0.03)
    for (_, curves), all_curves in zip(shown.pieces, every, strict=True):
        assert numbers(curves) == pytest.approx(numbers(all_curves), abs=2e-4)


@pytest.fixture(scope="module")
def block() -> cq.Shape:
    """A block with a fillet, an undercut, bores that cross, counterbores, a pocket, and a foot crowned by 6 um."""
    body = cq.Workplane().box(60, 40, 30).faces(">Y").edges("<Z").fillet(3.0)
    body = body.faces(">Z").workplane().rect(40, 20).cutBlind(-6)
    body = body.faces("<X").workplane().hole(8.0).faces("<Y").workplane().hole(6.0)
    body = body.faces(">Z").workplane().rarray(44, 8, 2, 4).cboreHole(2.0, 3.0, 1.0, 4.0)
    body = body.cut(cq.Workplane().box(60, 40, 3).translate((50, 0, -8)))
    ball = cq.Workplane().sphere(2000.0).translate((0, 0, 2000.0 - 18.99))
    foot = cq.Workplane().box(10, 10, 4).translate((0, 0, -17)).intersect(ball)
    solid = body.union(foot).solids().val()
    assert isinstance(solid, cq.Shape)
    return solid


@pytest.mark.parametrize("direction", sorted(PROJECTIONS))
def test_the_faces_of_a_view_give_its_lines(block: cq.Shape, direction: str) -> None:
    projection = PROJECTIONS[direction]
    faces = faces_of_view(meshed(block.wrapped, triangulated(block, *FINE)), projection)
    assert len(cq.Shape.cast(faces).Faces()) < len(block.Faces())
    lines, every = (project(shape, projection, hidden=False)["VISIBLE"] for shape in (faces, block.wrapped))
    # Where bores cross, the faces that are left out draw pieces of other lines again.
    assert _covers(lines, every) and _covers(every, lines) and len(lines) <= len(every)


def _covers(lines: tuple[Curve, ...], others: tuple[Curve, ...]) -> bool:
    """Whether some lines are within 0.01 mm of all points of others."""
    rows = [[*curve_points(one, 10.0)] for one in lines]
    index = SegmentIndex([line for row in rows for line in polyline_lines(row)])
    points = (point for one in others for point in curve_points(one, 10.0))
    return all(index.count_in((u - 0.01, v - 0.01, u + 0.01, v + 0.01)) for u, v in points)


def test_parts_narrower_than_a_pixel_or_of_few_faces_are_drawn(block: cq.Shape) -> None:
    # Seen from the front, the sphere of the foot is 6 um high below the lower edge of the foot's front face.
    faces = faces_of_view(meshed(block.wrapped, triangulated(block, *FINE)), PROJECTIONS["front"])
    assert "SPHERE" in {face.geomType() for face in cq.Shape.cast(faces).Faces()}
    assert len(block.Faces()) <= MANY_FACES and faces_of_views(block.wrapped, None)(ISO) is block.wrapped
    plate = cq.Workplane().box(100, 100, 5).faces(">Z").workplane().rarray(9, 9, 10, 10).hole(3.0).solids().val()
    assert isinstance(plate, cq.Shape)
    seen = faces_of_views(plate.wrapped, None)(PROJECTIONS["top"])
    assert len(cq.Shape.cast(seen).Faces()) == 1
    assert len(project(seen, PROJECTIONS["top"], hidden=False)["VISIBLE"]) == 100 + 4


def test_walls_that_begin_at_the_wall_of_a_bore_are_not_seen_along_it() -> None:
    block = cq.Workplane().box(100, 40, 30).cut(cq.Workplane("YZ").circle(4).extrude(100, both=True))
    for x in (-30, -10, 10, 30):
        block = block.cut(cq.Workplane("XZ", origin=(x, 30, 0)).circle(2.5).extrude(30))
    solid = block.solids().val()
    assert isinstance(solid, cq.Shape)
    seen = faces_of_view(meshed(solid.wrapped, triangulated(solid, *FINE)), PROJECTIONS["left"])
    assert [face.geomType() for face in cq.Shape.cast(seen).Faces()] == ["PLANE"]


def test_neighbours_and_more_of_them_than_hatches_differ() -> None:
    base: Box = ((0.0, 0.0, 0.0), (100.0, 10.0, 20.0))
    on_base: list[Box] = [((x, 0.0, 20.0), (x + 10.0, 10.0, 30.0)) for x in (0.0, 10.0, 50.0)]
    boxes = [base, *on_base, ((0.0, 0.0, 30.0), (60.0, 10.0, 35.0))]
    hatches = different_hatches(boxes, 0.5)
    for (one, first), (two, second) in combinations(zip(boxes, hatches, strict=True), 2):
        assert first != second or not near(one, two, 0.0)
    # What stands alone has the ordinary hatch of a part on the base.
    assert hatches[0] == HATCHES[0] and hatches[3] == HATCHES[1]
    box: Box = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    hatches = different_hatches([box] * (len(HATCHES) + 2), 0.5)
    assert len(hatches) == len(HATCHES) + 2 and set(hatches) == set(HATCHES)


def test_the_text_of_the_views_is_the_same_in_every_process() -> None:
    """It is in the key of the stored pictures: with a set in it they were drawn again by every run."""
    program = "from drawings.friction_stage.sheets import VIEWS; print(VIEWS)"
    one, other = (python("-c", program, PYTHONHASHSEED=seed).stdout for seed in ("1", "2"))
    assert one == other != ""
