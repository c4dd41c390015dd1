"""Intervals of fitted values that stay honest when residuals are correlated in time or uneven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import blocks
from sysid.estimation.systematic_errors import systematic_errors
from sysid.prediction.model import PreparedRecord

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


def intervals(fitted: FittedModel, records: Sequence[PreparedRecord]) -> Intervals:
    """95 % intervals from a covariance in which whole blocks of time count as one observation.

        cov = H^-1 (sum_b g_b g_b^T + (g_b g_b+1^T + g_b+1 g_b^T)/2) H^-1 * (B - 1)/B
        g_b = (I - H_b H^-1)^-1 sum over a block of J^T w r,   H = sum_b H_b = J^T J within Huber's corner

    with Student's t on 2/3 B - p degrees of freedom. The factor before the sum undoes that a block has pulled the fit
    towards itself, and a value that one block alone tells becomes uncertain (CR3: Bell and McCaffrey 2002; Cameron and
    Miller 2015). The half of the neighbour's product is Bartlett's weight (Newey and West 1987) for correlation across
    the edge of a block; it costs a third of the freedom. Correlation, filtering and uneven noise widen the interval as
    they should; sampling faster does not narrow it. What was known before the fit enters as one more observation. What
    the comparison itself may be wrong by (`sysid.estimation.systematic_errors`) is added, value by value together.
    """
    fit = fitted.fit
    count = len(fit.keys)
    if count == 0:
        return Intervals({}, (), np.empty((0, 0)), ())
    norms = np.linalg.norm(fit.jacobian, axis=0)
    precision = fit.precision if fit.precision.size == count else np.zeros(count)
    size = np.where(norms > 0.0, norms, np.sqrt(precision))
    bound = np.array([key in fit.at_bound for key in fit.keys])
    free = (size > 0.0) & ~bound
    columns = fit.jacobian[:, free] / size[free]
    known = precision[free] / size[free] ** 2
    deviations = np.array([0.0 if u.prior is None else u.prior.std for u in fitted.model.unknowns])[free] * size[free]
    # The slope of Huber's influence, not its weight: beyond the corner a residual no longer pulls harder.
    inner = np.where(fit.weights >= 1.0, 1.0, 0.0)
    values, vectors = np.linalg.eigh(columns.T @ (inner[:, None] * columns) + np.diag(known))
    keep = values > 1e-9 * max(values.max(initial=0.0), 1e-300)
    root = vectors[:, keep] / np.sqrt(values[keep])

    numbers = blocks(records, fitted.weights, BLOCKS_PER_RECORD)
    pulls = _pulls(columns @ root, inner, fit.weights * fit.residual, numbers)
    crossed = pulls[:-1].T @ pulls[1:]
    for last in range(BLOCKS_PER_RECORD, pulls.shape[0], BLOCKS_PER_RECORD):
        # The last block of a record has no neighbour in the next.
        crossed -= np.outer(pulls[last - 1], pulls[last])
    seen = int(np.unique(numbers).size)
    told = (pulls.T @ pulls + 0.5 * (crossed + crossed.T)) * (seen - 1) / seen
    covariance = root @ (told + root.T @ np.diag((known * deviations) ** 2) @ root) @ root.T

    for change in systematic_errors(fitted, records):
        shift = root @ (root.T @ (columns.T @ (inner * change)))
        covariance += np.outer(shift, shift)

    # Never below what independent noise would give: a few lucky blocks are no knowledge.
    spread = np.maximum(np.diag(covariance), np.diag(root @ root.T))
    std = np.full(count, np.inf)
    std[free] = np.sqrt(spread) / size[free]
    unidentified = []
    keys_free = [k for k, f in zip(fit.keys, free, strict=True) if f]
    for vector in vectors[:, ~keep].T:
        strong = [keys_free[i] for i in np.argsort(-np.abs(vector)) if abs(vector[i]) > 0.3]
        unidentified.append(" against ".join(strong[:3]))
        for key in strong:
            std[fit.keys.index(key)] = np.inf
    reach = _student(max(int(seen / 1.5) - int(free.sum()), 1)) * std
    result = {}
    for k, key in enumerate(fit.keys):
        value = fit.values[key]
        if bound[k]:
            result[key] = Interval(value, float("inf"), float("-inf"), float("inf"), True)
        else:
            result[key] = Interval(value, float(std[k]), value - float(reach[k]), value + float(reach[k]))
    correlation = np.full((count, count), np.nan)
    index = np.flatnonzero(free)
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation[np.ix_(index, index)] = covariance / np.outer(scale, scale)
    return Intervals(result, fit.keys, correlation, tuple(unidentified))


MOST_LEVERAGE = 0.98
"""Share of what is known in some direction, told by one block, from which that block is not corrected further."""


def _pulls(columns: np.ndarray, inner: np.ndarray, influence: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Pull (B, p) of each block of time on the values, as if the block had not taken part in the fit.

    Args:
        columns: sensitivities (n, p) in coordinates in which J^T J is the unit matrix.
        inner: 1 where a residual is within Huber's corner, else 0, (n,).
        influence: Huber's influence of each residual, (n,).
        numbers: of the block of each sample, (n,).
    """
    pulls = np.zeros((int(numbers.max()) + 1, columns.shape[1]))
    np.add.at(pulls, numbers, columns * influence[:, None])
    order = np.argsort(numbers, kind="stable")
    edges = np.searchsorted(numbers[order], np.arange(pulls.shape[0] + 1))
    for b in range(pulls.shape[0]):
        own = columns[order[edges[b] : edges[b + 1]]] * inner[order[edges[b] : edges[b + 1]], None]
        share, axes = np.linalg.eigh(own.T @ own)
        pulls[b] = axes @ ((axes.T @ pulls[b]) / (1.0 - np.minimum(share, MOST_LEVERAGE)))
    return pulls


def _student(freedom: int) -> float:
    """Two-sided 95 % point of Student's t: Cornish-Fisher expansion, within 1 % from three degrees of freedom."""
    z = 1.959964
    if freedom < 3:
        return {1: 12.706, 2: 4.303}[max(freedom, 1)]
    g1 = (z**3 + z) / 4.0
    g2 = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    g3 = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + g1 / freedom + g2 / freedom**2 + g3 / freedom**3
