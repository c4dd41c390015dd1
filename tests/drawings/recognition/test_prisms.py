"""Slots, rectangular openings and regular pockets: sizes across, the place of the middle, and the angle."""

import math

import cadquery as cq
import pytest

from drawings.recognition.part_file import Proposal, in_position
from drawings.recognition.proposal import propose
from stagecad.solids.modelling.surface import prisms_of
from stagecad.solids.modelling.verification import DimensionVerifier

W = cq.Workplane


def plate(*cuts: cq.Workplane, size: tuple[float, float, float] = (90, 60, 6)) -> cq.Workplane:
    body = W().box(*size, centered=False)
    for cut in cuts:
        body = body.cut(cut)
    return body


def proposal_of(body: cq.Workplane) -> Proposal:
    found = propose(DimensionVerifier(in_position(body.solids().val())))  # pyright: ignore[reportArgumentType]
    assert not found.open
    return found


def sizes(found: Proposal, *methods: str) -> list[tuple[float, int, str]]:
    """Value, count and note of the dimensions by some methods, but the sizes of the whole."""
    rows = [one for one in found.dimensions if one.method in methods and one.name not in ("length", "width", "height")]
    return sorted((round(o.value, 3), o.fields.get("count", 1), o.fields.get("note", "")) for o in rows)


def slot(x: float, y: float, length: float, width: float, angle: float = 0.0) -> cq.Workplane:
    return W().center(x, y).slot2D(length, width, angle).extrude(50)


def test_a_slot_has_its_width_its_length_and_the_place_of_its_middle() -> None:
    assert sizes(proposal_of(plate(slot(30, 20, 30, 10))), "linear") == [
        (10.0, 1, ""), (20.0, 1, ""), (30.0, 1, ""), (30.0, 1, ""),
    ]  # fmt: skip
    # Of its length and the distance of the axes of its ends that which is in tenths is given.
    assert (25.0, 1, "") in sizes(proposal_of(plate(slot(30, 20, 25 + 8.3333, 8.3333))), "linear")


def test_equal_slots_in_a_row_have_a_pitch_and_slots_at_an_angle_have_it() -> None:
    row = proposal_of(plate(*(slot(x, 35, 24, 8, 90) for x in (20, 40, 60))))
    assert sizes(row, "pitch") == [(20.0, 1, "")]
    assert sizes(row, "linear") == [(8.0, 3, ""), (20.0, 1, ""), (24.0, 3, ""), (35.0, 1, "")]
    turned = proposal_of(plate(slot(25, 30, 26, 8, 30), slot(65, 22, 26, 8, 30)))
    assert sizes(turned, "angle") == [(30.0, 1, "")]
    assert sizes(turned, "linear") == [
        (8.0, 2, ""), (22.0, 1, ""), (25.0, 1, ""), (26.0, 2, ""), (30.0, 1, ""), (65.0, 1, ""),
    ]  # fmt: skip


@pytest.mark.parametrize(("sides", "note", "angle"), [(6, "HEX AF", 0.0), (8, "OCT AF", 22.5), (4, "SQ", 45.0)])
def test_a_regular_pocket_has_one_width_and_the_radius_of_its_corners(sides: int, note: str, angle: float) -> None:
    pocket = W().workplane(offset=5).polygon(sides, 20 / math.cos(math.pi / sides)).extrude(20).edges("|Z").fillet(1.5)
    found = proposal_of(plate(pocket.translate((35, 25, 0)), size=(80, 60, 15)))
    assert (20.0, 1, note) in sizes(found, "linear") and sizes(found, "radius") == [(1.5, sides, "")]
    assert sizes(found, "angle") == ([(angle, 1, "")] if angle else [])
    assert len(sizes(found, "linear")) == 4


def test_a_key_seat_is_placed_from_the_shoulder_and_has_a_length_a_width_and_the_shaft_below_it() -> None:
    shaft = W("YZ").circle(15).extrude(40).faces(">X").workplane().circle(12.5).extrude(50)
    seat = W("XY").workplane(offset=8.5).center(63, 0).slot2D(36, 8).extrude(20)
    found = proposal_of(shaft.cut(seat))
    assert sizes(found, "linear") == [(5.0, 1, ""), (8.0, 1, ""), (21.0, 1, ""), (36.0, 1, ""), (40.0, 1, "")]


def test_openings_that_are_no_prisms_are_none() -> None:
    """A cross, a curved slot, a hole with two flats, and a slot that is open at the side."""
    cross = W().rect(30, 8).extrude(50).union(W().rect(8, 30).extrude(50))
    flats = W().circle(10).extrude(50).intersect(W().rect(12, 40).extrude(50))
    for cut in (cross, flats, slot(0, 30, 30, 8, 90).translate((0, -2, 0))):
        body = W().box(90, 60, 6).cut(cut)
        assert [*prisms_of(DimensionVerifier(body.val()).surfaces)] == []
    (found,) = prisms_of(
        DimensionVerifier(W().box(90, 60, 6).cut(slot(0, 0, 30, 8).mirror("XY", union=True)).val()).surfaces
    )
    assert found.centre == pytest.approx((0.0, 0.0, 0.0)) and [value for _, value in found.widths] == [8.0, 30.0]
