"""Least squares of a model against prepared records: bounded, scaled, robust to outliers, honest about its columns.

A value known beforehand to a deviation pulls the fit as one more measurement of it would (a normal prior). Where the
model leaves more than the noise, the prior weighs as much more: residuals are then no measure of the values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sysid.experiment.unknowns import Unknown

HUBER = 2.5
"""Residuals beyond this many robust deviations count by their size, not its square."""

ResidualFunction = Callable[[np.ndarray], np.ndarray]


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
        measured: whether the columns are differences at the best values, not from nearby, as the steps amended them.
        precision: what the priors add to the diagonal of J^T w J, (p,); zero where nothing was known.
    """

    values: dict[str, float]
    cost: float
    jacobian: np.ndarray
    residual: np.ndarray
    weights: np.ndarray
    keys: tuple[str, ...]
    at_bound: tuple[str, ...] = ()
    inactive: tuple[str, ...] = ()
    iterations: int = 0
    converged: bool = True
    measured: bool = True
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
    function: ResidualFunction,
    point: np.ndarray,
    base: np.ndarray,
    unknowns: Sequence[Unknown],
    known: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Forward (at a high bound, backward) differences (n, p) of the residual, but for the columns that are known."""
    out = np.empty((base.size, point.size), order="F")
    for k, unknown in enumerate(unknowns):
        if known is not None and unknown.key in known:
            out[:, k] = known[unknown.key]
            continue
        step = 1e-5 * max(abs(point[k]), unknown.size)
        if point[k] + step > unknown.high:
            step = -step
        moved = point.copy()
        moved[k] += step
        out[:, k] = (function(moved) - base) / step
    return out


@dataclass(frozen=True)
class _Loss:
    """What a fit makes small: Huber's loss of a residual at a fixed scale, and what the priors add.

    Args:
        scale: of the residual; infinite for plain squares.
        priors: of the values.
    """

    scale: float
    priors: _Priors

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Robust weights (n,)."""
        return huber_weights(residual, self.scale) if np.isfinite(self.scale) else np.ones_like(residual)

    def of_residual(self, residual: np.ndarray) -> float:
        """Of a residual (n,) alone."""
        return huber_cost(residual, self.scale) if np.isfinite(self.scale) else 0.5 * float(residual @ residual)

    def __call__(self, residual: np.ndarray, point: np.ndarray) -> float:
        """Of a residual (n,) at a point (p,); endless where there is no number."""
        if not np.isfinite(residual).all():
            return np.inf
        return self.of_residual(residual) + self.priors.cost(point, self.scale)


@dataclass(frozen=True)
class _Bowl:
    """The loss near a point as its columns foretell it: a quadratic form of the values that are free to move.

    Args:
        free: which values move, (p,).
        norms: of all columns, (p,).
        normal: of the scaled values, (f, f).
        right: its negative gradient, (f,).
    """

    free: np.ndarray
    norms: np.ndarray
    normal: np.ndarray
    right: np.ndarray

    def step(self, damping: float) -> tuple[np.ndarray, float] | None:
        """Step (p,) to its lowest point, damped, and by how much the loss would fall; none where there is none."""
        try:
            scaled = np.linalg.solve(self.normal + damping * np.diag(np.diag(self.normal) + 1e-12), self.right)
        except np.linalg.LinAlgError:
            return None
        out = np.zeros(self.free.size)
        out[self.free] = scaled / self.norms[self.free]
        return out, float(scaled @ (self.right - 0.5 * self.normal @ scaled))


def _bowl(
    columns: np.ndarray, base: np.ndarray, point: np.ndarray, loss: _Loss, low: np.ndarray, high: np.ndarray
) -> _Bowl | None:
    """The loss around a point; none where no value is free to move.

    A value whose gradient pushes it through its bound is held there, and a column of zeros is left out.
    """
    precision = loss.priors.precision(loss.scale)
    weighted = loss.weights(base)[:, None] * columns
    normal = columns.T @ weighted
    gradient = weighted.T @ base + precision * (point - loss.priors.value)
    norms = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    blocked = ((point <= low) & (gradient > 0)) | ((point >= high) & (gradient < 0))
    free = (norms > 0.0) & ~blocked
    if not free.any():
        return None
    lengths = norms[free]
    scaled = normal[np.ix_(free, free)] / np.outer(lengths, lengths) + np.diag(precision[free] / lengths**2)
    return _Bowl(free, norms, scaled, -gradient[free] / lengths)


TRIES = 8
"""Steps tried from one point, each ten times as damped as the one before."""

AS_FORETOLD = 0.4
"""Part of the drop of loss that the columns foretold, or of the one found, from which the step amends the columns."""

NO_DROP = 0.01
"""Part of the tolerance below which a foretold drop is tried once, and no more."""


def least_squares(
    function: ResidualFunction,
    unknowns: Sequence[Unknown],
    robust: bool = True,
    iterations: int = 25,
    tolerance: float = 1e-5,
    known: Mapping[str, np.ndarray] | None = None,
    exact_jacobian: bool = False,
    final_jacobian: bool = True,
) -> FitResult:
    """Levenberg-Marquardt within bounds on a weighted residual, with Huber weights renewed at every step.

    A value whose gradient pushes it through its bound is held there for the step; a column of zeros is left out and
    reported. Both would otherwise stall the fit in silence.

    A prediction costs far more than a step: while the columns of differences foretell what steps do, each step amends
    them (C. G. Broyden, Math. Comp. 19 (1965) 577); measured anew, they have the last word, and are what is returned.

    Args:
        function: weighted residual (n,) at a point (p,).
        unknowns: what is moved.
        robust: Huber's loss at a scale taken from the residual, else plain squares.
        iterations: at most so many accepted or refused steps.
        tolerance: relative change of cost at which it stops.
        known: columns (n,) of the residual's differences by key, as they were at a point near the start.
        as_measured: they are those of the start itself.
        last_word: measure the columns that are returned anew; without, they are as the steps left them.
    """
    point = np.array([min(max(u.start, u.low), u.high) for u in unknowns], dtype=float)
    base = function(point)
    keys = tuple(u.key for u in unknowns)
    priors = _Priors(unknowns)
    low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])

    def loss_here() -> _Loss:
        return _Loss(robust_scale(base) if robust else np.inf, priors)

    columns, measured = jacobian(function, point, base, unknowns, known), exact_jacobian or not known
    inactive = tuple(sorted(keys[k] for k in np.flatnonzero(~columns.any(axis=0))))
    damping, accepted, left = 1e-4, 0, iterations if unknowns else 0
    converged = not unknowns
    while left > 0 and not converged:
        loss = loss_here()
        cost = loss(base, point)
        bowl = _bowl(columns, base, point, loss, low, high)
        new, new_cost, trial = base, np.inf, point
        for _ in range(TRIES if bowl is not None else 0):
            assert bowl is not None
            found = bowl.step(damping)
            if found is not None:
                trial = np.clip(point + found[0], low, high)
                new = function(trial)
                new_cost = loss(new, trial)
                if new_cost < cost:
                    damping = max(damping * 0.1, 1e-9)
                    break
                if not measured or found[1] < NO_DROP * tolerance * cost:
                    break
            damping *= 10.0
        if not new_cost < cost:
            if measured:
                converged = True
            else:
                columns, measured = jacobian(function, point, base, unknowns), True
            continue
        left -= 1
        accepted += 1
        assert bowl is not None
        moved = trial - point
        foretold = base + columns @ moved
        fell, should = cost - new_cost, cost - loss(foretold, trial)
        point, base = trial, new
        settled = fell < tolerance * cost
        if settled or not AS_FORETOLD * should < fell < should / AS_FORETOLD:
            converged = settled and measured
            columns, measured = jacobian(function, point, base, unknowns), True
        else:
            lengths = bowl.norms**2 * moved
            columns, measured = columns + np.outer(lengths / float(lengths @ moved), base - foretold).T, False
    if not measured and final_jacobian:
        columns, measured = jacobian(function, point, base, unknowns), True
    loss = loss_here()
    at_bound = tuple(u.key for u, value in zip(unknowns, point, strict=True) if (value <= u.low or value >= u.high))
    return FitResult(
        values=dict(zip(keys, point.tolist(), strict=True)),
        cost=loss.of_residual(base),
        jacobian=columns, residual=base, weights=loss.weights(base), keys=keys, at_bound=at_bound,
        inactive=inactive, iterations=accepted, converged=converged, measured=measured,
        precision=priors.precision(loss.scale),
    )  # fmt: skip
