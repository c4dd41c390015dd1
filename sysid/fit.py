"""Least squares of a model against prepared records: bounded, scaled, robust to outliers, honest about its columns.

A value known beforehand to a deviation pulls the fit as one more measurement of it would (a normal prior). Where the
model leaves more than the noise, the prior weighs as much more: residuals are then no measure of the values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

HUBER = 2.5
"""Residuals beyond this many robust deviations count by their size, not its square."""

ResidualFunction = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Prior:
    """What is known of a number before the fit: its value and standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Unknown:
    """One number a fit moves: its key, start, bounds, typical size, and what was known of it beforehand."""

    key: str
    start: float
    low: float
    high: float
    size: float
    prior: Prior | None = None


@dataclass
class FitResult:
    """Outcome of a fit.

    Args:
        values: best values by key.
        cost: half the robust sum of squares of the weighted residual.
        jacobian: of the weighted residual at the best values, (n, p), without robust weights.
        residual: weighted residual (n,).
        weights: robust weights (n,) in (0, 1].
        at_bound: keys of values that ended on a bound.
        dead: keys whose change did not change the prediction at the start.
        iterations: accepted steps.
        converged: whether the last step was small.
        precision: what the priors add to the diagonal of J^T w J, (p,); zero where nothing was known.
    """

    values: dict[str, float]
    cost: float
    jacobian: np.ndarray
    residual: np.ndarray
    weights: np.ndarray
    keys: tuple[str, ...]
    at_bound: tuple[str, ...] = ()
    dead: tuple[str, ...] = ()
    iterations: int = 0
    converged: bool = True
    precision: np.ndarray = field(default_factory=lambda: np.empty(0))


def huber_weights(residual: np.ndarray, scale: float) -> np.ndarray:
    """Weights (n,) of Huber's loss with the corner at `HUBER` times `scale`."""
    size = np.abs(residual)
    corner = HUBER * scale
    return np.where(size <= corner, 1.0, corner / np.maximum(size, 1e-300))


def robust_scale(residual: np.ndarray) -> float:
    """1.4826 times the median absolute residual; the rms where more than half the residual is exactly zero."""
    scale = 1.4826 * float(np.median(np.abs(residual)))
    return scale if scale > 0.0 else float(np.sqrt(np.mean(residual**2))) or 1.0


def huber_cost(residual: np.ndarray, scale: float) -> float:
    """Sum of Huber's loss over the residual (n,)."""
    size = np.abs(residual)
    corner = HUBER * scale
    inner = np.minimum(size, corner)
    # A step too far may make residuals beyond all numbers: their cost is endless, and the step is not taken.
    with np.errstate(over="ignore"):
        return float(np.sum(0.5 * inner**2 + corner * (size - inner)))


VAST = 1e100
"""As large as a scale may count: its square is still a number."""


class _Priors:
    """The priors of a fit as sums: precision (p,) at a residual scale, cost and gradient at a point."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        self.value = np.array([0.0 if u.prior is None else u.prior.value for u in unknowns])
        self.inverse = np.array([0.0 if u.prior is None else max(u.prior.std, 1.0 / VAST) ** -2 for u in unknowns])

    def precision(self, scale: float) -> np.ndarray:
        """Weight (p,) of each prior beside residuals of this scale: they are no better than what the model leaves."""
        return self.inverse * (min(max(scale, 1.0), VAST) ** 2 if np.isfinite(scale) else 1.0)

    def cost(self, point: np.ndarray, scale: float) -> float:
        """What the priors add to the cost at a point (p,)."""
        return 0.5 * float(np.sum(self.precision(scale) * (point - self.value) ** 2))


def jacobian(
    function: ResidualFunction, point: np.ndarray, base: np.ndarray, unknowns: Sequence[Unknown]
) -> np.ndarray:
    """Forward (at a high bound, backward) differences (n, p) of the residual."""
    out = np.empty((base.size, point.size))
    for k, unknown in enumerate(unknowns):
        step = 1e-5 * max(abs(point[k]), unknown.size)
        if point[k] + step > unknown.high:
            step = -step
        moved = point.copy()
        moved[k] += step
        out[:, k] = (function(moved) - base) / step
    return out


def least_squares(
    function: ResidualFunction,
    unknowns: Sequence[Unknown],
    robust: bool = True,
    iterations: int = 25,
    tolerance: float = 1e-5,
) -> FitResult:
    """Levenberg-Marquardt within bounds on a weighted residual, with Huber weights renewed at every step.

    A value whose gradient pushes it through its bound is held there for the step; a column of zeros is left out and
    reported. Both would otherwise stall the fit in silence.

    Args:
        function: weighted residual (n,) at a point (p,).
        unknowns: what is moved.
        robust: Huber's loss at a scale taken from the residual, else plain squares.
        iterations: at most so many accepted or refused steps.
        tolerance: relative change of cost at which it stops.
    """
    point = np.array([min(max(u.start, u.low), u.high) for u in unknowns], dtype=float)
    base = function(point)
    keys = tuple(u.key for u in unknowns)
    if not unknowns:
        scale = robust_scale(base)
        weights = huber_weights(base, scale) if robust else np.ones_like(base)
        return FitResult({}, huber_cost(base, scale), np.empty((base.size, 0)), base, weights, keys)
    damping = 1e-4
    priors = _Priors(unknowns)
    low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
    dead: set[str] = set()
    accepted = 0
    converged = False
    columns = jacobian(function, point, base, unknowns)
    first = True
    for _ in range(iterations):
        scale = robust_scale(base) if robust else np.inf
        weights = huber_weights(base, scale) if robust else np.ones_like(base)
        cost = (huber_cost(base, scale) if robust else 0.5 * float(base @ base)) + priors.cost(point, scale)
        precision = priors.precision(scale)
        norms = np.sqrt(np.einsum("ij,ij->j", columns, columns))
        alive = norms > 0.0
        if first:
            dead = {keys[k] for k in np.flatnonzero(~alive)}
            first = False
        gradient = columns.T @ (weights * base) + precision * (point - priors.value)
        blocked = ((point <= low) & (gradient > 0)) | ((point >= high) & (gradient < 0))
        free = alive & ~blocked
        if not free.any():
            converged = True
            break
        scaled = columns[:, free] / norms[free]
        normal = scaled.T @ (weights[:, None] * scaled) + np.diag(precision[free] / norms[free] ** 2)
        right = -gradient[free] / norms[free]
        improved = False
        for _ in range(8):
            try:
                step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), right) / norms[free]
            except np.linalg.LinAlgError:
                damping *= 10.0
                continue
            trial = point.copy()
            trial[free] = np.clip(point[free] + step, low[free], high[free])
            new = function(trial)
            new_cost = (
                (huber_cost(new, scale) if robust else 0.5 * float(new @ new)) + priors.cost(trial, scale)
                if np.isfinite(new).all()
                else np.inf
            )
            if new_cost < cost:
                improved = True
                damping = max(damping * 0.1, 1e-9)
                break
            damping *= 10.0
        if not improved:
            converged = True
            break
        accepted += 1
        drop = (cost - new_cost) / max(cost, 1e-300)
        point, base = trial, new
        columns = jacobian(function, point, base, unknowns)
        if drop < tolerance:
            converged = True
            break
    scale = robust_scale(base)
    weights = huber_weights(base, scale) if robust else np.ones_like(base)
    at_bound = tuple(u.key for u, value in zip(unknowns, point, strict=True) if (value <= u.low or value >= u.high))
    return FitResult(
        values=dict(zip(keys, point.tolist(), strict=True)),
        cost=huber_cost(base, scale) if robust else 0.5 * float(base @ base),
        jacobian=columns, residual=base, weights=weights, keys=keys, at_bound=at_bound,
        dead=tuple(sorted(dead)), iterations=accepted, converged=converged,
        precision=priors.precision(scale if robust else np.inf),
    )  # fmt: skip
