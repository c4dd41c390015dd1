"""Proposals for parts of which dimensions do not give every face, and faces of one radius of different kinds."""

from pathlib import Path

import cadquery as cq
import pytest

from drawings.recognition.proposal import propose
from tests.drawings.recognition.proposals import W, proposal_of, values, verifier_of
from tests.refusals import refused
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file

OUT_OF_REACH = """
import cadquery as cq
body = cq.Workplane().box(60, 40, 20)
show_object(body.cut(cq.Workplane().box(9.2, 7.7, 4.4).rotate((0, 0, 0), (1, 2, 3), 33)), name="void")
"""
"""A void within a block at no angle to its axes, which no view shows."""


def test_holes_have_a_diameter_beside_notches_of_their_radius() -> None:
    rows = [(x, y) for x in range(-30, 35, 5) for y in (-15, -10, 10, 15)]
    board = W().box(70, 30, 3).pushPoints([*rows, *((x, y) for y in range(-10, 15, 5) for x in (30, 35))]).hole(2)
    found = proposal_of(board.pushPoints([(x, y) for x in (-30, 30) for y in (-10, 10)]).hole(4))
    assert values(found, "diameter") == [(2.0, 25), (4.0, 4)] and values(found, "radius") == [(1.0, 31)]


def test_a_dome_over_a_bore_of_its_radius() -> None:
    body = W().box(40, 40, 20).faces("<Z").workplane().hole(10, 12)
    found = proposal_of(body.union(W().sphere(5).translate((0, 0, 10))))
    assert values(found, "diameter") == [(10.0, 1)] and values(found, "radius") == [(5.0, 1)]


def test_a_distance_from_a_centre_line_is_shown() -> None:
    """The end of a rib beside a boss, whose axis is drawn in the view from the side."""
    body = W().circle(30).extrude(8).faces(">Z").workplane().circle(12).extrude(20)
    body = body.union(W("XZ").polyline([(10, 8), (26, 8), (10, 24)]).close().extrude(2, both=True))
    found = proposal_of(body.edges(cq.selectors.BoxSelector((-29, -29, 7.9), (29, 29, 8.1))).fillet(1.5))
    assert (26.0, 1) in values(found, "linear") and not found.undefined


def test_each_of_several_slanting_holes_has_its_angle() -> None:
    plate = W().box(40, 40, 2.5).faces(">Z").workplane()
    plate = plate.transformed(offset=cq.Vector(0, -15, 10), rotate=cq.Vector(60, 0, 0))
    found = propose(verifier_of(plate.rect(15, 15, forConstruction=True).vertices().hole(2.5)))
    assert {value for value, _ in values(found, "angle")} == {30.0}  # against the plate
    assert len({one.key for one in found.dimensions}) == len(found.dimensions)
    assert all(one.key.isidentifier() for one in found.dimensions)


@pytest.mark.slow
def test_faces_that_no_view_shows_are_given_by_the_model_as_the_file_says(tmp_path: Path) -> None:
    (tmp_path / "void.py").write_text(OUT_OF_REACH, "utf-8")
    (document,) = draw_file(tmp_path / "void.py", Design(), True, tmp_path)
    assert [hit for sheet in document["sheets"] for hit in sheet["hits"]] == []
    (question,) = [one for one in document["questions"] if "no dimension gives" in one]
    assert question.count("plane at") == 6
    file = tmp_path / "void_proposed.py"
    text = file.read_text("utf-8")
    first = text.partition("FACES_BY_MODEL = (\n")[2].partition("\n")[0]
    file.write_text(text.replace(f"{first}\n", "", 1), "utf-8")
    (again,) = draw_file(file, Design(), True, tmp_path / "again")
    hits = [hit for sheet in again["sheets"] for hit in sheet["hits"]]
    assert hits and all(first.strip(" ',") in hit for hit in hits)
    file.write_text(text.replace(first, "    'plane near the middle',", 1), "utf-8")
    refused("FACES_BY_MODEL", draw_file, file, Design(), True, tmp_path / "again")


@pytest.mark.slow
def test_what_the_drawn_sheet_does_not_show_is_given_by_the_model(tmp_path: Path) -> None:
    """A dimple within the block, whose arc is in no view from outside."""
    script = "import cadquery as cq\nball = cq.Workplane().sphere(3).translate((0, 0, 6))\n"
    (tmp_path / "dimple.py").write_text(f"{script}show_object(cq.Workplane().box(20, 20, 10).cut(ball))\n", "utf-8")
    (document,) = draw_file(tmp_path / "dimple.py", Design(), True, tmp_path)
    assert [hit for sheet in document["sheets"] for hit in sheet["hits"]] == []
    assert ["sphere at 0, 0, 9" in one for one in document["questions"]] == [True]
