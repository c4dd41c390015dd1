"""Pieces of one shape that nothing hides are drawn once and moved; one that is partly hidden is not among them."""

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest

from drawings.pictures.picture import Picture, picture
from drawings.pictures.visibility import Scene, moved
from drawings.views.bounding_box import extreme_points
from drawings.views.projection import hidden_lines
from drawings.views.view import PROJECTIONS, Curve
from stagecad.solids.modelling.frame import Frame

ISO = PROJECTIONS["iso"]
BOLT = cq.Workplane().circle(4).extrude(6).faces(">Z").workplane().polygon(6, 4.2).cutBlind(-3).val()
PLATE = cq.Workplane().box(40, 40, 4).val()
# On the plate, above it, beside it, and half behind it.
PLACES = ((10.0, 10.0, 2.0), (-10.0, -10.0, 30.0), (60.0, -20.0, 0.0), (-25.0, 0.0, -3.0))


@pytest.fixture(scope="module")
def shown() -> Picture:
    assert isinstance(BOLT, cq.Shape) and isinstance(PLATE, cq.Shape)
    scene = Scene({"bolt": BOLT.wrapped, "plate": PLATE.wrapped})
    pieces = [("bolt", "bolt", Frame(shift=place)) for place in PLACES]
    return picture("iso", ISO, scene, [*pieces, ("plate", "plate", Frame())])


def numbers(curves: tuple[Curve, ...]) -> np.ndarray:
    """Points along some curves, in one order."""
    return np.array(sorted(tuple(np.round(point, 4) + 0.0) for curve in curves for point in extreme_points(curve)))


@pytest.mark.parametrize("number", [1, 2])
def test_a_piece_that_nothing_hides_is_drawn_as_alone(shown: Picture, number: int) -> None:
    assert isinstance(BOLT, cq.Shape)
    (alone,) = hidden_lines([moved(BOLT.wrapped, Frame(shift=PLACES[number]))], ISO, chord=0.03)
    lines = numbers(shown.pieces[number][1])
    assert lines.shape == numbers(alone).shape
    assert lines == pytest.approx(numbers(alone), abs=2e-4)


def test_a_hidden_one_keeps_its_own_lines(shown: Picture) -> None:
    lengths = [len(numbers(lines)) for part, lines in shown.pieces if part == "bolt"]
    assert lengths[3] < lengths[2]
    assert all(lengths)
