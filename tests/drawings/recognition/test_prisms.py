"""Slots, openings and pockets; arms at an angle; a V: sizes, places, angles."""

import math
from dataclasses import replace

import cadquery as cq
import pytest

from drawings.dimensions.definition import Notes, definition
from drawings.recognition.part_file import Proposal, as_dimension
from stagecad.solids.modelling.surface import prisms_of
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.recognition import proposals
from tests.drawings.recognition.proposals import W, proposal_of, verifier_of


def plate(*cuts: cq.Workplane, size: tuple[float, float, float] = (90, 60, 6)) -> cq.Workplane:
    body = W().box(*size, centered=False)
    for cut in cuts:
        body = body.cut(cut)
    return body


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
    assert sizes(found, "angle") == ([(angle, 1, "")] if angle else []) and len(sizes(found, "linear")) == 4


def test_a_key_seat_is_placed_from_the_shoulder_and_has_a_length_a_width_and_the_shaft_below_it() -> None:
    shaft = W("YZ").circle(15).extrude(40).faces(">X").workplane().circle(12.5).extrude(50)
    found = proposal_of(shaft.cut(W("XY").workplane(offset=8.5).center(63, 0).slot2D(36, 8).extrude(20)))
    assert sizes(found, "linear") == [(5.0, 1, ""), (8.0, 1, ""), (21.0, 1, ""), (36.0, 1, ""), (40.0, 1, "")]


def test_openings_that_are_no_prisms_are_none() -> None:
    """A cross, a curved slot, a hole with two flats, and a slot that is open at the side."""
    cross = W().rect(30, 8).extrude(50).union(W().rect(8, 30).extrude(50))
    flats = W().circle(10).extrude(50).intersect(W().rect(12, 40).extrude(50))
    for cut in (cross, flats, slot(0, 30, 30, 8, 90).translate((0, -2, 0))):
        body = W().box(90, 60, 6).cut(cut)
        assert [*prisms_of(DimensionVerifier(body.val()).surfaces)] == []
    body = W().box(90, 60, 6).cut(slot(0, 0, 30, 8).mirror("XY", union=True))
    (found,) = prisms_of(DimensionVerifier(body.val()).surfaces)
    assert found.centre == pytest.approx((0.0, 0.0, 0.0)) and [value for _, value in found.widths] == [8.0, 30.0]


def test_rows_of_equal_holes_have_the_distance_between_them_from_the_bore_that_they_are_about() -> None:
    holes = W().center(45, 25).rect(31, 31, forConstruction=True).vertices().circle(1.6).extrude(20)
    found = proposal_of(plate(holes, W().center(45, 25).circle(11).extrude(20), slot(12, 30, 20, 4, 90)))
    assert sizes(found, "linear") == [
        (4.0, 1, ""), (12.0, 1, ""), (15.5, 1, ""), (15.5, 1, ""), (20.0, 1, ""), (25.0, 1, ""), (30.0, 1, ""),
        (31.0, 1, ""), (31.0, 1, ""), (45.0, 1, ""),
    ]  # fmt: skip


def test_a_face_at_the_level_of_the_end_of_a_slot_has_a_dimension_of_its_own() -> None:
    """The end of the slot and the edge of the opening are at 42 mm."""
    found = proposal_of(plate(slot(20, 30, 24, 8, 90), W().center(60, 35).rect(20, 14).extrude(20)))
    assert {30.0, 35.0, 20.0, 60.0} <= {value for value, _, _ in sizes(found, "linear")}


def test_the_middle_of_a_slot_on_an_arm_is_on_its_ray_and_a_counterbore_beside_a_slit_has_a_depth() -> None:
    arm = W().circle(15).extrude(18).union(W().center(-18, 0).rect(20, 8).extrude(12))
    arm = arm.union(W().transformed(rotate=(0, 0, 30)).center(35, 0).rect(70, 14).extrude(8))
    end = (70 * math.cos(math.pi / 6), 35.0)
    arm = arm.union(W().center(*end).circle(9).extrude(8)).cut(W().rect(12, 12).extrude(40))
    arm = arm.cut(W().center(*end).circle(3).extrude(40))
    found = proposal_of(arm.cut(W().transformed(rotate=(0, 0, 30)).center(40, 0).slot2D(24, 6).extrude(20)))
    assert sizes(found, "angle") == [(30.0, 1, "")]
    assert {40.0, 70.0} <= {value for value, _, _ in sizes(found, "linear")}
    bore, seat = W("XZ").center(0, 27), W("XZ").workplane(offset=6).center(0, 27)
    block = W().box(70, 30, 50, centered=(True, True, False)).cut(bore.circle(13).extrude(30, both=True))
    block = block.cut(seat.circle(16).extrude(9)).cut(W().box(2, 60, 100).translate((0, 0, 80)))
    assert sizes(proposal_of(block), "depth") == [(9.0, 1, "")]


def test_sizes_are_named_after_what_they_are_of() -> None:
    pocket = W(origin=(64, 37, 10)).box(28, 16, 8).edges("|Z").fillet(3)
    body = plate(slot(24, 27, 30, 9, 90), pocket, size=(96, 54, 10)).edges("|Z").edges("<X or >X").fillet(6)
    for x in (48, 64, 80):
        body = body.cut(W().center(x, 15).circle(2.75).extrude(10))
    found = [one for one in proposal_of(body).dimensions if one.name.startswith(("opening", "slot"))]
    sizes_of = {one.name: round(one.value, 6) for one in found if one.name.endswith(("width", "length"))}
    assert sizes_of == {"opening 2 width": 16.0, "opening 2 length": 28.0, "slot 1 width": 9.0, "slot 1 length": 30.0}


def lever(*arms: tuple[float, float]) -> cq.Workplane:
    """A hub at the origin with arms of angles, degrees, and lengths."""
    body, bores = W().circle(16).extrude(24), W().circle(8).extrude(50)
    for angle, length in arms:
        x, y = length * math.cos(math.radians(angle)), length * math.sin(math.radians(angle))
        web = W().center(x / 2, y / 2).transformed(rotate=(0, 0, angle)).rect(length, 11).extrude(8)
        body = body.union(web).union(W().center(x, y).circle(10).extrude(16))
        bores = bores.union(W().center(x, y).circle(4).extrude(50))
    return body.cut(bores)


def values(found: Proposal, method: str) -> list[float]:
    return [value for value, _ in proposals.values(found, method)]


def test_an_arm_at_an_angle_has_a_distance_an_angle_and_a_width() -> None:
    body = lever((0, 60), (110, 45))
    verifier, found = verifier_of(body), proposal_of(body)
    assert values(found, "angle") == [110.0] and values(found, "linear") == [8.0, 11.0, 16.0, 24.0, 45.0, 60.0]
    # Neither of them alone gives the place, and a dimension along an axis beside them is one too many.
    dimensions = [as_dimension(one) for one in found.dimensions]
    for kind, value in (("angle", 110.0), ("linear", 45.0), ("linear", 11.0)):
        rest = [d for d in dimensions if (d.kind, round(d.value, 6)) != (kind, value)]
        assert any("place" in line for line in definition(verifier, rest, (), Notes(packaged=False)).problems)
    ray = next(d for d in dimensions if round(d.value, 6) == 45.0)
    step = abs(ray.points[1][1] - ray.points[0][1])
    twice = [*dimensions, replace(ray, name="height of the axis", direction=(0.0, 1.0, 0.0), value=step)]
    assert "follows from others" in definition(verifier, twice, (), Notes(packaged=False)).problems[0]


def test_equal_arms_have_one_width_for_all_of_them_and_those_of_a_star_no_other_place() -> None:
    for angles in ((90, 210, 330), (0, 72, 144, 216, 288), (0, 90, 180, 270), (0, 90, 210)):
        body = lever(*((angle, 45.0) for angle in angles))
        for one in (body, body.edges("|Z").fillet(1.5)):
            found = proposal_of(one)
            (arm,) = [d for d in found.dimensions if abs(d.value - 11.0) < 1e-6]
            assert arm.fields["count"] == len(angles)
            assert values(found, "pitch_circle") == [90.0] and values(found, "linear") == [8.0, 11.0, 16.0, 24.0]
            assert not any(d.fields.get("note") == "HEX AF" for d in found.dimensions)
    body = lever((90, 45), (210, 45), (330, 45))
    verifier, dimensions = verifier_of(body), [as_dimension(one) for one in proposal_of(body).dimensions]
    fewer = [replace(d, count=2) if d.count == 3 and d.value == 11.0 else d for d in dimensions]
    assert any("place" in line for line in definition(verifier, fewer, (), Notes("xy", packaged=False)).problems)


def test_a_wall_that_touches_two_round_faces_needs_no_dimension() -> None:
    far, angle = 60.0, math.acos((16 - 10) / 60.0)
    ends = [(r * math.cos(angle) + x, side * r * math.sin(angle)) for side in (1, -1) for x, r in ((0, 16), (far, 10))]
    web = W().polyline([ends[0], ends[1], ends[3], ends[2]]).close().extrude(8)
    body = web.union(W().circle(16).extrude(20)).union(W().center(far, 0).circle(10).extrude(14))
    found = proposal_of(body.cut(W().circle(7).extrude(50)).cut(W().center(far, 0).circle(4).extrude(50)))
    assert not values(found, "angle") and values(found, "linear") == [8.0, 14.0, 20.0, 60.0]


def test_a_v_with_a_relief_has_its_angle_and_the_depth_of_its_theoretical_edge() -> None:
    block = W().box(60, 40, 40, centered=(True, True, False))
    block = block.cut(W("XZ").moveTo(-27, 45).lineTo(0, 18).lineTo(27, 45).close().extrude(50, both=True))
    found = proposal_of(block.cut(W().box(4, 60, 12, centered=(True, True, False)).translate((0, 0, 12))))
    assert values(found, "angle") == [90.0] and values(found, "linear") == [4.0, 12.0, 22.0, 40.0, 40.0, 60.0]
