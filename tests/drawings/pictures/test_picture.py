"""Pictures of assemblies: pieces hide one another, and the faces left out beforehand are invisible ones."""

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest

from drawings.pictures.picture import Picture, Piece, picture
from drawings.pictures.scene import meshed, moved, visible_faces
from drawings.views.bounding_box import extreme_points
from drawings.views.projection import hidden_lines
from drawings.views.view import PROJECTIONS, Curve
from stagecad.solids.modelling.frame import UNMOVED, Frame

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
    assert lines.shape == numbers(alone).shape
    assert lines == pytest.approx(numbers(alone), abs=2e-4)


def test_a_partly_hidden_piece_has_fewer_lines(shown: Picture) -> None:
    lengths = [len(numbers(lines)) for part, lines in shown.pieces if part == "bolt"]
    assert lengths[3] < lengths[2]
    assert all(lengths)


def test_invisible_faces_are_left_out_and_change_no_line(pieces: list[Piece], shown: Picture) -> None:
    faces = visible_faces([(piece.shape, piece.frame) for piece in pieces], ISO)
    counts = [len(cq.Shape.cast(shape).Faces()) for shape in faces if shape is not None]
    assert len(counts) == len(pieces)
    assert counts[-1] == 3
    every = hidden_lines([moved(piece.shape.shape, piece.frame) for piece in pieces], ISO, chord=0.03)
    for (_, curves), all_curves in zip(shown.pieces, every, strict=True):
        assert numbers(curves) == pytest.approx(numbers(all_curves), abs=2e-4)


def test_a_piece_behind_another_has_no_visible_face() -> None:
    assert isinstance(BOLT, cq.Shape) and isinstance(PLATE, cq.Shape)
    bolt, plate = meshed(BOLT.wrapped), meshed(PLATE.wrapped)
    below = visible_faces([(bolt, Frame(shift=(0.0, 0.0, -20.0))), (plate, UNMOVED)], PROJECTIONS["top"])
    assert below[0] is None
    assert below[1] is not None
