"""Intervals of fitted values: textbook covariances, coverage of a true value, and the wild bootstrap."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from sim.effects.catalogue import find
from sysid.estimation.bootstrap import Bootstrap, bootstrap_of, refit_of, refitted
from sysid.estimation.covariance import Interval, Intervals, has_size, intervals, known_combination
from sysid.estimation.fit import FittedModel
from sysid.estimation.least_squares import least_squares
from sysid.estimation.misfit import ResidualWeights
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.known import Prior, Unknown
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, SIGN, TIME, VELOCITY, slide

SAMPLES = 2000
TRUTH = np.array([1.5, -0.7])
TIMES = np.linspace(0.0, 1.0, SAMPLES)
COLUMNS = np.column_stack([np.ones(SAMPLES), np.sin(14.0 * TIMES)])


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


def test_deviation_and_coverage_under_white_and_correlated_noise() -> None:
    share, deviation, scatter = held(lambda rng: rng.standard_normal(SAMPLES))
    # 400 intervals: a share of 0.95 has a deviation of 0.011.
    assert share == pytest.approx(0.95, abs=0.035)
    textbook = np.sqrt(np.diag(np.linalg.inv(COLUMNS.T @ COLUMNS)))
    assert deviation == pytest.approx(textbook, rel=0.15)
    assert scatter == pytest.approx(textbook, rel=0.15)

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
    # Of equal values a and b the sum 2 a is known to a deviation s: the relative change of a b to s / a.
    value = found.by_key["first"].value
    assert found.by_key["second"].value == pytest.approx(value, rel=1e-6)
    begin, _, percent = known_combination(found, ["first", "second"]).partition(", to ")
    assert begin == " Known is first * second"
    deviation = 1.959964 / np.sqrt(np.sum(COLUMNS[:, 1] ** 2)) / abs(value)
    assert float(percent.removesuffix(" %.")) == pytest.approx(100.0 * deviation, rel=0.3)


def test_a_value_at_its_bound_has_no_interval_and_columns_correlate() -> None:
    rng = np.random.default_rng(2)
    found = told(COLUMNS, COLUMNS @ TRUTH + rng.standard_normal(SAMPLES), [unknown("a"), unknown("b", low=0.0)])
    assert found.by_key["b"].at_bound
    assert np.isinf(found.by_key["b"].high)
    assert not found.by_key["a"].at_bound
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


DRAWS = 150
FORCE = 1.3 * SIGN + 8.0 * VELOCITY
MEMORY = 0.8


def drawn(problem: Problem, draws: int = DRAWS) -> Bootstrap:
    refit = refit_of(problem, fit_stated_model(problem).fitted)
    return bootstrap_of(refit, [refitted(refit, (1, k)) for k in range(draws)])


def exact(covariance: np.ndarray, samples: int) -> np.ndarray:
    """Deviations of least squares in Coulomb force and viscous coefficient under errors of a known covariance."""
    columns = np.column_stack([SIGN, VELOCITY])[:samples]
    inverse = np.linalg.inv(columns.T @ columns)
    return np.sqrt(np.diag(inverse @ columns.T @ covariance[:samples, :samples] @ columns @ inverse))


def fitted_samples(problem: Problem) -> int:
    """Samples of the record that is fitted: the end of the motion is held out."""
    return max(record.size for record in problem.fit_records)


def test_errors_of_a_bootstrap_white_and_autocorrelated(tmp_path: Path) -> None:
    problem = slide(tmp_path, FORCE, "coulomb", "viscous")
    found = drawn(problem)
    assert found.keys == ("coulomb.force", "viscous.coefficient")
    wanted = exact(NOISE**2 * np.eye(TIME.size), fitted_samples(problem))
    # A deviation over 150 draws of some 40 blocks is itself known to a fifth.
    assert found.std == pytest.approx(wanted, rel=0.3)
    low, high = found.band
    assert np.all((low < found.best) & (found.best < high))
    assert high - low == pytest.approx(2 * 1.96 * found.std, rel=0.25)
    rng = np.random.default_rng(8)
    shocks = rng.standard_normal(TIME.size + 100)
    coloured = 0.03 * np.asarray(lfilter([1.0], [1.0, -MEMORY], shocks))[100:]
    problem = slide(tmp_path, FORCE + coloured, "coulomb", "viscous", noise=0.0)
    covariance = 0.03**2 / (1 - MEMORY**2) * toeplitz(MEMORY ** np.arange(TIME.size))
    samples = fitted_samples(problem)
    wanted = exact(covariance, samples)
    as_white = exact(np.diag(np.diag(covariance)), samples)
    found = drawn(problem).std
    assert np.all(wanted > 2.0 * as_white)
    assert found == pytest.approx(wanted, rel=0.4)


def test_bootstrap_at_a_bound_and_with_a_prior(tmp_path: Path) -> None:
    """The true drag is negative: the fit ends at zero, as do half the refits; the others scatter with the noise."""
    deviation = exact(NOISE**2 * np.eye(TIME.size), TIME.size)[1]
    found = drawn(slide(tmp_path, 1.3 * SIGN - 4.0 * deviation * VELOCITY, "coulomb", "viscous"))
    at = found.keys.index("viscous.coefficient")
    assert found.best[at] == 0.0
    assert found.band[0][at] == 0.0
    assert 0.2 < np.mean(found.values[:, at] == 0.0) < 0.9
    assert 0.5 * deviation < found.band[1][at] < 4.0 * deviation
    # With a prior far tighter than the record the refits scatter as the prior does.
    tight = 1e-4
    parameters = {"coulomb.force": {"start": f"1.3 +- {tight:g} N"}}
    problem = slide(tmp_path, FORCE, "coulomb", "viscous", parameters=parameters)
    found = drawn(problem)
    at = found.keys.index("coulomb.force")
    assert found.std[at] == pytest.approx(tight, rel=0.25)


@pytest.mark.parametrize(
    "effect,stds,at_bound,sized",
    [
        ("stribeck", {"force": 0.1, "velocity": 0.1}, (), True),
        ("stribeck", {"force": 0.6, "velocity": 0.1}, (), False),
        ("stribeck", {"force": 0.1, "velocity": 0.6}, (), False),
        ("stribeck", {"force": np.inf, "velocity": 0.1}, (), False),
        ("stribeck", {"force": 0.6, "velocity": 0.1}, ("force",), True),
        ("stribeck", {}, (), True),
        # Bristles act without damping.
        ("presliding:lugre", {"force": 0.1, "stiffness": 0.1, "damping": 0.6}, (), True),
    ],
)
def test_an_effect_has_a_size_and_a_width(
    effect: str, stds: dict[str, float], at_bound: tuple[str, ...], sized: bool
) -> None:
    found = {
        f"{effect}.{name}": Interval(1.0, std, 1.0 - 2.0 * std, 1.0 + 2.0 * std, name in at_bound)
        for name, std in stds.items()
    }
    assert has_size(Intervals(found, tuple(found), np.eye(len(found)), ()), find(effect)) == sized
