"""Grids of several sweeps."""

from __future__ import annotations

import json

import pytest

from designcalc.checks.run import run_checks
from designcalc.checks.sweep import combinations, grid_table, read_range, run_points
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design


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
