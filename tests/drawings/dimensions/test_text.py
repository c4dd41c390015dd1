"""Texts of dimensions, and declarations that contradict each other or the solid."""

from dataclasses import replace
from pathlib import Path

import cadquery as cq
import pytest

from drawings.dimensions.consistency import contradictions, mistakes, unsuited
from drawings.dimensions.text import callout, dimension_text, lines_of_features, number
from stagecad.friction_stage.construction import part_definition
from stagecad.parameters.dimension import DatumFeature, Dimension, GeometricTolerance, SurfaceTexture
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.solids.modelling.part import notes_of, treatment_of
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.drawn import thesis
from tests.drawings.own_parts import draw_part, hits_of

ENDS = ((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("value", "tolerance", "text"),
    [
        (12.0, "X", "12"),
        (12.0, "X.X", "12.0"),
        (25.4, "X.XX", "25.40"),
        (0.1 + 0.2, "X.X", "0.3"),
        (7.9375, None, "7.938"),
        (5.0, None, "5"),
        # What the class would round off is printed, and its tolerance beside it.
        (230.7, "X", "230.7 ±0.1"),
        (4.646, "X.X", "4.646 ±0.1"),
        (14.2875, "X.X", "14.287 ±0.1"),
    ],
)
def test_decimals_are_the_class_or_the_tolerance_is_spelled_out(value: float, tolerance: str | None, text: str) -> None:
    assert number(value, tolerance, 0.1) == text


def declared(kind: str, name: str, value: float, **more: object) -> Dimension:
    points = ENDS if kind in ("depth", "linear", "pitch") else ENDS[:1]
    tolerance = more.pop("tolerance", "X.X")
    return Dimension(name, kind, value, "stage.length", points, (0.0, 0.0, -1.0), tolerance, **more)  # type: ignore[arg-type]


def test_texts_of_single_and_theoretically_exact_dimensions() -> None:
    assert dimension_text(declared("diameter", "bore", 16.02, tolerance="X.XX", count=3), 0.01) == "3x ⌀16.02"
    assert dimension_text(declared("radius", "nose", 20.0, note="spherical; coated"), 0.1) == "SR20.0"
    assert dimension_text(declared("radius", "corner", 5.0, tolerance="X", count=4), 0.1) == "4x R5"
    assert dimension_text(declared("chamfer", "edge", 0.5), 0.1) == "0.5x45°"
    assert dimension_text(declared("slope", "wedge", 0.05, tolerance=None), 0.0) == "slope 1:20"
    assert dimension_text(declared("slope", "wedge", 0.053, tolerance=None), 0.0) == "slope 0.053"
    assert dimension_text(declared("angle", "neck", 85.0, tolerance="X", count=2), 0.1) == "2x 85°"
    assert dimension_text(declared("linear", "spacing", 46.0, tolerance="X.XX", exact=True), 0.01) == "{box:46}"
    pitch = declared("pitch", "pitch", 50.0, tolerance="X.X", count=3, exact=True)
    assert dimension_text(pitch, 0.1) == "3x {box:50} (=150)"
    assert dimension_text(declared("slope", "wedge", 0.05, tolerance=None, exact=True), 0.0) == "slope {box:1:20}"


def test_texts_of_threads_in_stepped_and_blind_holes() -> None:
    note = "3/8-16 UNC"
    hole = [
        declared("tap_drill", "way hole tap drill", 7.9375, tolerance=None, note=note, count=14, feature="way hole"),
        declared("thread_depth", "way hole thread depth", 15.0, note=note, count=14, feature="way hole"),
        declared("depth", "way hole drill depth", 18.0, note=note, count=14, feature="way hole"),
        declared("count", "way holes in a row", 7, tolerance=None, note="2 rows", feature="way hole"),
    ]
    deep = ("14x 3/8-16 UNC {depth}15.0", "drill ⌀7.938 {depth}18.0", "7 in a row, 2 rows")
    assert callout(hole, [0.0, 0.1, 0.1, 0.0]) == deep
    assert callout(hole[:1], [0.0]) == ("14x 3/8-16 UNC through", "drill ⌀7.938")
    for end in ("to bore", "through one wall"):
        remark = declared("callout", "way hole remark", 0.0, tolerance=None, note=end, feature="way hole")
        assert callout([hole[0], remark], [0.0, 0.0]) == ("14x 3/8-16 UNC", "drill ⌀7.938", end)
    hole = [
        declared("diameter", "clamp counterbore", 15.9, tolerance=None, feature="hole"),
        declared("diameter", "clearance hole", 10.5, tolerance=None, feature="hole", note="to the slot"),
        declared("tap_drill", "thread", 7.938, tolerance=None, feature="hole", note="3/8-16 UNC"),
    ]
    stepped = ("{counterbore}⌀15.9", "⌀10.5 to the slot", "3/8-16 UNC through", "drill ⌀7.938")
    assert callout(hole, [0.0] * 3) == stepped
    own = [one for one in part_definition("base").dimensions(thesis()) if one.feature == "clamp screw hole"]
    own = [one for one in own if one.view != "section"]
    lines = callout(own, [0.1] * len(own))
    assert "3/8-16 UNC" in lines and not any("through" in line for line in lines)


def test_texts_of_counterbores_and_counts() -> None:
    hole = [
        declared("diameter", "clamp counterbore", 15.9, count=4, feature="clamp screw hole"),
        declared("depth", "clamp counterbore depth", 12.0, count=4, feature="clamp screw hole"),
        declared("diameter", "clamp clearance hole", 10.5, count=4, feature="clamp screw hole", note="to the gap slot"),
    ]
    assert callout(hole, [0.1] * 3) == ("4x {counterbore}⌀15.9 {depth}12.0", "⌀10.5 to the gap slot")
    hole = [
        declared("diameter", "hole 1", 5.5, count=4, feature="hole 1", note="through"),
        declared("diameter", "hole 1 counterbore", 10.0, count=4, feature="hole 1"),
        declared("depth", "hole 1 counterbore depth", 5.5, count=4, feature="hole 1"),
    ]
    assert callout(hole, [0.1] * 3) == ("4x ⌀5.5 through", "{counterbore}⌀10.0 {depth}5.5")
    row = [
        declared("diameter", "screw hole", 10.5, count=7, note="through", feature="screw hole"),
        declared("count", "screw holes", 7, tolerance=None, feature="screw hole"),
    ]
    assert callout(row, [0.1, 0.0]) == ("7x ⌀10.5 through",)
    alone = [declared("count", "teeth in a group", 2, tolerance=None, count=2, feature="teeth")]
    assert callout(alone, [0.0]) == ("2x 2 teeth in a group",)


X, Y, Z, DOWN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
BLOCK = cq.Workplane().box(60, 40, 20, centered=(True, True, False))
DRILLED = BLOCK.cut(cq.Workplane().pushPoints([(-20, -10), (20, -10)]).circle(2.5).extrude(20))
SOLID = DRILLED.cut(cq.Workplane().workplane(offset=8).pushPoints([(-20, 10), (20, 10)]).circle(3.3).extrude(12))
LENGTH = Dimension("length", "linear", 60.0, "part.length", ((-30, -20, 0), (30, -20, 0)), X)
BLIND = Dimension("blind", "diameter", 6.6, "part.blind", ((20, 10, 15), (23.3, 10, 15)), Z, count=2, feature="blind")
OPEN = Dimension("open", "diameter", 5.0, "part.open", ((20, -10, 10), (22.5, -10, 10)), Z, count=2, note="through")
DRILL = Dimension(
    "m8 drill depth", "depth", 12.0, "part.deep", ((20, 10, 20), (20, 10, 8)), DOWN, feature="m8", major=8.0
)
THREAD = Dimension(
    "m8 thread depth", "thread_depth", 10.0, "part.full", ((20, 10, 20),), DOWN, note="M8x1.25", feature="m8"
)
ROW = Dimension("row", "pitch", 20.0, "part.row", ((-20, -10, 20), (20, -10, 20)), X, count=2)
FLAT = GeometricTolerance("flat", "flatness", 0.01, "part.flat", ((0, 0, 20),), Z, "front")
SQUARE = GeometricTolerance("square", "perpendicularity", 0.02, "part.square", ((30, 0, 10),), X, "front", ("A",))
BASE = DatumFeature("A", ((0, 0, 0),), DOWN, "front")


@pytest.fixture(scope="module")
def verifier() -> DimensionVerifier:
    solid = SOLID.solids().val()
    assert isinstance(solid, cq.Solid)
    return DimensionVerifier(solid)


@pytest.mark.parametrize(
    "dimensions, requirements, text",
    [
        ([LENGTH, BLIND, OPEN], [BASE, FLAT, SQUARE], ""),
        ([LENGTH, LENGTH], [], "two dimensions have the name 'length'"),
        ([replace(LENGTH, value=61.0)], [], "dimension 'length': declared 61, the solid measures 60"),
        ([replace(OPEN, points=((20, -11, 10),))], [], "no round face about"),
        ([replace(OPEN, points=((20, -10, 10), (23, -10, 10)))], [], "no round face of diameter 6 about"),
        ([ROW], [], "dimension 'row': no hole of the row at (0.0, -10.0, 20.0)"),
        ([], [SQUARE], "requirement 'square': no datum A is declared"),
        ([], [BASE, replace(BASE, points=((30, 0, 10),))], "two datums have the letter 'A'"),
        ([], [replace(FLAT, points=((0, 0, 21),))], "requirement 'flat': no face of the solid at (0, 0, 21)"),
    ],
)
def test_what_cannot_be_drawn_is_named(dimensions, requirements, text: str, verifier: DimensionVerifier) -> None:
    found = list(mistakes(dimensions, requirements, verifier))
    assert (len(found) == 1 and text in found[0]) if text else not found


@pytest.mark.parametrize(
    "dimensions, text",
    [
        ([BLIND, OPEN, DRILL, replace(THREAD, value=9.0)], ""),
        ([DRILL, replace(THREAD, value=12.0)], "'m8 thread depth' of 12 mm needs a drill 13.9 mm deep, not 12 mm"),
        ([BLIND, replace(OPEN, feature="blind")], "'blind' and 'open' are in one callout, and not about one axis"),
        ([replace(BLIND, note="through")], "'blind' goes through by its note, the hole of the solid does not"),
        ([replace(OPEN, tolerance="g6", deviations=(-0.03, 0.0))], "'open': g6 is a class of shafts (ISO 286)"),
    ],
)
def test_contradictions_are_named(dimensions: list[Dimension], text: str, verifier: DimensionVerifier) -> None:
    found = [*mistakes(dimensions, (), verifier), *contradictions(verifier, dimensions, (), 0.8)]
    assert found == ([text] if text else [])


def test_the_roughness_of_a_bore_is_in_its_callout_and_counts_for_its_fit(verifier: DimensionVerifier) -> None:
    fit = replace(OPEN, tolerance="H7", deviations=(0.0, 0.012), feature="open")
    smooth = SurfaceTexture("open", 0.8, "part.ra", ((22.5, -10, 10),), X, "top", feature="open")
    assert len([*contradictions(verifier, [fit], (), 3.2)]) == 1
    assert not [*contradictions(verifier, [fit], [smooth], 3.2)]
    assert lines_of_features([smooth, BASE]) == {"open": ["{surface}Ra 0.8"]}


def test_threads_and_coatings_follow_the_material() -> None:
    design = load_design()
    texts = ("hard anodise: see notes", "Edges polished.")
    brittle, light, steel = (design.materials[name] for name in ("alumina", "al_6061_t6", "steel"))
    drill = replace(DRILL, name="m8 tap drill", kind="tap_drill")
    assert ["is brittle" in line for line in unsuited(brittle, (drill,), ())] == [True]
    assert not [*unsuited(light, (drill,), texts)]
    assert ["Steel is not anodised" in line for line in unsuited(steel, (drill,), texts)] == [True]
    stainless = load_design(None, ("stage.material=sus416",))
    said = [" ".join(notes_of(part_definition("stage"), one)) for one in (design, stainless)]
    assert ["anodised" in text for text in said] == [True, False]
    assert treatment_of(part_definition("stage"), stainless, "sus416") == "PTFE: see notes"


def test_a_wrong_value_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"undef\.py: dimension 'width': declared 60, the solid measures 40"):
        draw_part(tmp_path, "undef", ('d.linear("width", "width"', 'd.linear("width", "length"'))


def test_a_distance_whose_view_shows_no_line_at_its_ends_is_reported(tmp_path: Path) -> None:
    """A slot in the lower face is declared for the view from above."""
    below = ('.faces(">Z").workplane().center(0, 10)', ".cut(cq.Workplane().center(0, 10).slot2D(20, 5).extrude(3))")
    value = ('"width": "40.0 mm"', '"width": "40.0 mm", "slot": "5.0 mm"')
    line = '    d.linear("slot", "slot", (0, 7.5, 0), (0, 12.5, 0), Y, view="top")\n    return tuple(d)'
    changes = ((".slot2D(20, 5).cutBlind(-3)", ""), below, value, ("    return tuple(d)", line))
    assert "'slot' ends where the view 'top' shows no line" in hits_of(tmp_path, "undef", *changes)
