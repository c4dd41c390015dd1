"""Intervals of fitted values that stay honest when residuals are correlated in time or uneven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sysid.base_fit import Fitted
from sysid.misfit import blocks
from sysid.model import Prepared

BLOCKS_PER_RECORD = 40


@dataclass(frozen=True)
class Interval:
    """A fitted value with its standard deviation and 95 % interval; infinite where the records do not tell."""

    value: float
    std: float
    low: float
    high: float
    at_bound: bool = False


@dataclass(frozen=True)
class Intervals:
    """Intervals of every fitted value, and how the values hang together.

    Args:
        by_key: by parameter key.
        keys: order of the correlation matrix.
        correlation: (p, p); NaN for a value the records say nothing about.
        unidentified: directions in parameter space that the records do not tell apart, as `a` against `b`, in words.
    """

    by_key: dict[str, Interval]
    keys: tuple[str, ...]
    correlation: np.ndarray
    unidentified: tuple[str, ...]


def intervals(fitted: Fitted, records: Sequence[Prepared]) -> Intervals:
    """95 % intervals from a covariance in which whole blocks of time count as one observation.

        cov = H^-1 (sum_b g_b g_b^T) H^-1 * B/(B - p),   g_b = sum over a block of J^T w r,   H = J^T w J

    with Student's t on B - p degrees of freedom (Liang and Zeger 1986; Cameron and Miller 2015). Correlation within a
    block, filtering and uneven noise widen the interval as they should; sampling faster does not narrow it.
    """
    fit = fitted.fit
    count = len(fit.keys)
    if count == 0:
        return Intervals({}, (), np.empty((0, 0)), ())
    norms = np.linalg.norm(fit.jacobian, axis=0)
    alive = norms > 0.0
    bound = np.array([key in fit.at_bound for key in fit.keys])
    free = alive & ~bound
    scaled = fit.jacobian[:, free] / norms[free]
    weight = fit.weights
    hessian = scaled.T @ (weight[:, None] * scaled)
    values, vectors = np.linalg.eigh(hessian)
    keep = values > 1e-9 * max(values.max(initial=0.0), 1e-300)
    inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T
    numbers = blocks(records, fitted.weights, BLOCKS_PER_RECORD)
    total = int(numbers.max()) + 1
    pulls = np.zeros((total, scaled.shape[1]))
    np.add.at(pulls, numbers, scaled * (weight * fit.residual)[:, None])
    seen = int(np.unique(numbers).size)
    freedom = max(seen - int(free.sum()), 1)
    covariance = inverse @ (pulls.T @ pulls) @ inverse * seen / freedom
    # Never below what independent noise would give: a few lucky blocks are no knowledge.
    spread = np.maximum(np.diag(covariance), np.diag(inverse))
    std = np.full(count, np.inf)
    std[free] = np.sqrt(spread) / norms[free]
    unidentified = []
    keys_free = [k for k, f in zip(fit.keys, free, strict=True) if f]
    for vector in vectors[:, ~keep].T:
        strong = [keys_free[i] for i in np.argsort(-np.abs(vector)) if abs(vector[i]) > 0.3]
        unidentified.append(" against ".join(strong[:3]))
        for key in strong:
            std[fit.keys.index(key)] = np.inf
    reach = _student(freedom) * std
    result = {}
    for k, key in enumerate(fit.keys):
        value = fit.values[key]
        if bound[k]:
            result[key] = Interval(value, float("inf"), float("-inf"), float("inf"), True)
        else:
            result[key] = Interval(value, float(std[k]), value - float(reach[k]), value + float(reach[k]))
    correlation = np.full((count, count), np.nan)
    index = np.flatnonzero(free)
    root = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation[np.ix_(index, index)] = covariance / np.outer(root, root)
    return Intervals(result, fit.keys, correlation, tuple(unidentified))


def _student(freedom: int) -> float:
    """Two-sided 95 % point of Student's t: Cornish-Fisher expansion, within 1 % from three degrees of freedom."""
    z = 1.959964
    if freedom < 3:
        return {1: 12.706, 2: 4.303}[max(freedom, 1)]
    g1 = (z**3 + z) / 4.0
    g2 = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    g3 = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + g1 / freedom + g2 / freedom**2 + g3 / freedom**3
