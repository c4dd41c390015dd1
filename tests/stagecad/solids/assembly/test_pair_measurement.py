"""Common volume and least distance of two solids in any position."""

import math

import cadquery as cq
import pytest

from stagecad.solids.assembly.pair_measurement import common_volume, common_volumes, least_distance, relative_frame
from stagecad.solids.modelling.frame import Frame

C, S = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
TURNED = ((C, -S, 0.0), (S, C, 0.0), (0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def solids():
    """A plate of 40 x 40 x 10 with a bore of 12 through its middle, and a pin of 10 x 30 along z."""
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


@pytest.fixture(scope="module")
def drilled():
    """A plate of 200 x 40 x 10 with 20 holes of 6 mm, 9 mm apart."""
    holes = cq.Workplane().box(200, 40, 10, centered=False).faces(">Z").workplane(origin=(0, 20, 0))
    return holes.pushPoints([(10 + 9 * k, 0) for k in range(20)]).hole(6).solids().val()


RING = math.pi * (3.5**2 - 3.0**2) * 10
"""Common volume of the plate and a pin of 7 mm in one of its holes, mm^3."""


@pytest.mark.parametrize("holes", [(0,), (3, 0, 19), tuple(range(20))])
def test_common_volumes_of_others_that_are_apart(drilled, holes: tuple[int, ...]) -> None:
    pin = cq.Solid.makeCylinder(3.5, 30)
    others = [(pin, Frame(shift=(10.0 + 9 * hole, 20.0, -5.0))) for hole in holes]
    beside = (pin, Frame(shift=(10.0, 60.0, -5.0)))
    volumes = common_volumes(drilled, [*others, beside])
    assert volumes == pytest.approx([RING] * len(holes) + [0.0], rel=1e-9)


def test_common_volumes_of_one_that_is_cut_into_several_pieces(drilled) -> None:
    # Two grooves of 2 mm leave five layers, of which three are the plate's and two are air.
    layers = [cq.Solid.makeBox(200, 40, 2, cq.Vector(0, 0, z)) for z in (0.0, 4.0, 8.0)]
    solid = cq.Compound.makeCompound(layers)
    block = cq.Solid.makeBox(5, 5, 30)
    others = [(block, Frame(shift=(x, 2.0, -5.0))) for x in (10.0, 30.0)]
    assert common_volumes(solid, others) == pytest.approx([5 * 5 * 6.0] * 2, rel=1e-9)


def test_common_volumes_of_overlapping_others_are_those_of_each_alone(drilled) -> None:
    pin = cq.Solid.makeCylinder(3.5, 30)
    near = [(pin, Frame(shift=(19.0 + by, 20.0, -5.0))) for by in (0.0, 0.2, 1.5)]
    alone = [common_volume(drilled, other, frame) for other, frame in near]
    assert alone[0] == pytest.approx(RING, rel=1e-9) and alone[2] > 1.5 * RING
    # With the first three, a piece of the plate is taken; with the last too, the plate.
    assert common_volumes(drilled, near) == pytest.approx(alone, rel=1e-9)
    far = (pin, Frame(shift=(181.0, 20.0, -5.0)))
    assert common_volumes(drilled, [*near, far]) == pytest.approx([*alone, RING], rel=1e-9)


@pytest.mark.parametrize(
    ("shift", "expected"),
    [((0.0, 0.0, -5.0), 1.0), ((0.25, 0.0, -5.0), 0.75), ((13.0, 0.0, 10.0), 0.0), ((13.0, 0.0, 10.4), 0.4)],
)
def test_distance_up_to_the_gap_is_exact(solids, shift: tuple[float, float, float], expected: float) -> None:
    plate, pin = solids
    assert least_distance(plate, pin, Frame(shift=shift), 1.5) == pytest.approx(expected, abs=1e-9)


def test_distance_above_the_gap_is_above_it(solids) -> None:
    plate, pin = solids
    for height in (12.0, 30.0, 300.0):
        distance = least_distance(plate, pin, Frame(shift=(13.0, 0.0, height)), 1.5)
        assert distance is not None and distance > 1.5
