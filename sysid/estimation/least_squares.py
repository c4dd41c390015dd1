"""Bounded, robust nonlinear least squares of a model against records (Levenberg-Marquardt with Broyden updates).

The objective is Huber's loss of the weighted residual plus the normal priors of values known beforehand,

    F(p) = sum_i rho(r_i(p)) + sum_k (s / std_k)^2 (p_k - value_k)^2 / 2

with s the scale of the residual, at least 1: if the residual exceeds the noise, the priors have more weight relative to
the records.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stagecad.processes import map_threads
from sysid.experiment.known import Unknown

HUBER = 2.5
"""Corner of Huber's loss, in robust standard deviations of the residual."""

ResidualFunction = Callable[[np.ndarray], np.ndarray]


@dataclass
class FitResult:
    """Outcome of a fit: best values by key; half the robust sum of squares of the weighted residual; Jacobian of that
    (n, p) at the best values, without robust weights; the residual (n,) and these weights (n,) in (0, 1]; keys in the
    order of the columns; keys of values on a bound, and of those with a zero column at the start; accepted steps;
    whether the last one was small; whether the Jacobian is exact, not from Broyden updates; and the term of the priors
    on the diagonal of J^T w J, (p,), zero without a prior."""

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
    exact: bool = True
    precision: np.ndarray = field(default_factory=lambda: np.empty(0))


def huber_weights(residual: np.ndarray, scale: float) -> np.ndarray:
    """Weights (n,) of Huber's loss with its corner at `HUBER` times `scale`."""
    size = np.abs(residual)
    corner = HUBER * scale
    return np.divide(corner, size, out=np.ones_like(size), where=size > corner)


HELD = 1e-3
"""Part of the noise within which a residual is determined by nothing: friction holds the body against the measured
force, or a channel rests. Of noise, one sample in 1250 is so small."""

LEAST_SHARE = 0.1
"""Share of the samples that must exceed it; otherwise the noise is stated far too large, and all count."""


def robust_scale(residual: np.ndarray) -> float:
    """1.4826 times the median absolute residual (n,), without the samples that are determined by nothing."""
    size = np.abs(residual[residual != 0.0])
    free = size[size > HELD]
    size = free if free.size > LEAST_SHARE * residual.size else size
    return 1.4826 * float(np.median(size)) if size.size else 1.0


LARGEST_SCALE = 1e100
"""Upper limit of a scale, so that its square does not overflow."""


def jacobian(
    function: ResidualFunction,
    point: np.ndarray,
    base: np.ndarray,
    unknowns: Sequence[Unknown],
    known: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Jacobian (n, p) by forward differences, backward at an upper bound, at a point (p,) with residual `base` (n,);
    the columns (n,) that are `known`, by key, are not computed."""
    out = np.empty((base.size, point.size), order="F")

    def column(k: int) -> np.ndarray:
        unknown = unknowns[k]
        if known is not None and unknown.key in known:
            return known[unknown.key]
        step = 1e-5 * max(abs(point[k]), unknown.size)
        if point[k] + step > unknown.high:
            step = -step
        moved = point.copy()
        moved[k] += step
        return (function(moved) - base) / step

    for k, values in enumerate(map_threads(column, range(point.size))):
        out[:, k] = values
    return out


class _Problem:
    """Optimisation problem: the residual function, the unknowns with bounds (p,) and priors, and the kind of loss. The
    objective depends on the scale of the residual, which is infinite for plain squares."""

    def __init__(self, function: ResidualFunction, unknowns: Sequence[Unknown], robust: bool) -> None:
        self.function, self.unknowns, self.robust = function, unknowns, robust
        self.low, self.high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
        self.expected = np.array([0.0 if u.prior is None else u.prior.value for u in unknowns])
        stds = [np.inf if u.prior is None else max(u.prior.std, 1.0 / LARGEST_SCALE) for u in unknowns]
        self.inverse = np.array([std**-2 for std in stds])

    def scale(self, residual: np.ndarray) -> float:
        """Scale of a residual (n,)."""
        return robust_scale(residual) if self.robust else np.inf

    def precision(self, scale: float) -> np.ndarray:
        """Precision (p,) of the priors at a scale of the residual."""
        return self.inverse * (min(max(scale, 1.0), LARGEST_SCALE) ** 2 if np.isfinite(scale) else 1.0)

    def weights(self, residual: np.ndarray, scale: float) -> np.ndarray:
        """Robust weights (n,)."""
        return huber_weights(residual, scale) if np.isfinite(scale) else np.ones_like(residual)

    def loss(self, residual: np.ndarray, scale: float) -> float:
        """Sum of Huber's loss over a residual (n,), or half the sum of squares."""
        if not np.isfinite(scale):
            return 0.5 * float(residual @ residual)
        size, corner = np.abs(residual), HUBER * scale
        inner = np.minimum(size, corner)
        # Too long a step may overflow the residual: its cost is infinite, and the step is rejected.
        with np.errstate(over="ignore"):
            return float(np.sum(0.5 * inner**2 + corner * (size - inner)))

    def objective(self, residual: np.ndarray, point: np.ndarray, scale: float) -> float:
        """Loss and priors at a point (p,) with its residual (n,); infinite where the residual is not finite."""
        if not np.isfinite(residual).all():
            return np.inf
        return self.loss(residual, scale) + 0.5 * float(np.sum(self.precision(scale) * (point - self.expected) ** 2))


@dataclass(frozen=True)
class _Iterate:
    """A point (p,) with its residual (n,) and Jacobian (n, p); `exact` if the Jacobian was computed there."""

    point: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    exact: bool

    def measured(self, problem: _Problem) -> _Iterate:
        """This point with the Jacobian by differences."""
        columns = jacobian(problem.function, self.point, self.residual, problem.unknowns)
        return _Iterate(self.point, self.residual, columns, True)


@dataclass(frozen=True)
class _QuadraticModel:
    """Gauss-Newton model of the objective near a point, of the values that are `free` to move (f of p): `norms` of all
    columns (p,), J^T w J of the scaled free values (f, f), and its negative gradient (f,)."""

    free: np.ndarray
    norms: np.ndarray
    normal: np.ndarray
    right: np.ndarray

    def step(self, damping: float) -> tuple[np.ndarray, float] | None:
        """Damped step (p,) to the minimum and the predicted reduction; None if the equations are singular."""
        try:
            scaled = np.linalg.solve(self.normal + damping * np.diag(np.diag(self.normal) + 1e-12), self.right)
        except np.linalg.LinAlgError:
            return None
        out = np.zeros(self.free.size)
        out[self.free] = scaled / self.norms[self.free]
        return out, float(scaled @ (self.right - 0.5 * self.normal @ scaled))


def _quadratic_model(problem: _Problem, at: _Iterate, scale: float) -> _QuadraticModel | None:
    """The quadratic model at an iterate, None if no value is free: one at its bound with a descent direction out of it
    is fixed, and columns that are zero or overflow are left out, since each of them would stop the fit."""
    precision = problem.precision(scale)
    with np.errstate(over="ignore", invalid="ignore"):
        norms = np.sqrt(np.einsum("ij,ij->j", at.jacobian, at.jacobian))
    known = np.isfinite(norms)
    columns = at.jacobian if known.all() else np.where(known, at.jacobian, 0.0)
    norms = np.where(known, norms, 0.0)
    weighted = problem.weights(at.residual, scale)[:, None] * columns
    normal = columns.T @ weighted
    gradient = weighted.T @ at.residual + precision * (at.point - problem.expected)
    blocked = ((at.point <= problem.low) & (gradient > 0)) | ((at.point >= problem.high) & (gradient < 0))
    free = (norms > 0.0) & ~blocked
    if not free.any():
        return None
    lengths = norms[free]
    scaled = normal[np.ix_(free, free)] / np.outer(lengths, lengths) + np.diag(precision[free] / lengths**2)
    return _QuadraticModel(free, norms, scaled, -gradient[free] / lengths)


ATTEMPTS = 8
"""Largest number of steps tried from one point, each with ten times the damping of the previous one."""

LEAST_GAIN_RATIO = 0.4
"""Ratio of the smaller to the larger of predicted and actual reduction, above which the Jacobian is updated instead of
computed."""

LARGEST_FACTOR = 10.0
"""Largest factor by which one step changes a value whose lower bound is positive (a velocity, a length, a time). While
the amplitude of an effect is small, its shape has a small gradient, and the undamped step in the shape is too large."""

NEGLIGIBLE_REDUCTION = 0.01
"""Fraction of the tolerance below which only one step is tried for a predicted reduction."""


def _trial_step(
    problem: _Problem, at: _Iterate, scale: float, model: _QuadraticModel, damping: float, tolerance: float
) -> tuple[tuple[np.ndarray, np.ndarray, float] | None, float]:
    """Point, residual and cost of the first damped step that lowers the objective (None if no step does), and the
    damping of the next step. With an updated Jacobian only one step is tried."""
    cost = problem.objective(at.residual, at.point, scale)
    positive = problem.low > 0.0
    low = np.where(positive, np.maximum(problem.low, at.point / LARGEST_FACTOR), problem.low)
    high = np.where(positive, np.minimum(problem.high, at.point * LARGEST_FACTOR), problem.high)
    for _ in range(ATTEMPTS):
        found = model.step(damping)
        if found is not None:
            point = np.clip(at.point + found[0], low, high)
            residual = problem.function(point)
            new_cost = problem.objective(residual, point, scale)
            if new_cost < cost:
                return (point, residual, new_cost), max(damping * 0.1, 1e-9)
            if not at.exact or found[1] < NEGLIGIBLE_REDUCTION * tolerance * cost:
                break
        damping *= 10.0
    return None, damping


def _broyden_update(at: _Iterate, point: np.ndarray, residual: np.ndarray, norms: np.ndarray) -> _Iterate:
    """The iterate at an accepted point with Broyden's rank-one update of the Jacobian, columns scaled by `norms`."""
    moved = point - at.point
    predicted = at.residual + at.jacobian @ moved
    lengths = norms**2 * moved
    # Computed as a transpose, so that columns stay contiguous in memory.
    updated = at.jacobian + np.outer(lengths / float(lengths @ moved), residual - predicted).T
    return _Iterate(point, residual, updated, False)


MOST_STEPS = 25
"""Accepted steps after which a fit that is to be compared stops, and is reported as not converged."""


def least_squares(
    function: ResidualFunction,
    unknowns: Sequence[Unknown],
    robust: bool = True,
    iterations: int = MOST_STEPS,
    tolerance: float = 1e-5,
    known: Mapping[str, np.ndarray] | None = None,
    exact_jacobian: bool = False,
    final_jacobian: bool = True,
) -> FitResult:
    """Minimise a weighted residual within bounds by Levenberg-Marquardt, with new Huber weights at every step.

    Predictions dominate the computing time. While the gain ratio (actual over predicted reduction of the objective) is
    near one, the Jacobian is approximated by Broyden's update (C. G. Broyden, Math. Comp. 19 (1965) 577); otherwise,
    and before convergence is declared, it is computed by differences.

    Args:
        function: weighted residual (n,) at a point (p,).
        unknowns: of the fit.
        robust: Huber's loss at a scale estimated from the residual; otherwise squares.
        iterations: largest number of accepted steps.
        tolerance: relative reduction of the objective at which the iteration stops.
        known: columns (n,) of the Jacobian at a point near the start, by key.
        exact_jacobian: the known columns are exact at the start.
        final_jacobian: compute the returned Jacobian by differences; otherwise it is the last Broyden update.
    """
    keys = tuple(u.key for u in unknowns)
    problem = _Problem(function, unknowns, robust)
    point = np.array([min(max(u.start, u.low), u.high) for u in unknowns], dtype=float)
    residual = function(point)
    columns = jacobian(function, point, residual, unknowns, known)
    at = _Iterate(point, residual, columns, exact_jacobian or not known)
    inactive = tuple(sorted(keys[k] for k in np.flatnonzero(~columns.any(axis=0))))
    damping, accepted, converged = 1e-4, 0, not unknowns
    while accepted < iterations and not converged:
        scale = problem.scale(at.residual)
        model, trial = _quadratic_model(problem, at, scale), None
        if model is not None:
            trial, damping = _trial_step(problem, at, scale, model, damping, tolerance)
        if model is None or trial is None:
            converged = at.exact
            at = at if at.exact else at.measured(problem)
            continue
        accepted += 1
        point, residual, new_cost = trial
        cost = problem.objective(at.residual, at.point, scale)
        actual = cost - new_cost
        predicted = cost - problem.objective(at.residual + at.jacobian @ (point - at.point), point, scale)
        small = actual < tolerance * cost
        if small or not LEAST_GAIN_RATIO * predicted < actual < predicted / LEAST_GAIN_RATIO:
            converged = small and at.exact
            at = _Iterate(point, residual, at.jacobian, False)
            at = at if converged or accepted == iterations else at.measured(problem)
        else:
            at = _broyden_update(at, point, residual, model.norms)
    if not at.exact and final_jacobian:
        at = at.measured(problem)
    scale = problem.scale(at.residual)
    return FitResult(
        values=dict(zip(keys, at.point.tolist(), strict=True)),
        cost=problem.loss(at.residual, scale),
        jacobian=at.jacobian,
        residual=at.residual,
        weights=problem.weights(at.residual, scale),
        keys=keys,
        at_bound=tuple(u.key for u, v in zip(unknowns, at.point, strict=True) if v <= u.low or v >= u.high),
        inactive=inactive,
        iterations=accepted,
        converged=converged,
        exact=at.exact,
        precision=problem.precision(scale),
    )
