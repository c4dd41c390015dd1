"""Information criteria against the log-likelihood of a linear regression, written out."""

import numpy as np
import pytest

from sysid.estimation.fit import criteria_of


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


def test_scale_of_the_noise_changes_no_difference() -> None:
    random = np.random.default_rng(3)
    one, other = random.standard_normal(50), 1.2 * random.standard_normal(50)
    plain = criteria_of(one, 2).aic - criteria_of(other, 4).aic
    assert criteria_of(7.0 * one, 2).aic - criteria_of(7.0 * other, 4).aic == pytest.approx(plain, abs=1e-9)
