"""Manual changes of sheets: applied, kept when parameters change, reported when they no longer apply."""

from dataclasses import replace
from pathlib import Path

import pytest

from drawings.annotations.annotation import LinearDimension
from drawings.sheets.overrides import read_overrides
from drawings.sheets.part import part_sheets
from drawings.sheets.sheet import Sheet
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from tests.drawings.drawn import described

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
    assert {"left", "detail Z"} <= {view.name for view in sheet.views}
    assert sheet.view("detail Z").scale == 10.0
    assert [note.lines for note in sheet.notes[1:]] == [("Mark the north pole.",)]
    assert sheet.notes[1].at == pytest.approx((60.0, 200.0))
    assert "- Handle with gloves." in sheet.notes[0].lines
    without = magnet(tmp_path, CHANGES.replace('["7 mm", "-3 mm"]', '["0 mm", "0 mm"]'), f"magnet.length={length}")
    here, there = dimension(sheet, "length").line_at, dimension(without, "length").line_at
    assert (here[0] - there[0], here[1] - there[1]) == pytest.approx((7.0, -3.0), abs=1e-6)


def test_what_no_longer_applies_is_reported_and_the_rest_done(tmp_path: Path) -> None:
    assert magnet(tmp_path, CHANGES).unapplied == (
        "sheets.toml: [magnet] the sheet has a view 'top' already",
        "sheets.toml: [magnet] no dimension 'radius' on the sheet; allowed: edge chamfer, height, length, thickness",
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[magnett]\n", "no sheet 'magnett'; did you mean 'magnet'?"),
        ("[magnet]\nsize = 3\n", "no key 'size'"),
        ('[magnet]\npaper = "A9"\n', "allowed: A4, A3, A2, A1"),
        ('[magnet]\nscale = "half"\n', "write it like 1:2 or 5:1"),
        ('[magnet]\nmove = [{dimension = "length"}]\n', "move without 'by'"),
        ('[magnet]\nmove = [{dimension = "length", by = ["1 mm"]}]\n', "write 2 lengths"),
        ('[magnet]\nmove = [{dimension = "length", by = ["1 mm", "2 s"]}]\n', "move"),
        ('[magnet]\nview = [{projection = "above"}]\n', "projection = 'above'"),
        ("[magnet\n", "cannot be read"),
    ],
)
def test_a_mistake_is_one_clear_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "sheets.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_overrides(path, ["magnet", "tip"])
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
