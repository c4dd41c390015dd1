"""Minimum detectable effect size: the smallest effect that a diagnosis of these records would have found.

A candidate is detected if it removes a least share of the loss and this gain is significant (`sysid.diagnose`). With s
the change of the residual r (n,) per unit of the amplitude, parameters of the model profiled out, h Huber's square, and
Q the root of the sum of squares of s'r over blocks of time, both conditions hold for amplitudes of at least

    amplitude = max( sqrt(LEAST_GAIN * sum h(r) / s's),  2 * CERTAIN_Z * Q / s's )

Effects without an amplitude (lag, gap, presliding displacement) are inserted at increasing sizes until they are
detected.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from sim.effects.effect import Effect, Parameter
from sysid.diagnose import Diagnosis
from sysid.diagnosis.constants import CERTAIN_Z, LEAST_GAIN
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.misfit import LOSS_CORNER, blocks, huber_square, weighted_residual
from sysid.estimation.screening import orthonormal
from sysid.prediction.model import Scales, public_name, shape_grid, size_of, with_effect
from sysid.prediction.observable import candidate_effects
from sysid.prediction.prepared_record import PreparedRecord

MOST_SHAPES = 10
"""Points of the shape grid of an effect at which its size is computed."""

PER_RECORD = 24
"""Blocks of time per record; residuals of different blocks are taken to be independent."""


@dataclass(frozen=True)
class MinimumDetectableEffect:
    """Minimum detectable size of an effect, SI: its public name, key of the parameter that is its size, that size at
    the most detectable shape (None if no size within the bounds is detectable), and the shape parameters there."""

    effect: str
    key: str
    value: float | None
    at: dict[str, float]


def minimum_detectable_effects(diagnosis: Diagnosis) -> list[MinimumDetectableEffect]:
    """Minimum detectable sizes of the effects that a diagnosis did not find, in a model with the one that it found."""
    problem, best = diagnosis.problem, diagnosis.best
    fitted = best.fitted if best is not None else diagnosis.base.fitted
    if best is not None and any(getattr(record, "observer", None) for record in best.problem.fit_records):
        # Effects are compared along the measured motion: an observer integrates the model, and knows no other effects.
        fitted = fit_model(best.fitted.model, problem.fit_records, diagnosis.base.fitted.weights)
    present = [*(e.name for e in diagnosis.base.fitted.model.effects), *([best.name] if best is not None else [])]
    return minimum_sizes(fitted, candidate_effects(problem, present), problem.fit_records, problem.scales)


class _DetectionLimit:
    """Detection limit of a change of the residual, with the parameters of the model profiled out."""

    def __init__(self, fitted: FittedModel, records: Sequence[PreparedRecord], scales: Scales) -> None:
        self.fitted, self.records, self.scales = fitted, records, scales
        self.residual = fitted.fit.residual
        self.basis = orthonormal(fitted.fit.jacobian)
        self.numbers = blocks(records, fitted.weights, PER_RECORD)
        self.loss = LEAST_GAIN * float(huber_square(self.residual).sum())
        self.clipped = np.clip(self.residual, -8.0, 8.0)
        # Beyond the corner the loss is linear: a small change there does not reduce it on average.
        self.inner = np.abs(self.residual) <= LOSS_CORNER

    def needed(self, change: np.ndarray) -> float:
        """Factor by which a change (n,) of the residual must be scaled to be detectable; infinite for a zero change."""
        free = change - self.basis @ (self.basis.T @ change)
        square = float(free[self.inner] @ free[self.inner])
        if not isfinite(square) or square <= 1e-18 * float(change @ change) or square == 0.0:
            return inf
        sums = np.bincount(self.numbers, free * self.clipped)
        noise = sqrt(max(float(sums @ sums), float(np.sum((free * self.clipped) ** 2))))
        return max(sqrt(self.loss / square), 2.0 * CERTAIN_Z * noise / square)

    def residual_with(self, effect: Effect, values: Mapping[str, float]) -> np.ndarray:
        """Residual (n,) of the model with an effect at these values."""
        trial = with_effect(self.fitted.model, effect, self.scales, values)
        return weighted_residual(trial, self.records, self.fitted.weights)


def minimum_sizes(
    fitted: FittedModel, effects: Sequence[Effect], records: Sequence[PreparedRecord], scales: Scales
) -> list[MinimumDetectableEffect]:
    """Minimum detectable size of each effect on top of a fitted model."""
    limit = _DetectionLimit(fitted, records, scales)
    rows: dict[str, MinimumDetectableEffect] = {}
    for effect in effects:
        name = public_name(effect.name)
        if name in rows:
            continue
        amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
        size = amplitudes[0] if amplitudes and effect.friction_state is None else None
        row = _by_shape(limit, effect) if size is None else _by_amplitude(limit, effect, size)
        if row is not None:
            rows[name] = row
    return list(rows.values())


def _by_amplitude(limit: _DetectionLimit, effect: Effect, size: Parameter) -> MinimumDetectableEffect | None:
    key = f"{effect.name}.{size.name}"
    others = {f"{effect.name}.{p.name}": 0.0 for p in effect.parameters if p.role == "amplitude" and p is not size}
    phases = [f"{effect.name}.{p.name}" for p in effect.parameters if p.role == "phase"]
    step = 1e-3 * size_of(size, limit.scales)
    best, at = inf, {}
    for shape in shape_grid(effect, limit.scales, MOST_SHAPES):
        moves = [{}, *({phase: 0.5 * np.pi} for phase in phases)]
        # The phase of a true effect is unknown: the least detectable phase is taken.
        moved = (limit.residual_with(effect, {**shape, **others, key: step, **move}) for move in moves)
        needed = max(limit.needed(limit.residual - residual) for residual in moved)
        if step * needed < best:
            best, at = step * needed, shape
    if not isfinite(best):
        return None
    highest = max(abs(size.high), abs(size.low) if size.low < 0.0 else 0.0)
    return MinimumDetectableEffect(public_name(effect.name), key, best if best <= highest else None, at)


def _by_shape(limit: _DetectionLimit, effect: Effect) -> MinimumDetectableEffect | None:
    sizes = [p for p in effect.parameters if p.role == "shape" and p.scan is not None and not p.fixed]
    if not sizes or effect.is_mode:
        # The response of a mode without a mass ratio vanishes for high frequencies: there is no smallest size.
        return None
    key = f"{effect.name}.{sizes[0].name}"
    grid = sorted({shape[key] for shape in shape_grid(effect, limit.scales, MOST_SHAPES)})
    absent = limit.residual
    if effect.friction_state is not None:
        # Compared with the same law at a negligible presliding displacement.
        absent = limit.residual_with(effect, {key: max(1e-3 * grid[0], sizes[0].low)})
    before: tuple[float, float] | None = None
    for value in grid:
        needed = limit.needed(absent - limit.residual_with(effect, {key: value}))
        if needed <= 1.0:
            # No extrapolation below the smallest displacement of the grid, where the noise of the position dominates.
            seen = value if effect.friction_state is not None and before is None else _between(before, (value, needed))
            return MinimumDetectableEffect(public_name(effect.name), key, seen, {})
        before = (value, needed) if isfinite(needed) else None
    return MinimumDetectableEffect(public_name(effect.name), key, None, {}) if before is not None else None


def _between(before: tuple[float, float] | None, after: tuple[float, float]) -> float:
    """Size at which the factor is one, by log-log interpolation; linear below the grid."""
    (value, needed) = after
    if before is None:
        return value * needed
    slope = np.log(needed / before[1]) / np.log(value / before[0])
    return float(value * needed ** (-1.0 / slope)) if slope < 0.0 else value
