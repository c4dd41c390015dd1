"""Transfer of an effect: amplitude, significance on white and on correlated noise, effective number of blocks."""

import numpy as np
import pytest
from scipy.signal import lfilter

from sysid.diagnosis.transfer import correlation_time, transfer

BLOCKS, LENGTH = 24, 400
BLOCK = np.repeat(np.arange(BLOCKS), LENGTH)


def _noise(seed: int, correlation: float = 0.0) -> np.ndarray:
    """First-order autoregressive noise (n,) of standard deviation 1."""
    white = np.random.default_rng(seed).normal(size=BLOCK.size)
    return np.asarray(lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white))


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_correlation_time_of_autoregressive_noise(correlation: float) -> None:
    found = np.median([correlation_time(_noise(seed, correlation)) for seed in range(20)])
    assert found == pytest.approx((1.0 + correlation) / (1.0 - correlation), rel=0.15)


@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.97])
def test_significance_has_unit_standard_error(correlation: float) -> None:
    """With a constant change c the amplitude of n samples of noise of correlation time T has the deviation
    sqrt(T/n)/c."""
    expected = 6.0
    time = (1.0 + correlation) / (1.0 - correlation)
    size = expected * np.sqrt(time / BLOCK.size)
    found = [transfer(_noise(s, correlation) + size, _noise(s, correlation), BLOCK).z for s in range(200)]
    assert np.median(found) == pytest.approx(expected, rel=0.15)
    assert np.std(found) == pytest.approx(1.0, rel=0.35)


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_change_unrelated_to_the_noise_is_not_significant(correlation: float) -> None:
    wave = 0.3 * np.sin(0.05 * np.arange(BLOCK.size))
    found = [transfer(noise, noise - wave, BLOCK) for noise in (_noise(seed, correlation) for seed in range(100))]
    assert max(abs(one.z) for one in found) < 3.5
    assert np.mean([one.amplitude for one in found]) == pytest.approx(0.0, abs=0.1)


def test_amplitude_is_that_of_the_effect_and_one_event_is_one_block() -> None:
    noise, wave = _noise(1), np.sin(0.05 * np.arange(BLOCK.size))
    half = transfer(noise + 0.5 * wave, noise - 0.5 * wave, BLOCK)
    assert half.amplitude == pytest.approx(0.5, abs=0.03)
    assert half.blocks > 500
    slow = _noise(2, 0.99)
    once = transfer(slow + np.where(BLOCK == 7, 3.0, 0.0), slow, BLOCK)
    assert once.blocks < 8
    assert once.z < 6.0
    everywhere = transfer(noise + 1.0, noise, BLOCK)
    assert everywhere.p_value < 1e-6


def test_no_change_and_no_prediction_have_no_significance() -> None:
    noise = _noise(3)
    assert transfer(noise, noise, BLOCK).z == 0.0
    assert transfer(noise, np.where(BLOCK == 0, np.nan, noise), BLOCK).z == 0.0
