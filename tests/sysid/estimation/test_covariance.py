"""Intervals of fitted values: textbook covariances, and coverage of a known true value."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import t as student

from sysid.estimation.covariance import Intervals, _student, intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.least_squares import least_squares
from sysid.estimation.misfit import ResidualWeights
from sysid.experiment.questions import Prior, Unknown
from sysid.prediction.model import Model

SAMPLES = 2000
TRUTH = np.array([1.5, -0.7])
TIME = np.linspace(0.0, 1.0, SAMPLES)
COLUMNS = np.column_stack([np.ones(SAMPLES), np.sin(14.0 * TIME)])


def unknown(key: str, prior: Prior | None = None, low: float = -99.0, high: float = 99.0) -> Unknown:
    return Unknown(key, 0.0, low, high, 1.0, prior)


def told(columns: np.ndarray, measured: np.ndarray, unknowns: list[Unknown]) -> Intervals:
    """Intervals of a linear model fitted to one record, in deviations of the noise."""
    fit = least_squares(lambda p: measured - columns @ p, unknowns, iterations=60, tolerance=1e-12)
    record: Any = SimpleNamespace(size=measured.size)
    weights = ResidualWeights(({"y": np.ones(measured.size)},), ({"y": np.arange(measured.size)},))
    return intervals(FittedModel(Model((), dict(fit.values), tuple(unknowns)), fit, weights), [record])


def held(noise: Any, draws: int = 200) -> tuple[float, np.ndarray, np.ndarray]:
    """Share of intervals that hold the truth, the mean of their deviations, and the scatter of the values themselves,
    over draws of the noise."""
    rng = np.random.default_rng(4)
    hits, deviations, values = [], [], []
    for _ in range(draws):
        found = told(COLUMNS, COLUMNS @ TRUTH + noise(rng), [unknown("a"), unknown("b")]).by_key
        hits += [found[key].low <= truth <= found[key].high for key, truth in zip("ab", TRUTH, strict=True)]
        deviations.append([found[key].std for key in "ab"])
        values.append([found[key].value for key in "ab"])
    return float(np.mean(hits)), np.mean(deviations, axis=0), np.std(values, axis=0)


def test_white_noise_gives_the_textbook_deviation_and_its_coverage() -> None:
    share, deviation, scatter = held(lambda rng: rng.standard_normal(SAMPLES))
    # 400 intervals: a share of 0.95 has a deviation of 0.011.
    assert share == pytest.approx(0.95, abs=0.035)
    textbook = np.sqrt(np.diag(np.linalg.inv(COLUMNS.T @ COLUMNS)))
    assert deviation == pytest.approx(textbook, rel=0.15)
    assert scatter == pytest.approx(textbook, rel=0.15)


def test_autocorrelated_noise_widens_the_interval() -> None:
    def coloured(rng: np.random.Generator) -> np.ndarray:
        return np.asarray(lfilter([1.0], [1.0, -0.8], rng.standard_normal(SAMPLES + 100)))[100:]

    share, deviation, scatter = held(coloured)
    assert share == pytest.approx(0.95, abs=0.035)
    # The mean of a first-order autoregression varies as if its samples were (1 + r)/(1 - r) times fewer.
    assert deviation[0] == pytest.approx(1.0 / (1.0 - 0.8) / np.sqrt(SAMPLES), rel=0.15)
    assert deviation == pytest.approx(scatter, rel=0.15)


@pytest.mark.parametrize("correlation", [0.9, 0.97])
def test_noise_correlated_over_a_block_of_time_keeps_the_coverage(correlation: float) -> None:
    def coloured(rng: np.random.Generator) -> np.ndarray:
        drive = np.sqrt(1.0 - correlation**2) * rng.standard_normal(SAMPLES + 300)
        return np.asarray(lfilter([1.0], [1.0, -correlation], drive))[300:]

    # A block has 50 samples, the noise a correlation time of 10 or 33. 1000 intervals: a deviation of 0.007.
    share, deviation, scatter = held(coloured, draws=500)
    assert 0.93 <= share <= 0.975
    assert deviation == pytest.approx(scatter, rel=0.12)


def test_heteroscedastic_noise_is_weighted_locally() -> None:
    def uneven(rng: np.random.Generator) -> np.ndarray:
        # Loud where the sine is large: its amplitude is known less well than an even noise of that size would tell.
        return rng.standard_normal(SAMPLES) * (0.2 + 2.0 * np.abs(COLUMNS[:, 1]))

    share, deviation, scatter = held(uneven)
    assert share == pytest.approx(0.95, abs=0.035)
    assert deviation == pytest.approx(scatter, rel=0.15)
    even = np.sqrt(np.mean((0.2 + 2.0 * np.abs(COLUMNS[:, 1])) ** 2) / np.sum(COLUMNS**2, axis=0))
    assert deviation[1] / deviation[0] > 1.1 * even[1] / even[0]


def test_values_of_which_only_the_sum_is_identifiable_have_no_interval() -> None:
    rng = np.random.default_rng(1)
    columns = np.column_stack([COLUMNS, COLUMNS[:, 1]])
    found = told(
        columns, COLUMNS @ TRUTH + rng.standard_normal(SAMPLES), [unknown("a"), unknown("first"), unknown("second")]
    )
    assert np.isinf(found.by_key["first"].std)
    assert np.isinf(found.by_key["second"].std)
    assert np.isfinite(found.by_key["a"].std)
    assert {frozenset(text.split(" against ")) for text in found.unidentified} == {frozenset(("first", "second"))}


def test_a_value_at_its_bound_has_no_interval() -> None:
    rng = np.random.default_rng(2)
    found = told(COLUMNS, COLUMNS @ TRUTH + rng.standard_normal(SAMPLES), [unknown("a"), unknown("b", low=0.0)])
    assert found.by_key["b"].at_bound
    assert np.isinf(found.by_key["b"].high)
    assert not found.by_key["a"].at_bound


def test_correlation_is_that_of_the_columns() -> None:
    rng = np.random.default_rng(3)
    lean = np.column_stack([np.ones(SAMPLES), 1.0 + 0.3 * COLUMNS[:, 1]])
    found = told(lean, rng.standard_normal(SAMPLES), [unknown("a"), unknown("b")])
    covariance = np.linalg.inv(lean.T @ lean)
    wanted = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert found.correlation[0, 1] == pytest.approx(wanted, abs=0.02)
    assert np.diag(found.correlation) == pytest.approx(1.0)


@pytest.mark.parametrize("known", [0.004, 0.05])
def test_a_prior_counts_as_one_more_measurement(known: float) -> None:
    rng = np.random.default_rng(5)
    measured = COLUMNS @ TRUTH + rng.standard_normal(SAMPLES)
    found = told(COLUMNS, measured, [unknown("a", Prior(TRUTH[0], known)), unknown("b")])
    alone = np.sqrt(np.linalg.inv(COLUMNS.T @ COLUMNS)[0, 0])
    both = 1.0 / np.hypot(1.0 / alone, 1.0 / known)
    assert found.by_key["a"].std == pytest.approx(both, rel=0.35 if known > alone else 0.1)
    assert found.by_key["a"].std < 1.05 * known


def test_what_the_record_does_not_show_keeps_the_interval_it_was_known_to() -> None:
    rng = np.random.default_rng(6)
    columns = np.column_stack([COLUMNS[:, 0], np.zeros(SAMPLES)])
    found = told(columns, rng.standard_normal(SAMPLES), [unknown("a"), unknown("b", Prior(0.0, 0.3))]).by_key
    assert found["b"].std == pytest.approx(0.3)


@pytest.mark.parametrize("freedom", [1, 2, 3, 5, 12, 60])
def test_students_t(freedom: int) -> None:
    assert _student(freedom) == pytest.approx(student.ppf(0.975, freedom), rel=0.01)
