"""Size and colour of the noise on a smooth signal: differences of rising order, and windows of growing length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from sysid.cycles import trimmed_rms

MAD_TO_STD = 1.482602218505602
ORDERS = range(1, 9)
WINDOWS = (16, 32, 64, 128)
DEGREE = 3
CORRELATIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.96, 0.98, 0.99)
FILTERED_FALL = 1.25
"""White noise keeps its size from one order of differences to the next; falling by this much still at the eighth order
tells that nothing white is left in the log."""


UNSEEN_UNDER_STEP = 0.1
"""Noise below a tenth of a sensor's step leaves no trace in its readings; it is taken to be that tenth."""


@dataclass(frozen=True)
class Colour:
    """Noise as a first-order autoregression.

    Args:
        value: standard deviation.
        correlation: of neighbouring samples.
        filtered: the log has no white part, `value` is a lower bound.
    """

    value: float
    correlation: float
    filtered: bool


def segments(time: np.ndarray, values: np.ndarray, step: float) -> list[np.ndarray]:
    """Stretches of `values` without a gap and with even steps, of at least sixteen samples each."""
    good = ~np.isnan(values)
    joined = good[1:] & good[:-1] & (np.abs(np.diff(time) - step) <= 0.02 * step)
    breaks = np.flatnonzero(~joined) + 1
    return [piece for piece in np.split(values, breaks) if piece.size >= WINDOWS[0]]


def difference_scale(differences: np.ndarray) -> float:
    """Standard deviation by the median of the sizes, blind to a minority of jumps and outliers."""
    return float(MAD_TO_STD * np.median(np.abs(differences)))


def colour_of(pieces: Sequence[np.ndarray], quantum: float | None = None) -> Colour | None:
    """Noise of a signal given in stretches.

    Args:
        pieces: stretches, each of shape (n,).
        quantum: grid the values lie on; medians are no measure on a coarse grid, whose own noise is taken off.

    Returns:
        None where the stretches are too short altogether (fewer than 64 samples).
    """
    if sum(piece.size for piece in pieces) < 64:
        return None
    scales = [_order_scale(pieces, order) for order in ORDERS]
    floor = scales[-1]
    if quantum is not None and floor < 3.0 * quantum:
        return Colour(_under_quantum(pieces, quantum), 0.0, False)
    if floor <= 0.0:
        return Colour(0.0, 0.0, False)
    if scales[-3] > FILTERED_FALL**2 * floor:
        return Colour(floor, 0.0, True)
    order, white = next(
        (order, scale)
        for order, scale, after in zip(ORDERS, scales, [*scales[1:], floor])
        if scale <= 1.06 * after or order == ORDERS[-1]
    )
    return _coloured([_without_outliers(piece, white) for piece in pieces], order, white)


def _order_scale(pieces: Sequence[np.ndarray], order: int) -> float:
    parts = [np.diff(piece, order) for piece in pieces if piece.size > order]
    return difference_scale(np.concatenate(parts)) / np.sqrt(comb(2 * order, order))


def _under_quantum(pieces: Sequence[np.ndarray], quantum: float) -> float:
    """Noise of a channel with coarse steps, without the noise of the steps themselves."""
    total = min(
        trimmed_rms(np.concatenate([np.diff(piece, order) for piece in pieces])) / np.sqrt(comb(2 * order, order))
        for order in (2, 3, 4)
    )
    left = total**2 - quantum**2 / 12.0
    return max(float(np.sqrt(max(left, 0.0))), UNSEEN_UNDER_STEP * quantum)


def _without_outliers(piece: np.ndarray, scale: float) -> np.ndarray:
    """Lone samples far from the median of the five about them are put on that median."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(piece, 2, mode="edge"), 5)
    middle = np.median(around, axis=1)
    return np.where(np.abs(piece - middle) > 6.0 * scale, middle, piece)


def _coloured(pieces: Sequence[np.ndarray], order: int, white: float) -> Colour:
    """Compare the scatter in windows with the differences, and find the autoregression that gives both."""
    measured = {}
    for length in WINDOWS:
        scatter = _window_scatter(pieces, length)
        if scatter:
            measured[length] = scatter
    if len(measured) < 3 or measured[min(measured)] <= 1.1 * white:
        return Colour(white, 0.0, False)
    best = (np.inf, 0.0)
    for correlation in CORRELATIONS:
        size = white / _difference_share(order, correlation)
        errors = [np.log(scatter / (size * _window_share(w, correlation))) for w, scatter in measured.items()]
        best = min(best, (float(np.max(np.abs(errors))), correlation))
    misfit, correlation = best
    # A signal that bends within the windows grows without levelling off, and no autoregression gives that.
    if misfit > 0.12 or correlation == 0.0:
        return Colour(white, 0.0, False)
    return Colour(white / _difference_share(order, correlation), correlation, False)


def _window_scatter(pieces: Sequence[np.ndarray], length: int) -> float | None:
    """Standard deviation about a cubic in windows of `length`, from the quieter half of the windows."""
    windows = [piece[: piece.size // length * length].reshape(-1, length) for piece in pieces if piece.size >= length]
    if not windows or sum(window.shape[0] for window in windows) < 12:
        return None
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), DEGREE + 1))
    rows = np.concatenate(windows)
    rest = rows - (rows @ basis) @ basis.T
    freedom = length - DEGREE - 1
    variances = np.sum(rest**2, axis=1) / freedom
    # Quarter point of a chi-square over its mean (Wilson and Hilferty 1931).
    quarter = (1.0 - 2.0 / (9.0 * freedom) - 0.67449 * np.sqrt(2.0 / (9.0 * freedom))) ** 3
    return float(np.sqrt(np.quantile(variances, 0.25) / quarter))


@cache
def _difference_share(order: int, correlation: float) -> float:
    """Normalised difference of an autoregression of unit size, over that of white noise of unit size."""
    binomial = np.array([(-1) ** k * comb(order, k) for k in range(order + 1)], dtype=float)
    lags = np.abs(np.subtract.outer(np.arange(order + 1), np.arange(order + 1)))
    return float(np.sqrt(binomial @ correlation**lags @ binomial / comb(2 * order, order)))


@cache
def _window_share(length: int, correlation: float) -> float:
    """Scatter about a cubic in a window, of an autoregression of unit size."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), DEGREE + 1))
    lags = np.abs(np.subtract.outer(np.arange(length), np.arange(length)))
    matrix = correlation**lags
    rest = np.trace(matrix) - np.trace(basis.T @ matrix @ basis)
    return float(np.sqrt(rest / (length - DEGREE - 1)))
