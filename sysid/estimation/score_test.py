"""What an effect promises before it is fitted: how much of the residual small amplitudes of it could take.

An effect's amplitudes enter the residual linearly while they are small; its shape parameters (a Stribeck velocity, a
pitch, a lag) have no gradient where the effect is absent, so they are searched on a grid, and at each grid point the
drop in squared residual is found with the base model's parameters free to move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.library.effect import Effect
from sysid.estimation.fit import FittedModel
from sysid.estimation.least_squares import robust_scale
from sysid.estimation.misfit import weighted_residual
from sysid.prediction.model import PreparedRecord, Scales, shape_grid, size_of, with_effect

KEPT_SCORES = 6
"""Grid points of an effect that are remembered: starts for its refit."""

IN_PAIRS = 2
"""Of those, the ones that enter pairs of effects, and keep their columns for it."""

EVERY_ROW = slice(None)

WINSOR = 8.0
"""Robust deviations beyond which a residual counts no more in the linear score."""


@dataclass(frozen=True)
class ScoreStatistic:
    """Linear score of an effect at one grid point.

    Args:
        drop: expected share of the squared residual that goes, base parameters free.
        start: values to start a refit from.
        shape: the grid point.
        moves: parameter values of each move, amplitudes away from zero.
        columns: what each move does to the residual beyond what the base parameters can do, (n, k); none of the scores
            beyond the first `IN_PAIRS` of an effect.
        barred: drop that amplitudes beyond their bounds (a negative drag) would have made.
        whole: of a core, the drop as it stands: it is there or not, half of it is no model.
    """

    predicted_reduction: float
    start: dict[str, float]
    shape: dict[str, float]
    directions: list[dict[str, float]]
    columns: np.ndarray
    blocked_reduction: float = 0.0
    full_step_reduction: float = 0.0


def project_out(columns: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Part of each column (n, k) that the orthonormal `base` (n, p) cannot make."""
    return columns - base @ (base.T @ columns)


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis (n, r) of the span of the columns, dead and dependent ones left out."""
    norms = np.linalg.norm(columns, axis=0)
    alive = norms > 0.0
    if not alive.any():
        return np.empty((columns.shape[0], 0))
    scaled = columns[:, alive] / norms[alive]
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return u[:, s > 1e-8 * s[0]]


@dataclass(frozen=True)
class GridPoint:
    """What an effect does to a model's residual at one point of its shape grid, while its amplitudes are small.

    Args:
        shape: the grid point.
        moves: parameter values of each move, amplitudes away from zero.
        changes: of the residual at some of its rows by each move, (n, k).
    """

    shape: dict[str, float]
    directions: list[dict[str, float]]
    changes: np.ndarray


def candidate_directions(
    base: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, rows: slice = EVERY_ROW
) -> list[GridPoint]:
    """An effect at every point of its shape grid on top of a fitted model.

    Args:
        base: the fitted model.
        effect: the candidate.
        records: those fitted.
        scales: of the records.
        rows: of the residual that are kept.
    """
    residual = base.fit.residual
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    phases = [p for p in effect.parameters if p.role == "phase"]
    points = []
    for shape in shape_grid(effect, scales):
        trial = with_effect(base.model, effect, scales, shape)
        zero = {f"{effect.name}.{p.name}": 0.0 for p in amplitudes}
        directions: list[dict[str, float]] = []
        if not amplitudes or effect.friction_state is not None:
            directions.append({})
        else:
            for amplitude in amplitudes:
                key = f"{effect.name}.{amplitude.name}"
                step = 1e-3 * size_of(amplitude, scales)
                directions.append({**zero, key: step})
                for phase in phases:
                    directions.append({**zero, key: step, f"{effect.name}.{phase.name}": 0.5 * np.pi})
        columns = []
        for move in directions:
            moved = weighted_residual(trial, records, base.weights, {**trial.values, **move})
            columns.append((residual - moved)[rows])
        matrix = np.column_stack(columns)
        if np.isfinite(matrix).all():
            points.append(GridPoint(shape, directions, matrix))
    return points


def score_test(
    effect: Effect, grid: Sequence[GridPoint], basis: np.ndarray, target: np.ndarray
) -> list[ScoreStatistic]:
    """Scores of an effect at the points of its shape grid, best first.

    Args:
        effect: the candidate.
        grid: what it does to the residual.
        basis: orthonormal basis of the base model's Jacobian, (n, p).
        target: residual of the base model, winsorised, with the basis projected out, (n,).
    """
    total = float(target @ target) or 1.0
    scores: list[ScoreStatistic] = []
    for point in grid:
        free = project_out(point.changes, basis)
        normal, right = free.T @ free, free.T @ target
        norms = np.sqrt(np.diag(normal))
        if not (norms > 1e-9 * np.linalg.norm(point.changes, axis=0)).any():
            continue
        coefficients = _solved(normal, right, np.where(norms > 0.0, norms, 1.0))
        predicted_reduction, blocked_reduction = float(right @ coefficients) / total, 0.0
        if out_of_bounds(effect, point.directions, coefficients):
            predicted_reduction, blocked_reduction = 0.0, predicted_reduction
        start = start_for(effect, point.shape, point.directions, coefficients)
        full_step_reduction = (
            float(2.0 * right[0] - normal[0, 0]) / total if effect.friction_state is not None else predicted_reduction
        )
        scores.append(
            ScoreStatistic(
                predicted_reduction, start, point.shape, point.directions, free, blocked_reduction, full_step_reduction
            )
        )
        if len(scores) > KEPT_SCORES:
            sparable = [
                score for score in scores if score.full_step_reduction < max(s.full_step_reduction for s in scores)
            ] or scores
            scores.remove(min(sparable, key=lambda s: (s.predicted_reduction, s.blocked_reduction)))
    scores.sort(key=lambda s: -s.predicted_reduction)
    return [*scores[:IN_PAIRS], *(replace(s, columns=s.columns[:, :0].copy()) for s in scores[IN_PAIRS:])]


ALIKE = 1e-12
"""Eigenvalue of the scaled normal equations, of their largest, below which moves do the same."""


def _solved(normal: np.ndarray, right: np.ndarray, norms: np.ndarray) -> np.ndarray:
    """Least squares of moves (k,) from their normal equations, each scaled to length one; the shortest of all alike."""
    scaled = normal / np.outer(norms, norms)
    return np.linalg.pinv(scaled, rcond=ALIKE, hermitian=True) @ (right / norms) / norms


def out_of_bounds(effect: Effect, directions: list[dict[str, float]], coefficients: np.ndarray) -> bool:
    """Whether the one amplitude of an effect, zero at its bound, would have to go beyond that bound."""
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    if effect.friction_state is not None or len(amplitudes) != 1 or len(directions) != 1:
        return False
    wanted = float(coefficients[0])
    return (wanted < 0.0 <= amplitudes[0].low) or (wanted > 0.0 >= amplitudes[0].high)


def start_for(
    effect: Effect, shape: dict[str, float], directions: list[dict[str, float]], weights: np.ndarray
) -> dict[str, float]:
    """Values to start a refit from: a grid point, and the amplitudes that the moves' linear weights (k,) amount to."""
    if effect.friction_state is not None or not any(directions):
        return dict(shape)
    return {**shape, **_amplitude_start(effect, directions, weights)}


def _amplitude_start(effect: Effect, directions: list[dict[str, float]], weights: np.ndarray) -> dict[str, float]:
    """Amplitudes (and phases) that the linear coefficients of the moves amount to."""
    start: dict[str, float] = {}
    phase = next((p for p in effect.parameters if p.role == "phase"), None)
    for k, move in enumerate(directions):
        key = next(name for name, value in move.items() if value != 0.0)
        value = move[key] * float(weights[k])
        if phase is None:
            start[key] = value
            continue
        phase_key = f"{effect.name}.{phase.name}"
        if phase_key in move:
            sine = start[key]
            start[key] = float(np.hypot(sine, value))
            start[phase_key] = float(np.arctan2(value, sine))
        else:
            start[key] = value
    for parameter in effect.parameters:
        key = f"{effect.name}.{parameter.name}"
        if key in start:
            start[key] = min(max(start[key], parameter.low), parameter.high)
    return start


def profiled_residual(base: FittedModel, rows: slice = EVERY_ROW) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal basis (n, p) of the base model's Jacobian at some rows, and its residual there (n,), winsorised, with
    that taken out."""
    basis = orthonormal(base.fit.jacobian[rows])
    corner = WINSOR * robust_scale(base.fit.residual)
    clipped = np.clip(base.fit.residual[rows], -corner, corner)
    return basis, clipped - basis @ (basis.T @ clipped)
