"""Equal features around an axis, on a circle or in a row have one dimension, whatever divides or covers them."""

import math
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import pytest
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideAngle

from drawings.dimensions.consistency import mistakes
from drawings.recognition.part_file import Proposal, Proposed, as_dimension
from drawings.recognition.proposal import propose
from tests.drawings.recognition.proposals import W, problems, proposal_of, sheet_of, values, verifier_of


def open_without(body: cq.Workplane, name: str, found: Proposal) -> tuple[str, ...]:
    verifier = verifier_of(body)
    rest: list[Proposed] = [one for one in found.dimensions if one.name != name]
    assert len(rest) < len(found.dimensions)
    return problems(verifier, rest)


def turned(body: cq.Workplane, angle: float) -> cq.Workplane:
    return body.rotate((0, 0, 0), (0, 0, 1), angle)


@pytest.mark.parametrize("count", [3, 4])
def test_the_slits_of_a_collet_have_one_width_and_one_angle_in_one_view(count: int) -> None:
    profile = [(0, 0), (9, 0), (9, 30), (13, 42), (13, 46), (0, 46)]
    collet = W("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0)).cut(W().circle(5).extrude(46))
    for number in range(count):
        slit = W(origin=(0, 0, 16)).rect(20, 0.8).extrude(40).translate((10, 0, 0))
        collet = collet.cut(turned(slit, 90 + number * 360 / count))
    found = proposal_of(collet)
    (width,) = [one for one in found.dimensions if one.value == pytest.approx(0.8)]
    assert width.fields["count"] == count and values(found, "angle") == [(360.0 / count, count)]
    assert all(value == round(value, 1) for value, _ in values(found, "linear"))


def test_holes_at_unequal_angles_on_one_circle_have_the_circle_and_angles_from_the_axes() -> None:
    for angles, stated in (((90, 180, 270), []), ((30, 120, 225), [(30.0, 1), (30.0, 1), (45.0, 1)])):
        plate = W().circle(25).extrude(8).union(W().rect(60, 30).extrude(8)).cut(W().circle(7).extrude(8))
        for angle in angles:
            plate = plate.cut(turned(W().center(16, 0).circle(2.5).extrude(8), angle))
        found = proposal_of(plate)
        assert values(found, "pitch_circle") == [(32.0, 1)] and values(found, "angle") == stated
        assert 16.0 not in {value for value, _ in values(found, "linear")}
        assert any("place" in line for line in open_without(plate, "pitch circle 1", found))


def test_the_teeth_of_a_face_coupling_have_a_width_beside_the_angle_between_them() -> None:
    ring = W().circle(30).circle(18).extrude(12)
    for number in range(12):
        ring = ring.cut(turned(W("YZ").polyline([(-3, 12), (0, 8), (3, 12)]).close().extrude(40), 30 * number))
    found = proposal_of(ring)
    assert (6.0, 12) in values(found, "linear") and values(found, "angle") == [(30.0, 12)]


def test_windows_around_a_cell_and_grooves_of_a_piston_are_counted(tmp_path: Path) -> None:
    cell = W().circle(20).circle(15).extrude(14)
    for angle in (0, 120, 240):
        cell = cell.cut(turned(W("YZ", origin=(0, 0, 5.5)).rect(3, 2).extrude(30), angle))
    assert {(2.0, 3), (3.0, 3)} <= set(values(proposal_of(cell), "linear"))
    piston = W().circle(25).extrude(48)
    for level, width in ((32, 2), (37, 2), (42, 2.5)):
        piston = piston.cut(W(origin=(0, 0, level)).circle(40).circle(22.5).extrude(width))
    found = proposal_of(piston)
    assert values(found, "pitch") == [(5.0, 1)] and {(2.0, 2), (2.5, 1)} <= set(values(found, "linear"))
    assert not {39.0, 44.5} & {value for value, _ in values(found, "linear")}
    knob = W().circle(20).extrude(14).union(W(origin=(0, 0, -8)).circle(9).extrude(8))
    knob = knob.cut(W().polarArray(23, 0, 360, 8).circle(6).extrude(14)).cut(W(origin=(0, 0, -8)).circle(3).extrude(16))
    sheet_of(knob, "scalloped", tmp_path)


def test_flats_that_a_collar_covers_from_both_ends_have_their_width_from_the_side() -> None:
    shaft = W("YZ").circle(10).extrude(40)
    for side in (1, -1):
        shaft = shaft.cut(W(origin=(20, 0, side * 28.5)).box(10, 60, 40))
    (width,) = [one for one in proposal_of(shaft).dimensions if one.value == pytest.approx(17.0)]
    assert width.fields["view"] == "front"


def test_a_floor_that_a_crossing_hole_cuts_is_one_of_equal_holes() -> None:
    block = W().box(90, 60, 50, centered=False)
    for y, z in ((20, 20), (40, 30)):
        block = block.cut(W("YZ", origin=(0, y, z)).circle(4).extrude(70))
        block = block.cut(W("YZ", origin=(0, y, z)).circle(6.5).extrude(12))
    block = block.cut(W(origin=(14, 20, 50)).circle(4).extrude(-30))
    found, verifier = proposal_of(block), verifier_of(block)
    assert (13.0, 2) in values(found, "diameter")
    dimensions = [as_dimension(one) for one in found.dimensions]
    assert not [*mistakes(dimensions, (), verifier, alike=True)]
    wrong = [replace(d, count=3) if d.value == 13.0 else d for d in dimensions]
    assert [*mistakes(wrong, (), verifier, alike=True)]
    # A crossing hole divides the wall of one of two.
    holes = W(origin=(0, 0, 6)).pushPoints([(20, 20), (60, 20)]).circle(4).extrude(24)
    block = W().box(80, 40, 30, centered=False).cut(holes)
    verifier = verifier_of(block.cut(W("XZ", origin=(60, 40, 18)).circle(5).extrude(40)))
    dimensions = [as_dimension(one) for one in propose(verifier).dimensions]
    assert not [*mistakes(dimensions, (), verifier, alike=True)]


def test_a_slanting_port_that_meets_a_bore_begins_at_its_axis() -> None:
    body = W().box(60, 40, 40, centered=(True, True, False)).cut(W("YZ", origin=(-30, 0, 20)).circle(8).extrude(60))
    port = W("XZ").circle(2.5).extrude(30).rotate((0, 0, 0), (1, 0, 0), -30).translate((5, 0, 20))
    found = proposal_of(body.cut(port))
    assert values(found, "angle") == [(60.0, 1)]
    assert all(value == round(value, 1) for value, _ in values(found, "linear"))


def test_a_spider_about_a_lying_axis_has_its_circle_and_nothing_beside_it() -> None:
    body = W("XZ").circle(16).extrude(14)
    for angle in (90, 210, 330):
        arm = W("XZ").rect(40, 10).extrude(8).translate((20, -3, 0)).union(W("XZ").center(40, 0).circle(9).extrude(14))
        body = body.union(arm.rotate((0, 0, 0), (0, 1, 0), angle))
    for angle in (90, 210, 330):
        body = body.cut(W("XZ").center(40, 0).circle(4).extrude(14).rotate((0, 0, 0), (0, 1, 0), angle))
    found = proposal_of(body.cut(W("XZ").circle(7).extrude(14)))
    assert values(found, "pitch_circle") == [(80.0, 1)] and values(found, "angle") == []
    assert values(found, "linear") == [(8.0, 1), (10.0, 3), (14.0, 1)] and "back" not in found.views


def test_a_slot_at_an_angle_is_not_placed_without_it() -> None:
    plate = W().box(90, 60, 6, centered=False).cut(W().center(30, 25).slot2D(30, 8, 30).extrude(6))
    found = proposal_of(plate)
    assert any("place" in line for line in open_without(plate, "slot 1 angle", found))


def test_the_floor_of_a_slot_is_no_datum() -> None:
    plate = W().slot2D(80, 30).extrude(12).cut(W(origin=(35, 0, 0)).rect(30, 20).extrude(12))
    assert all(abs(datum.normal[0]) < 0.5 for datum in proposal_of(plate).datums)


def test_details_have_letters_of_their_own(tmp_path: Path) -> None:
    shaft = W("YZ").circle(12).extrude(300)
    for level in (40, 90):
        shaft = shaft.cut(W("YZ", origin=(level, 0, 0)).circle(30).circle(11).extrude(0.8 + level / 1000))
    shaft = shaft.cut(W(origin=(20, 0, 8)).slot2D(12, 5).extrude(20))
    views = sheet_of(shaft, "grooves", tmp_path)["views"]
    letters = [view.split()[1] for view in views if view.startswith("detail")]
    assert len(letters) == len({*letters}) == 2 and not {*letters} & set("ABC")


def test_equal_slots_have_the_place_of_their_middles_and_a_hole_divided_by_another_is_one() -> None:
    plate = W().box(90, 60, 8, centered=False)
    for x, y in ((20, 15), (62, 38)):
        plate = plate.cut(W().center(x, y).slot2D(24, 8).extrude(8))
    found = proposal_of(plate)
    assert {(8.0, 2), (24.0, 2), (20.0, 1), (15.0, 1), (62.0, 1), (38.0, 1)} <= set(values(found, "linear"))
    block = W().box(80, 40, 30, centered=False).cut(W("YZ", origin=(0, 20, 15)).circle(4).extrude(80))
    found = proposal_of(block.cut(W(origin=(40, 20, 0)).circle(7).extrude(30)))
    assert values(found, "diameter") == [(8.0, 1), (14.0, 1)]
    assert math.isclose(sum(one.fields.get("note") == "through" for one in found.dimensions), 2)


def test_ends_of_cones_of_one_diameter_are_counted() -> None:
    barbs = [at for z in (10, 16, 22) for at in ((8.0, z), (6.0, z + 6))]
    body = W("XZ").polyline([(0, 0), (5, 0), (5, 10), *barbs, (0, 28)]).close().revolve()
    found = proposal_of(body)
    assert {(12.0, 3), (16.0, 3)} <= {*values(found, "diameter")}
    (cone,) = (one for one in found.dimensions if one.value == 16.0 and one.method == "diameter")
    for count in (2, 4):
        changed = replace(cone, fields={**cone.fields, "count": count})
        left = problems(verifier_of(body), [changed if one is cone else one for one in found.dimensions])
        assert left or [*mistakes([as_dimension(changed)], [], verifier_of(body))]


def test_vs_in_a_row_have_one_angle_and_fillets_behind_each_other_their_radius() -> None:
    body = W().box(60, 20, 20).cut(W().box(60, 6, 4).translate((0, 0, -8)))
    for x in range(-20, 21, 10):
        body = body.cut(W("XZ", origin=(x, 20, -10)).polyline([(-2, 0), (2, 0), (0, 2)]).close().extrude(40))
    assert values(proposal_of(body), "angle") == [(90.0, 5)]
    fins = W().circle(10).extrude(40)
    for z in (0, 12, 24, 36):
        fins = fins.union(W().workplane(offset=z).rect(40, 40).extrude(4).edges("|Z").fillet(6))
    assert 6.0 in {value for value, _ in values(proposal_of(fins), "radius")}


def test_spline_surfaces_that_are_round_or_plane_are_recognised() -> None:
    body = W(cq.Solid.makeCone(20, 14, 10)).union(W().circle(12).extrude(18)).union(W().sphere(8).translate((0, 0, 18)))
    kinds = {s.kind for s in verifier_of(W(body.val().toNURBS())).surfaces}  # pyright: ignore[reportAttributeAccessIssue]
    assert kinds == {"CONE", "CYLINDER", "PLANE", "SPHERE"}


def test_a_space_in_the_planes_of_a_wall_has_a_width_of_its_own() -> None:
    disc = W().circle(50).extrude(5).union(W().circle(14).extrude(30)).cut(W().circle(5).extrude(30))
    for number in range(6):
        disc = disc.union(turned(W(origin=(30, 0, 4)).box(36, 3, 18, centered=(True, True, False)), 60 * number))
    tongue = W().box(80, 20, 16).cut(W().box(22, 20, 16).cut(W().box(22, 8, 16)).translate((-29, 0, 0)))
    for body, at, length, width in ((disc, 5, 8, 3), (tongue, 29, 22, 8)):
        own, wider = (body.cut(W().box(length, wide, 70).translate((at, 0, 0))) for wide in (width, width + 1))
        found = proposal_of(own)
        rows = [one.name for one in found.dimensions if one.method == "linear" and abs(one.value - width) < 1e-6]
        assert len(rows) == 2 and all(open_without(own, name, found) for name in rows)
        assert problems(verifier_of(wider), [*found.dimensions])


def test_four_ribs_have_one_angle_and_width_and_a_hole_behind_an_arm_is_one_of_four() -> None:
    body = W().circle(45).extrude(10).union(W().circle(22).extrude(50))
    rib = W("XZ").polyline([(20, 10), (42, 10), (20, 40)]).close().extrude(3, both=True)
    for number in range(4):
        body = body.union(turned(rib, 90 * number))
    arm = W(origin=(0, 0, 40)).box(60, 12, 10, centered=(False, True, False))
    found = proposal_of(body.union(arm).cut(W().polarArray(33, 0, 360, 4).circle(3).extrude(10)))
    assert (90.0, 4) in values(found, "angle") and (6.0, 4) in values(found, "linear")
    assert (6.0, 4) in values(found, "diameter")


def test_a_bore_that_an_equal_one_divides_is_open_at_the_ends_of_the_whole() -> None:
    block = W().box(40, 40, 40).cut(W("YZ", origin=(-20, 0, 0)).circle(4).extrude(40))
    for depth, ends in ((40, (True, True)), (35, (True,))):
        verifier = verifier_of(block.cut(W(origin=(0, 0, 20)).circle(4).extrude(-depth)))
        walls = [s for s in verifier.surfaces if s.is_round(4.0) and abs(s.axis[2]) > 0.5]
        assert len(walls) == 2 and {verifier.open_ends(wall, (0.0, 0.0, 1.0)) for wall in walls} == {ends}


def test_a_shaft_whose_round_faces_are_divided_in_quarters_is_dimensioned_as_the_whole() -> None:
    """The rest of a round face is no side that would make a quarter of it a fillet."""
    shaft = W().circle(12.5).extrude(40).union(W(origin=(0, 0, 40)).circle(10).extrude(30))
    shaft = shaft.cut(W(origin=(0, 0, 7)).box(6, 18, 40, centered=(True, True, False)).translate((10.5, 0, 12)))
    divided = ShapeUpgrade_ShapeDivideAngle(math.pi / 2, shaft.val().wrapped)
    assert divided.Perform()
    quarters = W(obj=cq.Shape.cast(divided.Result()))
    assert quarters.faces().size() > shaft.faces().size()
    assert values(proposal_of(quarters), "diameter") == values(proposal_of(shaft), "diameter")
    assert not problems(verifier_of(quarters), proposal_of(quarters).dimensions)


def test_saw_teeth_have_one_angle_and_the_places_of_two_corners() -> None:
    rims = [(r, math.tau * n / 12) for n in range(12) for r in (40, 34)]
    wheel = W().polyline([(r * math.cos(a), r * math.sin(a)) for r, a in rims]).close().extrude(8)
    wheel = wheel.union(W().circle(15).extrude(20)).cut(W().rect(8, 8).extrude(20))
    found = proposal_of(wheel)
    assert values(found, "angle") == [(30.0, 12)] and {(34.0, 1), (40.0, 1)} < set(values(found, "linear"))
    assert all(open_without(wheel, one.name, found) for one in found.dimensions)


def test_sizes_and_places_of_other_features_are_not_those_of_a_slot() -> None:
    rotor = W().circle(32).extrude(30).cut(W().circle(9).extrude(30)).cut(W().rect(24, 4).extrude(30))
    for number in range(7):
        slot = W().center(26, 0).rect(16, 3).extrude(30).union(W().center(17, 0).circle(2).extrude(30))
        rotor = rotor.cut(turned(slot, 360 * number / 7))
    assert (4.0, 7) in values(proposal_of(rotor), "diameter")
    angle = W("XZ").polyline([(0, 0), (70, 0), (70, 5), (5, 5), (5, 70), (0, 70)]).close().extrude(25, both=True)
    angle = angle.cut(W().center(48, 0).slot2D(22, 11, 90).extrude(5))
    angle = angle.cut(W("YZ").pushPoints([(-11, 48), (11, 48)]).circle(4.5).extrude(5))
    assert values(proposal_of(angle), "linear").count((22.0, 1)) == 2


def test_a_radial_hole_at_an_angle_has_this_and_its_depth_and_a_chamfer_that_grooves_divide_is_one() -> None:
    disc = W().circle(40).extrude(15).faces(">Z").edges().chamfer(1).cut(W().circle(12).extrude(15))
    for number in range(3):
        disc = disc.cut(turned(W(origin=(35, 0, 15)).rect(20, 6).extrude(-4), 120 * number))
    for angle in (-90, -45):
        disc = disc.cut(turned(W("YZ", origin=(28, 0, 7)).circle(2).extrude(20), angle))
    found = proposal_of(disc)
    assert (45.0, 1) in values(found, "angle") and (12.0, 1) in values(found, "depth")
    assert values(found, "chamfer") == [(1.0, 1)]


def test_corners_that_alone_end_a_part_with_curved_sides_are_placed() -> None:
    curve = [(25, -12), (40, 10), (30, 34)]
    plate = W().moveTo(0, -20).spline(curve, includeCurrent=True).lineTo(6, 50).lineTo(-14, 44)
    plate = plate.spline([(-22, 20), (-18, -8), (0, -20)], includeCurrent=True).close().extrude(7)
    proposal_of(plate.cut(W().center(22, 24).circle(4.25).extrude(7)).cut(W().center(-8, 34).circle(2.6).extrude(7)))
