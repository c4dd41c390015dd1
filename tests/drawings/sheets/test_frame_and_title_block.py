"""Frame, title block and free area of a sheet; how scales are written."""

import math
from dataclasses import replace

import pytest

from drawings.annotations.annotation_geometry import text_box
from drawings.annotations.primitives import Text
from drawings.sheets.frame import PAPERS, drawing_space, frame
from drawings.sheets.sheet import scale_text, sheet_area
from drawings.sheets.title_block import title_box, title_primitives
from tests.drawings.plate_sheet import TITLE


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
    boxes = [text_box(word) for word in words]
    assert all(x0 <= box[0] and y0 <= box[1] and box[2] <= x1 and box[3] <= y1 for box in boxes)
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_long_fields_shrink_rather_than_leave_their_cell() -> None:
    long = replace(TITLE, material="Pure iron, magnetically soft, annealed in hydrogen, twice, and slowly cooled")
    x0, *_ = title_box("A3")
    word = next(ink for ink in title_primitives(long, "A3") if isinstance(ink, Text) and ink.text == long.material)
    assert text_box(word)[2] <= x0 + 66.0


def test_scales_as_they_are_written() -> None:
    scales = {1.0: "1:1", 0.5: "1:2", 0.2: "1:5", 0.25: "1:4", 2.0: "2:1", 0.35: "0.350"}
    assert {scale: scale_text(scale) for scale in scales} == scales


def test_the_free_area_leaves_out_the_title_block() -> None:
    area = sheet_area("A3")
    assert area.taken[0] == title_box("A3")
    assert math.isclose(area.space[0], 25.0)
