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
from ezdxf.filemanagement import readfile
from PIL import Image
from plate_sheet import TITLE, plate, sheet

from drawings.annotation import (
    Linear,
    Note,
    Symbol,
)
from drawings.document import LAYERS, document_of, dxf_bytes, measured_text
from drawings.dxf_writing import entity_text
from drawings.export import DPI, Renderings, render
from drawings.frame import PAPERS, drawing_space, frame
from drawings.ink import Words
from drawings.sheet import scale_text, sheet_area
from drawings.title_block import title_box, title_ink


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
    wrong = Linear("top", (0, 0), (40, 0), 0.0, (0, 0), "2x 41.0", 40.0, ("width",))
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
    drawn, filled = [], 0
    for group in root.findall("{*}g"):
        outlines = [path.get("d", "") for path in group]
        if group.get("stroke-width") is None:
            filled += len(outlines)
        else:
            drawn += [(float(group.get("stroke-width", "")), outline) for outline in outlines]
    content = zlib.decompress(made.pdf.partition(b"stream\n")[2].partition(b"\nendstream")[0]).decode()
    assert content.count("f\n") == filled > 20
    strokes = content.split("S\n")[:-1]
    assert len(strokes) == len(drawn) > 50
    pixels = np.asarray(Image.open(io.BytesIO(made.png)))
    weight, to_pixels = 0.0, DPI["A3"] / 25.4
    for stroke, (width, outline) in zip(strokes, drawn, strict=True):
        *head, path = stroke.rpartition(" w\n")
        weight = float(head[0].split()[-1]) * 25.4 / 72 if head[0] else weight
        assert weight == pytest.approx(width, abs=1e-3)
        if "Q" in outline:
            continue
        points = np.array(_numbers(outline)).reshape(-1, 2)
        written = np.array(_numbers(path)).reshape(-1, 2) * 25.4 / 72
        assert written == pytest.approx(np.array((0.0, 297.0)) + points * (1.0, -1.0), abs=0.005)
        x, y = (points[0] * to_pixels).astype(int)
        assert pixels[max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3].min() < 128


def test_the_table_of_the_pdf_tells_where_its_objects_are(made: Renderings) -> None:
    table = int(made.pdf.rstrip().splitlines()[-2])
    entries = re.findall(rb"(\d{10}) 00000 n \n", made.pdf[table:])
    assert len(entries) == 5
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
    names = [ink.text for ink in frame(paper) if isinstance(ink, Words)]
    x0, y0, x1, y1 = drawing_space(paper)
    assert (x0, y0, width - x1, height - y1) == (20.0, 10.0, 10.0, 10.0)
    assert sorted(set(names)) == sorted(name for name in set(names) if names.count(name) == 2)
    assert {"A", "B", "1", "2"} <= set(names)
    assert not {"I", "O"} & set(names)
    assert {"A3": 14, "A2": 20, "A1": 28}.get(paper, len(set(names))) == len(set(names))


def test_the_title_block_says_everything_within_its_cells() -> None:
    x0, y0, x1, y1 = title_box("A3")
    words = [ink for ink in title_ink(TITLE, "A3") if isinstance(ink, Words)]
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
    from drawings.annotation_ink import text_box

    boxes = [text_box(word) for word in words]
    assert all(x0 <= box[0] and y0 <= box[1] and box[2] <= x1 and box[3] <= y1 for box in boxes)
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_long_fields_shrink_rather_than_leave_their_cell() -> None:
    long = replace(TITLE, material="Pure iron, magnetically soft, annealed in hydrogen, twice, and slowly cooled")
    x0, *_ = title_box("A3")
    word = next(ink for ink in title_ink(long, "A3") if isinstance(ink, Words) and ink.text == long.material)
    from drawings.annotation_ink import text_box

    assert text_box(word)[2] <= x0 + 66.0


def test_scales_as_they_are_written() -> None:
    assert [scale_text(scale) for scale in (1.0, 0.5, 0.2, 0.25, 2.0, 0.35)] == [
        "1:1", "1:2", "1:5", "1:4", "2:1", "0.350",
    ]  # fmt: skip


def test_the_free_area_leaves_out_the_title_block() -> None:
    area = sheet_area("A3")
    assert area.taken[0] == title_box("A3")
    assert math.isclose(area.space[0], 25.0)
