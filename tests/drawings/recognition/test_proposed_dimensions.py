"""Dimensions proposed for parts that nobody declared define them completely, and none of them is spare.

The mutations protect what no other test does: that the check of definition notices each dimension that is missing.
"""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import cadquery as cq
import ezdxf
import pytest

from benchmarks.generators.undeclared_parts import PARTS
from drawings.dimensions.consistency import mistakes
from drawings.recognition.features import features_of, tap_drill_of
from drawings.recognition.part_file import Proposal, Proposed, as_dimension, in_position, part_text
from drawings.recognition.proposal import propose
from drawings.views.section import cut_faces, cut_shape, hatch
from drawings.views.view import PROJECTIONS, Cut
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.recognition.proposals import W, problems, sheet_of, verifier_of
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file

QUICK = ("sprayer", "keyed_shaft", "slotted_plate", "stepped_block", "gib", "t_nut", "wedge_block", "crossed_pin")


@cache
def proposed(name: str) -> tuple[DimensionVerifier, Proposal]:
    verifier = verifier_of(PARTS[name]())
    return verifier, propose(verifier)


def is_refused(verifier: DimensionVerifier, changed: Proposed) -> bool:
    """Whether the solid does not have a dimension, or measures another value."""
    try:
        measured = verifier.measure(as_dimension(changed))
    except LookupError:
        return True
    return measured is None or abs(measured - changed.value) > 1e-6


def check(name: str) -> tuple[int, int]:
    """Numbers of mutations (a dimension left out, or with another value or count), and of those that are noticed."""
    verifier, proposal = proposed(name)
    assert not proposal.open
    dimensions, known = list(proposal.dimensions), set(proposal.open)
    for one in dimensions:
        measured = verifier.measure(as_dimension(one))
        assert measured is not None and math.isclose(measured, one.value, abs_tol=1e-6), one
    mutations = noticed = 0
    for number, one in enumerate(dimensions):
        before, after = dimensions[:number], dimensions[number + 1 :]
        noticed += not known.issuperset(problems(verifier, before + after))
        noticed += is_refused(verifier, replace(one, value=one.value + 0.5))
        mutations += 2
        count = one.fields.get("count", 1)
        for other in (count - 1, count + 1) if count > 1 and one.method != "linear" else ():
            # The count of a hole is that of all dimensions of its callout.
            feature = one.fields.get("feature")
            of_callout = [d is one or (bool(feature) and d.fields.get("feature") == feature) for d in dimensions]
            counted = [replace(d, fields={**d.fields, "count": other}) for d in dimensions]
            alike = [new if changed else d for d, new, changed in zip(dimensions, counted, of_callout)]
            refused = any(mistakes([as_dimension(d) for d in alike], (), verifier))
            noticed += refused or not known.issuperset(problems(verifier, alike))
            mutations += 1
    return mutations, noticed


@pytest.mark.parametrize("name", QUICK)
def test_each_dimension_left_out_or_changed_is_noticed(name: str) -> None:
    mutations, noticed = check(name)
    assert mutations >= 6 and noticed == mutations


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PARTS if name not in QUICK])
def test_each_dimension_of_any_part_left_out_or_changed_is_noticed(name: str) -> None:
    mutations, noticed = check(name)
    assert noticed == mutations


def test_features_are_recognised() -> None:
    block = features_of(DimensionVerifier(PARTS["pillow_block"]().solids().val()))
    steps = sorted(tuple(round(radius, 3) for radius, _ in hole.steps) for hole in block.holes)
    assert steps == [(5.0, 2.75)] * 4 + [(11.0,)] and all(hole.through for hole in block.holes)
    assert len(block.fillets) == 4
    strip = features_of(DimensionVerifier(PARTS["countersunk_strip"]().solids().val()))
    assert {(round(hole.sink[0], 6), round(hole.sink[1], 6)) for hole in strip.holes} == {(9.0, 90.0)}
    assert len(features_of(DimensionVerifier(PARTS["gib"]().solids().val())).chamfers) == 2


def test_a_bore_is_called_out_from_both_ends_and_a_hole_into_it_is_not_called_through() -> None:
    found = features_of(proposed("seat_housing")[0])
    upright = [hole for hole in found.holes if abs(hole.into[2]) == 1.0]
    steps = {hole.into[2]: [round(value, 3) for step in hole.steps for value in step] for hole in upright}
    assert steps == {-1.0: [20.0, 25.0, 12.0, 33.0], 1.0: [18.0, 12.0]}
    assert [hole.way_out for hole in upright] == ["through", ""]
    assert [(round(groove.radius, 6), round(groove.high - groove.low, 6)) for groove in found.grooves] == [(21.5, 1.8)]
    assert [hole.way_out for hole in found.holes if abs(hole.into[1]) == 1.0] == ["to bore"]


def test_holes_around_a_tube_are_a_ring_and_a_groove_about_a_bore_is_no_counterbore() -> None:
    shown = {one.name: one for one in proposed("sprayer")[1].dimensions}
    assert shown["angle 1"].value == pytest.approx(60.0) and shown["angle 1"].fields["count"] == 6
    assert shown["hole 1"].fields == {"view": "front", "count": 6, "feature": "hole 1", "note": "through"}
    flange = [one for one in proposed("sealed_flange")[1].dimensions if one.method == "diameter"]
    assert [one.name for one in flange if one.value == 44.0] == ["diameter 3"]
    inner = [one for one in proposed("hollow_block")[1].dimensions if one.name.startswith("hole")]
    assert {one.fields["view"] for one in inner} == {"section"}
    radii = {(one.value, one.fields.get("count", 1)) for one in proposed("curved_slots")[1].dimensions}
    assert (3.0, 4) in radii


def test_datums_are_faces_that_show_or_the_axis_of_a_rim() -> None:
    """Edges of the fins pass others in the view from below."""
    datums = proposed("finned_base")[1].datums
    assert [(one.letter, one.view) for one in datums] == [("A", "front"), ("B", "bottom"), ("C", "front")]
    assert [(one.letter, one.round) for one in proposed("index_disc")[1].datums] == [("A", True), ("B", False)]


def test_a_part_lies_along_the_middle_between_its_flanks_and_by_its_boss() -> None:
    """In any position in its file: along a flank its holes would be 69.8 mm and 5 mm apart."""
    solid = PARTS["tapered_lever"]().solids().val()
    for position in (solid, solid.rotate((0, 0, 0), (1, 2, 3), 31)):
        verifier = DimensionVerifier(in_position(position))
        holes = features_of(verifier).holes
        apart = sorted(abs(a - b) for a, b in zip(holes[0].mouth, holes[1].mouth))
        assert (apart[0], apart[2]) == pytest.approx((0.0, 70.0), abs=1e-6)
        datums = propose(verifier).datums
        assert [one.letter for one in datums] == ["A", "B"] and [one.round for one in datums] == [False, True]


def test_slots_grooves_and_hexagons_have_their_sizes() -> None:
    dimensions = proposed("gusseted_angle")[1].dimensions
    assert [(one.value, one.fields["count"]) for one in dimensions if one.method == "diameter"] == [(6.6, 2)]
    inner = next(one for one in proposed("seal_cover")[1].dimensions if one.value == pytest.approx(57.2))
    assert inner.fields["view"] == "bottom"
    assert values("hexagon_bolt", "linear") == [
        ("linear", 17.0, 1, "HEX AF"), ("linear", 42.0, 1, ""), ("linear", 7.0, 1, ""),
    ]  # fmt: skip
    shaft = values("two_keys", "linear")
    assert ("linear", 1.3, 2, "") in shaft or shaft.count(("linear", 1.3, 1, "")) == 2
    assert {36.5, 37.8, 93.0, 94.3}.intersection(one[1] for one in shaft) == {36.5, 93.0}


def test_legible_sheets_of_rings_and_crossed_keyways(tmp_path: Path) -> None:
    sheet_of(PARTS["hexagon_adapter"](), "adapter", tmp_path)
    shaft = W("YZ").circle(12).extrude(80)
    shaft = shaft.cut(W().workplane(offset=8).center(30, 0).slot2D(28, 8).extrude(10))
    shaft = shaft.cut(W("XZ").center(30, 9).circle(2.5).extrude(40, both=True))
    sheet_of(shaft, "shaft", tmp_path)


def values(name: str, *methods: str) -> list[tuple[str, float, int, str]]:
    """Method, value, count and note of the proposals of a part by some methods."""
    found = [one for one in proposed(name)[1].dimensions if not methods or one.method in methods]
    return [(one.method, round(one.value, 3), one.fields.get("count", 1), one.fields.get("note", "")) for one in found]


def test_equal_features_have_a_pitch_or_an_angle_and_one_of_them_its_sizes() -> None:
    sink = [one for one in proposed("heat_sink")[1].dimensions if one.arguments[-1] == (1.0, 0.0, 0.0)]
    assert {(round(one.value, 3), one.fields.get("count", 1)) for one in sink if one.method == "linear"} == {
        (60.0, 1), (40.0, 1), (4.0, 7),
    }  # fmt: skip
    assert ("pitch", 7.0, 1, "") in values("heat_sink", "pitch")
    rack = values("rack", "linear", "pitch")
    assert {("linear", 1.64, 8, ""), ("linear", 3.64, 8, ""), ("linear", 5.28, 8, "")} < set(rack)
    assert [round(one[1], 3) for one in rack if one[0] == "pitch"] == [6.283] and len(rack) < 15
    assert ("angle", 60.0, 6, "") in values("index_disc") and ("linear", 5.0, 6, "") in values("index_disc")
    grooves = values("kinematic_plate", "linear", "angle")
    angles = {("angle", 120.0, 3, ""), ("angle", 90.0, 1, "")}
    assert angles | {("linear", 8.0, 3, ""), ("linear", 16.0, 3, "")} < set(grooves)
    assert values("three_flats", "linear", "angle") == [
        ("angle", 120.0, 3, ""), ("linear", 27.0, 1, ""), ("linear", 20.0, 1, ""), ("linear", 12.0, 1, ""),
    ]  # fmt: skip


def test_a_dovetail_has_an_angle_and_slots_have_their_widths() -> None:
    table = values("dovetail_table", "linear", "angle")
    assert ("angle", 59.036, 2, "") in table and ("linear", 36.0, 1, "") in table
    assert {("linear", 6.0, 2, ""), ("linear", 14.0, 2, "")} < set(table)
    assert not {24.0, 48.0} & {one[1] for one in table}
    top = 20 + 8 * math.tan(math.radians(30))
    wedge = W("XZ").polyline([(0, 0), (60, 0), (60, 20), (52, top), (0, top)]).close().extrude(30)
    found = propose(DimensionVerifier(in_position(wedge.solids().val())))
    sizes = {one.method: round(one.value, 6) for one in found.dimensions if one.method == "angle"}
    assert sizes == {"angle": 30.0} and not found.open
    assert {round(one.value, 3) for one in found.dimensions} & {52.0, 20.0, 24.619} == {52.0, 24.619}


def test_pockets_beside_each_other_are_in_one_section() -> None:
    """A plane that touches the round corner of a pocket leaves a wire without edges, which has no hatch."""
    plate = W().box(120, 60, 20, (False, False, False))
    for x, y, tall, depth in ((25, 30, 20, 8), (60, 32, 16, 5), (95, 25, 30, 10)):
        pocket = W().workplane(offset=20 - depth).center(x, y).rect(20, tall).extrude(12)
        plate = plate.cut(pocket.edges("|Z").fillet(3))
    found = propose(DimensionVerifier(plate.solids().val()))
    planes = {one.arguments[1][1] for one in found.dimensions if one.fields.get("view") == "section"}
    assert not found.open and len(planes) == 1
    at = Cut((0.0, 23.0, 0.0), (0.0, -1.0, 0.0), "A")
    assert hatch(cut_faces(cut_shape(plate.val().wrapped, at), at), PROJECTIONS["front"], 1.0)


def test_holes_on_circles_with_and_without_symmetry() -> None:
    circle = values("spigot_flange", "pitch_circle", "angle")
    assert sorted(one[:2] for one in circle) == [("angle", 45.0), ("pitch_circle", 71.0), ("pitch_circle", 82.0)]
    found = proposed("flanged_bush")[1]
    assert not found.open and [one.value for one in found.dimensions if one.method == "pitch_circle"] == [37.0]


def test_tapers_counterbores_and_bores_have_diameters_and_sections() -> None:
    """The end of the taper is within the outline of another diameter."""
    sizes = {one.value: one.name for one in proposed("nozzle")[1].dimensions if one.method == "diameter"}
    assert set(sizes) == {6.0, 10.0, 16.0, 30.0} and not any("countersink" in name for name in sizes.values())
    collar = proposed("clamp_collar")[1]
    assert not collar.open
    (floor,) = [one for one in collar.dimensions if one.value == pytest.approx(8.0)]
    assert floor.fields["view"] == "section" and floor.arguments[1][2] == pytest.approx(7.5)
    assert {("linear", 2.0, 1, ""), ("diameter", 5.5, 1, "one wall")} <= {*values("clamp_collar")}


def test_holes_in_a_slanting_face_are_placed_in_an_auxiliary_view() -> None:
    _, proposal = proposed("wedge_block")
    shown = {one.name: one.value for one in proposal.dimensions if one.fields["view"] == "auxiliary"}
    assert {"hole 1", "hole 1 depth", "hole 2", "hole 2 depth"} < set(shown)
    across = math.hypot(70 - 55, 27 - 12)
    places = sorted(value for name, value in shown.items() if name.startswith("place"))
    assert places == pytest.approx([across - 12, across, 30.0, across + 12], abs=1e-6)


def test_fillets_of_a_floor_are_in_a_section_and_holes_around_a_tube_with_a_branch_are_on_a_circle() -> None:
    pocket = W().workplane(offset=10).rect(40, 30).extrude(15).edges("|Z").fillet(4)
    block = W().box(90, 70, 25, centered=(True, True, False)).cut(pocket.faces("<Z").edges().fillet(2))
    tube = W().circle(20).extrude(8).union(W().circle(10).extrude(40))
    tube = tube.union(W("YZ").center(0, 25).circle(8).extrude(25)).faces("<Z").workplane().hole(14)
    tube = tube.faces("<Z").workplane().polarArray(15, 45, 360, 4).hole(4.4, 8)
    found = [propose(DimensionVerifier(in_position(body.solids().val()))) for body in (block, tube)]
    radii = {one.value: one.fields["view"] for one in found[0].dimensions if one.method == "radius"}
    assert radii == {4.0: "top", 2.0: "section"} and not found[0].open
    assert [one.value for one in found[1].dimensions if one.method == "pitch_circle"] == [30.0]
    # Views that follow from the declarations are not stated: a designer may change the declarations.
    (views,) = [line for line in part_text("block", "block.step", found[0]).splitlines() if line.startswith("VIEWS")]
    assert "section" in found[0].views and "'section'" not in views


def test_rows_of_holes_askew_solids_and_tap_drills() -> None:
    """In a plate of 120 x 80 with holes at a pitch of 20, the edges are as far from the outer holes as a pitch."""
    _, proposal = proposed("hole_grid")
    assert [one.value for one in proposal.dimensions if one.method == "pitch"] == [20.0, 20.0]
    assert {120.0, 80.0} <= {one.value for one in proposal.dimensions if one.method == "linear"}
    solid = PARTS["plate"]().solids().val()
    assert isinstance(solid, cq.Solid)
    askew = in_position(solid.rotate((0, 0, 0), (1, 2, 3), 31).translate((5.0, -7.0, 11.0)))
    straight, found = (propose(DimensionVerifier(one)) for one in (in_position(solid), askew))
    values = [sorted(one.value for one in proposal.dimensions) for proposal in (straight, found)]
    assert values[1] == pytest.approx(values[0], abs=1e-6) and not found.open
    _, proposal = proposed("t_nut")
    assert proposal.questions == ("hole 1: is 5 mm the tap drill of M6x1? Then declare it with d.tapped(...)",)
    text = part_text("t_nut", "t_nut.step", proposal)
    compile(text, "t_nut_proposed.py", "exec")
    assert "d.diameter('hole 1'" in text and "- hole 1: is 5 mm" in text
    # A plain hole of 6 or 12 mm is none for a size of second choice (M7, M14), and 15.5 mm is for nothing but M18.
    drills = (2.5, 5.0, 6.0, 6.8, 12.0, 15.5, 24.0)
    assert [*map(tap_drill_of, drills)] == ["M3x0.5", "M6x1", "", "M8x1.25", "", "M18x2.5", ""]


def test_bores_are_shown_in_a_section_and_chamfers_are_counted() -> None:
    _, proposal = proposed("hub")
    assert proposal.views[0].startswith("front aligned")
    (chamfer,) = [one for one in proposal.dimensions if one.method == "chamfer"]
    assert chamfer.fields["count"] == 2
    assert not features_of(DimensionVerifier(PARTS["rail"]().solids().val())).chamfers
    # The datum is the axis of the largest round face, not its outline.
    (axis,) = [one for one in proposal.datums if one.round]
    assert axis.letter == "A" and math.dist(*axis.points) == pytest.approx(45.0)


def test_the_position_of_a_solid_does_not_matter() -> None:
    """A shaft along y somewhere else gets the dimensions of the shaft along x."""
    solid = PARTS["stepped_shaft"]().solids().val()
    assert isinstance(solid, cq.Solid)
    elsewhere = in_position(solid.rotate((0, 0, 0), (0, 0, 1), 90).translate((17.3, -220.0, 40.0)))
    sizes = [found.dimensions for found in (propose(DimensionVerifier(elsewhere)), proposed("stepped_shaft")[1])]
    assert sorted(one.value for one in sizes[0]) == pytest.approx(sorted(one.value for one in sizes[1]))


def test_features_that_are_not_legible_at_the_scale_are_in_details(tmp_path: Path) -> None:
    sheet = sheet_of(PARTS["fine_plate"](), "fine_plate", tmp_path)
    assert sheet["scale"] == "1:5"
    assert [view for view in sheet["views"] if view.startswith("detail")] == ["detail X", "detail Y"]
    drawn = ezdxf.readfile(tmp_path / "fine_plate.dxf").modelspace().query("DIMENSION")
    assert sum(abs(one.get_measurement() - 1.5) < 1e-6 for one in drawn) == 1


@pytest.mark.slow
def test_a_script_and_a_step_file_are_drawn_and_drawn_again_from_their_proposal(tmp_path: Path) -> None:
    cq.exporters.export(PARTS["angle_bracket"](), str(tmp_path / "bracket.step"))
    (document,) = draw_file(tmp_path / "bracket.step", Design(), False, tmp_path / "out")
    assert [hit for sheet in document["sheets"] for hit in sheet["hits"]] == []
    before = (tmp_path / "out" / "bracket.dxf").read_bytes()
    (again,) = draw_file(tmp_path / "out" / "bracket_proposed.py", Design(), True, tmp_path / "again")
    assert (tmp_path / "again" / "bracket.dxf").read_bytes() == before
    assert again["part"] == "bracket"


@pytest.mark.slow
def test_a_script_that_shows_two_solids_gives_two_sheets(tmp_path: Path) -> None:
    script = "import cadquery as cq\na = cq.Workplane().box(30, 20, 10)\nshow_object(a, name='Block A')\n"
    script += "show_object(a.faces('>Z').workplane().hole(6))"
    (tmp_path / "two.py").write_text(script, "utf-8")
    documents = draw_file(tmp_path / "two.py", Design(), True, tmp_path / "out")
    assert [document["part"] for document in documents] == ["block_a", "two_2"]


@pytest.mark.slow
def test_parts_of_an_assembly_have_their_names_and_equal_ones_one_sheet(tmp_path: Path) -> None:
    lines = (
        "import cadquery as cq",
        "pin = cq.Workplane().circle(3).extrude(20)",
        "vice = cq.Assembly(name='Vice').add(cq.Workplane().box(60, 40, 10), name='Base plate')",
        "vice.add(pin, name='Dowel', loc=cq.Location((20, 0, 5))).add(pin, name='Dowel 2')",
        "vice.add(cq.Workplane().box(9, 8, 7))",
        "vice.export(FILE) if hasattr(vice, 'export') else vice.save(FILE)",
        "show_object(vice)",
    )
    script = "\n".join(lines).replace("FILE", repr(str(tmp_path / "vice.step")))
    (tmp_path / "vice.py").write_text(script, "utf-8")
    for file in ("vice.py", "vice.step"):
        documents = draw_file(tmp_path / file, Design(), True, tmp_path / "out")
        assert [document["part"] for document in documents] == ["base_plate", "dowel", "vice_4"]
        assert "Quantity: 2." in (tmp_path / "out" / "dowel_proposed.py").read_text("utf-8")
        assert "Quantity" not in (tmp_path / "out" / "vice_4_proposed.py").read_text("utf-8")
