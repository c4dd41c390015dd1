"""SVG, PDF and PNG of a sheet: each primitive in each format, against ezdxf's rendering of the DXF, the same twice."""

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from pypdfium2 import PdfDocument

from drawings.annotations.annotation import Note
from drawings.annotations.primitives import (
    LINE_TYPES,
    ArcStroke,
    FilledPolygon,
    LineStyle,
    Primitive,
    Stroke,
    Symbol,
    Text,
    text_width,
)
from drawings.export.drawing_model import DrawingModel, PrimitiveGroup, bezier_curves, drawing_model, text_origin
from drawings.export.pdf import DPI, pdf_bytes, png_bytes, svg_bytes
from drawings.views.view import Arc
from tests.drawings.plate_sheet import plate, sheet
from tests.drawings.rendered import assert_same_picture, picture_of

SCALE = DPI["A3"] / 25.4
"""Pixels per mm."""


def only(*primitives: Primitive) -> DrawingModel:
    return DrawingModel("test", "A3", 1.0, (PrimitiveGroup(primitives),))


def drawn_at(picture: np.ndarray, x: float, y: float) -> bool:
    """Whether there is ink within 2 pixels of a point of the paper, mm."""
    column, row = round(x * SCALE), round((297.0 - y) * SCALE)
    return picture[row - 2 : row + 3, column - 2 : column + 3].min() < 128


@pytest.fixture(scope="module")
def drawing() -> DrawingModel:
    return drawing_model(sheet())


@pytest.fixture(scope="module")
def picture(drawing: DrawingModel) -> np.ndarray:
    return picture_of(drawing)


def test_every_format_is_the_same_twice_and_as_large_as_the_paper(drawing: DrawingModel, picture: np.ndarray) -> None:
    again = drawing_model(sheet())
    assert svg_bytes(drawing) == svg_bytes(again)
    pdf = pdf_bytes(drawing)
    assert pdf == pdf_bytes(again) and png_bytes(pdf, "A3") == png_bytes(pdf, "A3")
    root = ET.fromstring(svg_bytes(drawing))
    assert (root.get("width"), root.get("height")) == ("420mm", "297mm")
    page = PdfDocument(pdf_bytes(drawing))[0]
    assert [side * 25.4 / 72 for side in page.get_size()] == pytest.approx([420, 297], abs=0.01)
    assert picture.shape[::-1] == pytest.approx((420 * SCALE, 297 * SCALE), abs=1.1)
    for stroke in (stroke for strokes in drawing.strokes().values() for stroke in strokes):
        x, y = stroke.points[0] if isinstance(stroke, Stroke) else _ends(stroke.arc)[0]
        assert drawn_at(picture, x, y)


def test_the_picture_is_that_of_the_dxf_document_by_ezdxf(drawing: DrawingModel) -> None:
    assert_same_picture(drawing)


def test_svg_has_each_line_polygon_and_text(drawing: DrawingModel) -> None:
    root = ET.fromstring(svg_bytes(drawing))
    paths = [(group, path.get("d", "")) for group in root.findall(".//{*}g") for path in group.findall("{*}path")]
    expected = [(style, stroke) for style, strokes in drawing.strokes().items() for stroke in strokes]
    assert len(paths) == len(expected) + len(drawing.polygons())
    for (group, outline), (style, stroke) in zip(paths, expected, strict=False):
        dashes = " ".join(f"{length:g}" for length in LINE_TYPES[style.line_type]) or None
        assert (float(group.get("stroke-width", 0)), group.get("stroke-dasharray")) == (style.weight, dashes)
        points = np.array(re.findall(r"-?\d+\.\d+", outline), dtype=float).reshape(-1, 2)
        ends = stroke.points if isinstance(stroke, Stroke) else _ends(stroke.arc)
        assert points[[0, -1]] == pytest.approx(np.array([ends[0], ends[-1]]), abs=0.001)
    texts = [group.get("aria-label") for group in root.findall(".//{*}g") if group.get("aria-label")]
    assert texts == [text.text for text in drawing.texts()]


def _ends(arc: Arc) -> list[tuple[float, float]]:
    angles = map(math.radians, (arc.start_angle, arc.end_angle))
    return [(arc.centre[0] + arc.radius * math.cos(a), arc.centre[1] + arc.radius * math.sin(a)) for a in angles]


@pytest.mark.parametrize("radius", [50.0, 2e3, 1e6])
def test_an_arc_with_its_centre_outside_the_sheet_is_drawn(radius: float) -> None:
    half = math.degrees(math.asin(20.0 / radius))
    arc = Arc((200.0, 150.0 - radius), radius, 90.0 - half, 90.0 + half)
    sag = radius - math.sqrt(radius**2 - 20.0**2)
    drawing = only(ArcStroke(arc, "VISIBLE"))
    picture = picture_of(drawing)
    places = [(200.0, 150.0), (180.5, 150.0 - sag * (19.5 / 20.0) ** 2), (219.5, 150.0 - sag * (19.5 / 20.0) ** 2)]
    assert all(drawn_at(picture, x, y) for x, y in places)
    assert (picture < 128).sum() == pytest.approx(2 * half / 180 * math.pi * radius * 0.5 * SCALE**2, rel=0.15)
    (outline,) = re.findall(r'd="M([^"]*C[^"]*)"', svg_bytes(drawing).decode().split("</defs>")[1])
    points = np.array(re.findall(r"-?\d+\.\d+", outline), dtype=float).reshape(-1, 2)
    assert points[0] == pytest.approx((220.0, 150.0 - sag), abs=0.001)
    assert points[-1] == pytest.approx((180.0, 150.0 - sag), abs=0.001)


def test_arcs_and_polygons_of_svg() -> None:
    for arc in (Arc((1.0, 2.0), 3.0), Arc((1.0, 2.0), 3.0, 350.0, 370.0), Arc((0.0, 0.0), 5.0, 30.0, 250.0)):
        begin, curves = bezier_curves(arc)
        for first, second, end in curves:
            for t in np.linspace(0.0, 1.0, 9):
                weights = np.array(((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3))
                point = weights @ np.array((begin, first, second, end))
                assert math.dist(point, arc.centre) == pytest.approx(arc.radius, rel=5e-6)
            begin = end
        assert begin == pytest.approx(_ends(arc)[1], abs=1e-9)
    crown = Arc((15.0, 2000.0), 2000.0, 270.0 - 0.2, 270.0 + 0.2)
    view = replace(plate(0.5, (100.0, 180.0)), curves={"VISIBLE": (crown,)})
    assert drawn_at(picture_of(drawing_model(replace(sheet(), views=(view,), annotations=()))), 107.5, 180.0)
    square = ((50.0, 50.0), (60.0, 50.0), (60.0, 60.0), (50.0, 60.0))
    turned = tuple((x + 5.0, y + 5.0) for x, y in reversed(square))
    picture = picture_of(only(FilledPolygon(square), FilledPolygon(turned)))
    assert all(drawn_at(picture, x, x) for x in (52.5, 57.5, 62.5))


@pytest.mark.parametrize("line_type", ["DASHED", "CHAIN", "PHANTOM"])
def test_a_broken_line_has_its_dashes_and_gaps(line_type) -> None:
    picture = picture_of(only(Stroke(((50.0, 100.0), (150.0, 100.0)), "VISIBLE", LineStyle(0.25, line_type))))
    row = picture[round(197.0 * SCALE) - 1 : round(197.0 * SCALE) + 2].min(axis=0)
    x = 50.0
    for number, length in enumerate(LINE_TYPES[line_type] * 2):
        middle = row[round((x + length / 2) * SCALE)]
        assert middle < 128 if number % 2 == 0 else middle > 128
        x += length


def test_texts_of_the_pdf_can_be_searched_with_more_characters_than_one_font_has(drawing: DrawingModel) -> None:
    page = PdfDocument(pdf_bytes(drawing))[0].get_textpage()
    found = page.get_text_range()
    for text in drawing.texts():
        assert text.text in found
    assert {"FILE_NAME", "Al 6061-T651", "±0.01"} <= set(found.split("\r\n"))
    characters = "".join(chr(number) for number in range(0x100, 0x100 + 300))
    lines = [Text(characters[start : start + 60], (20.0, 250.0 - start)) for start in range(0, 300, 60)]
    page = PdfDocument(pdf_bytes(only(*lines)))[0].get_textpage()
    assert all(text.text in page.get_text_range() for text in lines)


@pytest.mark.parametrize("angle", [0.0, 90.0, 45.0])
@pytest.mark.parametrize("alignment", ["left", "middle", "right"])
def test_a_text_is_at_its_place_in_pdf_and_svg(alignment, angle: float) -> None:
    text = Text("HIH", (200.0, 150.0), 5.0, alignment, angle)
    width, turn = text_width("HIH", 5.0), math.radians(angle)
    rows, columns = np.nonzero(picture_of(only(text)) < 128)
    x, y = columns / SCALE - 200.0, 297.0 - rows / SCALE - 150.0
    along, up = x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)
    start = {"left": 0.0, "middle": -width / 2, "right": -width}[alignment]
    # An H stands off its origin by a seventh of its height.
    assert (along.min(), along.max()) == pytest.approx((start + 0.55, start + width - 0.55), abs=0.25)
    assert (up.min(), up.max()) == pytest.approx((0.0, 5.0), abs=0.25)
    (matrix,) = re.findall(r'aria-label="HIH" transform="matrix\(([^)]*)\)"', svg_bytes(only(text)).decode())
    a, b, c, d, e, f = map(float, matrix.split())
    assert (e, f) == pytest.approx(text_origin(text), abs=1e-3)
    assert math.degrees(math.atan2(b, a)) == pytest.approx(angle, abs=1e-3)
    assert math.hypot(a, b) / math.hypot(c, d) == pytest.approx(0.8, rel=1e-5)


def test_every_sign_and_symbol_is_drawn_and_none_as_an_empty_box() -> None:
    names = get_args(Symbol)
    texts = ["\U000f0000", *"⌀±°Rax×", *(f"{{{name}}}" for name in names)]
    notes = tuple(Note((40.0 + 15.0 * i, 100.0), (text,)) for i, text in enumerate(texts))
    bare = replace(sheet(), annotations=(), views=(plate(0.5, (100, 180)),), notes=notes)
    pixels = picture_of(drawing_model(bare))
    band = pixels[pixels.shape[0] - round(106 * SCALE) : pixels.shape[0] - round(98 * SCALE)]
    places = [note.at[0] for note in notes]
    empty, *drawn = (band[:, round((x - 2) * SCALE) : round((x + 9) * SCALE)] for x in places)
    for text, cell in zip(texts[1:], drawn, strict=True):
        assert (cell < 128).mean() > 0.004, text
        assert cell.shape != empty.shape or not (cell == empty).all(), text
