"""Correlations of residuals and information criteria, against definitions written out."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2

from sysid.estimation.fit import criteria_of
from sysid.estimation.residual_correlation import correlations


def test_correlations_are_their_sums_over_records_and_gaps() -> None:
    random = np.random.default_rng(1)
    e = [random.standard_normal(40), random.standard_normal(25)]
    u = [random.standard_normal(40), random.standard_normal(25)]
    e[0][7:11], u[0][7:11] = np.nan, np.nan
    found = correlations("f", 0.1, e, {"u": u}, lags=5)
    mean_e, mean_u = (np.nanmean(np.concatenate(parts)) for parts in (e, u))
    square_e = sum(np.nansum((part - mean_e) ** 2) for part in e)
    square_u = sum(np.nansum((part - mean_u) ** 2) for part in u)
    for lag in range(6):
        products = [np.nansum((part[: part.size - lag] - mean_e) * (part[lag:] - mean_e)) for part in e]
        assert found.autocorrelation[lag] == pytest.approx(sum(products) / square_e, abs=1e-12)
        # The residual follows the input: e(t + lag) u(t).
        behind = sum(np.nansum((a[: a.size - lag] - mean_u) * (b[lag:] - mean_e)) for a, b in zip(u, e))
        before = sum(np.nansum((a[lag:] - mean_u) * (b[: b.size - lag] - mean_e)) for a, b in zip(u, e))
        assert found.cross["u"][5 + lag] == pytest.approx(behind / np.sqrt(square_e * square_u), abs=1e-12)
        assert found.cross["u"][5 - lag] == pytest.approx(before / np.sqrt(square_e * square_u), abs=1e-12)
    assert found.samples == 61 and found.cross_lags[0] == pytest.approx(-0.5)


def test_the_statistic_of_ljung_and_box_finds_white_noise() -> None:
    random = np.random.default_rng(2)
    tried = [correlations("f", 1.0, [random.standard_normal(600)], {}, lags=20) for _ in range(200)]
    rejected = sum(found.p_value < 0.05 for found in tried)
    assert 3 <= rejected <= 20  # 10 expected; 0.1 % of binomial outcomes lie outside
    outside = np.mean([np.abs(found.autocorrelation[1:]) > found.bound for found in tried])
    assert outside == pytest.approx(0.01, abs=0.005)
    e = np.array([1.0, -1.0, 2.0, 0.5, -0.5, -2.0, 1.5, 0.0, -1.5, 0.0])
    found = correlations("f", 1.0, [e], {}, lags=2)
    r = [np.sum(e[:-k] * e[k:]) / np.sum(e**2) for k in (1, 2)]
    q = 10 * 12 * (r[0] ** 2 / 9 + r[1] ** 2 / 8)
    assert found.p_value == pytest.approx(chi2.sf(q, 2), rel=1e-12)
    random = np.random.default_rng(3)
    e = np.asarray(lfilter([1.0], [1.0, -0.8], random.standard_normal(60_000)))
    found = correlations("f", 1.0, [e], {}, lags=6)
    np.testing.assert_allclose(found.autocorrelation, 0.8 ** np.arange(7), atol=0.02)
    assert found.p_value < 1e-6


def test_a_missing_delay_shows_at_its_lag_and_independent_inputs_stay_in_their_bound() -> None:
    random = np.random.default_rng(4)
    outside = []
    for _ in range(60):
        u, e = (np.asarray(lfilter([1.0], [1.0, -0.9], random.standard_normal(3000))) for _ in range(2))
        found = correlations("f", 0.01, [e], {"u": [u]}, lags=10)
        outside.append(np.abs(found.cross["u"]) > found.cross_bound["u"])
        # The bound of white series would be passed far more often.
    assert np.mean(outside) < 0.04
    u = random.standard_normal(2000)
    e = 0.3 * np.roll(u, 4) + random.standard_normal(2000)
    found = correlations("f", 0.01, [e], {"u": [u]}, lags=10)
    largest = int(np.argmax(np.abs(found.cross["u"])))
    assert found.cross_lags[largest] == pytest.approx(0.04)
    assert np.sum(np.abs(found.cross["u"]) > found.cross_bound["u"]) <= 2


def test_the_inputs_that_the_residual_follows_are_named() -> None:
    random = np.random.default_rng(8)
    cause, other = random.normal(size=(2, 4000))
    residual = random.normal(size=4000)
    # A dynamic response to one input over several samples.
    for lag, gain in enumerate((0.5, 0.4, 0.3, 0.2), start=1):
        residual[lag:] += gain * cause[:-lag]
    found = correlations("force", 1e-3, [residual], {"cause": [cause], "other": [other]})
    assert found.correlated_inputs == ("cause",) and not found.is_white
    assert found.cross_lags[np.argmax(np.abs(found.cross["cause"]))] == pytest.approx(1e-3)
    assert correlations("force", 1e-3, [random.normal(size=4000)], {"other": [other]}).correlated_inputs == ()


def _criteria_by_likelihood(y: np.ndarray, columns: np.ndarray) -> tuple[float, float]:
    """AIC and BIC of a regression, -2 log L + penalty, at the maximum of the normal likelihood over all of its k + 1
    values; less the constant n (1 + ln 2 pi)."""
    n = y.size
    residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    variance = np.mean(residual**2)
    log_likelihood = np.sum(-0.5 * np.log(2.0 * np.pi * variance) - 0.5 * residual**2 / variance)
    k = columns.shape[1] + 1
    constant = n * (1.0 + np.log(2.0 * np.pi))
    return -2.0 * log_likelihood + 2.0 * k - constant, -2.0 * log_likelihood + k * np.log(n) - constant


def test_criteria_are_those_of_the_normal_likelihood() -> None:
    random = np.random.default_rng(1)
    x = np.linspace(-1.0, 1.0, 200)
    y = 1.0 + 2.0 * x + 0.3 * random.standard_normal(x.size)
    for degree in (1, 2, 5):
        columns = np.vander(x, degree + 1)
        residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        found = criteria_of(residual, columns.shape[1] + 1)
        assert (found.aic, found.bic) == pytest.approx(_criteria_by_likelihood(y, columns), rel=1e-12)
        assert (found.samples, found.parameters) == (200, degree + 2)
    random = np.random.default_rng(3)
    one, other = random.standard_normal(50), 1.2 * random.standard_normal(50)
    plain = criteria_of(one, 2).aic - criteria_of(other, 4).aic
    assert criteria_of(7.0 * one, 2).aic - criteria_of(7.0 * other, 4).aic == pytest.approx(plain, abs=1e-9)


def test_a_term_that_is_there_lowers_both_and_idle_terms_raise_the_bic() -> None:
    random = np.random.default_rng(2)
    x = np.linspace(-1.0, 1.0, 400)
    y = 1.0 + 2.0 * x + 0.3 * random.standard_normal(x.size)
    by_degree = []
    for degree in (0, 1, 6):
        columns = np.vander(x, degree + 1)
        residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        by_degree.append(criteria_of(residual, degree + 2))
    constant, line, curve = by_degree
    assert line.aic < constant.aic - 100.0 and line.bic < constant.bic - 100.0
    assert curve.bic > line.bic + 10.0
