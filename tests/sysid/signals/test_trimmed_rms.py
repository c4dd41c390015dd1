"""The trimmed root mean square: the standard deviation of normal noise, whatever a few samples are."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from sysid.signals.trimmed_rms import KEPT, TRIM_FACTOR, trimmed_rms


def test_noise_alone_gives_one() -> None:
    residual = np.random.default_rng(0).standard_normal(200_000)
    assert trimmed_rms(residual) == pytest.approx(1.0, abs=0.01)
    assert trimmed_rms(3.0 * residual) == pytest.approx(3.0, abs=0.03)


def test_trim_factor_is_that_of_the_normal_distribution() -> None:
    corner = norm.ppf(0.5 + 0.5 * KEPT)
    inner, _ = quad(lambda x: x**2 * norm.pdf(x), -corner, corner)
    assert pytest.approx(np.sqrt(inner / KEPT), rel=1e-6) == TRIM_FACTOR


def test_trimmed_rms_leaves_out_three_samples_of_a_hundred() -> None:
    residual = np.random.default_rng(0).standard_normal(10_000)
    clean = trimmed_rms(residual)
    residual[:250] = 1e6
    assert trimmed_rms(residual) < 1.15 * clean
    residual[:400] = 1e6
    assert trimmed_rms(residual) > 1e3


def test_trimmed_rms_of_no_sample_is_nan() -> None:
    assert np.isnan(trimmed_rms(np.empty(0)))
