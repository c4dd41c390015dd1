"""Standard deviation and autocorrelation of the noise of a channel, from differences at several lags.

The normalised difference of order m at lag k of noise with autocorrelation r(k) has the variance

    V(k) = sigma^2 sum_ij c_i c_j r(k |i - j|) / sum_i c_i^2,     c_i = (-1)^i binomial(m, i).

For white noise V is constant, for a first-order autoregression it grows with k, at most in proportion, from
0.67 (1 - r) sigma^2 (order 2) to sigma^2, and for a smooth signal with k^(2m). A white part, an autoregressive part and
a smooth part are fitted to V jointly, over the longest range of lags in which they agree with it; the noise is the sum
of the first two. V is computed from a quantile of the sizes, so that jumps and outliers do not contribute.

Sources: Allan, Proc. IEEE 54 (1966) 221, and Serroukh, Walden and Percival, J. Am. Stat. Assoc. 95 (2000) 184 (variance
of differences against lag); Rice, Ann. Statist. 12 (1984) 1215 (noise from differences).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from math import comb, factorial
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from sysid.signals import WHITE, NoiseSpectrum

LAGS = tuple(np.unique(np.round(2.0 ** np.arange(0.0, 10.1, 0.5)).astype(int)).tolist())
QUANTILE, NORMAL_QUANTILE = 0.35, 0.453762
"""Quantile of the sizes of the differences, and the same of a standard normal variable: low, so that sections in which
the signal changes fast do not contribute."""

HIGH, NORMAL_HIGH, TAIL = 0.85, 1.439531, 1.2
"""A high quantile, and the same of a standard normal variable. V from it exceeds V from the low one by less than the
factor `TAIL`, beside its statistical error, where the differences consist of noise: the contribution of a signal is
concentrated in time."""

CORRELATIONS = (0.0, *np.exp(-1.0 / 2.0 ** np.arange(-1.0, 9.01, 0.25)).tolist())

AGREES = 0.08
"""Largest relative error of V, beside its statistical error."""

UNEVEN = 4.0
"""Largest such ratio of noise whose standard deviation changes in time."""

ENOUGH = 8
"""Lag up to which the simplest noise must agree with V."""

LEAST_SPANS = 60
"""Differences per lag from which V is used: neighbouring differences are correlated over the lag."""

SHORT = 16
"""Longest lag of a channel that is not compared with recorded motion: noise of a longer correlation time is not
distinguishable from a signal."""

ORDERS = (2, 4, 6)
FILTERED_ORDERS, FILTERED_FALL = (6, 8), 1.25
"""Orders whose differences have the same size for white noise; a fall by this factor shows that the log has no white
part."""

MOST_DIFFERENCES = 8_000

EVEN = 1e-7
"""Largest deviation of a step from the usual one, relative to it, at even spacing."""


@dataclass(frozen=True)
class Series:
    """A channel of one record: times (n,), s; values (n,), NaN in gaps; usual step, s; and the part of the noise power
    that was removed from the values, (m,) from frequency zero to Nyquist's, none if empty."""

    time: np.ndarray
    values: np.ndarray
    step: float
    removed: np.ndarray = field(default_factory=lambda: np.empty(0))

    @cached_property
    def even(self) -> bool:
        """Whether the times are evenly spaced up to rounding errors, but for gaps."""
        excess = np.diff(self.time) / self.step - 1.0
        return bool(np.all((np.abs(excess) < EVEN) | (excess > 0.5)))


@dataclass(frozen=True)
class Autoregression:
    """White noise plus a first-order autoregression: standard deviation and spectrum of the sum; whether the log has no
    white part, so that this is a lower bound; longest lag of the fit, rows; the factor by which the value may be wrong,
    half the range of the fits that agree with V; and that of white noise with the same finest differences."""

    value: float
    spectrum: NoiseSpectrum = WHITE
    filtered: bool = False
    reach: int = 1
    factor: float = 1.0
    finest: float = np.nan


class _Fit(NamedTuple):
    """Correlation and variance of the autoregressive part, variance of the white part, and largest error of V over the
    allowed one."""

    correlation: float
    white: float
    coloured: float
    error: float


def without_outliers(values: np.ndarray) -> np.ndarray:
    """`values` (n,) with NaN at samples more than six standard deviations from the median of their four neighbours."""
    known = np.flatnonzero(np.isfinite(values))
    out = values.copy()
    if known.size < 5:
        return out
    held = values[known]
    padded = np.pad(held, 2, mode="edge")
    beside = np.sort([padded[:-4], padded[1:-3], padded[3:-1], padded[4:]], axis=0)
    away = np.abs(held - 0.5 * (beside[1] + beside[2]))
    scale = 1.4826 * float(np.median(away))
    if scale > 0.0:
        out[known[away > 6.0 * scale]] = np.nan
    return out


def _differences(series: Series, lag: int, order: int) -> np.ndarray:
    """Divided differences (m,) at a lag in rows, normalised to unit variance for white noise of unit variance; at any
    spacing they are zero for a polynomial of lower order. Values held constant over a difference are left out."""
    count = series.values.size - order * lag
    if count <= 0:
        return np.empty(0)
    start = slice(0, count, _stride(count))
    times = [series.time[j * lag :][start] for j in range(order + 1)]
    values = [series.values[j * lag :][start] for j in range(order + 1)]
    total, square = np.zeros(times[0].size), np.zeros(times[0].size)
    uneven = np.ones(times[0].size, dtype=bool)
    if series.even:
        uneven = times[-1] - times[0] > (order * lag + 0.25) * series.step
        weights = [(-1.0) ** (order - j) / (factorial(j) * factorial(order - j)) for j in range(order + 1)]
        for weight, value in zip(weights, values, strict=True):
            total += weight * (value - values[0])
        square += np.sum(np.square(weights))
    if uneven.any():
        times_there = [time[uneven] for time in times]
        total[uneven], square[uneven] = _divided([value[uneven] for value in values], times_there, lag * series.step)
    used = np.isfinite(total) & (times[-1] - times[0] <= 2.0 * order * lag * series.step)
    used &= np.any([other != values[0] for other in values[1:]], axis=0)
    return total[used] / np.sqrt(square[used])


def _divided(values: Sequence[np.ndarray], times: Sequence[np.ndarray], step: float) -> tuple[np.ndarray, np.ndarray]:
    """Divided differences (m,) of values, each (m,), at any times, in units of a step; sums of the squared weights."""
    total, square = np.zeros(times[0].size), np.zeros(times[0].size)
    for j, time in enumerate(times):
        weight = np.ones(time.size)
        for m, other in enumerate(times):
            if m != j:
                weight *= step / (time - other)
        total += weight * (values[j] - values[0])
        square += weight**2
    return total, square


def _stride(count: int) -> int:
    return max(1, count // MOST_DIFFERENCES)


class _Spread(NamedTuple):
    """V at one lag, the ratio of V from the high quantile to it, and the number of independent differences."""

    variance: float
    tail: float
    spans: float


def _spread(series: Sequence[Series], lag: int, order: int) -> _Spread:
    parts = [np.abs(_differences(one, lag, order)) for one in series]
    sizes = np.concatenate(parts)
    if not sizes.size:
        return _Spread(np.nan, np.nan, 0.0)
    spans = sum(part.size * min(1.0, _stride(one.values.size) / lag) for one, part in zip(series, parts, strict=True))
    low, high = (np.quantile(sizes, [QUANTILE, HIGH]) / [NORMAL_QUANTILE, NORMAL_HIGH]) ** 2
    return _Spread(float(low), float(high / max(low, 1e-300)), spans)


@cache
def _shares(order: int) -> np.ndarray:
    """V over the variance of an autoregression, (lags, correlations)."""
    c = np.array([(-1) ** k * comb(order, k) for k in range(order + 1)], dtype=float)
    apart = np.abs(np.subtract.outer(np.arange(order + 1), np.arange(order + 1)))
    over_lag = np.array(CORRELATIONS) ** np.array(LAGS)[:, None]
    return np.einsum("i,lrij,j->lr", c, over_lag[:, :, None, None] ** apart, c) / comb(2 * order, order)


def _removed_shares(order: int, removed: np.ndarray) -> np.ndarray:
    """Part of `_shares` that is lost with the part `removed` (m,) of the power, from frequency zero to Nyquist's."""
    return _responses(order, removed.size) @ (_spectra(removed.size) * removed / removed.size).T


@lru_cache(maxsize=8)
def _responses(order: int, size: int) -> np.ndarray:
    """Squared frequency responses (lags, size) of the differences, from frequency zero to Nyquist's."""
    angle = np.linspace(0.0, np.pi, size)
    return (2.0 * np.sin(0.5 * angle * np.array(LAGS)[:, None])) ** (2 * order) / comb(2 * order, order)


@lru_cache(maxsize=4)
def _spectra(size: int) -> np.ndarray:
    """Power spectra (correlations, size) of the autoregressions."""
    angle = np.linspace(0.0, np.pi, size)
    return np.array([NoiseSpectrum(correlation, 0.0).power(angle) for correlation in CORRELATIONS])


def fit_noise(signal: Sequence[Series], residual: Sequence[Series] | None = None) -> Autoregression | None:
    """Noise of a channel."""
    parts = [signal] if residual is None else [signal, residual]
    if _spread(signal, 1, 2).spans < 8:
        constant = sum(int(np.isfinite(one.values).sum()) for one in signal) >= 10
        return Autoregression(0.0) if constant else None
    high = [min(_spread(part, 1, order) for part in parts) for order in FILTERED_ORDERS]
    if not high[-1].variance > 0.0:
        return Autoregression(0.0, filtered=True)
    finest = float(np.sqrt(high[-1].variance))
    found = Autoregression(finest, finest=finest)
    if high[0].variance > FILTERED_FALL**2 * high[-1].variance:
        return replace(found, filtered=True)
    # Noise of varying standard deviation has a larger ratio at every lag; an undersampled signal a still larger one.
    uneven = high[-1].tail if 1.0 < high[-1].tail < UNEVEN else 1.0
    for order in ORDERS:
        usable: list[_Spread] = []
        for lag in LAGS if residual is not None and order == ORDERS[0] else [lag for lag in LAGS if lag <= SHORT]:
            measured = min(_spread(part, lag, order) for part in parts)
            tail = TAIL * uneven * (1.0 + 6.0 / np.sqrt(max(measured.spans, 1.0)))
            none = measured.spans < LEAST_SPANS or not measured.variance > 0.0
            if none or (measured.tail > tail and (lag > 3 or order == ORDERS[0])):
                break
            usable.append(measured)
        shares = _shares(order)
        if residual is not None:
            shares = shares - np.mean([_removed_shares(order, one.removed) for one in residual], axis=0)
        fitted = _fit(usable, order, shares)
        if fitted is not None and fitted.reach > found.reach:
            found = replace(fitted, finest=finest)
        if found.reach >= ENOUGH:
            break
    return found


def _fit(measured: Sequence[_Spread], order: int, shares: np.ndarray) -> Autoregression | None:
    """The simplest noise that agrees with V up to the lag `ENOUGH`, over the longest range of lags; else any that does.
    `shares` (lags, correlations) is V over the variance of each autoregression."""
    shorter = None
    for parts in (1, 2, 3):
        for size in range(len(measured), 2, -1):
            lag = np.array(LAGS[:size])
            variance = np.array([one.variance for one in measured[:size]])
            allowed = (AGREES + 4.0 / np.sqrt([one.spans for one in measured[:size]])) * variance
            smooth = (lag / lag[-1]) ** (2.0 * order)
            columns = np.column_stack([shares[:size] / allowed[:, None], smooth / allowed])
            if fits := list(_candidates(lag, variance / allowed, columns, parts)):
                found = _middle(fits, int(lag[-1]))
                if found.reach >= ENOUGH:
                    return found
                shorter = found if shorter is None or found.reach > shorter.reach else shorter
                break
    return shorter


def _middle(fits: Sequence[_Fit], reach: int) -> Autoregression:
    """The fit nearest to the mean of their logarithmic standard deviations, weighted by agreement, with that mean."""
    values = np.sqrt([fit.white + fit.coloured for fit in fits])
    mean = float(np.exp(np.average(np.log(values), weights=[(1.0 - fit.error) ** 2 for fit in fits])))
    best = fits[int(np.argmin(np.abs(np.log(values / mean))))]
    spectrum = NoiseSpectrum(best.correlation, best.white / (best.white + best.coloured))
    return Autoregression(mean, spectrum, False, reach, float(np.sqrt(values.max() / values.min())))


def _candidates(lag: np.ndarray, target: np.ndarray, columns: np.ndarray, parts: int) -> Iterator[_Fit]:
    """The fits that agree with V over its allowed error, `target` (l,)."""
    for k, correlation in enumerate(CORRELATIONS):
        if (correlation == 0.0) != (parts == 1):
            continue
        if correlation > 0.0 and -1.0 / np.log(correlation) > 2.0 * lag[-1]:
            return
        used = [0, k, -1] if parts == 3 else [k, -1]
        variances, _ = nnls(columns[:, used], target)
        error = float(np.max(np.abs(columns[:, used] @ variances - target)))
        if lag.size > len(used) and error < 1.0 and variances[:-1].sum() > 0.0:
            white = float(variances[0]) if parts != 2 else 0.0
            yield _Fit(correlation, white, float(variances[:-1].sum()) - white, error)
