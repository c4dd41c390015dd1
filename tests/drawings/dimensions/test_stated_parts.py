"""The check of definition holds for parts of a user's own: what a sheet leaves open is a hit."""

from pathlib import Path

import pytest

from drawings.dimensions.definition import HEADINGS
from tests.drawings.own_parts import PARTS, draw_part, hits_of


def test_more_holes_than_the_solid_has_and_unlike_holes_are_refused(tmp_path: Path) -> None:
    hits = hits_of(tmp_path, "three")
    assert "'hole' is given for 3 features, the solid has 2 of this diameter" in hits
    two = hits_of(tmp_path, "three", ("count=3", "count=2"))
    assert "'hole' is one dimension for holes that go through and holes that do not" in two


def test_a_slot_without_dimensions_is_named_face_by_face(tmp_path: Path) -> None:
    hits = hits_of(tmp_path, "undef")
    assert [hit for hit in hits if "is not defined" in hit] == hits
    assert "the place of face 13 (plane at 0, 10, 5) is not defined" in hits
    assert {int(hit.split("face ")[1].split()[0]) for hit in hits} == {9, 10, 11, 12, 13}
    rows = (tmp_path / "undef_definition.csv").read_text("utf-8").splitlines()
    assert rows[0] == ",".join(HEADINGS) and len(rows) == 14


@pytest.mark.parametrize(("name", "faces"), [("fx_base", {16, 17, 18, 19}), ("keyshaft", {4, 6})])
def test_a_slot_without_a_place_along_its_row_is_named(name: str, faces: set[int], tmp_path: Path) -> None:
    hits = hits_of(tmp_path, name)
    assert {int(hit.split("face ")[1].split()[0]) for hit in hits} == faces


def test_windows_without_size_and_place_are_named(tmp_path: Path) -> None:
    hits = hits_of(tmp_path, "fx_block")
    assert len(hits) == 8 and all(hit.startswith("the place of face") for hit in hits)


def test_a_view_that_a_declaration_names_is_drawn(tmp_path: Path) -> None:
    document = draw_part(
        tmp_path, "fx_shaft", ('"head", (0, 0, 3), Z, Y, view="front"', '"head", (0, 0, 3), Z, Y, view="right"')
    )
    (sheet,) = document["sheets"]
    assert "bottom" in sheet["views"] and sheet["hits"] == []
    manifold = draw_part(tmp_path, "manifold")
    assert {"left", "back"} <= set(manifold["sheets"][0]["views"])


def test_a_dimension_that_its_view_does_not_show_is_reported(tmp_path: Path) -> None:
    hits = hits_of(tmp_path, "fx_shaft")
    assert hits == ["'head' is declared for the view 'front', which does not show it: it is in 'right'"]
    wrong = hits_of(tmp_path, "fx_shaft", ('view="bottom"', 'view="top"'))
    assert "'thread drill' is not seen in the view 'top'" in wrong or any("is not seen in" in hit for hit in wrong)


def test_a_circle_of_holes_is_one_dimension(tmp_path: Path) -> None:
    lines = (PARTS / "housing.py").read_text("utf-8").splitlines()
    (linear,) = [line for line in lines if '"bolt circle"' in line]
    circle = '    d.pitch_circle("bolt circle", "pcd", (0, 0, t), (p.pcd / 2, 0, 5), 6, view="top")'
    assert hits_of(tmp_path, "housing")
    assert hits_of(tmp_path, "housing", (linear, circle)) == []


def test_a_form_that_its_orientation_includes_and_a_rough_fit_are_reported(tmp_path: Path) -> None:
    """A flatness as large as the perpendicularity of its face, and Ra 3.2 on a 6 H7 (12 um)."""
    (line,) = [one for one in (PARTS / "fx_block.py").read_text("utf-8").splitlines() if "f.tolerance(" in one]
    flat = line.replace("perpendicularity", "flatness").replace(', datums=("A",)', "").replace('"leaf"', '"leaf face"')
    hits = hits_of(tmp_path, "fx_block", (line, f"{line}\n{flat}"))
    assert any(hit.startswith("the flatness") and "is not smaller than its perpendicularity" in hit for hit in hits)
    fit = hits_of(tmp_path, "undef", ('"hole": "6.6 mm"', '"hole": {"value": "6.6 mm", "tolerance": "H7"}'))
    assert "Ra 3.2 of 'hole' is too rough for its tolerance of 0.015 mm: Ra 1.9 at most" in fit


def test_sheets_toml_adds_a_section_and_a_view_to_a_part(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    (tmp_path / "source" / "sheets.toml").write_text(
        '[manifold]\nview = [{projection = "bottom"}]\n'
        'section = [{letter = "B", projection = "right", at = ["12 mm", "0 mm", "0 mm"]}]\n',
        "utf-8",
    )
    (sheet,) = draw_part(tmp_path, "manifold")["sheets"]
    assert {"bottom", "section B-B"} <= set(sheet["views"])
