"""The fit: against certified nonlinear regressions, bounds, dead columns and outliers."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from sysid.fit import Unknown, least_squares

REFERENCE = tomllib.loads((Path(__file__).parents[1] / "reference" / "nonlinear_regression.toml").read_text("utf-8"))


@pytest.mark.parametrize("start", ["start_1", "start_2"])
def test_certified_regression_misra1a(start: str) -> None:
    data = REFERENCE["misra1a"]
    x, y = np.array(data["x"]), np.array(data["y"])
    unknowns = [Unknown(f"b{k}", value, -np.inf, np.inf, abs(value)) for k, value in enumerate(data[start])]
    found = least_squares(
        lambda b: y - b[0] * (1.0 - np.exp(-b[1] * x)), unknowns, robust=False, iterations=200, tolerance=1e-14
    )
    assert list(found.values.values()) == pytest.approx(data["certified"], rel=1e-5)
    assert 2.0 * found.cost == pytest.approx(data["residual_sum_of_squares"], rel=1e-6)


def test_bound_is_kept_and_reported() -> None:
    x = np.linspace(0, 1, 50)
    found = least_squares(
        lambda p: 2.0 - 3.0 * x - (p[0] + p[1] * x),
        [Unknown("a", 0.0, -9.0, 9.0, 1.0), Unknown("b", 1.0, 0.0, 9.0, 1.0)],
        robust=False,
    )
    assert found.values["b"] == 0.0
    assert found.at_bound == ("b",)
    assert found.values["a"] == pytest.approx(0.5)


def test_a_dead_column_does_not_stall_the_others() -> None:
    x = np.linspace(0, 1, 50)
    found = least_squares(
        lambda p: 2.0 * x - p[0] * x, [Unknown("a", 0.0, -9, 9, 1.0), Unknown("nothing", 1.0, -9, 9, 1.0)], robust=False
    )
    assert found.values["a"] == pytest.approx(2.0)
    assert found.dead == ("nothing",)


def test_outliers_do_not_pull() -> None:
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 1, 400)
    y = 3.0 * x + rng.normal(scale=0.01, size=400)
    y[::20] += 5.0
    found = least_squares(
        lambda p: (y - p[0] * x - p[1]) / 0.01, [Unknown("a", 0, -9, 9, 1), Unknown("b", 0, -9, 9, 1)]
    )
    assert found.values["a"] == pytest.approx(3.0, abs=0.01)
    assert found.values["b"] == pytest.approx(0.0, abs=0.005)
