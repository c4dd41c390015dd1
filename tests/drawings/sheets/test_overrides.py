"""Frame and title block of a sheet, and manual changes that are applied, kept and reported."""

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from drawings.annotations.annotation import LinearDimension, SectionMark, text_box
from drawings.annotations.primitives import Text
from drawings.sheets.frame import PAPERS, drawing_space, frame, title_box, title_primitives
from drawings.sheets.overrides import read_overrides
from drawings.sheets.part import part_sheets
from drawings.sheets.sheet import Sheet, scale_text, sheet_area
from stagecad.parameters.load import load_design
from tests.drawings.drawn import described
from tests.drawings.plate_sheet import TITLE
from tests.reference.tables import cases
from tests.refusals import refused

CHANGES = """
[magnet]
paper = "A2"
scale = "4:1"
move = [{dimension = "length", by = ["7 mm", "-3 mm"]}, {dimension = "radius", by = ["1 mm", "1 mm"]}]
note = [{text = "Mark the north pole.", at = ["60 mm", "200 mm"]}, {text = "Handle with gloves."}]
view = [{projection = "left"}, {projection = "top"}]
detail = [{letter = "Z", projection = "front", at = ["20 mm", "0 mm", "0 mm"], radius = "2 mm", scale = "10:1"}]
"""


def magnet(tmp_path: Path, text: str, *overrides: str) -> Sheet:
    path = tmp_path / "sheets.toml"
    path.write_text(text)
    design = replace(load_design(overrides=overrides), sheets=read_overrides(path, ["magnet", "tip"]))
    (sheet,) = part_sheets(described("magnet", design), design)
    return sheet


def dimension(sheet: Sheet, name: str) -> LinearDimension:
    return next(a for a in sheet.annotations if isinstance(a, LinearDimension) and a.names == (name,))


@pytest.mark.parametrize("length", ["40 mm", "36 mm"])
def test_changes_are_applied_whatever_the_parameters(length: str, tmp_path: Path) -> None:
    sheet = magnet(tmp_path, CHANGES, f"magnet.length={length}", f"tooth_iron.length={length}")
    assert (sheet.paper, sheet.scale) == ("A2", 4.0)
    assert {"left", "detail Z"} <= {view.name for view in sheet.views} and sheet.view("detail Z").scale == 10.0
    assert [note.lines for note in sheet.notes[1:]] == [("Mark the north pole.",)]
    assert sheet.notes[1].at == pytest.approx((60.0, 200.0)) and "- Handle with gloves." in sheet.notes[0].lines
    without = magnet(tmp_path, CHANGES.replace('["7 mm", "-3 mm"]', '["0 mm", "0 mm"]'), f"magnet.length={length}")
    here, there = dimension(sheet, "length").line_at, dimension(without, "length").line_at
    assert (here[0] - there[0], here[1] - there[1]) == pytest.approx((7.0, -3.0), abs=1e-6)


def test_sections_along_several_planes_are_stated(tmp_path: Path) -> None:
    places = '[["0 mm", "0 mm", "0 mm"], ["8 mm", "0 mm", "1 mm"]]'
    text = f'[magnet]\nsection = [{{letter = "K", projection = "front", at = {places}}}, '
    text += '{letter = "L", projection = "front", at = ["0 mm", "0 mm", "0 mm"], kind = "half"}]'
    sheet = magnet(tmp_path, text)
    offset, half = (sheet.view(f"section {letter}-{letter}").cut for letter in "KL")
    assert offset and offset.changes == pytest.approx((4.0,)) and half and half.kind == "half"
    marks = {mark.letter: mark for mark in sheet.annotations if isinstance(mark, SectionMark)}
    assert len(marks["K"].corners) == 2 and len(marks["L"].corners) == 1


def test_what_no_longer_applies_is_reported_and_the_rest_done(tmp_path: Path) -> None:
    assert magnet(tmp_path, CHANGES).unapplied == (
        "sheets.toml: [magnet] no dimension 'radius' on the sheet; allowed: edge chamfer, height, length, thickness",
    )


@pytest.mark.parametrize(("text", "says"), cases("mistakes", "sheet_overrides"))
def test_a_mistake_is_one_clear_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "sheets.toml"
    path.write_text(text)
    refused(re.escape(says), read_overrides, path, ["magnet", "tip"])


@pytest.mark.parametrize("paper", list(PAPERS))
def test_the_frame_stands_within_the_paper_and_its_zones_are_named(paper) -> None:
    width, height = PAPERS[paper]
    names = [ink.text for ink in frame(paper) if isinstance(ink, Text)]
    x0, y0, x1, y1 = drawing_space(paper)
    assert (x0, y0, width - x1, height - y1) == (20.0, 10.0, 10.0, 10.0)
    assert sorted(set(names)) == sorted(name for name in set(names) if names.count(name) == 2)
    assert {"A", "B", "1", "2"} <= set(names) and not {"I", "O"} & set(names)
    assert {"A3": 14, "A2": 20, "A1": 28}.get(paper, len(set(names))) == len(set(names))


def test_the_title_block_says_everything_within_its_cells() -> None:
    x0, y0, x1, y1 = title_box("A3")
    words = [ink for ink in title_primitives(TITLE, "A3") if isinstance(ink, Text)]
    text = " ".join(word.text for word in words)
    fields = ("FILE_NAME", "PLATE", "1:2", "MM", "2 of 3", "Al 6061-T651", "1.25 kg", "a1b2c3d4", "X.XX", "±0.01")
    assert all(field in text for field in (*fields, "ANGLE", "±0.5°"))
    boxes = [text_box(word) for word in words]
    assert all(x0 <= box[0] and y0 <= box[1] and box[2] <= x1 and box[3] <= y1 for box in boxes)
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_fields_scales_and_free_areas_of_the_frame() -> None:
    long = replace(TITLE, material="Pure iron, magnetically soft, annealed in hydrogen, twice, and slowly cooled")
    x0, *_ = title_box("A3")
    word = next(ink for ink in title_primitives(long, "A3") if isinstance(ink, Text) and ink.text == long.material)
    assert text_box(word)[2] <= x0 + 66.0
    scales = {1.0: "1:1", 0.5: "1:2", 0.2: "1:5", 0.25: "1:4", 2.0: "2:1", 0.35: "0.350"}
    assert {scale: scale_text(scale) for scale in scales} == scales
    area = sheet_area("A3")
    assert area.taken[0] == title_box("A3") and math.isclose(area.space[0], 25.0)
