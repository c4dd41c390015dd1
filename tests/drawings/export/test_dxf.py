"""DXF: entities, layers and styles; its geometry equals the model."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import zip_longest

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing
from ezdxf.filemanagement import readfile
from scipy.spatial import KDTree

from drawings.annotations.annotation import LinearDimension, label_primitives, text_box
from drawings.annotations.primitives import (
    LAYERS,
    TEXT_STYLE,
    THICK,
    WIDTH_FACTOR,
    Alignment,
    ArcStroke,
    FilledPolygon,
    Primitive,
    Stroke,
    Text,
    printed,
)
from drawings.export.dxf import VIEWPORT_LAYER, ModelMapping, add_primitive, dxf_bytes, flattened, measured_text
from drawings.placement.lint_rules import primitive_lines, view_lines
from drawings.sheets.frame import frame, title_primitives
from drawings.sheets.sheet import Sheet
from drawings.views.segment_index import Line, polyline_lines
from drawings.views.view import Arc
from stagecad.friction_stage.construction import MADE
from tests.drawings.drawn import document_of, sheets
from tests.drawings.export.dxf_reading import PaperContent, entity_points, visible_entities
from tests.drawings.plate_sheet import sheet
from tests.drawings.test_lint import CLEAN

HALF = ModelMapping(0.5, 1.0)
"""Paper to model space for a view at 1:2."""
SAME = 1e-3
"""Greatest distance of a place in the file from that on the sheet, mm."""


@pytest.fixture(scope="module")
def document() -> Drawing:
    return document_of(sheet())


def test_every_dimension_measures_its_number_with_its_decimals(document) -> None:
    found = {}
    for entity in document.modelspace().query("DIMENSION"):
        number = re.sub(r"[^\d.]", "", entity.dxf.text.replace("2x", "").replace("%%c", "").replace("%%d", ""))
        assert number == ""  # the number itself is measured by whoever opens the file
        found.setdefault(entity.dimtype, []).append(entity.get_measurement())
    assert sorted(found[0]) == pytest.approx([16.0, 40.0, 80.0], abs=1e-9)
    assert found[3] == pytest.approx([16.0]) and found[4] == pytest.approx([8.0])
    assert found[5] == pytest.approx([45.0])
    for entity in document.modelspace().query("DIMENSION"):
        style = document.dimstyles.get(entity.dxf.dimstyle)
        assert style.dxf.dimzin == 0 and style.dxf.dimdsep == ord(".")
    plain = document.modelspace().query("DIMENSION[text=='<>']")
    (width,) = [one for one in plain if round(one.get_measurement(), 6) == 80.0]
    assert document.dimstyles.get(width.dxf.dimstyle).dxf.dimdec == 2


def test_a_text_without_the_measured_number_is_refused() -> None:
    wrong = LinearDimension("top", (0, 0), (40, 0), 0.0, (0, 0), "2x 41.0", 40.0, ("width",))
    with pytest.raises(ValueError, match=r"width has the text '2x 41\.0', but measures 40"):
        measured_text(wrong)
    assert measured_text(replace(wrong, text="4x 40.00 [1]")) == ("4x <> [1]", 2)
    assert measured_text(replace(wrong, text="40x 40")) in (("<>x 40", 0), ("40x <>", 0))


def test_scales_and_layers_of_the_model_space(document) -> None:
    outline = list(document.modelspace().query("LINE[layer=='VISIBLE']"))
    lengths = sorted(round((line.dxf.end - line.dxf.start).magnitude, 9) for line in outline)
    assert lengths == [40.0] * 4 + [80.0] * 4
    views = [view for view in document.paperspace().query("VIEWPORT") if view.dxf.id != 1]
    assert sorted(round(view.get_scale(), 9) for view in views) == [0.5, 2.0]
    assert all(view.dxf.layer == VIEWPORT_LAYER for view in views)
    assert document.layers.get(VIEWPORT_LAYER).dxf.plot == 0
    widths = [(view.dxf.view_center_point[0], view.dxf.width / view.get_scale()) for view in views]
    boxes = [(middle - width / 2, middle + width / 2) for middle, width in widths]
    (_, first_end), (second_start, _) = sorted(boxes)
    assert first_end < second_start
    for name, (weight, line_type) in LAYERS.items():
        layer = document.layers.get(name)
        assert (layer.dxf.lineweight, layer.dxf.linetype.upper()) == (round(100 * weight), line_type)
    assert document.layers.get("VISIBLE").dxf.lineweight == 2 * document.layers.get("HIDDEN").dxf.lineweight


def test_the_file_is_sound_and_the_same_whatever_the_order_of_a_set(document, tmp_path) -> None:
    data = dxf_bytes(document)
    assert data == dxf_bytes(document_of(sheet()))
    path = tmp_path / "plate.dxf"
    path.write_bytes(data)
    again = readfile(path)
    assert not again.audit().errors and len(again.modelspace().query("DIMENSION")) == 6
    names = re.findall(rb"  0\r?\nCLASS\r?\n  1\r?\n(\S+)", dxf_bytes(document))
    assert len(names) > 5 and names == sorted(names)


@pytest.fixture
def layout():
    doc = ezdxf.new("R2010")  # type: ignore[attr-defined]
    doc.styles.add(TEXT_STYLE, font="DejaVuSans.ttf")
    return doc.modelspace()


def test_styles_and_polygons_of_entities(layout) -> None:
    add_primitive(layout, Stroke(((0.0, 1.0), (2.0, 3.0)), "VISIBLE"), HALF)
    add_primitive(layout, Stroke(((0.0, 1.0), (2.0, 3.0), (4.0, 6.0)), "HIDDEN"), HALF)
    add_primitive(layout, ArcStroke(Arc((5.0, 6.0), 7.0), "VISIBLE"), HALF)
    add_primitive(layout, ArcStroke(Arc((5.0, 6.0), 7.0, 10.0, 20.0), "CENTRE"), HALF)
    line, polyline, circle, arc = layout
    assert (line.dxftype(), line.dxf.layer) == ("LINE", "VISIBLE")
    assert (line.dxf.start, line.dxf.end) == ((2.0, 2.0, 0.0), (6.0, 6.0, 0.0))
    assert not line.dxf.hasattr("ltscale")
    assert (polyline.dxftype(), polyline.dxf.layer, polyline.dxf.ltscale) == ("LWPOLYLINE", "HIDDEN", 2.0)
    assert [(x, y) for x, y, *_ in polyline] == [(2.0, 2.0), (6.0, 6.0), (10.0, 12.0)]
    assert (circle.dxftype(), circle.dxf.center, circle.dxf.radius) == ("CIRCLE", (12.0, 12.0, 0.0), 14.0)
    assert (arc.dxftype(), arc.dxf.radius, arc.dxf.start_angle, arc.dxf.end_angle) == ("ARC", 14.0, 10.0, 20.0)
    layout.delete_all_entities()
    add_primitive(layout, Stroke(((0.0, 0.0), (6.0, 0.0)), "SECTION", THICK), HALF)
    (line,) = layout
    assert (line.dxf.layer, line.dxf.linetype, line.dxf.lineweight) == ("SECTION", "CONTINUOUS", 70)
    layout.delete_all_entities()
    corners = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))
    add_primitive(layout, FilledPolygon(corners[:3]), ModelMapping())
    add_primitive(layout, FilledPolygon(corners), ModelMapping())
    add_primitive(layout, FilledPolygon((*corners, (-1.0, 0.5))), ModelMapping())
    arrow, box, hatch = layout
    assert [(p.x, p.y) for p in arrow.wcs_vertices()] == list(corners[:3])
    assert [(p.x, p.y) for p in box.wcs_vertices()] == list(corners)
    assert hatch.dxftype() == "HATCH" and len(hatch.paths[0].vertices) == 5


@pytest.mark.parametrize(("alignment", "name"), [("left", "LEFT"), ("middle", "CENTER"), ("right", "RIGHT")])
def test_a_text_keeps_place_height_angle_and_alignment(layout, alignment: Alignment, name: str) -> None:
    add_primitive(layout, Text("⌀8 ±0.1°", (1.0, 2.0), 3.5, alignment, 30.0), HALF)
    (text,) = layout
    align, first, second = text.get_placement()
    assert (align.name, second or first) == (name, (4.0, 4.0, 0.0))
    assert (text.dxf.text, text.dxf.height, text.dxf.rotation) == ("%%c8 %%p0.1%%d", 7.0, 30.0)
    assert (text.dxf.layer, text.dxf.style, text.dxf.width) == ("TEXT", TEXT_STYLE, WIDTH_FACTOR)


def test_the_number_of_a_theoretically_exact_dimension_is_measured_and_framed(tmp_path) -> None:
    document = document_of(sheets("holder")[0])
    (spacing,) = [d for d in document.modelspace().query("DIMENSION") if d.dxf.text.endswith("[2]")]
    assert spacing.dxf.text == "<> [2]" and spacing.get_measurement() == pytest.approx(46.0)
    assert document.dimstyles.get(spacing.dxf.dimstyle).dxf.dimgap < 0.0
    frames = [e for e in document.blocks.get(spacing.dxf.geometry) if e.dxftype() == "LWPOLYLINE" and len(e) == 5]
    assert len(frames) == 1


def drawn_by(sheet: Sheet) -> Iterator[Primitive]:
    """All primitives of a sheet but the lines of its views."""
    yield from (*frame(sheet.paper), *title_primitives(sheet.title, sheet.paper), *sheet.tables)
    for note in sheet.notes:
        yield from note.primitives()
    for view in sheet.views:
        yield from label_primitives(view)
    for annotation in sheet.annotations:
        yield from annotation.primitives(sheet.view(annotation.view))


def ends(lines: list[Line]) -> np.ndarray:
    return np.array([end for x0, y0, x1, y1 in lines for end in ((x0, y0), (x1, y1))])


def apart(points: np.ndarray, others: np.ndarray) -> list[list[float]]:
    """Those of some points that are at none of the others."""
    distance, _ = KDTree(others).query(points)
    return points[distance > SAME].round(3).tolist()


def differences(sheet: Sheet, document: Drawing) -> list:
    """What the document shows otherwise than the sheet, a line each."""
    content, pieces = PaperContent(document), list(drawn_by(sheet))
    lines = [line for view in sheet.views for line in view_lines(view)]
    lines += [line for piece in pieces for line in primitive_lines(piece)]
    found: list = list(content.cut_off)
    found += [f"no line ends at {end}" for end in apart(ends(lines), ends(content.lines))]
    found += [f"a line ends at {end}" for end in apart(ends(content.lines), ends(lines))]
    boxes = [(p.text, text_box(replace(p, text=printed(p.text)))) for p in pieces if isinstance(p, Text)]
    wanted = sorted((text.replace("⌀", "Ø"), ((b[0] + b[2]) / 2, (b[1] + b[3]) / 2)) for text, b in boxes)
    written = sorted((text.text, text.middle) for text in content.texts)
    found += [f"{a} and {b}" for a, b in zip_longest(wanted, written) if a is None or b is None or a[0] != b[0]]
    places = [np.array([middle for _, middle in texts]) for texts in (wanted, written)]
    return found + apart(*places) + apart(*reversed(places))


def wrong_numbers(document: Drawing) -> list[str]:
    """Dimensions whose drawn text is not what their points measure."""
    found = []
    for dimension in document.modelspace().query("DIMENSION"):
        measured = dimension.get_measurement()  # pyright: ignore[reportAttributeAccessIssue]
        decimals = document.dimstyles.get(dimension.dxf.dimstyle).dxf.dimdec
        expected = dimension.dxf.text.replace("<>", f"{measured:.{decimals}f}")
        drawn = "".join(one.plain_text() for one in visible_entities(document, [dimension]) if one.dxftype() == "TEXT")
        for code, sign in (("%%c", "Ø"), ("%%d", "°"), ("%%p", "±"), ("⌀", "Ø")):
            expected, drawn = expected.replace(code, sign), drawn.replace(code, sign)
        if "<>" not in dimension.dxf.text or expected != drawn:
            found.append(f"{drawn} is drawn, {expected} is measured")
    return found


@pytest.mark.parametrize("part", MADE)
def test_the_file_shows_what_the_sheet_has(part: str) -> None:
    for one in sheets(part):
        document = document_of(one)
        assert differences(one, document) == [] and wrong_numbers(document) == []
        auditor = document.audit()
        assert [error.message for error in (*auditor.errors, *auditor.fixes)] == []


def test_a_line_or_number_that_differs_is_found() -> None:
    document = document_of(CLEAN)
    assert differences(CLEAN, document) == []
    document.modelspace().add_line((250.0, 350.0), (251.0, 350.0), dxfattribs={"layer": "VISIBLE"})
    assert differences(CLEAN, document)
    dimension = document.modelspace().query("DIMENSION").first
    assert dimension is not None
    assert wrong_numbers(document) == []
    dimension.dxf.defpoint3 = (dimension.dxf.defpoint3.x + 1.0, dimension.dxf.defpoint3.y)
    assert len(wrong_numbers(document)) == 1


def test_all_lines_and_texts_are_at_their_places_on_the_paper() -> None:
    (sheet,) = sheets("stop_bar")
    before, flat = PaperContent(document_of(sheet)), flattened(document_of(sheet))
    assert not flat.modelspace().query("DIMENSION") and len(flat.paperspace().query("VIEWPORT")) <= 1
    curves = [entity for entity in flat.modelspace() if entity.dxftype() != "TEXT"]
    lines = [line for entity in curves for line in polyline_lines(entity_points(entity))]
    ends = [np.array([end for line in found for end in (line[:2], line[2:])]) for found in (before.lines, lines)]
    for some, others in (ends, ends[::-1]):
        # Chords of arcs are as dense as the scale of the view asks for.
        distance, _ = KDTree(others).query(some)
        assert np.quantile(distance, 0.9) < 1e-6 and distance.max() < 3.0
    texts = sorted(entity.plain_text() for entity in flat.modelspace().query("TEXT"))
    assert texts == sorted(text.text for text in before.texts)
    assert not flat.audit().errors
