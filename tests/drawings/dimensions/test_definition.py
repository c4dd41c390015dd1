"""Completeness of definition: complete on the parts of the thesis, and every dimension that is left out is missed."""

from dataclasses import replace
from functools import cache

import cadquery as cq
import pytest

from drawings.dimensions.definition import Definition, Notes, definition, notes_on_shape
from stagecad.friction_stage.construction import MADE, part_definition
from stagecad.parameters.dimension import Dimension, Point
from stagecad.parameters.load import load_design
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.drawn import described, thesis

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def linear(name: str, first: Point, second: Point, along: Point, value: float) -> Dimension:
    return Dimension(name, "linear", value, f"block.{name}", (first, second), along, "X.X")


BLOCK = cq.Solid.makeBox(40, 30, 10).cut(cq.Solid.makeCylinder(3, 10, cq.Vector(10, 8, 0))).Solids()[0]
DIMENSIONS = (
    linear("length", (0, 5, 5), (40, 5, 5), X, 40.0),
    linear("width", (5, 0, 5), (5, 30, 5), Y, 30.0),
    linear("height", (5, 5, 0), (5, 5, 10), Z, 10.0),
    linear("hole along", (0, 5, 5), (10, 8, 5), X, 10.0),
    linear("hole across", (5, 0, 5), (10, 8, 5), Y, 8.0),
    Dimension("hole", "diameter", 6.0, "block.hole", ((10, 8, 5),), Z, "X.X"),
)


def of_block(*dimensions: Dimension) -> Definition:
    return definition(DimensionVerifier(BLOCK), dimensions, (), Notes())


def test_a_block_with_a_hole_is_defined_by_six_dimensions() -> None:
    assert of_block(*DIMENSIONS).problems == ()


@pytest.mark.parametrize("left_out", range(len(DIMENSIONS)))
def test_every_dimension_that_is_left_out_is_missed(left_out: int) -> None:
    rest = [d for number, d in enumerate(DIMENSIONS) if number != left_out]
    assert of_block(*rest).problems


def test_a_dimension_given_twice_is_reported() -> None:
    again = linear("hole from the far end", (10, 8, 5), (40, 5, 5), X, 30.0)
    assert of_block(*DIMENSIONS, again).problems == ("the dimension 'hole from the far end' follows from others",)
    assert of_block(*DIMENSIONS, replace(again, reference=True)).problems == ()


def test_symmetry_of_the_notes_places_both_ends() -> None:
    solid = cq.Solid.makeBox(40, 30, 10, cq.Vector(-20, -15, 0))
    dimensions = (
        linear("length", (-20, 5, 5), (20, 5, 5), X, 40.0),
        linear("width", (5, -15, 5), (5, 15, 5), Y, 30.0),
        linear("height", (5, 5, 0), (5, 5, 10), Z, 10.0),
    )
    found = definition(DimensionVerifier(solid), dimensions, (), Notes("xy"))
    assert found.problems == ()


@cache
def of_part(name: str) -> tuple[DimensionVerifier, tuple[Dimension, ...]]:
    part = described(name, thesis())
    return DimensionVerifier(part.solid), part.dimensions


@pytest.mark.parametrize("name", MADE)
def test_the_parts_of_the_thesis_are_defined_completely(name: str) -> None:
    verifier, dimensions = of_part(name)
    notes = notes_on_shape(part_definition(name), thesis())
    assert definition(verifier, dimensions, (), notes).problems == ()


@pytest.mark.parametrize(
    ("name", "left_out"),
    [
        ("stage", "iron pocket width"),
        ("stage", "thickness"),
        ("holder", "floor"),
        ("holder", "lead slot width"),
        ("tip", "arm width"),
        ("bearing_way", "flange thickness"),
        ("height_pin_1", "spigot length"),
        ("tooth_bar", "channel width"),
    ],
)
def test_a_dimension_left_out_of_a_part_is_missed(name: str, left_out: str) -> None:
    verifier, dimensions = of_part(name)
    rest = [d for d in dimensions if d.name != left_out and left_out.removesuffix("s") not in d.derived_from]
    rest = [d for d in rest if not (left_out == "floor" and d.name == "well floor")]
    assert len(rest) < len(dimensions)
    notes = notes_on_shape(part_definition(name), thesis())
    assert definition(verifier, rest, (), notes).problems


@pytest.mark.parametrize(
    "name, override",
    [
        ("base", "base.length=365.2 mm"),
        ("tooth_iron", "teeth.per_iron=1"),
        ("tooth_iron", "teeth.per_iron=3"),
        ("tooth_bar", "teeth.per_iron=1"),
        ("tooth_bar", "teeth.per_iron=3"),
    ],
)
def test_parts_of_other_designs_are_defined_completely(name: str, override: str) -> None:
    # In the thesis's base the floor of a counterbore lies at the level of another face.
    design = load_design(overrides=[override])
    part = described(name, design)
    notes = notes_on_shape(part_definition(name), design)
    assert definition(DimensionVerifier(part.solid), part.dimensions, part.requirements, notes).problems == ()
