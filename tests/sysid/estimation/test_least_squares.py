"""Bounded robust least squares: certified regressions, bounds, zero columns, outliers, priors and Jacobian updates."""

from collections.abc import Callable

import numpy as np
import pytest

from sysid.estimation.least_squares import least_squares, robust_scale
from sysid.experiment.known import Prior, Unknown
from tests.reference.tables import reference

REFERENCE = reference("nonlinear_regression")


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


def test_bounds_and_zero_columns_do_not_stall_a_fit() -> None:
    x = np.linspace(0, 1, 50)
    unknowns = [Unknown("a", 0.0, -9.0, 9.0, 1.0), Unknown("b", 1.0, 0.0, 9.0, 1.0)]
    found = least_squares(lambda p: 2.0 - 3.0 * x - (p[0] + p[1] * x), unknowns, robust=False)
    assert found.values["b"] == 0.0
    assert found.at_bound == ("b",)
    assert found.values["a"] == pytest.approx(0.5)
    unknowns = [Unknown("a", 0.0, -9, 9, 1.0), Unknown("nothing", 1.0, -9, 9, 1.0)]
    found = least_squares(lambda p: 2.0 * x - p[0] * x, unknowns, robust=False)
    assert found.values["a"] == pytest.approx(2.0)
    assert found.inactive == ("nothing",)


@pytest.mark.filterwarnings("error")
def test_a_column_that_overflows_is_left_out() -> None:
    x = np.linspace(0.0, 1.0, 50)
    unknowns = [Unknown("a", 0.0, -9.0, 9.0, 1.0), Unknown("huge", 0.0, -9.0, 9.0, 1.0)]
    found = least_squares(lambda p: 2.0 * x - p[0] * x - 1e180 * p[1], unknowns, robust=False)
    assert found.values == {"a": pytest.approx(2.0), "huge": 0.0}


def test_outliers_do_not_shift_the_fit() -> None:
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 1, 400)
    y = 3.0 * x + rng.normal(scale=0.01, size=400)
    y[::20] += 5.0
    unknowns = [Unknown("a", 0, -9, 9, 1), Unknown("b", 0, -9, 9, 1)]
    found = least_squares(lambda p: (y - p[0] * x - p[1]) / 0.01, unknowns)
    assert found.values["a"] == pytest.approx(3.0, abs=0.01)
    assert found.values["b"] == pytest.approx(0.0, abs=0.005)


def test_priors_act_as_measurements_and_more_where_the_model_is_wrong() -> None:
    x = np.linspace(-1, 1, 50)
    y = 3.0 * x + 0.5 + np.random.default_rng(1).normal(size=50)
    known = Prior(2.0, 0.2)
    unknowns = [Unknown("a", 0, -9, 9, 1, known), Unknown("b", 0, -9, 9, 1)]
    found = least_squares(lambda p: y - p[0] * x - p[1], unknowns, robust=False, tolerance=1e-12)
    # One more row of the regression: a / 0.2 = 2.0 / 0.2.
    rows = np.vstack([np.column_stack([x, np.ones(50)]), [1.0 / known.std, 0.0]])
    wanted = np.linalg.lstsq(rows, np.append(y, known.value / known.std), rcond=None)[0]
    assert list(found.values.values()) == pytest.approx(wanted, rel=1e-6)
    x = np.linspace(-1, 1, 401)
    pattern = 30.0 * x**3

    def slope(prior: Prior | None) -> float:
        found = least_squares(lambda p: 3.0 * x + pattern - p[0] * x, [Unknown("a", 0, -99, 99, 1, prior)])
        return found.values["a"]

    # A missing cubic, 13 deviations strong, would be taken for slope: what is known of the slope outweighs it.
    assert slope(None) > 15.0
    assert slope(Prior(3.0, 0.1)) == pytest.approx(3.0, abs=0.7)


def test_scales_that_overflow_and_channels_at_rest() -> None:
    # A noise given as 1e-300 N makes deviations of such a size.
    x = np.linspace(0, 1, 50)
    unknowns = [Unknown("a", 0.5, -9.0, 9.0, 1.0), Unknown("b", 1.0, 0.0, 9.0, 1.0, Prior(1.0, 1e-200))]
    with np.errstate(over="ignore", invalid="ignore"):
        found = least_squares(lambda p: 1e160 * (2.0 * x - p[0] * x - (p[1] - 1.0)), unknowns)
    assert found.values["b"] == pytest.approx(1.0)
    assert np.isfinite(found.values["a"])
    residual = np.random.default_rng(1).standard_normal(4000)
    assert robust_scale(np.concatenate([residual, np.zeros(6000)])) == pytest.approx(1.0, abs=0.05)
    assert robust_scale(np.zeros(3)) == 1.0


def _misra(asked: list[np.ndarray]) -> tuple[Callable[[np.ndarray], np.ndarray], list[Unknown], dict[str, np.ndarray]]:
    """Residual and unknowns of a published problem, and its exact columns at the start of the fit."""
    data = REFERENCE["misra1a"]
    x, y = np.array(data["x"]), np.array(data["y"])

    def residual(b: np.ndarray) -> np.ndarray:
        asked.append(b)
        return y - b[0] * (1.0 - np.exp(-b[1] * x))

    first, second = data["start_2"]
    unknowns = [Unknown(f"b{k}", value, -np.inf, np.inf, value) for k, value in enumerate((first, second))]
    return residual, unknowns, {"b0": np.exp(-second * x) - 1.0, "b1": -first * x * np.exp(-second * x)}


def test_the_jacobian_is_updated_and_recomputed_at_the_end_if_asked() -> None:
    x = np.array(REFERENCE["misra1a"]["x"])
    residual, unknowns, _ = _misra(asked := [])
    found = least_squares(residual, unknowns, robust=False, tolerance=1e-12)
    point = np.array(list(found.values.values()))
    exact = np.column_stack([np.exp(-point[1] * x) - 1.0, -point[0] * x * np.exp(-point[1] * x)])
    assert found.jacobian == pytest.approx(exact, rel=1e-4)
    # Measured at every step, the columns alone would ask for the residual twice a step.
    assert found.iterations >= 3
    assert len(asked) < 3 * found.iterations + 1
    residual, unknowns, columns = _misra([])
    short = least_squares(residual, unknowns, robust=False, iterations=2, known=columns, final_jacobian=False)
    anew = least_squares(residual, unknowns, robust=False, iterations=2, known=columns)
    assert short.values == anew.values
    assert anew.exact and not short.exact
    assert not np.allclose(short.jacobian, anew.jacobian, rtol=1e-3)


@pytest.mark.parametrize("wrong_by", [1.0, 0.5, -1.0])
def test_initial_jacobian_only_saves_evaluations(wrong_by: float) -> None:
    certified = REFERENCE["misra1a"]["certified"]
    residual, unknowns, columns = _misra(asked := [])
    known = {key: wrong_by * column for key, column in columns.items()}
    found = least_squares(residual, unknowns, robust=False, tolerance=1e-12, known=known)
    assert list(found.values.values()) == pytest.approx(certified, rel=1e-6)
    assert found.exact
    if wrong_by == 1.0:
        other, _, _ = _misra(without := [])
        least_squares(other, unknowns, robust=False, tolerance=1e-12)
        assert len(asked) == len(without) - len(unknowns)


@pytest.mark.parametrize("width", [0.0005, 0.03])
def test_one_step_does_not_move_a_positive_value_out_of_the_data(width: float) -> None:
    # With a small amplitude the undamped step in the width of the curve is hundreds of times the width.
    v = np.linspace(0.0, 0.02, 2000)
    y = 1.5 * np.exp(-((v / 0.004) ** 2))
    seen: list[float] = []

    def residual(p: np.ndarray) -> np.ndarray:
        seen.append(p[1])
        return (y - p[0] * np.exp(-((v / p[1]) ** 2))) / 0.01

    unknowns = [Unknown("force", 0.02, 0.0, np.inf, 0.02), Unknown("velocity", width, 1e-9, 1e3, width)]
    found = least_squares(residual, unknowns)
    assert found.values["force"] == pytest.approx(1.5, rel=1e-4)
    assert found.values["velocity"] == pytest.approx(0.004, rel=1e-4)
    ratios = np.abs(np.diff(np.log(seen)))
    assert np.max(ratios) <= 2.0 * np.log(10.0) + 1e-6
