"""What holds for every part that is made: one sound solid, its dimensions true and complete, its datums on it."""

from collections.abc import Callable
from functools import cache
from typing import Any

import cadquery as cq
import pytest

from stagecad.friction_stage.construction import MADE, part_definition
from stagecad.parameters.dimension import DatumFeature, Dimension, GeometricTolerance, SurfaceTexture
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.tracking import TrackedDesign
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.thesis_parts import solid_of, thesis

SWITCHES = {"teeth.fitted", "sea.whole_underside"}
"""Which features a part has, not how large they are: they are told by the features' being there."""


@cache
def read_by(name: str) -> frozenset[str]:
    notes: dict[Any, str] = {}
    part_definition(name).build(TrackedDesign(thesis(), notes))
    return frozenset(".".join(str(step[1]) for step in way) for way in notes)


def changed(key: str, factor: float = 1.01) -> str:
    """An override that changes one parameter a little, and none of the values computed from it."""
    entry = thesis().entry(key)
    if isinstance(entry.value, int):
        return f"{key}={entry.value + 1}"
    return f"{key}={entry.value * factor!r} {entry.unit}".strip()


@pytest.mark.parametrize("name", MADE)
def test_one_valid_closed_solid_with_its_datums_and_thread_depths(name: str) -> None:
    solid = solid_of(name)
    assert isinstance(solid, cq.Solid) and solid.isValid()
    assert len(solid.Shells()) == 1 and solid.Shells()[0].Closed() and solid.Volume() > 0
    # A datum of a face has material behind it and none before it; one of an axis or plane lies in the air.
    for datum in part_definition(name).datums(thesis()).values():
        x, y, z = datum.origin
        at = cq.Vertex.makeVertex(x, y, z)
        if solid.distance(at) > 1e-6 or not _on_surface(solid, at):
            continue
        ahead = tuple(p + 1e-3 * n for p, n in zip(datum.origin, datum.normal, strict=True))
        assert not solid.isInside(cq.Vector(*ahead), 1e-6), f"{datum.name} points into the material"  # pyright: ignore[reportAttributeAccessIssue]
    dimensions = {dimension.name: dimension for dimension in part_definition(name).dimensions(thesis())}
    for dimension in list(dimensions.values()):
        if dimension.kind == "thread_depth":
            assert dimensions[f"{dimension.feature} drill depth"].value > dimension.value and dimension.note


@pytest.mark.parametrize("name", MADE)
def test_dimensions_measure_as_declared_and_agree_with_their_parameters(name: str) -> None:
    gauge = DimensionVerifier(solid_of(name))
    wrong = []
    for dimension in part_definition(name).dimensions(thesis()):
        measured = gauge.measure(dimension)
        if measured is not None and abs(measured - dimension.value) > 1e-6:
            wrong.append((dimension.name, dimension.value, measured))
    assert wrong == []
    dimensions = part_definition(name).dimensions(thesis())
    assert len({dimension.name for dimension in dimensions}) == len(dimensions)
    for dimension in dimensions:
        assert dimension.view != "any"
        if dimension.derived_from:
            assert set(dimension.derived_from) <= read_by(name)
            continue
        assert dimension.parameter in packaged_machine().schema()
        assert dimension.value == pytest.approx(float(thesis().value(dimension.parameter)), abs=1e-12)


@pytest.mark.parametrize("name", MADE)
def test_every_parameter_that_shapes_the_part_is_declared_once_and_only_once(name: str) -> None:
    own = [dimension for dimension in part_definition(name).dimensions(thesis()) if not dimension.derived_from]
    # The callout of each tapped hole is complete: a tap drill is declared once for each feature with its thread.
    declared = [(dimension.parameter, dimension.feature if dimension.kind == "tap_drill" else "") for dimension in own]
    assert sorted(declared) == sorted(set(declared))
    assert read_by(name) - SWITCHES <= {parameter for parameter, _ in declared}
    # What is declared and does not shape the solid is the depth of a thread, which is cosmetic.
    rest = {dimension for dimension in own if dimension.parameter not in read_by(name)}
    assert all(dimension.kind == "thread_depth" for dimension in rest)


@pytest.mark.parametrize("name", MADE)
def test_requirements_stand_on_faces_of_the_solid_and_refer_to_its_datums(name: str) -> None:
    required = getattr(part_definition(name), "requirements", lambda _: ())(thesis())
    letters = {requirement.letter for requirement in required if isinstance(requirement, DatumFeature)}
    for requirement in required:
        if isinstance(requirement, GeometricTolerance):
            assert set(requirement.datums) <= letters
        median = isinstance(requirement, DatumFeature) and requirement.median
        # The faces of a middle plane look in opposite directions; all others in that of the requirement.
        outward = [(1.0, -1.0)[index] if median else 1.0 for index in range(len(requirement.points))]
        assert len(outward) == 2 or not median
        for point, sign in zip(requirement.points, outward, strict=True):
            on = [face for face in solid_of(name).Faces() if face.distance(cq.Vertex.makeVertex(*point)) < 1e-6]
            if isinstance(requirement, SurfaceTexture) or not requirement.round:
                (face,) = on
                normal = face.normalAt(cq.Vector(*point)).toTuple()
                assert normal == pytest.approx([sign * n for n in requirement.normal], abs=1e-6)
            else:
                bore = Dimension("bore", "diameter", 1.0, "any", (point,), requirement.normal)
                assert DimensionVerifier(solid_of(name)).measure(bore)


@pytest.mark.parametrize("name", MADE)
def test_the_solid_follows_every_parameter_at_once(name: str) -> None:
    """Each parameter changed by its own small factor: the solid measures as the new values say, everywhere."""
    module = part_definition(name)
    keys = sorted(key for key in read_by(name) - SWITCHES if not isinstance(thesis().value(key), int))
    factors = {key: 1 + 0.002 * (1 + index / len(keys)) for index, key in enumerate(keys)}
    design = load_design(overrides=[changed(key, factors[key]) for key in keys], rules=False)
    solid = module.build(design)
    assert solid.isValid()
    gauge = DimensionVerifier(solid)
    for dimension in module.dimensions(design):
        measured = gauge.measure(dimension)
        if dimension.parameter in factors:
            assert dimension.value == pytest.approx(thesis().value(dimension.parameter) * factors[dimension.parameter])
        if measured is not None:
            assert measured == pytest.approx(dimension.value, abs=1e-6), dimension.name


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_each_parameter_changes_the_solid_and_its_dimension_follows(name: str) -> None:
    module, before = part_definition(name), solid_of(name)
    for key in sorted(read_by(name) - SWITCHES):
        if key == "pads.count":
            continue  # four pads are a test of their own
        design = load_design(overrides=[changed(key)], rules=False)
        after = module.build(design)
        assert _signature(after) != _signature(before), f"{key} is read, but the solid stays as it is"
        shown = next(dimension for dimension in module.dimensions(design) if dimension.parameter == key)
        measured = DimensionVerifier(after).measure(shown)
        assert measured == pytest.approx(design.value(key), abs=1e-6), key


def _signature(solid: Any) -> tuple[float, ...]:
    """Volume and moments of inertia: no two different sizes or places share all of them."""
    centre, moments = solid.Center(), cq.Shape.matrixOfInertia(solid)
    first = [round(value, 7) for value in (solid.Volume(), *centre.toTuple())]
    return (*first, *(round(m, 3) for r in moments for m in r))


def _on_surface(solid: cq.Shape, at: cq.Vertex) -> bool:
    return min(face.distance(at) for face in solid.Faces()) < 1e-6


def test_a_gauge_finds_a_wrong_dimension() -> None:
    """The measurement is of the solid, not of the declaration: another solid's dimension does not fit this one."""
    longer = load_design(overrides=["stage.payload_pitch=51 mm"], rules=False)
    stage: Callable[[Any], tuple[Dimension, ...]] = part_definition("stage").dimensions
    gauge = DimensionVerifier(solid_of("stage"))
    pitch = next(d for d in stage(longer) if d.parameter == "stage.payload_pitch")
    with pytest.raises(LookupError):
        gauge.measure(pitch)
