"""The DXF document: sound, measurable, the same bytes twice; and the formats made from it show what it holds."""

from __future__ import annotations

import io
import math
import re
import xml.etree.ElementTree as ET
import zlib
from dataclasses import replace
from typing import get_args

import ezdxf
import numpy as np
import pytest
from ezdxf._options import options
from ezdxf.enums import TextEntityAlignment
from ezdxf.filemanagement import readfile
from PIL import Image

from drawings.annotations.annotation import (
    LinearDimension,
    Note,
    Symbol,
)
from drawings.annotations.font import TEXT_STYLE, WIDTH_FACTOR, glyph
from drawings.annotations.primitives import Alignment, Text
from drawings.export.document import LAYERS, document_of, dxf_bytes
from drawings.export.dxf_dimensions import measured_text
from drawings.export.dxf_entities import Place, add_arc, add_line, add_polyline, add_words
from drawings.export.dxf_writing import entity_text
from drawings.export.pdf import PER_FONT
from drawings.export.png import DPI
from drawings.export.render import Renderings, render
from drawings.export.strokes import shown
from drawings.sheets.frame import PAPERS, drawing_space, frame
from drawings.sheets.sheet import scale_text, sheet_area
from drawings.sheets.title_block import title_box, title_primitives
from drawings.views.view import Arc
from tests.drawings.plate_sheet import TITLE, plate, sheet


@pytest.fixture(scope="module")
def document() -> ezdxf.document.Drawing:  # type: ignore[name-defined]
    return document_of(sheet())


def test_every_dimension_measures_what_it_says(document) -> None:
    found = {}
    for entity in document.modelspace().query("DIMENSION"):
        number = re.sub(r"[^\d.]", "", entity.dxf.text.replace("2x", "").replace("%%c", "").replace("%%d", ""))
        assert number == ""  # the number itself is measured by whoever opens the file
        found.setdefault(entity.dimtype, []).append(entity.get_measurement())
    assert sorted(found[0]) == pytest.approx([16.0, 40.0, 80.0], abs=1e-9)
    assert found[3] == pytest.approx([16.0])
    assert found[4] == pytest.approx([8.0])
    assert found[5] == pytest.approx([45.0])


def test_the_file_is_what_the_dxf_library_itself_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    document = document_of(sheet())
    layout = document.modelspace()
    # Entities with more than a sheet's usual have are left to the library.
    odd = [
        layout.add_line((0, 0), (1, 1), dxfattribs={"color": 1, "layer": "HIDDEN"}),
        layout.add_lwpolyline([(0, 0, 0, 0, 0.5), (1, 1)]),
        layout.add_text("tagged", height=2.5),
    ]
    odd[2].set_xdata("ACAD", [(1000, "note")])
    assert [entity_text(entity) for entity in odd] == [None] * 3
    known = [entity.dxftype() for block in document.blocks for entity in block if entity_text(entity)]
    assert {"LINE", "CIRCLE", "ARC", "LWPOLYLINE", "TEXT"} == set(known)
    ours = dxf_bytes(document)
    stream = io.StringIO()
    monkeypatch.setattr(options, "write_fixed_meta_data_for_testing", True)
    document.write(stream)
    assert ours == stream.getvalue().encode("utf-8")


def test_entities_are_those_that_the_dxf_library_makes(monkeypatch: pytest.MonkeyPatch) -> None:
    # Fixed, so that two documents can be compared at all.
    monkeypatch.setattr(options, "write_fixed_meta_data_for_testing", True)
    ours, theirs = ezdxf.new("R2010"), ezdxf.new("R2010")  # type: ignore[attr-defined]
    spaces = [(doc.modelspace(), doc.paperspace(), doc.blocks.new("B")) for doc in (ours, theirs)]
    broken = {"layer": "HIDDEN", "ltscale": 0.5, "linetype": "CONTINUOUS", "lineweight": 70}
    for own, other in zip(*spaces, strict=True):
        for attributes in ({"layer": "VISIBLE"}, broken):
            add_line(own, (1.0, 2.0), (3.0, 4.5), attributes)
            other.add_line((1.0, 2.0), (3.0, 4.5), dxfattribs=attributes)
            add_polyline(own, [(0.0, 1.0), (2.0, 3.0), (4.0, 6.0)], attributes)
            other.add_lwpolyline([(0.0, 1.0), (2.0, 3.0), (4.0, 6.0)], dxfattribs=attributes)
            add_arc(own, (5.0, 6.0), 7.0, Arc((0.0, 0.0), 7.0), attributes)
            other.add_circle((5.0, 6.0), 7.0, dxfattribs=attributes)
            add_arc(own, (5.0, 6.0), 7.0, Arc((0.0, 0.0), 7.0, 10.0, 20.0), attributes)
            other.add_arc((5.0, 6.0), 7.0, 10.0, 20.0, dxfattribs=attributes)
        for alignment, align in _ALIGNED.items():
            add_words(own, Text("⌀8 ±0.1", (1.0, 2.0), 3.5, alignment, 30.0), Place(0.5, (1.0, 0.0)))
            text = other.add_text(
                "%%c8 %%p0.1",
                height=7.0,
                rotation=30.0,
                dxfattribs={"layer": "TEXT", "style": TEXT_STYLE, "width": WIDTH_FACTOR},
            )
            text.set_placement((4.0, 4.0), align=align)
        for space in (own, other):
            assert all(entity.doc.entitydb[entity.dxf.handle] is entity for entity in space)
    written = []
    for doc in (ours, theirs):
        doc.classes.classes = dict(sorted(doc.classes.classes.items(), key=str))
        doc.styles.add(TEXT_STYLE, font="DejaVuSans.ttf")
        stream = io.StringIO()
        doc.write(stream)
        written.append(stream.getvalue())
        assert not doc.audit().errors
    assert written[0] == written[1]


_ALIGNED: dict[Alignment, TextEntityAlignment] = {
    "left": TextEntityAlignment.LEFT,
    "middle": TextEntityAlignment.CENTER,
    "right": TextEntityAlignment.RIGHT,
}


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


def test_a_text_that_says_something_else_is_refused() -> None:
    wrong = LinearDimension("top", (0, 0), (40, 0), 0.0, (0, 0), "2x 41.0", 40.0, ("width",))
    with pytest.raises(ValueError, match=r"width says '2x 41\.0', but measures 40"):
        measured_text(wrong)
    assert measured_text(replace(wrong, text="4x 40.00 [1]")) == ("4x <> [1]", 2)
    assert measured_text(replace(wrong, text="40x 40")) in (("<>x 40", 0), ("40x <>", 0))


def test_the_part_is_at_its_true_size_and_the_sheet_at_scale(document) -> None:
    outline = list(document.modelspace().query("LINE[layer=='VISIBLE']"))
    lengths = sorted(round((line.dxf.end - line.dxf.start).magnitude, 9) for line in outline)
    assert lengths == [40.0] * 4 + [80.0] * 4
    views = [view for view in document.paperspace().query("VIEWPORT") if view.dxf.id != 1]
    assert sorted(round(view.get_scale(), 9) for view in views) == [0.5, 2.0]
    assert all(view.dxf.layer == "VIEWPORT" for view in views)
    assert document.layers.get("VIEWPORT").dxf.plot == 0


def test_views_of_two_scales_do_not_meet_in_model_space(document) -> None:
    boxes = []
    for view in document.paperspace().query("VIEWPORT"):
        if view.dxf.id != 1:
            width = view.dxf.width / view.get_scale()
            boxes.append((view.dxf.view_center_point[0] - width / 2, view.dxf.view_center_point[0] + width / 2))
    (_, first_end), (second_start, _) = sorted(boxes)
    assert first_end < second_start


def test_layers_have_the_weights_of_iso_128(document) -> None:
    for name, (_, weight, line_type) in LAYERS.items():
        layer = document.layers.get(name)
        assert (layer.dxf.lineweight, layer.dxf.linetype.upper()) == (weight, line_type)
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


@pytest.fixture(scope="module")
def made(document) -> Renderings:
    return render(document, "A3")


def test_svg_and_pdf_are_the_same_twice(made: Renderings) -> None:
    again = render(document_of(sheet()), "A3")
    assert made.svg == again.svg
    assert made.pdf == again.pdf
    assert made.png == again.png


def test_each_format_has_the_size_of_the_paper(made: Renderings) -> None:
    root = ET.fromstring(made.svg)
    assert (root.get("width"), root.get("height")) == ("420mm", "297mm")
    box = re.search(rb"/MediaBox \[([^\]]*)\]", made.pdf)
    assert box
    assert [float(value) * 25.4 / 72 for value in box.group(1).split()] == pytest.approx([0, 0, 420, 297], abs=0.01)
    picture = Image.open(io.BytesIO(made.png))
    assert picture.size == pytest.approx((420 / 25.4 * DPI["A3"], 297 / 25.4 * DPI["A3"]), abs=1.1)


def _numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", text)]


def test_svg_pdf_and_png_show_the_same_lines(made: Renderings) -> None:
    root = ET.fromstring(made.svg)
    drawn: list[tuple[float, str]] = []
    for group in root.findall("{*}g"):
        if group.get("stroke-width") is not None:
            drawn += [(float(group.get("stroke-width", "")), path.get("d", "")) for path in group]
    content = _page(made.pdf)
    assert content.startswith(f"{72 / 25.4 / 1000:.9f} 0 0 {72 / 25.4 / 1000:.9f} 0 0 cm\n")
    strokes = content.split("S\n")[:-1]
    assert len(strokes) == len(drawn) > 50
    pixels = np.asarray(Image.open(io.BytesIO(made.png)))
    weight, to_pixels = 0.0, DPI["A3"] / 25.4
    for stroke, (width, outline) in zip(strokes, drawn, strict=True):
        *head, path = stroke.rpartition(" w\n")
        weight = float(head[0].split()[-1]) / 1000 if head[0] else weight
        assert weight == pytest.approx(width)
        points = np.array(_numbers(outline)).reshape(-1, 2)
        written = np.array([float(number) for number in re.findall(r"-?\d+", path)]).reshape(-1, 2) / 1000
        assert written == pytest.approx(np.array((0.0, 297.0)) + points * (1.0, -1.0), abs=0.0011)
        x, y = (points[0] * to_pixels).astype(int)
        assert pixels[max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3].min() < 128


def _streams(pdf: bytes) -> dict[int, str]:
    """Streams of a PDF by the number of their objects."""
    found = re.finditer(rb"(\d+) 0 obj\n<<[^>]*/FlateDecode >>\nstream\n(.*?)\nendstream", pdf, re.DOTALL)
    return {int(match.group(1)): zlib.decompress(match.group(2)).decode("ascii") for match in found}


def _page(pdf: bytes) -> str:
    (number,) = re.findall(rb"/Contents (\d+) 0 R", pdf)
    return _streams(pdf)[int(number)]


def _letters(pdf: bytes) -> list[dict[int, str]]:
    """Of each font which letter its codes stand for."""
    streams = _streams(pdf)
    tables = [streams[int(number)] for number in re.findall(rb"/ToUnicode (\d+) 0 R", pdf)]
    rows = [re.findall(r"<(..)> <(\w{4,})>\n", table) for table in tables]
    return [{int(code, 16): bytes.fromhex(sign).decode("utf-16-be") for code, sign in row} for row in rows]


def _texts(pdf: bytes) -> list[str]:
    """Texts of a PDF as a reader finds them."""
    letters, found, font = _letters(pdf), [], 0
    for operands, operator in re.findall(r"([^\n]*) (Tf|Tj)\n", _page(pdf)):
        if operator == "Tf":
            font = int(operands.split()[0].removeprefix("/F"))
        else:
            (codes,) = re.findall(r"<(\w+)>", operands)
            found.append("".join(letters[font][code] for code in bytes.fromhex(codes)))
    return found


def test_texts_of_the_pdf_can_be_searched(document, made: Renderings) -> None:
    found = _texts(made.pdf)
    said = [text.words for text in shown(document).texts]
    assert found == said
    assert {"FILE_NAME", "Al 6061-T651", "±0.01"} <= set(found)


def test_signs_beyond_one_font_of_a_pdf_are_in_the_next() -> None:
    signs = "".join(chr(number) for number in range(0xA1, 0xA1 + PER_FONT + 40) if chr(number).isprintable())
    assert len(set(signs)) > PER_FONT
    bare = replace(sheet(), annotations=(), views=(plate(0.5, (100, 180)),), notes=(Note((30.0, 100.0), (signs,)),))
    made = render(document_of(bare), "A3")
    assert len(_letters(made.pdf)) == 2
    assert signs in "".join(_texts(made.pdf))


def test_texts_stand_at_the_same_place_in_every_format(document, made: Renderings) -> None:
    """A sign's box: in the SVG, and in the PDF by its font and the text's matrix, as the advances put it."""
    texts = shown(document).texts
    root = ET.fromstring(made.svg)
    paths = [path.get("d", "") for path in root.findall("{*}g")[-1]]
    rows = re.findall(r"([-\d. ]+) Tm", _page(made.pdf))
    assert len(paths) == len(rows) == len(texts)
    for text, path, row in zip(texts, paths, rows, strict=True):
        a, b, c, d, x, y = (float(number) / 1000 for number in row.split())
        signs = [sign for sign in text.words if len(glyph(sign).points)]
        starts = np.array([_numbers(part)[:2] for part in path.split("M")[1:]])
        assert len(starts) == len(signs)
        along = 0.0
        placed = iter(starts)
        for sign in text.words:
            if len(glyph(sign).points):
                there = next(placed)
                assert there == pytest.approx((x + a * along, 297.0 - y - b * along), abs=0.01 + 1e-4 * along)
            along += glyph(sign).advance
        assert (a * d - b * c) == pytest.approx(text.height**2 * text.narrowed, rel=1e-3)


def test_the_table_of_the_pdf_tells_where_its_objects_are(made: Renderings) -> None:
    table = int(made.pdf.rstrip().splitlines()[-2])
    entries = re.findall(rb"(\d{10}) 00000 n \n", made.pdf[table:])
    assert len(entries) > 50
    for number, entry in enumerate(entries, start=1):
        assert made.pdf[int(entry) :].startswith(b"%d 0 obj" % number)


def test_every_sign_and_symbol_is_drawn_and_none_as_an_empty_box() -> None:
    names = get_args(Symbol)
    texts = ["\U000f0000", *"⌀±°Rax×", *(f"{{{name}}}" for name in names)]
    notes = tuple(Note((40.0 + 15.0 * i, 100.0), (text,)) for i, text in enumerate(texts))
    bare = replace(sheet(), annotations=(), views=(plate(0.5, (100, 180)),), notes=notes)
    pixels = np.asarray(Image.open(io.BytesIO(render(document_of(bare), "A3").png)))
    scale = DPI["A3"] / 25.4
    top = pixels.shape[0]
    cells = [
        pixels[top - round(106 * scale) : top - round(98 * scale), round((x - 2) * scale) : round((x + 9) * scale)]
        for x in (note.at[0] for note in notes)
    ]
    empty, *drawn = cells
    for text, cell in zip(texts[1:], drawn, strict=True):
        assert (cell < 128).mean() > 0.004, text
        assert cell.shape != empty.shape or not (cell == empty).all(), text


@pytest.mark.parametrize("paper", list(PAPERS))
def test_the_frame_stands_within_the_paper_and_its_zones_are_named(paper) -> None:
    width, height = PAPERS[paper]
    names = [ink.text for ink in frame(paper) if isinstance(ink, Text)]
    x0, y0, x1, y1 = drawing_space(paper)
    assert (x0, y0, width - x1, height - y1) == (20.0, 10.0, 10.0, 10.0)
    assert sorted(set(names)) == sorted(name for name in set(names) if names.count(name) == 2)
    assert {"A", "B", "1", "2"} <= set(names)
    assert not {"I", "O"} & set(names)
    assert {"A3": 14, "A2": 20, "A1": 28}.get(paper, len(set(names))) == len(set(names))


def test_the_title_block_says_everything_within_its_cells() -> None:
    x0, y0, x1, y1 = title_box("A3")
    words = [ink for ink in title_primitives(TITLE, "A3") if isinstance(ink, Text)]
    text = " ".join(word.text for word in words)
    for field in (
        "FILE_NAME",
        "PLATE",
        "1:2",
        "MM",
        "2 of 3",
        "Al 6061-T651",
        "1.25 kg",
        "a1b2c3d4",
        "X.XX",
        "±0.01",
        "ANGLE",
        "±0.5°",
    ):
        assert field in text
    from drawings.annotations.annotation_geometry import text_box

    boxes = [text_box(word) for word in words]
    assert all(x0 <= box[0] and y0 <= box[1] and box[2] <= x1 and box[3] <= y1 for box in boxes)
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_long_fields_shrink_rather_than_leave_their_cell() -> None:
    long = replace(TITLE, material="Pure iron, magnetically soft, annealed in hydrogen, twice, and slowly cooled")
    x0, *_ = title_box("A3")
    word = next(ink for ink in title_primitives(long, "A3") if isinstance(ink, Text) and ink.text == long.material)
    from drawings.annotations.annotation_geometry import text_box

    assert text_box(word)[2] <= x0 + 66.0


def test_scales_as_they_are_written() -> None:
    assert [scale_text(scale) for scale in (1.0, 0.5, 0.2, 0.25, 2.0, 0.35)] == [
        "1:1", "1:2", "1:5", "1:4", "2:1", "0.350",
    ]  # fmt: skip


def test_the_free_area_leaves_out_the_title_block() -> None:
    area = sheet_area("A3")
    assert area.taken[0] == title_box("A3")
    assert math.isclose(area.space[0], 25.0)
