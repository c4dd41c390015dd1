"""Each sheet says everything that is declared, once and truly, and everything that a view contains is ink on it."""

import math
import re
from collections import Counter
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from drawings.annotations.annotation import (
    AngularDimension,
    Callout,
    DatumSymbol,
    FeatureControlFrame,
    HoleTag,
    LinearDimension,
    RadialDimension,
    ReferenceArrow,
)
from drawings.annotations.primitives import Text
from drawings.dimensions.text import number, tolerance_text
from drawings.export.drawing_model import drawing_model
from drawings.export.pdf import DPI
from drawings.lint import lint
from drawings.views.segment_index import curve_points
from drawings.views.view import Arc, View
from stagecad.friction_stage.construction import MADE, part_definition
from stagecad.parameters.dimension import DatumFeature, GeometricTolerance, SurfaceTexture
from stagecad.parameters.tracking import TrackedDesign
from stagecad.solids.modelling.part import notes_of, treatment_of
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.drawn import described, document_of, framed, sheets, thesis, words
from tests.drawings.rendered import assert_same_picture, picture_of

NOT_DIMENSIONS = {
    "teeth.fitted": "whether pockets and tapped holes for the teeth are there: seen from their being there",
    "sea.whole_underside": "whether grooves bound the drive surface: seen from their being there",
}
"""Parameters that shape a part and are no number on any sheet, with the reason."""


def stated(part: str) -> list[tuple[str, Any]]:
    """Declarations, and the annotations of the part's sheets that state them."""
    every = [annotation for sheet in sheets(part) for annotation in sheet.annotations]
    kinds = LinearDimension | RadialDimension | AngularDimension | Callout
    return [(name, annotation) for annotation in every if isinstance(annotation, kinds) for name in annotation.names]


@cache
def named(part: str) -> Counter[str]:
    """How often each declaration is on the part's sheets."""
    return Counter([*(name for name, _ in stated(part)), *(name for sheet in sheets(part) for name in sheet.tabulated)])


@pytest.mark.parametrize("part", MADE)
def test_every_declaration_datum_and_parameter_is_on_the_sheets_once(part: str) -> None:
    module = part_definition(part)
    required = described(part, thesis()).requirements
    textures = [r for r in required if isinstance(r, SurfaceTexture)]
    marks = [f"texture {r.name}" for r in textures if not r.feature]
    assert named(part) == Counter([*(d.name for d in module.dimensions(thesis())), *marks])
    callouts = [line for sheet in sheets(part) for a in sheet.annotations if isinstance(a, Callout) for line in a.lines]
    texts = [*callouts, *(item.text for sheet in sheets(part) for item in sheet.tables if isinstance(item, Text))]
    assert all(any(f"Ra {r.roughness:g}" in text for text in texts) for r in textures if r.feature)
    every = [annotation for sheet in sheets(part) for annotation in sheet.annotations]
    letters = [annotation.letter for annotation in every if isinstance(annotation, DatumSymbol)]
    assert sorted(letters) == sorted(r.letter for r in required if isinstance(r, DatumFeature))
    frames = [(a.characteristic, a.tolerance, a.datums) for a in every if isinstance(a, FeatureControlFrame)]
    frames += [framed(line) for a in every if isinstance(a, Callout) for line in a.lines if line.startswith("{frame:")]
    tolerances = [r for r in required if isinstance(r, GeometricTolerance)]
    tabulated = [r for r in tolerances if r.feature and r.feature not in features_of_callouts(part)]
    frames += [(r.characteristic, tolerance_text(r), r.datums) for r in tabulated if table_has(part, r)]
    assert sorted(frames) == sorted((r.characteristic, tolerance_text(r), r.datums) for r in tolerances)
    notes: dict[Any, str] = {}
    module.build(TrackedDesign(thesis(), notes))
    shape = {".".join(str(step[1]) for step in way) for way in notes} - set(NOT_DIMENSIONS)
    shown: Counter[str] = Counter()
    for dimension in module.dimensions(thesis()):
        if dimension.parameter:
            shown[dimension.parameter] += named(part)[dimension.name]
    assert shape <= set(shown)
    # The callout of each tapped hole is complete: tap drills are repeated.
    assert {times for key, times in shown.items() if not key.startswith("threads.")} == {1}


@pytest.mark.parametrize("part", MADE)
def test_every_number_is_printed_with_the_decimals_of_its_class(part: str) -> None:
    said = {name: words(annotation) for name, annotation in stated(part)}
    for sheet in sheets(part):
        table = " ".join(item.text for item in sheet.tables if isinstance(item, Text))
        said.update((name, table) for name in sheet.tabulated)
    for dimension in part_definition(part).dimensions(thesis()):
        if dimension.kind == "callout" or (dimension.table and dimension.kind in ("linear", "count")):
            continue
        value = number(dimension.value, None if dimension.exact else dimension.tolerance, 0.0)
        if dimension.kind == "slope":
            value = f"1:{1 / dimension.value:g}"
        text = said[dimension.name]
        assert value in text, (dimension.name, value, text)
        if dimension.kind != "count" and not dimension.table:
            assert dimension.count == 1 or text.startswith(f"{dimension.count}x ")


@pytest.mark.parametrize("part", MADE)
def test_what_a_dimension_spans_on_the_sheet_is_what_the_solid_measures(part: str) -> None:
    """From the points on the paper back to the part, against a gauge on the solid; and on to the DXF entity."""
    gauge = DimensionVerifier(described(part, thesis()).solid)
    declared = {dimension.name: dimension for dimension in part_definition(part).dimensions(thesis())}
    for sheet in sheets(part):
        measured: list[float] = []
        for annotation in sheet.annotations:
            if isinstance(annotation, LinearDimension):
                turn = math.radians(annotation.angle)
                (u0, v0), (u1, v1) = annotation.first, annotation.second
                span = abs((u1 - u0) * math.cos(turn) + (v1 - v0) * math.sin(turn))
            elif isinstance(annotation, RadialDimension):
                span = annotation.radius * (2 if annotation.kind == "diameter" else 1)
            else:
                continue
            dimension = declared[annotation.names[0]]
            steps = dimension.count if dimension.kind == "pitch" else 1
            assert span == pytest.approx(steps * (gauge.measure(dimension) or 0.0), abs=1e-6)
            measured.append(span)
        entities = document_of(sheet).modelspace().query("DIMENSION")
        lengths = [d.get_measurement() for d in entities if d.dxf.dimtype & 7 in (0, 3, 4)]  # type: ignore[attr-defined]
        assert sorted(lengths) == pytest.approx(sorted(measured), abs=1e-6)


def features_of_callouts(part: str) -> set[str]:
    """Features whose callout is in a view, not in a hole table."""
    return {d.feature for d in part_definition(part).dimensions(thesis()) if d.feature and not d.table}


def table_has(part: str, tolerance: GeometricTolerance) -> bool:
    """Whether a hole table has a control frame with the text of a tolerance."""
    texts = {item.text for sheet in sheets(part) for item in sheet.tables if isinstance(item, Text)}
    return {tolerance_text(tolerance), *tolerance.datums} <= texts


def test_the_hole_table_gives_the_places_of_the_holes_on_the_solid() -> None:
    """X and Y of every hole, and its name beside it, against the cylinders of the solid."""
    solid, (sheet, *_) = described("base", thesis()).solid, sheets("base")
    axes = {
        (round(s.origin[0], 3) + 0.0, round(s.origin[1], 3) + 0.0)
        for s in DimensionVerifier(solid).surfaces
        if s.kind == "CYLINDER" and abs(s.axis[2]) > 0.999
    }
    rows = table_rows([item for item in sheet.tables if isinstance(item, Text)])
    tags = {a.text: a.at for a in sheet.annotations if isinstance(a, HoleTag)}
    assert len(rows) == 34 and rows.keys() == tags.keys()
    for name, place in rows.items():
        assert place in axes and tags[name] == pytest.approx(place, abs=1e-6)


def table_rows(texts: list[Text]) -> dict[str, tuple[float, float]]:
    """Names and coordinates in a hole table: the texts of a row are next to each other."""
    found = {}
    for name, x, y in zip(texts, texts[1:], texts[2:], strict=False):
        if re.fullmatch(r"[A-Z]\d+", name.text):
            found[name.text] = (float(x.text), float(y.text))
    return found


@pytest.mark.parametrize("part", MADE)
def test_the_sheets_of_the_thesis_are_free_of_hits(part: str) -> None:
    for sheet in sheets(part):
        assert [str(hit) for hit in lint(sheet)] == [], sheet.name


def test_an_axis_datum_is_in_line_with_the_dimension_of_its_diameter() -> None:
    (sheet,) = sheets("holder")
    (mark,) = (a for a in sheet.annotations if isinstance(a, DatumSymbol))
    diameter = next(a for a in sheet.annotations if isinstance(a, LinearDimension) and a.names == ("diameter",))
    assert mark.frame_at[1] == pytest.approx(diameter.line_at[1])
    assert sheet.view(mark.view).to_paper(mark.at)[1] == pytest.approx(diameter.line_at[1])


def test_every_place_to_which_a_position_tolerance_applies_is_theoretically_exact() -> None:
    """Of the holes with a position tolerance outside the hole table: the distances between their axes."""
    for part in ("stage", "holder", "base"):
        known = described(part, thesis())
        exact = {d.name for d in known.dimensions if d.exact}
        tolerated = [r for r in known.requirements if getattr(r, "characteristic", "") == "position"]
        for requirement in tolerated:
            tabulated = [d for d in known.dimensions if d.feature == requirement.feature and d.table]
            places = [point[:2] for point in requirement.points]
            lengths = [d for d in known.dimensions if d.kind in ("linear", "pitch")]
            lengths = [d for d in lengths if math.dist(d.points[0][:2], d.points[1][:2]) > 1e-6]
            between = {
                d.name for d in lengths if all(min(math.dist(p[:2], q) for q in places) < 1e-6 for p in d.points)
            }
            assert tabulated or (between and between <= exact), requirement.name


@pytest.mark.parametrize("part", ["holder", "stage"])
def test_a_view_out_of_its_place_has_a_letter_and_an_arrow(part: str) -> None:
    (sheet,) = sheets(part)
    arrows = {a.letter for a in sheet.annotations if isinstance(a, ReferenceArrow)}
    for view in sheet.views:
        if view.projection.name in ("back", "bottom") and not view.clip:
            assert view.label in arrows


def test_the_treatment_says_what_is_coated() -> None:
    parts = {name: part_definition(name) for name in MADE}
    said = {name: treatment_of(part, thesis(), part.material(thesis())) for name, part in parts.items()}
    assert said["height_pin_1"] == "hard anodise: see notes"
    assert said["base"].startswith("stress relieve") and said["bearing_way"] == "none"
    for name, part in parts.items():
        assert ("coated" in " ".join(notes_of(part, thesis()))) <= ("see notes" in said[name])


def test_the_chamfer_of_a_thread_is_omitted_from_its_end_view_but_not_that_of_the_pin() -> None:
    """ISO 6410-1; the tapped hole of height pin 1 has the axis of the pin, whose end has a chamfer too."""
    pin = thesis().height_pin_1
    (sheet,) = sheets("height_pin_1")
    view = sheet.view("top")
    radii = {round(curve.radius, 3) for curve in view.curves["VISIBLE"] if isinstance(curve, Arc)}
    assert {pin.diameter / 2, pin.diameter / 2 - pin.end_chamfer} <= radii
    (thread,) = view.curves["THREAD"]
    assert isinstance(thread, Arc) and not {r for r in radii if thread.radius < r < pin.diameter / 4}


STEP = 1.0
"""Distance of the points looked at along a curve, mm on the paper."""
NEAR = 0.05
"""Greatest distance of the end of a hatch line from the outline, mm on the paper."""


def points_on_paper(view: View, layer: str) -> list[np.ndarray]:
    """Each curve of a layer as points on the paper (n, 2), mm."""
    return [
        np.array([view.to_paper(point) for point in curve_points(curve, view.scale)])
        for curve in view.curves.get(layer, ())  # type: ignore[call-overload]
    ]


def along(points: np.ndarray) -> np.ndarray:
    """Points along a polyline at most `STEP` apart, its ends among them (n, 2)."""
    pieces = [np.linspace(start, end, 2 + int(math.dist(start, end) / STEP)) for start, end in pairwise(points)]
    return np.concatenate(pieces)


@pytest.mark.parametrize("part", MADE)
def test_visible_edges_are_covered_by_ink_and_hatches_end_on_the_outline(part: str) -> None:
    """The centres of the crowns of the pads are 2 m from the stage."""
    for sheet in sheets(part):
        drawing = drawing_model(sheet)
        picture, scale, height = picture_of(drawing), DPI[sheet.paper] / 25.4, drawing.size[1]
        for view in sheet.views:
            edges = points_on_paper(view, "VISIBLE")
            assert edges, view.name
            every = np.concatenate([along(edge) for edge in edges])
            column = np.rint(every[:, 0] * scale).astype(int)
            row = np.rint((height - every[:, 1]) * scale).astype(int)
            around = [picture[row + i, column + j] for i in range(-2, 3) for j in range(-2, 3)]
            assert (np.min(around, axis=0) < 128).all(), (sheet.name, view.name)
    # A hatch line that ended in the air would show an outline that is open there.
    for sheet in sheets(part):
        for view in sheet.views:
            if view.cut is None or view.clip is not None:
                continue
            hatch = points_on_paper(view, "HATCH")
            assert len(hatch) > 5
            outline = points_on_paper(view, "VISIBLE")
            lines = np.concatenate([np.hstack((edge[:-1], edge[1:])) for edge in outline])
            ends = np.concatenate([line[[0, -1]] for line in hatch])
            assert distance_to(lines, ends).max() < NEAR, (sheet.name, view.name)


def distance_to(lines: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Least distance of each point (n, 2) from straight lines (m, 4)."""
    start, step = lines[:, :2], lines[:, 2:] - lines[:, :2]
    square = np.maximum((step**2).sum(axis=1), 1e-12)
    found = []
    for block in np.array_split(points, max(1, len(points) // 200)):
        to = block[:, None, :] - start
        t = np.clip((to * step).sum(axis=2) / square, 0.0, 1.0)
        found.append(np.linalg.norm(to - t[..., None] * step, axis=2).min(axis=1))
    return np.concatenate(found)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["stage", "holder", "base"])
def test_the_picture_of_a_sheet_is_that_of_its_dxf_by_ezdxf(part: str) -> None:
    """The crowns of the stage's pads have their centres 2 m off the sheet."""
    for sheet in sheets(part):
        assert_same_picture(drawing_model(sheet))
