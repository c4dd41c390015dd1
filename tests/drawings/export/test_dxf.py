"""The DXF document of a sheet: sound, measurable, each primitive as its entity, the same bytes twice."""

import re
from dataclasses import replace

import ezdxf
import pytest
from ezdxf.document import Drawing
from ezdxf.filemanagement import readfile

from drawings.annotations.annotation import (
    LAYERS,
    TEXT_STYLE,
    THICK,
    WIDTH_FACTOR,
    Alignment,
    ArcStroke,
    FilledPolygon,
    LinearDimension,
    Stroke,
    Text,
)
from drawings.export.dxf import VIEWPORT_LAYER, ModelMapping, add_primitive, dxf_bytes, measured_text
from drawings.views.view import Arc
from tests.drawings.drawn import document_of
from tests.drawings.plate_sheet import sheet

HALF = ModelMapping(0.5, 1.0)
"""Paper to model space for a view at 1:2."""


@pytest.fixture(scope="module")
def document() -> Drawing:
    return document_of(sheet())


def test_every_dimension_measures_its_number(document) -> None:
    found = {}
    for entity in document.modelspace().query("DIMENSION"):
        number = re.sub(r"[^\d.]", "", entity.dxf.text.replace("2x", "").replace("%%c", "").replace("%%d", ""))
        assert number == ""  # the number itself is measured by whoever opens the file
        found.setdefault(entity.dimtype, []).append(entity.get_measurement())
    assert sorted(found[0]) == pytest.approx([16.0, 40.0, 80.0], abs=1e-9)
    assert found[3] == pytest.approx([16.0])
    assert found[4] == pytest.approx([8.0])
    assert found[5] == pytest.approx([45.0])


def test_decimals_are_kept(document) -> None:
    for entity in document.modelspace().query("DIMENSION"):
        style = document.dimstyles.get(entity.dxf.dimstyle)
        assert style.dxf.dimzin == 0
        assert style.dxf.dimdsep == ord(".")
    decimals = {
        round(entity.get_measurement(), 6): document.dimstyles.get(entity.dxf.dimstyle).dxf.dimdec
        for entity in document.modelspace().query("DIMENSION[text=='<>']")
    }
    assert decimals[80.0] == 2


def test_a_text_without_the_measured_number_is_refused() -> None:
    wrong = LinearDimension("top", (0, 0), (40, 0), 0.0, (0, 0), "2x 41.0", 40.0, ("width",))
    with pytest.raises(ValueError, match=r"width has the text '2x 41\.0', but measures 40"):
        measured_text(wrong)
    assert measured_text(replace(wrong, text="4x 40.00 [1]")) == ("4x <> [1]", 2)
    assert measured_text(replace(wrong, text="40x 40")) in (("<>x 40", 0), ("40x <>", 0))


def test_the_part_is_at_its_true_size_and_the_sheet_at_scale(document) -> None:
    outline = list(document.modelspace().query("LINE[layer=='VISIBLE']"))
    lengths = sorted(round((line.dxf.end - line.dxf.start).magnitude, 9) for line in outline)
    assert lengths == [40.0] * 4 + [80.0] * 4
    views = [view for view in document.paperspace().query("VIEWPORT") if view.dxf.id != 1]
    assert sorted(round(view.get_scale(), 9) for view in views) == [0.5, 2.0]
    assert all(view.dxf.layer == VIEWPORT_LAYER for view in views)
    assert document.layers.get(VIEWPORT_LAYER).dxf.plot == 0


def test_views_of_two_scales_do_not_meet_in_model_space(document) -> None:
    boxes = []
    for view in document.paperspace().query("VIEWPORT"):
        if view.dxf.id != 1:
            width = view.dxf.width / view.get_scale()
            boxes.append((view.dxf.view_center_point[0] - width / 2, view.dxf.view_center_point[0] + width / 2))
    (_, first_end), (second_start, _) = sorted(boxes)
    assert first_end < second_start


def test_layers_have_the_weights_of_iso_128(document) -> None:
    for name, (weight, line_type) in LAYERS.items():
        layer = document.layers.get(name)
        assert (layer.dxf.lineweight, layer.dxf.linetype.upper()) == (round(100 * weight), line_type)
    assert document.layers.get("VISIBLE").dxf.lineweight == 2 * document.layers.get("HIDDEN").dxf.lineweight


def test_the_file_is_sound_and_the_same_twice(document, tmp_path) -> None:
    data = dxf_bytes(document)
    assert data == dxf_bytes(document_of(sheet()))
    path = tmp_path / "plate.dxf"
    path.write_bytes(data)
    again = readfile(path)
    assert not again.audit().errors
    assert len(again.modelspace().query("DIMENSION")) == 6


def test_the_order_of_a_set_does_not_reach_the_file(document) -> None:
    names = re.findall(rb"  0\r?\nCLASS\r?\n  1\r?\n(\S+)", dxf_bytes(document))
    assert len(names) > 5
    assert names == sorted(names)


@pytest.fixture
def layout():
    doc = ezdxf.new("R2010")  # type: ignore[attr-defined]
    doc.styles.add(TEXT_STYLE, font="DejaVuSans.ttf")
    return doc.modelspace()


def test_lines_and_arcs_become_entities_in_model_space(layout) -> None:
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


def test_a_style_of_its_own_replaces_that_of_the_layer(layout) -> None:
    add_primitive(layout, Stroke(((0.0, 0.0), (6.0, 0.0)), "SECTION", THICK), HALF)
    (line,) = layout
    assert (line.dxf.layer, line.dxf.linetype, line.dxf.lineweight) == ("SECTION", "CONTINUOUS", 70)


def test_small_polygons_become_solids_and_others_hatches(layout) -> None:
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
    from tests.drawings.drawn import document_of, sheets

    document = document_of(sheets("holder")[0])
    (spacing,) = [d for d in document.modelspace().query("DIMENSION") if d.dxf.text.endswith("[2]")]
    assert spacing.dxf.text == "<> [2]"
    assert spacing.get_measurement() == pytest.approx(46.0)
    assert document.dimstyles.get(spacing.dxf.dimstyle).dxf.dimgap < 0.0
    frames = [e for e in document.blocks.get(spacing.dxf.geometry) if e.dxftype() == "LWPOLYLINE" and len(e) == 5]
    assert len(frames) == 1
