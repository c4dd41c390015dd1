"""Dimensions that a shop expects for usual features: of hexagons, webs, pockets, circles, bends, blind holes."""

import cadquery as cq
import pytest

from drawings.recognition.part_file import Proposal, in_position
from drawings.recognition.proposal import propose
from stagecad.solids.modelling.verification import DimensionVerifier


def proposal_of(body: cq.Workplane) -> Proposal:
    found = propose(DimensionVerifier(in_position(body.solids().val())))
    assert not found.open
    return found


def values(found: Proposal, method: str) -> list[tuple[float, int]]:
    """Values and counts of the dimensions of a kind."""
    return sorted((one.value, one.fields.get("count", 1)) for one in found.dimensions if one.method == method)


def test_hexagonal_pockets_have_one_width_and_the_places_of_their_middles() -> None:
    block = cq.Workplane("XY").box(80, 50, 12, centered=False)
    pockets = cq.Workplane("XY", origin=(0, 0, 7)).pushPoints([(15, 15), (65, 15), (52, 39)])
    found = proposal_of(block.cut(pockets.polygon(6, 10 / 0.75**0.5).extrude(5)))
    assert [one.value for one in found.dimensions if one.fields.get("note") == "HEX AF"] == [pytest.approx(10.0)]
    assert values(found, "angle") == []
    assert [value for value, _ in values(found, "linear")] == pytest.approx(
        [5.0, 10.0, 12.0, 15.0, 15.0, 39.0, 50.0, 52.0, 65.0, 80.0]
    )


def test_the_web_of_a_notch_hinge_has_its_thickness_and_that_between_bores_has_none() -> None:
    blade = cq.Workplane("XY").box(70, 24, 12, centered=(True, True, False))
    notches = cq.Workplane("XY").pushPoints([(x, y) for x in (-18, 18) for y in (-12.3, 12.3)]).circle(12).extrude(12)
    found = proposal_of(blade.cut(notches))
    web = next(one for one in found.dimensions if one.name == "web")
    assert (web.value, web.fields["count"]) == (pytest.approx(0.6), 2)
    assert not any(value == pytest.approx(24.6) for value, _ in values(found, "linear"))
    bores = cq.Workplane("XY").pushPoints([(0, 13), (0, -13)]).circle(12).extrude(12)
    bored = cq.Workplane("XY").box(70, 60, 12, centered=(True, True, False)).cut(bores)
    assert not any(one.name == "web" for one in proposal_of(bored).dimensions)


def test_a_pocket_has_its_depth_and_a_step_its_height() -> None:
    block = cq.Workplane("XY").box(90, 60, 30, centered=False)
    block = block.cut(cq.Workplane("XY", origin=(60, 0, 20)).box(30, 60, 10, centered=False))
    block = block.cut(cq.Workplane("XY", origin=(10, 12, 26)).box(31, 33, 4, centered=False))
    assert {4.0, 20.0} <= {value for value, _ in values(proposal_of(block), "linear")}


def test_a_floor_has_a_depth_although_another_hole_ends_at_its_level() -> None:
    plate = cq.Workplane("XY").box(80, 50, 20, centered=False)
    plate = plate.cut(cq.Workplane("XY").center(20, 22).circle(9).extrude(12))
    plate = plate.cut(cq.Workplane("XY", origin=(0, 0, 12)).pushPoints([(50, 11), (63, 33)]).circle(2).extrude(8))
    assert values(proposal_of(plate), "depth") == [(8.0, 2), (12.0, 1)]


def test_a_plate_without_straight_sides_is_dimensioned_from_its_bore() -> None:
    cam = cq.Workplane("XY").circle(35).extrude(8).union(cq.Workplane("XY").center(28, 0).circle(18).extrude(8))
    holes = cq.Workplane("XY").pushPoints([(34, 0), (-20, 3)]).circle(4).extrude(8)
    found = proposal_of(cam.cut(holes).cut(cq.Workplane("XY").circle(8).extrude(8)))
    assert {28.0, 34.0, 20.0, 3.0} == {value for value, _ in values(found, "linear")} - {8.0}


def test_equal_rounds_have_a_leader_in_each_view() -> None:
    plate = cq.Workplane("XY").box(40, 50, 2, centered=False).edges("|Z and <X").fillet(5)
    wall = cq.Workplane("XZ").moveTo(40, 0).lineTo(40, 2).radiusArc((43, 5), -3).lineTo(43, 35).lineTo(45, 35)
    bend = wall.lineTo(45, 5).radiusArc((40, 0), 5).close().extrude(-50)
    assert values(proposal_of(plate.union(bend)), "radius") == [(3.0, 1), (5.0, 1), (5.0, 2)]


def test_a_square_of_holes_is_on_a_circle_if_only_its_diameter_is_in_tenths() -> None:
    plate = cq.Workplane("XY").box(70, 60, 10, centered=False)
    circle = plate.cut(cq.Workplane("XY").center(30, 33).polarArray(18, 45, 360, 4).circle(2.5).extrude(10))
    square = plate.cut(
        cq.Workplane("XY").center(30, 33).rect(31, 31, forConstruction=True).vertices().circle(2).extrude(9)
    )
    assert values(proposal_of(circle), "pitch_circle") == [(pytest.approx(36.0), 1)]
    assert values(proposal_of(square), "pitch_circle") == []


def test_a_rib_has_no_odd_angle() -> None:
    base = cq.Workplane("XY").box(90, 60, 10, centered=False)
    wall = cq.Workplane("XY", origin=(0, 50, 10)).box(90, 10, 60, centered=False)
    rib = cq.Workplane("YZ", origin=(40, 0, 0)).polyline([(50, 10), (30, 10), (50, 25)]).close().extrude(6)
    assert values(proposal_of(base.union(wall).union(rib)), "angle") == []
