"""Completeness of definition: parts of the thesis and of a user's own; what a sheet leaves open; lines of faces."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cadquery as cq
import pytest

from drawings.dimensions.definition import HEADINGS, Definition, Notes, definition, notes_on_shape
from drawings.dimensions.edges import edge_of_face
from drawings.views.view import PROJECTIONS
from stagecad.friction_stage.construction import MADE, part_definition
from stagecad.parameters.dimension import DatumFeature, Dimension, Point
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.drawn import described, thesis
from tests.drawings.own_parts import PARTS, draw_part, hits_of
from tests.refusals import refused

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def linear(name: str, first: Point, second: Point, along: Point, value: float) -> Dimension:
    return Dimension(name, "linear", value, f"block.{name}", (first, second), along, "X.X")


BLOCK = cq.Solid.makeBox(40, 30, 10).cut(cq.Solid.makeCylinder(3, 10, cq.Vector(10, 8, 0))).Solids()[0]
DIMENSIONS = (
    linear("length", (0, 5, 5), (40, 5, 5), X, 40.0),
    linear("width", (5, 0, 5), (5, 30, 5), Y, 30.0),
    linear("height", (5, 5, 0), (5, 5, 10), Z, 10.0),
    linear("hole along", (0, 5, 5), (10, 8, 5), X, 10.0),
    linear("hole across", (5, 0, 5), (10, 8, 5), Y, 8.0),
    Dimension("hole", "diameter", 6.0, "block.hole", ((10, 8, 5),), Z, "X.X"),
)


def of_block(*dimensions: Dimension) -> Definition:
    return definition(DimensionVerifier(BLOCK), dimensions, (), Notes())


def test_a_block_is_defined_by_six_dimensions_each_given_once() -> None:
    assert of_block(*DIMENSIONS).problems == ()
    again = linear("hole from the far end", (10, 8, 5), (40, 5, 5), X, 30.0)
    assert of_block(*DIMENSIONS, again).problems == ("the dimension 'hole from the far end' follows from others",)
    assert of_block(*DIMENSIONS, replace(again, reference=True)).problems == ()


@pytest.mark.parametrize("left_out", range(len(DIMENSIONS)))
def test_every_dimension_that_is_left_out_is_missed(left_out: int) -> None:
    rest = [d for number, d in enumerate(DIMENSIONS) if number != left_out]
    assert of_block(*rest).problems


def test_a_bore_whose_outline_is_at_another_level_by_chance_is_not_placed_by_it() -> None:
    """The lowest line of the bore is as high as the floor of a blind hole, to which no dimension of the bore goes."""
    block = cq.Workplane("XY").box(60, 40, 45, centered=False).faces(">Z").workplane(origin=(10, 10, 45)).hole(4, 14)
    block = block.cut(cq.Workplane("YZ").center(20, 22).circle(9).extrude(60))
    dimensions = (
        linear("length", (0, 5, 5), (60, 5, 5), X, 60.0),
        linear("width", (5, 0, 5), (5, 40, 5), Y, 40.0),
        linear("height", (5, 5, 0), (5, 5, 45), Z, 45.0),
        linear("hole along", (0, 5, 5), (10, 10, 40), X, 10.0),
        linear("hole across", (5, 0, 5), (10, 10, 40), Y, 10.0),
        Dimension("hole", "diameter", 4.0, "block.hole", ((10, 10, 40),), Z, "X.X", feature="hole"),
        Dimension("depth", "depth", 14.0, "block.depth", ((10, 10, 45), (10, 10, 31)), Z, "X.X", feature="hole"),
        Dimension("bore", "diameter", 18.0, "block.bore", ((30, 20, 22),), X, "X.X"),
        linear("bore across", (5, 0, 5), (0, 20, 22), Y, 20.0),
    )
    verifier = DimensionVerifier(block.val())
    (problem,) = definition(verifier, dimensions, (), Notes(packaged=False)).problems
    assert "cylinder at 30, 20, 22" in problem
    high = linear("bore height", (5, 5, 0), (0, 20, 22), Z, 22.0)
    assert definition(verifier, (*dimensions, high), (), Notes(packaged=False)).problems == ()


def test_a_slot_is_placed_by_its_width_and_its_length_over_all() -> None:
    block = cq.Workplane().box(60, 40, 10).cut(cq.Workplane().slot2D(24, 8).extrude(5))
    dimensions = [
        linear("length", (-30, 0, 5), (30, 0, 5), X, 60.0),
        linear("width", (0, -20, 5), (0, 20, 5), Y, 40.0),
        linear("height", (-30, -20, -5), (-30, -20, 5), Z, 10.0),
        linear("depth", (0, -4, 0), (0, -4, 5), Z, 5.0),
        linear("slot width", (0, -4, 5), (0, 4, 5), Y, 8.0),
        linear("slot length", (-12, 0, 5), (12, 0, 5), X, 24.0),
    ]
    verifier, notes = DimensionVerifier(block.val()), Notes("xy", packaged=False)
    assert definition(verifier, dimensions, (), notes).problems == ()
    ends = definition(verifier, dimensions[:-1], (), notes).problems
    assert len(ends) == 2 and all("the place of face" in line and "cylinder" in line for line in ends)


def test_a_bend_of_a_rod_is_placed_by_its_axis() -> None:
    path = cq.Workplane("XZ").lineTo(0, 20).radiusArc((30, 50), 30).lineTo(50, 50)
    rod = DimensionVerifier(cq.Workplane().circle(6).sweep(path).val())
    (bend,) = [s for s in rod.surfaces if s.kind == "TORUS"]
    assert bend.origin == pytest.approx((30.0, 0.0, 20.0))
    dimensions = [
        Dimension("rod", "diameter", 12.0, "rod.rod", ((0, 0, 10),), Z, "X.X"),
        Dimension("end", "diameter", 12.0, "rod.rod", ((40, 0, 50),), X, "X.X"),
        Dimension("tube", "radius", 6.0, "rod.tube", (bend.vertices[0],), Y, "X.X"),
        linear("height", (0, 0, 0), (40, 0, 50), Z, 50.0),
        linear("length", (0, 0, 0), (50, 0, 50), X, 50.0),
    ]
    (problem,) = definition(rod, dimensions, (), Notes("y", packaged=False)).problems
    assert "the place of face" in problem and "(torus" in problem
    low, far = (next(v for v in bend.vertices if abs(v[n] - at) < 1e-6) for n, at in ((2, 20.0), (0, 30.0)))
    legs = [linear("upright", (0, 0, 0), low, Z, 20.0), linear("level", (0, 0, 0), far, X, 30.0)]
    assert definition(rod, [*dimensions, *legs], (), Notes("y", packaged=False)).problems == ()


def test_symmetry_of_the_notes_places_both_ends() -> None:
    solid = cq.Solid.makeBox(40, 30, 10, cq.Vector(-20, -15, 0))
    dimensions = (
        linear("length", (-20, 5, 5), (20, 5, 5), X, 40.0),
        linear("width", (5, -15, 5), (5, 15, 5), Y, 30.0),
        linear("height", (5, 5, 0), (5, 5, 10), Z, 10.0),
    )
    assert definition(DimensionVerifier(solid), dimensions, (), Notes("xy")).problems == ()


@cache
def of_part(name: str) -> tuple[DimensionVerifier, tuple[Dimension, ...]]:
    part = described(name, thesis())
    return DimensionVerifier(part.solid), part.dimensions


@pytest.mark.parametrize("name", MADE)
def test_the_parts_of_the_thesis_are_defined_completely(name: str) -> None:
    verifier, dimensions = of_part(name)
    module = part_definition(name)
    requirements = getattr(module, "requirements", lambda design: ())(thesis())
    assert definition(verifier, dimensions, requirements, notes_on_shape(module, thesis())).problems == ()


@pytest.mark.parametrize(("name", "left_out"), [
    ("stage", "iron pocket width"), ("stage", "thickness"), ("holder", "floor"), ("holder", "lead slot width"),
    ("tip", "arm width"), ("bearing_way", "flange thickness"), ("height_pin_1", "spigot length"),
    ("tooth_bar", "channel width"),
])  # fmt: skip
def test_a_dimension_left_out_of_a_part_is_missed(name: str, left_out: str) -> None:
    verifier, dimensions = of_part(name)
    rest = [d for d in dimensions if d.name != left_out and left_out.removesuffix("s") not in d.derived_from]
    rest = [d for d in rest if not (left_out == "floor" and d.name == "well floor")]
    assert len(rest) < len(dimensions)
    assert definition(verifier, rest, (), notes_on_shape(part_definition(name), thesis())).problems


@pytest.mark.parametrize("name, override", [
    ("base", "base.length=365.2 mm"), ("tooth_iron", "teeth.per_iron=1"), ("tooth_iron", "teeth.per_iron=3"),
    ("tooth_bar", "teeth.per_iron=1"), ("tooth_bar", "teeth.per_iron=3"),
])  # fmt: skip
def test_parts_of_other_designs_are_defined_completely(name: str, override: str) -> None:
    # In the thesis's base the floor of a counterbore lies at the level of another face.
    design = load_design(overrides=[override])
    part = described(name, design)
    notes = notes_on_shape(part_definition(name), design)
    assert definition(DimensionVerifier(part.solid), part.dimensions, part.requirements, notes).problems == ()


def test_unlike_holes_are_refused_and_a_circle_of_holes_is_one_dimension(tmp_path: Path) -> None:
    said = r"three\.py: 'hole' is given for 3 features, the solid has 2 of this diameter"
    refused(said, draw_part, tmp_path, "three")
    with pytest.raises(InputError, match=r"'hole' is one dimension for holes that go through and holes that do not"):
        draw_part(tmp_path, "three", ("count=3", "count=2"))
    lines = (PARTS / "housing.py").read_text("utf-8").splitlines()
    (linear,) = [line for line in lines if '"bolt circle"' in line]
    circle = '    d.pitch_circle("bolt circle", "pcd", (0, 0, t), (p.pcd / 2, 0, 5), 6, view="top")'
    assert hits_of(tmp_path, "housing") and hits_of(tmp_path, "housing", (linear, circle)) == []


def test_what_a_slot_or_window_lacks_is_named(tmp_path: Path) -> None:
    hits = hits_of(tmp_path, "undef")
    assert [hit for hit in hits if "is not defined" in hit] == hits
    assert "the place of face 13 (plane at 0, 10, 5) is not defined" in hits
    assert {int(hit.split("face ")[1].split()[0]) for hit in hits} == {9, 10, 11, 12, 13}
    rows = (tmp_path / "undef_definition.csv").read_text("utf-8").splitlines()
    assert rows[0] == ",".join(HEADINGS) and len(rows) == 14
    hits = hits_of(tmp_path, "fx_block")
    assert len(hits) == 8 and all(hit.startswith("the place of face") for hit in hits)


def test_the_depth_in_a_callout_is_that_of_all_its_holes(tmp_path: Path) -> None:
    depth = '(fx, fy, h - p.counterbore_depth), view="top", count=4,'
    assert hits_of(tmp_path, "fx_base", (depth, depth.replace(" count=4,", ""))) == hits_of(tmp_path, "fx_base")


def test_a_class_that_no_table_has_is_refused_in_a_fit(tmp_path: Path) -> None:
    said = r"PARAMETERS\['hole'\]: tolerance = 'H17'; allowed: X, X.X, X.XX, or a class of ISO 286"
    refused(said, draw_part, tmp_path, "undef", ('"hole": "6.6 mm"', '"hole": "6.6 H17"'))


@pytest.mark.parametrize(("name", "faces"), [("fx_base", {16, 17, 18, 19}), ("keyshaft", {4, 6})])
def test_a_slot_without_a_place_along_its_row_is_named(name: str, faces: set[int], tmp_path: Path) -> None:
    hits = hits_of(tmp_path, name)
    assert {int(hit.split("face ")[1].split()[0]) for hit in hits} == faces


def test_forms_views_and_fits_that_say_too_much_are_reported(tmp_path: Path) -> None:
    """A flatness as large as the perpendicularity of its face, and Ra 3.2 on a 6 H7 (12 um)."""
    (line,) = [one for one in (PARTS / "fx_block.py").read_text("utf-8").splitlines() if "f.tolerance(" in one]
    flat = line.replace("perpendicularity", "flatness").replace(', datums=("A",)', "").replace('"leaf"', '"leaf face"')
    hits = hits_of(tmp_path, "fx_block", (line, f"{line}\n{flat}"))
    assert any(hit.startswith("the flatness") and "is not smaller than its perpendicularity" in hit for hit in hits)
    fit = hits_of(tmp_path, "undef", ('"hole": "6.6 mm"', '"hole": {"value": "6.6 mm", "tolerance": "H7"}'))
    assert "Ra 3.2 of 'hole' is too rough for its tolerance of 0.015 mm: Ra 1.9 at most" in fit
    head = '"head", (0, 0, 3), Z, Y, view="{}"'
    (sheet,) = draw_part(tmp_path, "fx_shaft", (head.format("front"), head.format("right")))["sheets"]
    assert "bottom" in sheet["views"] and sheet["hits"] == []
    hits = hits_of(tmp_path, "fx_shaft")
    assert hits == ["'head': its outline is not seen in the view 'front'; declare another view"]
    # Where a view that others declare shows it, it is there, and this is said.
    beside = hits_of(tmp_path, "fx_shaft", ('NAME = "fx_shaft"', 'NAME = "fx_shaft"\nVIEWS = ("front", "right")'))
    assert beside == ["'head' is declared for the view 'front', which does not show it: it is in 'right'"]
    wrong = hits_of(tmp_path, "fx_shaft", ('view="bottom"', 'view="top"'))
    assert "'thread drill' is not seen in the view 'top'" in wrong or any("is not seen in" in hit for hit in wrong)


def test_sheets_toml_adds_a_section_and_a_view_to_a_part(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    section = 'section = [{letter = "B", projection = "right", at = ["12 mm", "0 mm", "0 mm"]}]\n'
    views = f'[manifold]\nview = [{{projection = "bottom"}}]\n{section}'
    (tmp_path / "source" / "sheets.toml").write_text(views, "utf-8")
    (sheet,) = draw_part(tmp_path, "manifold")["sheets"]
    # Two views more that its declarations name.
    assert {"bottom", "section B-B", "left", "back"} <= set(sheet["views"])


def test_an_angle_between_axes_may_be_given_for_several_and_that_around_an_axis_is_counted() -> None:
    disc = cq.Workplane().circle(30).extrude(8).faces(">Z").workplane().hole(10)
    disc = disc.faces(">Z").workplane().pushPoints([(20 * math.cos(0.6), 20 * math.sin(0.6))]).hole(4)
    for turn in range(3):
        disc = disc.cut(cq.Workplane().transformed(rotate=(0, 0, 120 * turn)).center(28, 0).rect(8, 5).extrude(8))
    verifier, centre = DimensionVerifier(disc.val()), (0.0, 0.0, 4.0)
    hole = (20 * math.cos(0.6), 20 * math.sin(0.6), 4.0)
    slot = (24 * math.cos(math.tau / 3), 24 * math.sin(math.tau / 3), 4.0)

    def measured(point: Point, count: int) -> float | None:
        angle = Dimension("angle", "angle", 1.0, "part.angle", (centre, point), (1.0, 0.0, 0.0), count=count)
        return verifier.measure(angle)

    assert measured(hole, 2) == pytest.approx(math.degrees(0.6)) and measured(slot, 3) == pytest.approx(120.0)
    with pytest.raises(LookupError, match="no 4 equal features"):
        measured(slot, 4)


@pytest.mark.parametrize("order", [1, -1])
def test_a_point_on_an_edge_is_on_the_face_of_the_stated_normal(order: int) -> None:
    """The top shares the point, and reaches farther, over the rounded corners; the order of the faces is by chance."""
    body: Any = cq.Workplane().box(96, 54, 10, centered=False).edges("|Z").fillet(6).val()
    view: Any = SimpleNamespace(projection=PROJECTIONS["top"], scale=1.0, cut=None)
    gauge: Any = SimpleNamespace(surfaces=[*DimensionVerifier(body).surfaces][::order])
    line = edge_of_face(view, DatumFeature("C", ((0.0, 18.6, 10.0),), (-1.0, 0.0, 0.0), "top"), gauge)
    assert sorted(end[1] for end in line[:2]) == pytest.approx([6.0, 48.0])
