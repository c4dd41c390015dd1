"""Noise with a correlation time, for tests of what is said of it."""

import numpy as np
from scipy.signal import lfilter

BLOCKS, LENGTH = 24, 400
BLOCK = np.repeat(np.arange(BLOCKS), LENGTH)
"""Block of each row of a residual."""


def autoregression(white: np.ndarray, correlation: float) -> np.ndarray:
    """First-order autoregressive noise (..., n) of unit variance from white noise of unit variance (..., n)."""
    drive = np.sqrt(1.0 - correlation**2) * white
    drive[..., 0] = white[..., 0]
    return np.asarray(lfilter([1.0], [1.0, -correlation], drive))


def noise_of_blocks(seed: int, correlation: float = 0.0) -> np.ndarray:
    """Noise for each row of the blocks."""
    return autoregression(np.random.default_rng(seed).normal(size=BLOCK.size), correlation)
