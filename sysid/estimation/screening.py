"""Screening of candidate effects: score test over the shape grid, short fit from its best points, then a full refit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.effects.effect import Effect
from sysid.estimation.driven_stage_search import ROUNDS, lowest_minimum, slipping_starts, synchronised_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber, with_final_jacobian
from sysid.estimation.friction_state_search import lowest_bristle_fit
from sysid.estimation.least_squares import MOST_STEPS
from sysid.estimation.score_test import EVERY_ROW, ScoreStatistic, candidate_directions, project_out, score_test
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, Scales, with_effect
from sysid.prediction.prepared_record import PreparedRecord


@dataclass(frozen=True)
class RefittedEffect:
    """One candidate effect on top of a base model, refitted."""

    effect: Effect  # the candidate
    predicted_reduction: float  # share of the squared residual, by the score test
    fitted: FittedModel  # the model with it
    blocked_reduction: float = 0.0  # share that only amplitudes beyond their bounds would remove


@dataclass(frozen=True)
class ScoredCandidate:
    """A candidate effect with its score statistics over the shape grid, best first, before any fit."""

    effect: Effect
    scores: list[ScoreStatistic]

    @property
    def score(self) -> float:
        """Largest predicted reduction; infinite without any score, where only a fit shows the reduction."""
        return max((score.full_step_reduction for score in self.scores), default=np.inf)

    @property
    def linear(self) -> bool:
        """Whether the effect has amplitudes, so that the score test applies to it."""
        return bool(self.scores) and any(p.role == "amplitude" for p in self.effect.parameters)


@dataclass(frozen=True)
class ScreeningFit(ScoredCandidate):
    """A scored candidate with a short fit from its best starting points."""

    fitted: FittedModel

    @property
    def blocked_reduction(self) -> float:
        """Largest reduction that only an amplitude beyond its bound would give."""
        return max((score.blocked_reduction for score in self.scores), default=0.0)

    @property
    def predicted_reduction(self) -> float:
        """Share of the squared residual, by the score test."""
        return max(self.scores[0].predicted_reduction, 0.0)

    @property
    def error(self) -> float:
        """Root mean Huber loss of the short fit on its own records, in standard deviations."""
        return root_mean_huber(self.fitted.fit.residual)


SHORT = 4
"""Steps of a screening fit."""

FAR = 5.0
"""Root mean Huber loss on a driven stage above which the score test does not give reliable starting points."""
STARTS_FROM_AFAR = 3
STEPS_FROM_AFAR = 8
"""Grid points, and steps of the screening fit from each, in that case."""

SHOWS_PROMISE = 0.5
"""Fraction of the error of the base model below which lower minima near the fit of a driven stage are searched."""


def screen_scored(
    known: ScoredCandidate,
    base: FittedModel,
    records: Sequence[PreparedRecord],
    scales: Scales,
    basis: np.ndarray,
    rows: slice = EVERY_ROW,
) -> ScreeningFit | None:
    """Short fit of a scored candidate from its best starting points; None if it does not change the prediction."""
    effect, scores = known.effect, known.scores
    far = any(isinstance(r, FrictionDriveRecord) for r in records) and root_mean_huber(base.fit.residual) > FAR
    starts = _screening_starts(known, base, records, scales, far)
    if not starts:
        return None
    steps = STEPS_FROM_AFAR if far else SHORT
    fits = [fit_model(start, records, base.weights, steps, near=base, final_jacobian=False) for start in starts]
    nearest = min(fits, key=lambda fitted: fitted.fit.cost)
    if not scores:
        # No gradient at the start: the change of the residual by the fit replaces the directions.
        own = {key: value for key, value in nearest.model.values.items() if key.startswith(f"{effect.name}.")}
        change = project_out((base.fit.residual - nearest.fit.residual)[rows, None], basis)
        scores = [ScoreStatistic(0.0, own, own, [{}], change)]
    return ScreeningFit(effect, scores, nearest)


def _screening_starts(
    known: ScoredCandidate, base: FittedModel, records: Sequence[PreparedRecord], scales: Scales, far: bool
) -> list[Model]:
    """Models with the candidate at the starting points of its screening fits; `far`: on a driven stage, the error of
    the base model is large."""
    effect, scores = known.effect, known.scores
    points = [score.start for score in (_distinct(scores, STARTS_FROM_AFAR) if far and scores else scores[:1])]
    if scores and effect.friction_state is not None:
        # A long presliding displacement may have the best score with a small weight, a short one with unit weight.
        best = max(scores, key=lambda score: score.full_step_reduction).start
        points += [best] if best is not points[0] else []
    starts = [with_effect(base.model, effect, scales, point) for point in points]
    starts += slipping_starts(base.model, effect, records, scales, far, points[0] if points else None)
    if starts and far:
        starts += synchronised_starts(starts, records, base.weights, STEPS_FROM_AFAR)
    return starts


def refit_candidate(
    base: FittedModel,
    screened: ScreeningFit,
    records: Sequence[PreparedRecord],
    scales: Scales,
    starts: int = 2,
    iterations: int = MOST_STEPS,
) -> RefittedEffect:
    """Refit of a screened effect from its screening fit and from other points of the grid; the fit of lowest cost."""
    best = fit_model(screened.fitted.model, records, base.weights, iterations, near=screened.fitted)
    for score in _distinct(screened.scores, starts)[1:]:
        start = with_effect(base.model, screened.effect, scales, score.start)
        fitted = fit_model(start, records, base.weights, iterations, near=base)
        if fitted.fit.cost < best.fit.cost:
            best = fitted
    if screened.effect.has_presliding:
        best = lowest_bristle_fit(best, records, scales, base.weights)
    return RefittedEffect(screened.effect, screened.predicted_reduction, best, screened.blocked_reduction)


def search_lower_minimum(
    base: FittedModel, candidate: RefittedEffect, records: Sequence[PreparedRecord], of_contact: bool = False
) -> RefittedEffect:
    """A refitted effect on a driven stage with its fit moved to the lowest nearby local minimum of the cost."""
    promising = root_mean_huber(candidate.fitted.fit.residual) <= SHOWS_PROMISE * root_mean_huber(base.fit.residual)
    if not of_contact and not promising:
        return candidate
    lowest = lowest_minimum(candidate.fitted, records, 1 if of_contact else ROUNDS)
    return candidate if lowest is candidate.fitted else replace(candidate, fitted=lowest)


def screen_and_refit(
    base: FittedModel,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    profiled: tuple[np.ndarray, np.ndarray],
    starts: int = 2,
    iterations: int = MOST_STEPS,
) -> RefittedEffect | None:
    """Screening and full refit of one effect; None if it does not change the prediction."""
    scores = score_test(effect, candidate_directions(base, effect, records, scales), *profiled)
    screened = screen_scored(ScoredCandidate(effect, scores), base, records, scales, profiled[0])
    return refit_candidate(base, screened, records, scales, starts, iterations) if screened is not None else None


def as_screened(screened: ScreeningFit, records: Sequence[PreparedRecord]) -> RefittedEffect:
    """The effect at the values of its screening fit, with the Jacobian measured there."""
    fitted = with_final_jacobian(screened.fitted, records)
    return RefittedEffect(screened.effect, screened.predicted_reduction, fitted, screened.blocked_reduction)


def _distinct(scores: list[ScoreStatistic], count: int) -> list[ScoreStatistic]:
    """The best score, and further ones of at least half its reduction with distinct starting values."""
    chosen = [scores[0]]
    for score in scores[1:]:
        if len(chosen) >= count:
            break
        strong = score.predicted_reduction > 0.5 * scores[0].predicted_reduction
        if strong and all(_apart(score.start, other.start) for other in chosen):
            chosen.append(score)
    return chosen


def _apart(a: dict[str, float], b: dict[str, float]) -> bool:
    """Whether some value of two points differs by more than 30 %."""
    return any(abs(a[k] - b.get(k, 0.0)) > 0.3 * max(abs(a[k]), abs(b.get(k, 0.0))) for k in a)
