"""How small an effect may be and still be found: what the records at hand could have shown of each.

An effect counts when it takes a least share of the loss and more than chance would (`sysid.diagnose`). With s the
change of the residual r per unit of the effect's amplitude, the parameters of the model free to move, and Q the spread
of s'r summed within blocks of time, both hold from

    amplitude = max( sqrt(LEAST_GAIN * loss / s's),  2 * LEAST_SIGNIFICANCE * Q / s's )

which is what a true effect of that size would gain on records such as these. Effects without an amplitude (a lag, a
gap, the stretch of a bristle) are put in at rising sizes until they would count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from sim.library.effect import Effect, Parameter
from sysid.diagnose import Diagnosis
from sysid.diagnosis.verdict_limits import LEAST_GAIN, LEAST_SIGNIFICANCE
from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import LOSS_CORNER, blocks, huber_square, weighted_residual
from sysid.estimation.score_test import orthonormal
from sysid.prediction.model import Model, PreparedRecord, Scales, public_name, shape_grid, size_of, with_effect
from sysid.prediction.observable import candidate_effects

MOST_SHAPES = 10
"""Points of an effect's grid of shapes at which its size is asked for."""

PER_RECORD = 24
"""Blocks of time per record within which a residual may hang together."""


@dataclass(frozen=True)
class MinimumDetectableEffect:
    """The smallest size of an effect that these records could have shown. SI units.

    Args:
        effect: the name everyone uses.
        key: of the parameter that is its size.
        value: that size, at the shape that shows best; none where no size that is allowed would have shown.
        at: its shape there, by key.
    """

    effect: str
    key: str
    value: float | None
    at: dict[str, float]


def minimum_detectable_effects(diagnosis: Diagnosis) -> list[MinimumDetectableEffect]:
    """What the records of a diagnosis could have shown of each effect it did not find, beside the one it found."""
    problem, best = diagnosis.problem, diagnosis.best
    fitted = best.fitted if best is not None else diagnosis.base.fitted
    present = [*(e.name for e in diagnosis.base.fitted.model.effects), *([best.name] if best is not None else [])]
    return minimum_sizes(fitted, candidate_effects(problem, present), problem.fit_records, problem.scales)


class _Judge:
    """What a change of the residual must be to count, with the model's own parameters free to move."""

    def __init__(self, fitted: FittedModel, records: Sequence[PreparedRecord]) -> None:
        self.residual = fitted.fit.residual
        self.basis = orthonormal(fitted.fit.jacobian)
        self.numbers = blocks(records, fitted.weights, PER_RECORD)
        self.loss = LEAST_GAIN * float(huber_square(self.residual).sum())
        self.significance = 2.0 * LEAST_SIGNIFICANCE
        self.clipped = np.clip(self.residual, -8.0, 8.0)
        # Where a residual is beyond the corner, its loss is straight: a small change there gains as much as it loses.
        self.inner = np.abs(self.residual) <= LOSS_CORNER

    def needed(self, change: np.ndarray) -> float:
        """Factor by which a change (n,) of the residual must grow to count; infinite where it changes nothing."""
        free = change - self.basis @ (self.basis.T @ change)
        square = float(free[self.inner] @ free[self.inner])
        if not isfinite(square) or square <= 1e-18 * float(change @ change) or square == 0.0:
            return inf
        sums = np.bincount(self.numbers, free * self.clipped)
        chance = sqrt(max(float(sums @ sums), float(np.sum((free * self.clipped) ** 2))))
        return max(sqrt(self.loss / square), self.significance * chance / square)


def minimum_sizes(
    fitted: FittedModel,
    effects: Sequence[Effect],
    records: Sequence[PreparedRecord],
    scales: Scales,
) -> list[MinimumDetectableEffect]:
    """Smallest size of each effect that the records could have shown on top of a fitted model.

    Args:
        fitted: the model, with what was found in it already.
        effects: that could be missing; of a family the first.
        records: those fitted.
        scales: of the records.
    """
    judge = _Judge(fitted, records)
    rows: dict[str, MinimumDetectableEffect] = {}
    for effect in effects:
        name = public_name(effect.name)
        if name in rows:
            continue
        size = _amplitude(effect)
        row = (
            _by_amplitude(judge, fitted, effect, size, records, scales)
            if size is not None
            else _by_shape(judge, fitted, effect, records, scales)
        )
        if row is not None:
            rows[name] = row
    return list(rows.values())


def _amplitude(effect: Effect) -> Parameter | None:
    if effect.friction_state is not None:
        return None
    return next((p for p in effect.parameters if p.role == "amplitude" and not p.fixed), None)


def _by_amplitude(
    judge: _Judge,
    fitted: FittedModel,
    effect: Effect,
    size: Parameter,
    records: Sequence[PreparedRecord],
    scales: Scales,
) -> MinimumDetectableEffect | None:
    key = f"{effect.name}.{size.name}"
    others = {f"{effect.name}.{p.name}": 0.0 for p in effect.parameters if p.role == "amplitude" and p is not size}
    phases = [f"{effect.name}.{p.name}" for p in effect.parameters if p.role == "phase"]
    step = 1e-3 * size_of(size, scales)
    best, at = inf, {}
    for shape in shape_grid(effect, scales, MOST_SHAPES):
        trial = with_effect(fitted.model, effect, scales, {**shape, **others, key: step})
        moves = [{}, *({phase: 0.5 * np.pi} for phase in phases)]
        # A phase is not chosen by the effect: the one that shows worst counts.
        needed = max(judge.needed(_change(fitted, trial, move, records)) for move in moves)
        if step * needed < best:
            best, at = step * needed, shape
    if not isfinite(best):
        return None
    highest = max(abs(size.high), abs(size.low) if size.low < 0.0 else 0.0)
    return MinimumDetectableEffect(public_name(effect.name), key, best if best <= highest else None, at)


def _by_shape(
    judge: _Judge, fitted: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales
) -> MinimumDetectableEffect | None:
    sizes = [p for p in effect.parameters if p.role == "shape" and p.scan is not None and not p.fixed]
    if not sizes or effect.name.partition(":")[0] == "flexible_mode":
        # A mode without a share of its own shows the less the stiffer it is: there is no smallest one.
        return None
    key = f"{effect.name}.{sizes[0].name}"
    grid = sorted({shape[key] for shape in shape_grid(effect, scales, MOST_SHAPES)})
    absent = fitted.fit.residual
    if effect.friction_state is not None:
        # Against the same law with a stretch that nothing shows, not against another law.
        rigid = with_effect(fitted.model, effect, scales, {key: max(1e-3 * grid[0], sizes[0].low)})
        absent = weighted_residual(rigid, records, fitted.weights)
    before: tuple[float, float] | None = None
    for value in grid:
        trial = with_effect(fitted.model, effect, scales, {key: value})
        needed = judge.needed(absent - weighted_residual(trial, records, fitted.weights))
        if needed <= 1.0:
            # How a bristle shows below the shortest one tried hangs on the noise of the position: no extrapolation.
            seen = value if effect.friction_state is not None and before is None else _between(before, (value, needed))
            return MinimumDetectableEffect(public_name(effect.name), key, seen, {})
        before = (value, needed) if isfinite(needed) else None
    return MinimumDetectableEffect(public_name(effect.name), key, None, {}) if before is not None else None


def _between(before: tuple[float, float] | None, after: tuple[float, float]) -> float:
    """Size at which the factor passes one, on a straight line in logarithms; to the first order below the grid."""
    (value, needed) = after
    if before is None:
        return value * needed
    slope = np.log(needed / before[1]) / np.log(value / before[0])
    return float(value * needed ** (-1.0 / slope)) if slope < 0.0 else value


def _change(fitted: FittedModel, trial: Model, move: dict[str, float], records: Sequence[PreparedRecord]) -> np.ndarray:
    """Change (n,) of the residual, in deviations, from the fitted model to `trial` with values moved."""
    return fitted.fit.residual - weighted_residual(trial, records, fitted.weights, {**trial.values, **move})
