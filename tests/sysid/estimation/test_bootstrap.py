"""Wild bootstrap: known covariances, and a value at its bound."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from sysid.estimation.bootstrap import Bootstrap, bootstrap_of, refit_of, refitted
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, SIGN, TIME, VELOCITY, slide

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


def test_white_errors_give_the_textbook_deviation(tmp_path: Path) -> None:
    problem = slide(tmp_path, FORCE, '"coulomb", "viscous"')
    found = drawn(problem)
    assert found.keys == ("coulomb.force", "viscous.coefficient")
    wanted = exact(NOISE**2 * np.eye(TIME.size), fitted_samples(problem))
    # A deviation over 150 draws of some 40 blocks is itself known to a fifth.
    assert found.std == pytest.approx(wanted, rel=0.3)
    low, high = found.band
    assert np.all((low < found.best) & (found.best < high))
    assert high - low == pytest.approx(2 * 1.96 * found.std, rel=0.25)


def test_autocorrelated_errors_give_a_wider_deviation(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    shocks = rng.standard_normal(TIME.size + 100)
    coloured = 0.03 * np.asarray(lfilter([1.0], [1.0, -MEMORY], shocks))[100:]
    problem = slide(tmp_path, FORCE + coloured, '"coulomb", "viscous"', noise=0.0)
    covariance = 0.03**2 / (1 - MEMORY**2) * toeplitz(MEMORY ** np.arange(TIME.size))
    samples = fitted_samples(problem)
    wanted = exact(covariance, samples)
    as_white = exact(np.diag(np.diag(covariance)), samples)
    found = drawn(problem).std
    assert np.all(wanted > 2.0 * as_white)
    assert found == pytest.approx(wanted, rel=0.4)


def test_value_at_its_bound_has_a_one_sided_band(tmp_path: Path) -> None:
    """The true drag is negative: the fit ends at zero, as do half the refits; the others scatter with the noise."""
    deviation = exact(NOISE**2 * np.eye(TIME.size), TIME.size)[1]
    found = drawn(slide(tmp_path, 1.3 * SIGN - 4.0 * deviation * VELOCITY, '"coulomb", "viscous"'))
    at = found.keys.index("viscous.coefficient")
    assert found.best[at] == 0.0
    assert found.band[0][at] == 0.0
    assert 0.2 < np.mean(found.values[:, at] == 0.0) < 0.9
    assert 0.5 * deviation < found.band[1][at] < 4.0 * deviation


def test_prior_is_drawn_in_each_replicate(tmp_path: Path) -> None:
    """With a prior far tighter than the record the refits scatter as the prior does."""
    tight = 1e-4
    parameters = f'[model.parameters]\n"coulomb.force" = {{start = "1.3 +- {tight:g} N"}}'
    problem = slide(tmp_path, FORCE, '"coulomb", "viscous"', parameters)
    found = drawn(problem)
    at = found.keys.index("coulomb.force")
    assert found.std[at] == pytest.approx(tight, rel=0.25)
