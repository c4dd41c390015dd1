"""The assembly's sheet: a balloon for each row of the parts list, on what it names, and none over another."""

from __future__ import annotations

import math

import pytest

from drawings.annotation import Balloon
from drawings.annotation_ink import BALLOON
from drawings.assembly_sheet import Assembled, assembly_sheet, spread
from drawings.document import document_of
from drawings.frame import drawing_space
from drawings.ink import Words
from drawings.lint import lint
from drawings.sheet import Sheet
from drawings.view import Segment
from stagecad.parameters.design import Design
from stagecad.solids.machine import Machine
from stagecad.solids.made_assembly import shapes_of


@pytest.fixture(scope="module")
def sheet(machine: Machine, design: Design) -> Sheet:
    shapes = shapes_of(machine.assembly.instances, machine.parts, design)
    assembled = Assembled(
        machine.assembly.instances,
        {name: shape.wrapped for name, shape in shapes.items()},
        machine.bill_of_materials,
        "1 kg",
        "0",
        "0",
    )
    return assembly_sheet(assembled, design)


def test_every_row_of_the_list_has_one_balloon(sheet: Sheet, machine: Machine) -> None:
    numbers = sorted(a.number for a in sheet.annotations if isinstance(a, Balloon))
    assert numbers == [row.item for row in machine.bill_of_materials]


def test_a_balloon_points_at_a_line_that_is_drawn(sheet: Sheet) -> None:
    for balloon in sheet.annotations:
        if isinstance(balloon, Balloon):
            (u, v) = balloon.at
            curves = sheet.view(balloon.view).curves["VISIBLE"]
            near = [
                c
                for c in curves
                if isinstance(c, Segment)
                and math.dist(c.start, (u, v)) + math.dist(c.end, (u, v)) < math.dist(c.start, c.end) + 0.1
            ]
            assert near or any(not isinstance(c, Segment) for c in curves)


def test_balloons_stand_apart_and_within_the_frame(sheet: Sheet) -> None:
    x0, y0, x1, y1 = drawing_space(sheet.paper)
    centres = [a.centre for a in sheet.annotations if isinstance(a, Balloon)]
    for i, one in enumerate(centres):
        assert x0 + BALLOON < one[0] < x1 - BALLOON and y0 + BALLOON < one[1] < y1 - BALLOON
        assert all(math.dist(one, other) > 2 * BALLOON for other in centres[i + 1 :])


def test_the_list_says_what_the_bill_of_materials_says(sheet: Sheet, machine: Machine) -> None:
    words = [ink.text for ink in sheet.tables if isinstance(ink, Words)]
    for row in machine.bill_of_materials:
        assert row.part.replace("_", " ") in words
        assert row.part_number in words
        assert row.material in words
    assert sum(int(words[i + 1]) for i, text in enumerate(words[6:], start=6) if (i - 6) % 6 == 0) == sum(
        row.quantity for row in machine.bill_of_materials
    )


def test_the_cut_is_hatched_and_the_cutting_line_shown(sheet: Sheet) -> None:
    section = sheet.view("section A-A")
    assert section.label == "A-A"
    assert len(section.curves["HATCH"]) > 50
    assert any(type(a).__name__ == "SectionMark" for a in sheet.annotations)


def test_the_sheet_is_free_of_hits(sheet: Sheet) -> None:
    assert [str(hit) for hit in lint(document_of(sheet))] == []


def test_places_are_spread_in_their_order() -> None:
    assert spread([1.0, 2.0, 30.0], 10.0, 0.0, 100.0) == [1.0, 11.0, 30.0]
    assert spread([90.0, 95.0, 99.0], 10.0, 0.0, 100.0) == [80.0, 90.0, 100.0]
    assert spread([], 10.0, 0.0, 1.0) == []
