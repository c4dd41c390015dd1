"""Dimensions and sections that a shop expects for usual features of parts that nobody declared; faces by the model."""

import math
from pathlib import Path
from typing import Any

import cadquery as cq
import ezdxf
import pytest

from benchmarks.generators.undeclared_parts import PARTS
from drawings.recognition.proposal import propose
from tests.drawings.recognition.proposals import W, problems, proposal_of, sheet_of, values, verifier_of
from tests.refusals import refused
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file, propose_sheet


def test_hexagonal_pockets_have_one_width_and_the_places_of_their_middles() -> None:
    block = W().box(80, 50, 12, centered=False)
    pockets = W(origin=(0, 0, 7)).pushPoints([(15, 15), (65, 15), (52, 39)])
    found = proposal_of(block.cut(pockets.polygon(6, 10 / 0.75**0.5).extrude(5)))
    assert [one.value for one in found.dimensions if one.fields.get("note") == "HEX AF"] == [pytest.approx(10.0)]
    assert values(found, "angle") == []
    linear = [value for value, _ in values(found, "linear")]
    assert linear == pytest.approx([5.0, 10.0, 12.0, 15.0, 15.0, 39.0, 50.0, 52.0, 65.0, 80.0])


def test_the_web_of_a_notch_hinge_has_its_thickness_and_that_between_bores_has_none() -> None:
    blade = W().box(70, 24, 12, centered=(True, True, False))
    notches = W().pushPoints([(x, y) for x in (-18, 18) for y in (-12.3, 12.3)]).circle(12).extrude(12)
    found = proposal_of(blade.cut(notches))
    web = next(one for one in found.dimensions if one.name == "web")
    assert (web.value, web.fields["count"]) == (pytest.approx(0.6), 2)
    assert not any(value == pytest.approx(24.6) for value, _ in values(found, "linear"))
    bores = W().pushPoints([(0, 13), (0, -13)]).circle(12).extrude(12)
    bored = W().box(70, 60, 12, centered=(True, True, False)).cut(bores)
    assert not any(one.name == "web" for one in proposal_of(bored).dimensions)


def test_pockets_steps_and_floors_have_depths() -> None:
    block = W().box(90, 60, 30, centered=False)
    block = block.cut(W(origin=(60, 0, 20)).box(30, 60, 10, centered=False))
    block = block.cut(W(origin=(10, 12, 26)).box(31, 33, 4, centered=False))
    assert {4.0, 20.0} <= {value for value, _ in values(proposal_of(block), "linear")}
    plate = W().box(80, 50, 20, centered=False)
    plate = plate.cut(W().center(20, 22).circle(9).extrude(12))
    plate = plate.cut(W(origin=(0, 0, 12)).pushPoints([(50, 11), (63, 33)]).circle(2).extrude(8))
    assert values(proposal_of(plate), "depth") == [(8.0, 2), (12.0, 1)]


def test_plates_without_straight_sides_and_equal_rounds() -> None:
    cam = W().circle(35).extrude(8).union(W().center(28, 0).circle(18).extrude(8))
    holes = W().pushPoints([(34, 0), (-20, 3)]).circle(4).extrude(8)
    found = proposal_of(cam.cut(holes).cut(W().circle(8).extrude(8)))
    assert {28.0, 34.0, 20.0, 3.0} == {value for value, _ in values(found, "linear")} - {8.0}
    plate = W().box(40, 50, 2, centered=False).edges("|Z and <X").fillet(5)
    wall = W("XZ").moveTo(40, 0).lineTo(40, 2).radiusArc((43, 5), -3).lineTo(43, 35).lineTo(45, 35)
    bend = wall.lineTo(45, 5).radiusArc((40, 0), 5).close().extrude(-50)
    assert values(proposal_of(plate.union(bend)), "radius") == [(3.0, 1), (5.0, 1), (5.0, 2)]
    base = W().box(90, 60, 10, centered=False)
    wall = W(origin=(0, 50, 10)).box(90, 10, 60, centered=False)
    rib = W("YZ", origin=(40, 0, 0)).polyline([(50, 10), (30, 10), (50, 25)]).close().extrude(6)
    assert values(proposal_of(base.union(wall).union(rib)), "angle") == []


def test_squares_and_flanges_of_holes_have_circles_and_sections() -> None:
    plate = W().box(70, 60, 10, centered=False)
    circle = plate.cut(W().center(30, 33).polarArray(18, 45, 360, 4).circle(2.5).extrude(10))
    square = plate.cut(W().center(30, 33).rect(31, 31, forConstruction=True).vertices().circle(2).extrude(9))
    assert values(proposal_of(circle), "pitch_circle") == [(pytest.approx(36.0), 1)]
    assert values(proposal_of(square), "pitch_circle") == []
    flange = W().circle(50).extrude(14).cut(W().circle(20).extrude(14))
    holes = [W().polarArray(39, start, 360, 6).circle(4.5).extrude(14) for start in (30, 0)]
    pin = W(origin=(-39, 0, 0)).circle(3).extrude(14)
    assert proposal_of(flange.cut(holes[0]).cut(pin)).views[0].startswith("front aligned 0 0 0 33.77")
    assert proposal_of(flange.cut(holes[1])).views[0] == "front section"


def letters_of(document: dict[str, Any], letter: str) -> int:
    (path,) = (file for file in document["files"] if file.endswith(".dxf"))
    texts = (entity for layout in ezdxf.readfile(path).layouts for entity in layout.query("TEXT MTEXT"))
    return sum((one.text if one.dxftype() == "MTEXT" else one.dxf.text) == letter for one in texts)


def test_holes_on_parallel_planes_have_an_offset_section_and_those_on_one_plane_a_straight_one(tmp_path: Path) -> None:
    block = W().box(90, 50, 30, centered=False)
    stepped = W(origin=(45, 25, 14)).circle(9).extrude(16)
    stepped = stepped.union(W(origin=(45, 25, 0)).circle(5).extrude(14))
    blind = W(origin=(72, 38, 18)).circle(3.4).extrude(12)
    body = block.cut(stepped).cut(blind)
    assert proposal_of(body).views[0] == "front offset 45 25 0 72 38 0"
    assert sheet_of(body, "offset_block", tmp_path)["views"] == ["section A-A", "top", "iso"]
    in_line = block.cut(stepped.translate((0, -5, 0))).cut(blind.translate((0, -18, 0)))
    assert proposal_of(in_line).views[0] == "front offset 58.5 20 0"


def test_a_turned_part_with_features_outside_and_inside_has_a_half_section_without_a_letter(tmp_path: Path) -> None:
    bush = PARTS["flanged_bush"]()
    assert proposal_of(bush).views[0] == "front half 0 0 0 1 0 0"
    assert sheet_of(bush, "flanged_bush", tmp_path)["views"][0] == "half front"
    # What ends on a line of the half that is cut away keeps the whole view.
    slot = W("XZ", origin=(0, 0, 20)).slot2D(18, 6, 90).extrude(40)
    assert not any("half" in view for view in proposal_of(bush.cut(slot)).views)


def test_a_bore_with_equal_counterbores_has_a_whole_callout_at_each_end(tmp_path: Path) -> None:
    block = W().box(100, 50, 40, centered=False).cut(W("YZ", origin=(0, 25, 20)).circle(4).extrude(100))
    for start in (0, 86):
        block = block.cut(W("YZ", origin=(start, 25, 20)).circle(5.9).extrude(14))
    found = proposal_of(block)
    assert values(found, "depth") == [(14.0, 1), (14.0, 1)]
    assert [value for value, _ in values(found, "diameter")] == pytest.approx([8.0, 11.8, 11.8])
    assert {"right", "left"} <= set(sheet_of(block, "ported_block", tmp_path)["views"])


@pytest.mark.parametrize("name", ["spacer_tube", "sprayer"])
def test_the_plane_of_a_section_is_marked_from_the_side_and_in_a_half_section(name: str, tmp_path: Path) -> None:
    # Two zones of the frame, the revision and a datum have the letter, too.
    assert letters_of(sheet_of(PARTS[name](), name, tmp_path), "A") == 4 + 2


def test_a_hole_that_is_cut_open_at_its_rim_is_a_hole_with_its_depth() -> None:
    plate = W().box(80, 50, 20, centered=False)
    for off in (4.9, 2.0):
        found = proposal_of(plate.cut(W(origin=(0, 0, 8)).pushPoints([(20, off), (60, 25)]).circle(5).extrude(12)))
        assert values(found, "diameter") == [(10.0, 2)] and values(found, "depth") == [(12.0, 2)]
        assert values(found, "radius") == []
    open_sink = W(origin=(0, 0, 14)).pushPoints([(20, 5), (60, 5)])
    bores = W().pushPoints([(20, 5), (60, 5)]).circle(3).extrude(20)
    found = proposal_of(plate.cut(bores).cut(open_sink.circle(7.1).extrude(6)))
    assert values(found, "diameter") == [(6.0, 2), (14.2, 2)] and values(found, "depth") == [(6.0, 2)]
    # Two of six holes on a circle cut the sides of a block, and so begin in its upper face.
    plate = W().circle(50).extrude(18)
    block = W(origin=(0, 0, 18)).box(55.2, 30, 12, centered=(True, True, False))
    found = proposal_of(plate.union(block).cut(W().polarArray(32, 0, 360, 6).circle(4.5).extrude(40)))
    (hole,) = [one for one in found.dimensions if one.method == "diameter" and one.value == 9.0]
    assert hole.fields["note"] == "through" and hole.fields["count"] == 6
    assert values(found, "pitch_circle") == [(64.0, 1)]


def test_coaxial_holes_that_end_in_bores_from_both_sides_have_a_callout_each() -> None:
    plate = W("XZ").rect(40, 40).extrude(9)
    for side in (-1, 1):
        plate = plate.cut(W("XZ").center(12 * side, 0).circle(3).extrude(9))
        plate = plate.cut(W("YZ", origin=(20 * side, -4.5, 0)).circle(1.25).extrude(-8 * side))
    found = proposal_of(plate)
    shown = [one.fields["view"] for one in found.dimensions if one.fields.get("note") == "to bore"]
    assert sorted(shown) == ["left", "right"] and not found.open


def test_a_hole_whose_floor_another_one_cuts_has_a_depth() -> None:
    block = W().box(70, 50, 45, centered=False)
    block = block.cut(W(origin=(20, 25, 9)).circle(5).extrude(36))
    found = proposal_of(block.cut(W("YZ", origin=(0, 25, 12)).circle(4).extrude(52)))
    assert values(found, "depth") == [(36.0, 1), (52.0, 1)]
    assert not any("note" in one.fields for one in found.dimensions)


def test_a_counterbore_in_a_round_outside_has_its_floor_at_a_usual_distance_from_the_axis() -> None:
    hub = W().circle(16).extrude(38).cut(W().circle(4).extrude(38))
    hub = hub.cut(W("XZ", origin=(10, 20, 6)).circle(2).extrude(40))
    found = proposal_of(hub.cut(W("XZ", origin=(10, -4, 6)).circle(3.7).extrude(20)))
    assert values(found, "depth") == [] and (4.0, 1) in values(found, "linear")


def test_a_collet_has_the_ends_of_its_cone_and_the_corners_of_a_turned_square_a_diameter() -> None:
    ends = [(0, 0), (9, 0), (13, 30), (13, 36), (0, 36)]
    collet = W("XZ").polyline(ends).close().revolve(360, (0, 0, 0), (0, 1, 0))
    collet = collet.cut(W().circle(5).extrude(36))
    for slit in (W(origin=(0, 0, 6)).rect(*size).extrude(30) for size in ((40, 0.8), (0.8, 40))):
        collet = collet.cut(slit)
    found = proposal_of(collet)
    assert values(found, "diameter") == [(10.0, 1), (18.0, 1), (26.0, 1)]
    assert not any(one.fields.get("note") == "SQ" for one in found.dimensions)
    found = proposal_of(W().rect(20, 20).extrude(60).intersect(W().circle(13).extrude(60)))
    assert values(found, "diameter") == [(26.0, 1)] and values(found, "radius") == []


def test_the_nose_of_a_cam_has_a_place_and_its_flanks_none() -> None:
    far, angle = 30.0, math.acos((25 - 10) / 30.0)
    ends = [(r * math.cos(angle) + x, side * r * math.sin(angle)) for side in (1, -1) for x, r in ((0, 25), (far, 10))]
    web = W().polyline([ends[0], ends[1], ends[3], ends[2]]).close().extrude(8)
    body = web.union(W().circle(25).extrude(8)).union(W().center(far, 0).circle(10).extrude(8))
    found = proposal_of(body.cut(W().circle(7).extrude(8)))
    assert values(found, "linear") == [(8.0, 1), (30.0, 1)] and values(found, "radius") == [(10.0, 1), (25.0, 1)]


def test_holes_begin_at_an_edge_and_not_at_a_slot_between_them_or_at_the_axis_of_a_fillet() -> None:
    plate = W().box(70, 30, 12, centered=False).cut(W().center(30, 12).slot2D(12, 3).extrude(12))
    found = proposal_of(plate.cut(W().pushPoints([(10, 12), (50, 12)]).circle(4).extrude(12)))
    lengths = [value for value, _ in values(found, "linear")]
    assert 40.0 in lengths and 10.0 in lengths and 20.0 not in lengths
    block = W().box(60, 40, 22, centered=False).edges("|Z and <X").fillet(8)
    block = block.cut(W("YZ").pushPoints([(8, 11), (32, 11)]).circle(2).extrude(10))
    block = block.cut(W().center(50, 9).circle(3).extrude(22))
    found = proposal_of(block.cut(W().center(24, 20).circle(6).extrude(22)))
    assert {24.0, 20.0} <= {value for value, _ in values(found, "linear")}


def test_engraved_text_has_its_depth_and_the_model_gives_its_outlines_and_free_form_faces_once() -> None:
    wave = W().moveTo(0, 0).lineTo(80, 0).lineTo(80, 40).spline([(60, 44), (30, 36), (0, 40)], includeCurrent=True)
    plate = wave.close().extrude(10).cut(W().center(65, 28).circle(3).extrude(10))
    engraved, deeper = (plate.cut(W(origin=(30, 15, 10)).text("K8B", 12, -deep)) for deep in (0.5, 0.8))
    found = proposal_of(engraved)
    assert [one.value for one in found.dimensions if one.method == "depth"] == [pytest.approx(0.5)]
    assert found.model == ("outlines of marks", "free-form faces") and len(found.questions) == 2
    assert len(found.dimensions) < 10
    for body, dimensions in ((deeper, found.dimensions), (engraved, [d for d in found.dimensions if d.name != "mark"])):
        assert sum("place" in line for line in problems(verifier_of(body), [*dimensions])) == 3


def test_the_sizes_of_a_part_with_torus_faces_are_those_between_its_outer_faces() -> None:
    block = W().box(100, 64, 24).edges("|Z").fillet(6).edges("<Z").fillet(2)
    assert {100.0, 64.0, 24.0} <= {value for value, _ in values(proposal_of(block), "linear")}


def test_corners_in_line_with_the_end_of_a_slot_and_theoretical_ones_beside_fillets_have_dimensions() -> None:
    block = W().box(60, 60, 70, centered=False).cut(W(origin=(0, 8, 8)).box(60, 60, 70, centered=False))
    rib = W("YZ", origin=(40, 0, 0)).polyline([(8, 8), (48, 8), (8, 56)]).close().extrude(6)
    found = proposal_of(block.union(rib).cut(W().center(20, 38).slot2D(20, 7, 90).extrude(8)))
    assert 48.0 in {value for value, _ in values(found, "linear")}
    pocket = W(origin=(0, 0, 4)).polyline([(10, 10), (50, 14), (50, 26), (10, 30)]).close().extrude(9)
    plate = W().box(60, 40, 10, centered=False).cut(pocket.edges("|Z").fillet(2))
    assert {12.0, 20.0} <= {value for value, _ in values(proposal_of(plate), "linear")}


OUT_OF_REACH = """
import cadquery as cq
body = cq.Workplane().box(60, 40, 20)
show_object(body.cut(cq.Workplane().box(9.2, 7.7, 4.4).rotate((0, 0, 0), (1, 2, 3), 33)), name="void")
"""
"""A void within a block at no angle to its axes, which no view shows."""


def test_holes_have_a_diameter_beside_notches_of_their_radius() -> None:
    rows = [(x, y) for x in range(-30, 35, 5) for y in (-15, -10, 10, 15)]
    board = W().box(70, 30, 3).pushPoints([*rows, *((x, y) for y in range(-10, 15, 5) for x in (30, 35))]).hole(2)
    found = proposal_of(board.pushPoints([(x, y) for x in (-30, 30) for y in (-10, 10)]).hole(4))
    assert values(found, "diameter") == [(2.0, 25), (4.0, 4)] and values(found, "radius") == [(1.0, 31)]


def test_a_dome_over_a_bore_of_its_radius() -> None:
    body = W().box(40, 40, 20).faces("<Z").workplane().hole(10, 12)
    found = proposal_of(body.union(W().sphere(5).translate((0, 0, 10))))
    assert values(found, "diameter") == [(10.0, 1)] and values(found, "radius") == [(5.0, 1)]


def test_a_distance_from_a_centre_line_is_shown() -> None:
    """The end of a rib beside a boss, whose axis is drawn in the view from the side."""
    body = W().circle(30).extrude(8).faces(">Z").workplane().circle(12).extrude(20)
    body = body.union(W("XZ").polyline([(10, 8), (26, 8), (10, 24)]).close().extrude(2, both=True))
    found = proposal_of(body.edges(cq.selectors.BoxSelector((-29, -29, 7.9), (29, 29, 8.1))).fillet(1.5))
    assert (26.0, 1) in values(found, "linear") and not found.undefined


def test_each_of_several_slanting_holes_has_its_angle() -> None:
    plate = W().box(40, 40, 2.5).faces(">Z").workplane()
    plate = plate.transformed(offset=cq.Vector(0, -15, 10), rotate=cq.Vector(60, 0, 0))
    found = propose(verifier_of(plate.rect(15, 15, forConstruction=True).vertices().hole(2.5)))
    assert {value for value, _ in values(found, "angle")} == {30.0}  # against the plate
    assert len({one.key for one in found.dimensions}) == len(found.dimensions)
    assert all(one.key.isidentifier() for one in found.dimensions)


@pytest.mark.slow
def test_faces_that_no_view_shows_are_given_by_the_model_as_the_file_says(tmp_path: Path) -> None:
    (tmp_path / "void.py").write_text(OUT_OF_REACH, "utf-8")
    (document,) = draw_file(tmp_path / "void.py", Design(), True, tmp_path)
    assert [hit for sheet in document["sheets"] for hit in sheet["hits"]] == []
    (question,) = [one for one in document["questions"] if "no dimension gives" in one]
    assert question.count("plane at") == 6
    file = tmp_path / "void_proposed.py"
    text = file.read_text("utf-8")
    first = text.partition("FACES_BY_MODEL = (\n")[2].partition("\n")[0]
    file.write_text(text.replace(f"{first}\n", "", 1), "utf-8")
    (again,) = draw_file(file, Design(), True, tmp_path / "again")
    hits = [hit for sheet in again["sheets"] for hit in sheet["hits"]]
    assert hits and all(first.strip(" ',") in hit for hit in hits)
    file.write_text(text.replace(first, "    'plane near the middle',", 1), "utf-8")
    refused("FACES_BY_MODEL", draw_file, file, Design(), True, tmp_path / "again")


@pytest.mark.slow
def test_what_the_drawn_sheet_does_not_show_is_given_by_the_model(tmp_path: Path) -> None:
    """A dimple within the block, whose arc is in no view from outside."""
    script = "import cadquery as cq\nball = cq.Workplane().sphere(3).translate((0, 0, 6))\n"
    (tmp_path / "dimple.py").write_text(f"{script}show_object(cq.Workplane().box(20, 20, 10).cut(ball))\n", "utf-8")
    (document,) = draw_file(tmp_path / "dimple.py", Design(), True, tmp_path)
    assert [hit for sheet in document["sheets"] for hit in sheet["hits"]] == []
    assert ["sphere at 0, 0, 9" in one for one in document["questions"]] == [True]


def texts_of(file: Path) -> set[str]:
    return {one.dxf.text for one in ezdxf.readfile(file).query("TEXT")}  # pyright: ignore[reportPrivateImportUsage]


def test_the_section_of_a_long_profile_is_drawn_at_a_scale_of_its_own(tmp_path: Path) -> None:
    """At the scale of its length it would need a detail at each slot, and its distances reach from one to another."""
    bar = W("YZ").rect(60, 60).extrude(1500).cut(W("YZ").center(0, 26).rect(16, 8).extrude(1500))
    bar = bar.cut(W("YZ").center(0, 30).rect(8, 10).extrude(1500))
    bar = bar.cut(W("YZ").pushPoints([(-20, -20), (20, -20)]).circle(3.4).extrude(25))
    document = propose_sheet("bar", bar.solids().val(), "bar.py", Design(), tmp_path)
    assert [sheet["hits"] for sheet in document["sheets"]] == [[]]
    assert not any("no dimension gives" in one for one in document["questions"])
    assert {"P (1:1)", "1:10"} <= texts_of(tmp_path / "bar.dxf")


def test_a_hole_in_a_slanting_face_has_one_view_though_a_corner_is_in_the_plane_of_another(tmp_path: Path) -> None:
    wall = W("XZ").polyline([(0, 0), (60, 0), (60, 40), (40, 60), (0, 60)]).close().extrude(-16)
    gusset = W("YZ").polyline([(0, 0), (-40, 0), (0, 40)]).close().extrude(8)
    face = cq.Plane(origin=(50, 8, 50), xDir=(0, 1, 0), normal=(1, 0, 1))
    sheet_of(gusset.union(wall).cut(W(face).circle(2.5).extrude(-14)), "wall", tmp_path)
    assert {*"PQ"} & texts_of(tmp_path / "wall.dxf") == {"P"}


def test_a_hole_square_to_a_face_at_a_compound_angle_is_drawn(tmp_path: Path) -> None:
    corner = cq.Plane(origin=(40, 30, 20), xDir=(1, -1, 0), normal=(1, 1, 1))
    block = W().box(40, 30, 20, centered=False).cut(W(corner).workplane(-12).rect(80, 80).extrude(40))
    document = propose_sheet("block", block.cut(W(corner).circle(2).extrude(-20)).val(), "b.py", Design(), tmp_path)  # pyright: ignore[reportArgumentType]
    assert document["files"]


def test_a_recess_around_a_core_is_no_counterbore_of_the_bore_in_it() -> None:
    cup = W().circle(25).extrude(30).cut(W().workplane(offset=6).circle(21).circle(12).extrude(24))
    cup = cup.cut(W().circle(3.5).extrude(30)).cut(W().workplane(offset=27).circle(13).extrude(3))
    found = proposal_of(cup)
    assert values(found, "diameter") == [(7.0, 1), (24.0, 1), (42.0, 1), (50.0, 1)]
    assert values(found, "depth") == [] and {6.0, 27.0} <= {value for value, _ in values(found, "linear")}


def test_a_circle_of_holes_does_not_place_other_holes_on_it() -> None:
    disc = W().circle(30).extrude(6).cut(W().polarArray(20, 30, 360, 3).circle(1.5).extrude(6))
    found = proposal_of(disc.cut(W().polarArray(20, 0, 360, 6).circle(2.1).extrude(6)))
    assert [one.arguments[2] for one in found.dimensions if one.method == "pitch_circle"] == [6, 3]


def test_holes_in_two_directions_at_one_level_have_a_place_each_unless_they_meet() -> None:
    angle = W().box(40, 60, 5, centered=(False, True, False)).union(W().box(5, 60, 40, centered=(False, True, False)))
    angle = angle.cut(W().pushPoints([(25, -15), (25, 15)]).circle(2).extrude(5))
    found = proposal_of(angle.cut(W("YZ").pushPoints([(-15, 30), (15, 30)]).circle(3).extrude(5)))
    assert values(found, "linear").count((30.0, 1)) == 3  # both spacings, and the height of the second pair
    block = W().box(60, 40, 20, centered=False).cut(W().center(20, 15).circle(5).extrude(20))
    crossed = proposal_of(block.cut(W("YZ").center(15, 10).circle(2).extrude(30)))
    assert values(crossed, "linear").count((15.0, 1)) == 1


def test_a_width_about_axes_places_no_wall_that_has_none_opposite() -> None:
    """The floor of a slot in an edge, as far from the axes of holes as the walls of two openings are from theirs."""
    plate = W().box(120, 100, 12, centered=False).cut(W().pushPoints([(60, 26), (60, 74)]).rect(90, 8).extrude(12))
    plate = plate.cut(W().pushPoints([(7, 50), (113, 50)]).circle(2).extrude(12))
    found = proposal_of(plate.cut(W().center(60, 0).rect(6, 10).extrude(12)))
    assert (5.0, 1) in values(found, "linear")
