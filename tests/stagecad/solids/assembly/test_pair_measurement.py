"""Common volume and least distance of two solids in any position."""

from __future__ import annotations

import math

import pytest

from stagecad.solids.assembly.pair_measurement import common_volume, least_distance, piece_near, relative_frame
from stagecad.solids.modelling.frame import Frame

C, S = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
TURNED = ((C, -S, 0.0), (S, C, 0.0), (0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def solids():
    """A plate of 40 x 40 x 10 with a bore of 12 through its middle, and a pin of 10 x 30 along z."""
    import cadquery as cq

    plate = cq.Solid.makeBox(40, 40, 10, cq.Vector(-20, -20, 0)).cut(cq.Solid.makeCylinder(6, 10))
    pin = cq.Solid.makeCylinder(5, 30)
    return plate.Solids()[0], pin


def test_relative_frame_is_that_of_the_second_seen_from_the_first() -> None:
    one, two = Frame(TURNED, (5.0, -3.0, 2.0)), Frame(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), (1, 2, 3))
    frame = relative_frame(one, two)
    for point in ((0.0, 0.0, 0.0), (1.0, -2.0, 4.0)):
        assert one.point(frame.point(point)) == pytest.approx(two.point(point), abs=1e-8)


def test_relative_frame_is_the_same_wherever_the_pair_is() -> None:
    one, two = Frame(shift=(0.1, 0.2, 0.3)), Frame(TURNED, (1.1, 0.7, 12.9))
    by = (100.3, -7.7, 1 / 3)
    assert relative_frame(one, two) == relative_frame(one.shifted(by), two.shifted(by))


def test_common_volume_of_a_pin_in_a_plate(solids) -> None:
    plate, pin = solids
    beside = Frame(TURNED, (13.0, -9.0, 4.0))
    assert common_volume(plate, pin, beside) == pytest.approx(math.pi * 25 * 6, rel=1e-9)
    assert common_volume(plate, pin, Frame(shift=(0.0, 0.0, -5.0))) == 0.0


def test_the_piece_near_others_has_the_same_common_volumes() -> None:
    import cadquery as cq

    holes = cq.Workplane().box(200, 40, 10, centered=False).faces(">Z").workplane(origin=(0, 20, 0))
    plate = holes.pushPoints([(10 + 9 * k, 0) for k in range(20)]).hole(6).solids().val()
    pin = cq.Solid.makeCylinder(3.5, 30)
    places = [(pin, Frame(shift=(19.0 + by, 20.0, -5.0))) for by in (0.0, 0.2, 1.5)]
    piece = piece_near(plate, places)
    assert len(piece.Faces()) < len(plate.Faces()) / 2
    for other, frame in places:
        assert common_volume(piece, other, frame) == pytest.approx(common_volume(plate, other, frame), rel=1e-9)
    # In one place, or where the others reach over most of it, the solid is taken as it is.
    assert piece_near(plate, places[:1]) is plate
    assert piece_near(plate, [*places, (pin, Frame(shift=(190.0, 20.0, -5.0)))]) is plate


@pytest.mark.parametrize(
    ("shift", "expected"),
    [
        ((0.0, 0.0, -5.0), 1.0),
        ((0.25, 0.0, -5.0), 0.75),
        ((13.0, 0.0, 10.0), 0.0),
        ((13.0, 0.0, 10.4), 0.4),
    ],
)
def test_distance_up_to_the_gap_is_exact(solids, shift: tuple[float, float, float], expected: float) -> None:
    plate, pin = solids
    assert least_distance(plate, pin, Frame(shift=shift), 1.5) == pytest.approx(expected, abs=1e-9)


def test_distance_above_the_gap_is_above_it(solids) -> None:
    plate, pin = solids
    for height in (12.0, 30.0, 300.0):
        distance = least_distance(plate, pin, Frame(shift=(13.0, 0.0, height)), 1.5)
        assert distance is not None and distance > 1.5
