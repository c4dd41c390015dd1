"""Root mean square without the largest samples, on the scale of the standard deviation of normal noise."""

import numpy as np

KEPT = 0.97
"""Share of samples in the trimmed rms; it leaves out single samples, such as those at jumps or beside a
reversal between two samples."""

_CORNER = 2.17009
"""Two-sided 97 % point of the normal distribution."""

TRIM_FACTOR = float(np.sqrt(1.0 - 2.0 * _CORNER * np.exp(-0.5 * _CORNER**2) / np.sqrt(2.0 * np.pi) / KEPT))
"""rms of a standard normal variable within its central 97 %."""


def trimmed_rms(residual: np.ndarray) -> float:
    """rms of the smallest 97 % of the samples (n,), over `TRIM_FACTOR`: the standard deviation of normal noise.

    Returns:
        NaN without samples.
    """
    if residual.size == 0:
        return float("nan")
    size = np.sort(np.abs(residual))
    kept = size[: max(1, int(np.ceil(KEPT * size.size)))]
    return float(np.sqrt(np.mean(kept**2))) / TRIM_FACTOR
