"""Masses between the solids of a sweep: as those of solids there, and solids everywhere where they are not smooth."""

from __future__ import annotations

import json

import numpy as np
import pytest

from designcalc.checks.run import run_checks
from designcalc.checks.sweep import SOLIDS, combinations, grid_table, masses_over, read_range, run_points
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import MassProperties, PartMasses
from stagecad.solids.assembly.built_machine import body_masses


def test_each_point_is_the_design_with_both_values() -> None:
    base = load_design()
    ranges = [read_range(text, base) for text in ("tip.nose_radius=10 mm:30 mm:2", "stage.travel=200 mm:300 mm:2")]
    found = combinations(ranges)
    assert found == [(10.0, 200.0), (10.0, 300.0), (30.0, 200.0), (30.0, 300.0)]
    load = lambda *words: load_design(None, words)  # noqa: E731
    points = run_points(ranges, found, load, base, None)
    assert [bool(point.refused) for point in points] == [False, True, False, True]
    alone = run_checks(load_design(None, ["tip.nose_radius=30 mm"]))
    assert [check.margin for check in points[2].checks] == [check.margin for check in alone]
    document = grid_table(ranges, points)
    json.dumps(document)
    assert document["points"][2]["values"] == [{"value": 0.03, "unit": "m"}, {"value": 0.2, "unit": "m"}]
    assert document["points"][1]["failing"] is None and "run off the way" in document["points"][1]["refused"]
    assert document["checks"]["tip contact pressure"]["verdict"][::2] == ["fails", "passes"]


def test_ranges_that_make_no_grid() -> None:
    base = load_design()
    one = read_range("tip.nose_radius=10 mm:30 mm:200", base)
    with pytest.raises(InputError, match="given twice"):
        combinations([one, one])
    with pytest.raises(InputError, match="40000 combinations; at most 10000"):
        combinations([one, read_range("stage.thickness=10 mm:30 mm:200", base)])


VALUES = np.linspace(1.0, 2.0, 50)


def plate(thickness: float, hole: float) -> PartMasses:
    """A plate of 1 m by 1 m with a blind hole of depth 1.5 m, which goes through thinner plates."""
    volume = thickness - hole * min(thickness, 1.5)
    centre = (0.5 * thickness**2 - hole * 0.5 * min(thickness, 1.5) ** 2) / volume
    one = MassProperties(volume, volume, (0, 0, centre), np.eye(3) * volume, ((0, 0, 0), (1, 1, thickness)))
    return PartMasses({"plate": one})


@pytest.mark.parametrize("hole, most", [(0.1, 30), (0.0, SOLIDS)])
def test_few_solids_give_the_masses_of_all(hole: float, most: int) -> None:
    made: list[int] = []

    def masses_at(place: int) -> PartMasses:
        made.append(place)
        return plate(VALUES[place], hole)

    found = masses_over(VALUES.tolist(), masses_at)
    assert len(made) == len(set(made)) <= most
    for value, one in zip(VALUES, found, strict=True):
        assert isinstance(one, PartMasses)
        expected = plate(value, hole).parts["plate"]
        assert one.parts["plate"].mass == pytest.approx(expected.mass, rel=1e-7)
        assert one.parts["plate"].centre_of_mass == pytest.approx(expected.centre_of_mass, abs=1e-7)


def test_a_value_without_a_solid_has_its_reason() -> None:
    def masses_at(place: int) -> PartMasses:
        if VALUES[place] > 1.7:
            raise InputError("no solid")
        return plate(VALUES[place], 0.0)

    found = masses_over(VALUES.tolist(), masses_at)
    assert [isinstance(one, str) for one in found] == [bool(value > 1.7) for value in VALUES]


def test_whole_numbers_have_their_own_solids() -> None:
    made: list[int] = []
    masses_over(list(range(20)), lambda place: made.append(place) or plate(1.0, 0.0), interpolate=False)
    assert made == list(range(20))


@pytest.mark.slow
def test_the_stage_between_solids_weighs_what_its_solid_weighs() -> None:
    values = np.linspace(11.0, 13.0, 9).tolist()
    made: list[int] = []

    def masses_at(place: int):
        made.append(place)
        return body_masses(load_design(None, [f"stage.thickness={values[place]} mm"]))

    found = masses_over(values, masses_at)
    place = min(set(range(9)) - set(made))
    exact = masses_at(place)
    assert not isinstance(found[place], str)
    assert found[place].moving.mass == pytest.approx(exact.moving.mass, rel=1e-8)
    assert np.allclose(found[place].moving.inertia, exact.moving.inertia, rtol=0, atol=1e-9)
