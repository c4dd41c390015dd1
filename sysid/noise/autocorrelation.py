"""Standard deviation and autocorrelation of the noise on a smooth signal, from differences of increasing order and
windows of increasing length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from sysid.noise.repeats import trimmed_rms

MAD_TO_STD = 1.482602218505602
ORDERS = range(1, 9)
WINDOWS = (16, 24, 32, 64, 128)
SHORT = 32
DEGREE = 3
CORRELATIONS = (*np.arange(0.0, 0.9, 0.05).round(2).tolist(), *np.arange(0.9, 0.995, 0.01).round(2).tolist())
LONGEST = 0.9
"""Largest correlation: noise correlated over more than ten samples is not distinguishable from a signal that moves."""
AGREES = 0.08
FILTERED_FALL = 1.25
"""White noise gives the same standard deviation at every order of differences; a fall by this factor up to the eighth
order shows that the log has no white part."""


LOCAL = 256
"""Differences from which the local standard deviation of the noise is estimated."""

UNEVEN = 0.15
"""Standard deviation of the logarithm of that size above which the noise is uneven; stationary white noise has 0.08."""

LEAST_LEVEL = 0.1
"""Lower limit of the local size relative to the usual size; constant values have size zero."""

UNSEEN_UNDER_STEP = 0.1
"""Noise below a tenth of a sensor's step does not affect its readings; it is taken to be that tenth."""


@dataclass(frozen=True)
class Autoregression:
    """Noise as a first-order autoregression.

    Args:
        value: standard deviation.
        correlation: of neighbouring samples.
        filtered: the log has no white part, so `value` is a lower bound.
        white: standard deviation of white noise that would give the same differences of neighbours.
    """

    value: float
    correlation: float
    filtered: bool
    white: float


def segments(time: np.ndarray, values: np.ndarray, step: float) -> list[np.ndarray]:
    """Stretches of `values` without a gap and with even steps, of at least sixteen samples each."""
    good = ~np.isnan(values)
    joined = good[1:] & good[:-1] & (np.abs(np.diff(time) - step) <= 0.02 * step)
    breaks = np.flatnonzero(~joined) + 1
    return [piece for piece in np.split(values, breaks) if piece.size >= WINDOWS[0]]


def difference_scale(differences: np.ndarray) -> float:
    """Standard deviation by the median of the sizes, robust against a minority of jumps and outliers."""
    return float(MAD_TO_STD * np.median(np.abs(differences)))


def fit_autoregression(
    pieces: Sequence[np.ndarray], quantisation_step: float | None = None, flat: bool = False
) -> Autoregression | None:
    """Noise of a signal given in stretches.

    Args:
        pieces: stretches, each of shape (n,).
        quantisation_step: step of the values; on a coarse grid medians are not used, and the quantisation noise is
            subtracted.
        flat: the stretches contain only noise and slow drift, so that long windows determine the correlation too.

    Returns:
        None where the stretches are too short in total (fewer than 64 samples).
    """
    if sum(piece.size for piece in pieces) < 64:
        return None
    scales = [_order_scale(pieces, order) for order in ORDERS]
    floor = scales[-1]
    if quantisation_step is not None and floor < 3.0 * quantisation_step:
        value = _under_quantum(pieces, quantisation_step)
        return Autoregression(value, 0.0, False, value)
    if floor <= 0.0:
        return Autoregression(0.0, 0.0, False, 0.0)
    if scales[-3] > FILTERED_FALL**2 * floor:
        return Autoregression(floor, 0.0, True, floor)
    order, white = next(
        (order, scale)
        for order, scale, after in zip(ORDERS, scales, [*scales[1:], floor])
        if scale <= 1.06 * after or order == ORDERS[-1]
    )
    levels = _levels(pieces, order, white)
    return _correlated([_without_outliers(piece, white) for piece in pieces], levels, order, white, flat)


def _levels(pieces: Sequence[np.ndarray], order: int, white: float) -> list[np.ndarray]:
    """Local size of the noise along each piece (n,) relative to its usual size, from differences; 1 for even noise."""
    spans = [piece.size - order for piece in pieces]
    differences = np.concatenate([np.diff(piece, order) for piece in pieces]) / np.sqrt(comb(2 * order, order))
    parts = np.array_split(differences, max(1, differences.size // LOCAL))
    sizes = np.maximum([difference_scale(part) / white for part in parts], LEAST_LEVEL)
    centres = (np.arange(sizes.size) + 0.5) * differences.size / sizes.size
    along = np.interp(np.arange(differences.size), centres, sizes)
    if float(np.std(np.log(along))) <= UNEVEN:
        return [np.ones(piece.size) for piece in pieces]
    return [np.pad(level, (0, order), mode="edge") for level in np.split(along, np.cumsum(spans)[:-1])]


def _order_scale(pieces: Sequence[np.ndarray], order: int) -> float:
    parts = [np.diff(piece, order) for piece in pieces if piece.size > order]
    return difference_scale(np.concatenate(parts)) / np.sqrt(comb(2 * order, order))


def _under_quantum(pieces: Sequence[np.ndarray], quantisation_step: float) -> float:
    """Noise of a coarsely quantised channel without the quantisation noise."""
    total = min(
        trimmed_rms(np.concatenate([np.diff(piece, order) for piece in pieces])) / np.sqrt(comb(2 * order, order))
        for order in (2, 3, 4)
    )
    left = total**2 - quantisation_step**2 / 12.0
    return max(float(np.sqrt(max(left, 0.0))), UNSEEN_UNDER_STEP * quantisation_step)


def _without_outliers(piece: np.ndarray, scale: float) -> np.ndarray:
    """Replace outliers by the running median of five samples."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(piece, 2, mode="edge"), 5)
    middle = np.median(around, axis=1)
    return np.where(np.abs(piece - middle) > 6.0 * scale, middle, piece)


def _correlated(
    pieces: Sequence[np.ndarray], levels: Sequence[np.ndarray], order: int, white: float, flat: bool
) -> Autoregression:
    """First-order autoregression that agrees with both the scatter in windows and the differences."""
    measured = {}
    for length in WINDOWS:
        scatter = _window_scatter(pieces, levels, length)
        if scatter:
            measured[length] = scatter
    short = [length for length in measured if length <= SHORT]
    if len(short) < 3 or 2 * SHORT not in measured or measured[short[0]] <= 1.1 * white:
        return Autoregression(white, 0.0, False, white)
    used = list(measured) if flat else short
    errors = {
        correlation: {
            length: float(np.log(scatter * _difference_share(order, correlation) / white / _seen(length, correlation)))
            for length, scatter in measured.items()
        }
        for correlation in CORRELATIONS
        if flat or correlation <= LONGEST
    }
    size = 1.0
    if flat:
        # Differences and windows each give the standard deviation: the correlation at which they agree best.
        spread = {c: float(np.std([0.0, *error.values()])) for c, error in errors.items()}
        best = min(spread, key=lambda correlation: spread[correlation])
        size = float(np.exp(np.mean([0.0, *errors[best].values()])))
    else:
        # A curved signal adds to the scatter, more so in longer windows: take the smallest correlation that agrees.
        sizes = {c: max(abs(error[length]) for length in used) for c, error in errors.items()}
        best = next(c for c, size in sizes.items() if size <= max(AGREES, min(sizes.values())))
    misfit = errors[best]
    # The scatter of a curved signal grows with the fourth power of the window, that of an autoregression slower.
    levels_off = misfit[2 * SHORT] < 0.4 and all(value > -0.25 for value in misfit.values())
    if max(abs(misfit[length]) for length in used) > 0.2 or not levels_off:
        return Autoregression(white, 0.0, False, white)
    return Autoregression(size * white / _difference_share(order, best), best, False, white)


def _window_scatter(pieces: Sequence[np.ndarray], levels: Sequence[np.ndarray], length: int) -> float | None:
    """Standard deviation about a cubic in windows of `length`, from the lower quartile of the windows' variances.

    The variance of each window is divided by the square of the local noise level, so that for uneven noise the lower
    quartile selects windows with little signal, not windows with little noise.
    """

    def windows_of(parts: Sequence[np.ndarray]) -> list[np.ndarray]:
        return [part[: part.size // length * length].reshape(-1, length) for part in parts if part.size >= length]

    windows = windows_of(pieces)
    if not windows or sum(window.shape[0] for window in windows) < 12:
        return None
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), DEGREE + 1))
    rows = np.concatenate(windows)
    rest = rows - (rows @ basis) @ basis.T
    freedom = length - DEGREE - 1
    variances = np.sum(rest**2, axis=1) / freedom / np.mean(np.concatenate(windows_of(levels)), axis=1) ** 2
    return float(np.sqrt(np.quantile(variances, 0.25) / _quarter(freedom)))


def _quarter(freedom: float) -> float:
    """Lower quartile of a chi-square variable over its mean (Wilson and Hilferty 1931)."""
    return (1.0 - 2.0 / (9.0 * freedom) - 0.67449 * np.sqrt(2.0 / (9.0 * freedom))) ** 3


@cache
def _difference_share(order: int, correlation: float) -> float:
    """Normalised difference of an autoregression of unit size, over that of white noise of unit size."""
    binomial = np.array([(-1) ** k * comb(order, k) for k in range(order + 1)], dtype=float)
    lags = np.abs(np.subtract.outer(np.arange(order + 1), np.arange(order + 1)))
    return float(np.sqrt(binomial @ correlation**lags @ binomial / comb(2 * order, order)))


@cache
def _seen(length: int, correlation: float) -> float:
    """Result of `_window_scatter` for an autoregression of unit size.

    Correlated samples have fewer degrees of freedom (Welch and Satterthwaite), and hence a lower quartile.
    """
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), DEGREE + 1))
    lags = np.abs(np.subtract.outer(np.arange(length), np.arange(length)))
    full = correlation**lags
    across = basis @ (basis.T @ full)
    matrix = full - across - across.T + basis @ (across @ basis).T
    total = float(np.trace(matrix))
    freedom = total**2 / float(np.sum(matrix**2))
    white_freedom = length - DEGREE - 1
    return float(np.sqrt(total / white_freedom * _quarter(freedom) / _quarter(white_freedom)))
