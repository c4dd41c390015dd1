"""The filter of the force balance on polynomials and noise, and the trimmed root mean square."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from sysid.signals import KEPT, TRIM_FACTOR, GaussianFilter, NoiseSpectrum, trimmed_rms
from tests.sysid.autoregression import autoregression


@pytest.mark.parametrize("width", [2e-3, 5e-3, 0.02])
def test_derivatives_of_a_parabola_are_exact(width: float) -> None:
    step = 1e-3
    t = step * np.arange(2000)
    x = 3.0 + 2.0 * t - 5.0 * t**2
    smooth = GaussianFilter(width, step, t.size)
    inner = slice(smooth.half, -smooth.half)
    assert np.allclose(smooth(x, 1)[inner], (2.0 - 10.0 * t)[inner], atol=1e-9)
    assert np.allclose(smooth(x, 2)[inner], -10.0, atol=1e-7)
    # A Gaussian adds half its variance times the second derivative, up to the sampling of its kernel.
    variance = float(np.sum(smooth.kernel() * (step * np.arange(-smooth.half, smooth.half + 1)) ** 2))
    assert np.allclose(smooth(x)[inner], (x - 5.0 * variance)[inner], atol=1e-10)


@pytest.mark.parametrize("averaged", [False, True])
@pytest.mark.parametrize("correlation", [0.0, 0.8, 0.98])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_noise_gain_is_that_of_generated_noise(order: int, correlation: float, averaged: bool) -> None:
    rng = np.random.default_rng(3)
    n, step = 200_000, 1e-3
    noise = autoregression(rng.normal(size=n), correlation)
    if averaged:
        noise[1:] = 0.5 * (noise[1:] + noise[:-1])
    smooth = GaussianFilter(4e-3, step, n)
    measured = float(np.std(smooth(noise, order)[1000:-1000]))
    assert measured == pytest.approx(smooth.noise_gain(order, NoiseSpectrum(correlation, 0.0, averaged)), rel=0.03)


def test_noise_gains_add_and_no_width_changes_nothing() -> None:
    smooth = GaussianFilter(4e-3, 1e-3, 4000)
    white, coloured = smooth.noise_gain(), smooth.noise_gain(0, NoiseSpectrum(0.9, 0.0))
    mixed = smooth.noise_gain(0, NoiseSpectrum(0.9, 0.3))
    assert mixed**2 == pytest.approx(0.3 * white**2 + 0.7 * coloured**2, rel=5e-3)
    x = np.arange(10.0)
    assert GaussianFilter(0.0, 1e-3, 10)(x) is x


@pytest.mark.parametrize("width", [2e-3, 7e-3])
def test_smoothing_at_some_samples_agrees_with_full_smoothing(width: float) -> None:
    signal = np.cumsum(np.random.default_rng(1).normal(size=3000))
    smooth = GaussianFilter(width, 1e-3, signal.size)
    index = np.concatenate([np.arange(0, 40), np.arange(40, 2960, 7), np.arange(2960, 3000)])
    assert np.allclose(smooth.at(signal, index), smooth(signal)[index], rtol=0.0, atol=1e-6 * np.ptp(signal))


def test_trimmed_rms_leaves_out_outliers_with_the_factor_of_the_normal_distribution() -> None:
    corner = norm.ppf(0.5 + 0.5 * KEPT)
    inner, _ = quad(lambda x: x**2 * norm.pdf(x), -corner, corner)
    assert pytest.approx(np.sqrt(inner / KEPT), rel=1e-6) == TRIM_FACTOR
    residual = np.random.default_rng(0).standard_normal(10_000)
    clean = trimmed_rms(residual)
    residual[:250] = 1e6
    assert trimmed_rms(residual) < 1.15 * clean
    residual[:400] = 1e6
    assert trimmed_rms(residual) > 1e3 and np.isnan(trimmed_rms(np.empty(0)))
    residual = np.random.default_rng(0).standard_normal(200_000)
    assert trimmed_rms(residual) == pytest.approx(1.0, abs=0.01)
    assert trimmed_rms(3.0 * residual) == pytest.approx(3.0, abs=0.03)
