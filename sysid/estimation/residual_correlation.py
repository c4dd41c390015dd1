"""Autocorrelation of the residual, and its cross-correlation with the inputs of the rig.

    r_ee(k) = sum_t e(t) e(t+k) / sum_t e(t)^2
    r_ue(k) = sum_t u(t) e(t+k) / sqrt(sum_t u(t)^2 sum_t e(t)^2)

of series less their means, over all records of a set. White noise stays within `bound` = 2.58/sqrt(n) at 99 % of the
lags. A correlation at positive lags shows dynamics that the model lacks; at negative lags the input depends on the
residual, as under feedback. The bound of r_ue uses Bartlett's variance for correlated series,

    var r_ue = (1/n) sum_j r_ee(j) r_uu(j)

(Ljung, System Identification (1999), sec. 16.6; Box, Jenkins and Reinsel, Time Series Analysis (1994), sec. 11.1.2;
test of all lags together: Ljung and Box, Biometrika 65 (1978) 297). The residual of a driven mass is filtered: there
one sample of each filter width is taken, as in the fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincc

from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, averaged

QUANTILE = 2.5758
"""Two-sided 99 % point of the normal distribution."""

LAGS = 25
LEVEL = 0.01
"""Level of the test for white noise."""
MOST_OUTSIDE = 0.05
"""Share of the lags at which independent series may exceed their 99 % bound."""


@dataclass(frozen=True)
class ResidualCorrelation:
    """Correlations of the residual of a channel: time between neighbouring samples, s, and their number; r_ee at the
    lags 0 .. k, (k + 1,), and its 99 % bound for white noise; r_ue at the lags -k .. k, (2k + 1,), by input, and its 99
    % bound for independent series; p value of the Ljung-Box test that the residual is white."""

    channel: str
    step: float
    samples: int
    autocorrelation: np.ndarray
    bound: float
    cross: Mapping[str, np.ndarray]
    cross_bound: Mapping[str, float]
    p_value: float

    @property
    def is_white(self) -> bool:
        """Whether the Ljung-Box test does not reject white noise at the level of 1 %."""
        return self.p_value > LEVEL

    @property
    def correlated_inputs(self) -> tuple[str, ...]:
        """Inputs whose correlation with the residual exceeds its bound at more lags than chance explains."""
        return tuple(
            name
            for name, r in self.cross.items()
            if int(np.sum(np.abs(r) > self.cross_bound[name])) > MOST_OUTSIDE * r.size
        )

    @property
    def lags(self) -> np.ndarray:
        """Lags of the autocorrelation, s, (k + 1,)."""
        return self.step * np.arange(self.autocorrelation.size)

    @property
    def series(self) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
        """Lags, s, correlations and bound: of the `residual` with itself, and with each input."""
        crossed = {name: (self.cross_lags, r, self.cross_bound[name]) for name, r in self.cross.items()}
        return {"residual": (self.lags, self.autocorrelation, self.bound), **crossed}

    @property
    def cross_lags(self) -> np.ndarray:
        """Lags of the cross-correlations, s, (2k + 1,)."""
        k = self.autocorrelation.size - 1
        return self.step * np.arange(-k, k + 1)


def residual_correlation(
    problem: Problem, model: Model, channel: str, part: str = "fit", lags: int = LAGS
) -> ResidualCorrelation:
    """Correlations of the residual of a model."""
    records = problem.fit_records if part == "fit" else problem.validate_records
    spacing = _spacing(records[0])
    residuals: list[np.ndarray] = []
    inputs: dict[str, list[np.ndarray]] = {}
    for record in records:
        if channel not in record.measured or abs(_spacing(record) - spacing) > 0.01 * spacing:
            continue
        every = round(spacing / record.step)
        predicted = predict(record, model.effects, model.values)[channel]
        residual = np.where(record.valid[channel], record.measured[channel] - predicted, np.nan)[::every]
        residuals.append(residual)
        for name, values in _inputs(problem, record).items():
            inputs.setdefault(name, []).append(np.where(np.isfinite(residual), values[::every], np.nan))
    kept = {name: series for name, series in inputs.items() if len(series) == len(residuals)}
    return correlations(channel, spacing, residuals, kept, lags)


def correlations(
    channel: str,
    step: float,
    residuals: Sequence[np.ndarray],
    inputs: Mapping[str, Sequence[np.ndarray]],
    lags: int = LAGS,
) -> ResidualCorrelation:
    """Correlations of series by record, each (n,), NaN in gaps; `inputs` by channel."""
    e = _centred(residuals)
    n = sum(int(np.isfinite(part).sum()) for part in residuals)
    lags = max(1, min(lags, max(part.size for part in e) - 1))
    acf = _correlation(e, e)
    bound = QUANTILE / np.sqrt(n)
    r = acf[acf.size // 2 :][: lags + 1]
    cross, cross_bound = {}, {}
    for name, series in inputs.items():
        u = _centred(series)
        if not any(part.any() for part in u):
            continue
        middle = acf.size // 2
        cross[name] = _correlation(u, e)[middle - lags : middle + lags + 1]
        # Large lags have few pairs and contain only noise.
        reach = slice(middle - n // 10, middle + n // 10 + 1)
        variance = float(np.sum(acf[reach] * _correlation(u, u)[reach])) / n
        cross_bound[name] = QUANTILE * float(np.sqrt(max(variance, 1.0 / n)))
    k = np.arange(1, r.size)
    statistic = n * (n + 2.0) * float(np.sum(r[1:] ** 2 / (n - k)))
    p_value = float(gammaincc(0.5 * k.size, 0.5 * statistic))
    return ResidualCorrelation(channel, step, n, r, float(bound), cross, cross_bound, p_value)


def _centred(series: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Series less their common mean, zero in gaps."""
    known = np.concatenate([part[np.isfinite(part)] for part in series])
    mean = float(known.mean()) if known.size else 0.0
    return [np.where(np.isfinite(part), part - mean, 0.0) for part in series]


def _correlation(u: Sequence[np.ndarray], e: Sequence[np.ndarray]) -> np.ndarray:
    """Correlation of u(t) with e(t + lag) at every lag up to the longest series, lag zero in the middle."""
    longest = max(part.size for part in e)
    total = np.zeros(2 * longest - 1)
    for a, b in zip(u, e, strict=True):
        lags = a.size + b.size - 1
        size = 1 << (lags - 1).bit_length()
        one = np.roll(np.fft.irfft(np.fft.rfft(b, size) * np.conj(np.fft.rfft(a, size)), size), a.size - 1)[:lags]
        start = longest - a.size
        total[start : start + lags] += one
    norm = np.sqrt(sum(float(a @ a) for a in u) * sum(float(b @ b) for b in e))
    return total / norm if norm > 0.0 else total


def _spacing(record: PreparedRecord) -> float:
    """Time between the samples that a fit scores, s: a filter width of a filtered record."""
    width = record.filter_width
    return max(1, int(width / record.step)) * record.step


def _inputs(problem: Problem, record: PreparedRecord) -> dict[str, np.ndarray]:
    """Logged inputs of the rig at the samples of a prepared record, (n,)."""
    logged = next(r for r in averaged(problem.experiment, problem.records)[1] if r.name == record.name)
    own = record.time
    out = {}
    for name in problem.experiment.rig.declaration.input_channels:
        if name in logged.channels:
            known = np.isfinite(logged.channels[name])
            out[name] = np.interp(logged.time[0] + own, logged.time[known], logged.channels[name][known])
    return out
