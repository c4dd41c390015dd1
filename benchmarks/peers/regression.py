"""Least squares that both peers share: fitted without the worst samples, judged without the worst samples."""

import numpy as np

KEPT = 0.97
"""Part of the samples that counts, as in the loop's own error: those beside a reversal are nobody's fault."""


def trimmed_error(residual: np.ndarray) -> float:
    """Rms of the best `KEPT` of a residual (n,)."""
    squares = residual**2
    count = max(int(KEPT * squares.size), 1)
    return float(np.sqrt(np.mean(np.partition(squares, count - 1)[:count])))


def coefficients(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Least squares, once over all samples and once more without those that were worst."""
    if columns.shape[1] == 0:
        return np.zeros(0)
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scale[scale == 0.0] = 1.0
    scaled = columns / scale
    found = np.linalg.lstsq(scaled, target, rcond=1e-10)[0]
    squares = (target - scaled @ found) ** 2
    good = squares <= np.quantile(squares, KEPT)
    return np.linalg.lstsq(scaled[good], target[good], rcond=1e-10)[0] / scale


def held_out_error(fit: np.ndarray, target: np.ndarray, held: np.ndarray, held_target: np.ndarray) -> float:
    """Trimmed error on the held-out record of columns fitted to the other."""
    return trimmed_error(held_target - held @ coefficients(fit, target))
