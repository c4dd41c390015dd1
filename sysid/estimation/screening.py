"""Every effect that may be missing, tried: a linear score orders the starts, a refit decides.

The score says what an effect promises at each point of its shape grid (`sysid/estimation/score_test.py`). A few steps
of a fit from the best point show what the effect is good for; the best effects are then refitted in full.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.library.effect import Effect
from sysid.estimation.driven_stage_search import ROUNDS, lowest_minimum, synchronised_starts
from sysid.estimation.driven_stage_starts import slipping_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber, with_final_jacobian
from sysid.estimation.score_test import EVERY_ROW, ScoreStatistic, candidate_directions, project_out, score_test
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import PreparedRecord, Scales, with_effect


@dataclass(frozen=True)
class RefittedEffect:
    """One effect tried on top of a base model.

    Args:
        effect: tried.
        expected_drop: share of the squared residual that its linear score promised.
        fitted: the model with it.
        barred: share that only amplitudes beyond their bounds would have taken.
    """

    effect: Effect
    predicted_reduction: float
    fitted: FittedModel
    blocked_reduction: float = 0.0


@dataclass(frozen=True)
class ScoredCandidate:
    """An effect scored over its grid, not fitted yet."""

    effect: Effect
    scores: list[ScoreStatistic]

    @property
    def score(self) -> float:
        """Share of the squared residual that its best point promises; without any point only a fit can tell."""
        return max((score.full_step_reduction for score in self.scores), default=np.inf)

    @property
    def linear(self) -> bool:
        """Whether its scores say what it can do: it has amplitudes that a linear weight stands for."""
        return bool(self.scores) and any(p.role == "amplitude" for p in self.effect.parameters)


@dataclass(frozen=True)
class ScreeningFit(ScoredCandidate):
    """A first look at an effect: its scores over the grid, and a short fit from the best of them."""

    fitted: FittedModel

    @property
    def blocked_reduction(self) -> float:
        """Largest drop that only an amplitude beyond its bounds would make."""
        return max((score.blocked_reduction for score in self.scores), default=0.0)

    @property
    def predicted_reduction(self) -> float:
        """Share of the squared residual that the linear score promised."""
        return max(self.scores[0].predicted_reduction, 0.0)

    @property
    def error(self) -> float:
        """Ranking error of the short fit, in deviations."""
        return root_mean_huber(self.fitted.fit.residual)


SHORT = 4
"""Steps of the fit of a first look: enough to see what an effect is good for, not to know its values."""


FAR = 5.0
"""Ranking error of a driven stage, in deviations, from which a linear score says little of where a fit should begin."""
STARTS_FROM_AFAR = 3
FROM_AFAR = 8
"""Points of the grid, and steps of the fit from each, in a first look from so far away."""


def screen_candidate(
    base: FittedModel,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    basis: np.ndarray,
    target: np.ndarray,
) -> ScreeningFit | None:
    """Score an effect over its grid, and fit it shortly from the best point; none where it changes nothing."""
    scores = score_test(effect, candidate_directions(base, effect, records, scales), basis, target)
    return screen_scored(ScoredCandidate(effect, scores), base, records, scales, basis)


def screen_scored(
    known: ScoredCandidate,
    base: FittedModel,
    records: Sequence[PreparedRecord],
    scales: Scales,
    basis: np.ndarray,
    rows: slice = EVERY_ROW,
) -> ScreeningFit | None:
    """The look at an effect whose scores, at some rows of the residual, are known; none where it changes nothing."""
    effect, scores = known.effect, known.scores
    far = any(isinstance(r, FrictionDriveRecord) for r in records) and root_mean_huber(base.fit.residual) > FAR
    points = [score.start for score in (_spread(scores, STARTS_FROM_AFAR) if far and scores else scores[:1])]
    if scores and effect.friction_state is not None:
        # Part of a long stretch may promise most, and a short one is what fits as a whole.
        best = max(scores, key=lambda score: score.full_step_reduction).start
        points += [best] if best is not points[0] else []
    starts = [with_effect(base.model, effect, scales, point) for point in points]
    starts += slipping_starts(base.model, effect, records, scales, far, points[0] if points else None)
    if not starts:
        return None
    if far:
        starts += synchronised_starts(starts, records, base.weights, FROM_AFAR)
    steps = FROM_AFAR if far else SHORT
    fits = [fit_model(start, records, base.weights, steps, near=base, final_jacobian=False) for start in starts]
    nearest = min(fits, key=lambda fitted: fitted.fit.cost)
    if not scores:
        # No gradient where it began: what it did where it ended stands for what it can do.
        own = {key: value for key, value in nearest.model.values.items() if key.startswith(f"{effect.name}.")}
        change = project_out((base.fit.residual - nearest.fit.residual)[rows, None], basis)
        scores = [ScoreStatistic(0.0, own, own, [{}], change)]
    return ScreeningFit(effect, scores, nearest)


def refit_candidate(
    base: FittedModel,
    look: ScreeningFit,
    records: Sequence[PreparedRecord],
    scales: Scales,
    starts: int = 2,
    iterations: int = 15,
) -> RefittedEffect:
    """The effect of a look refitted: further from where the look ended, and from other points of the grid."""
    best = fit_model(look.fitted.model, records, base.weights, iterations, near=look.fitted)
    others = _spread(look.scores, starts)[1:]
    if look.effect.friction_state is not None:
        others += sorted(look.scores, key=lambda score: -score.full_step_reduction)[:2]
    for score in others:
        start = with_effect(base.model, look.effect, scales, score.start)
        fitted = fit_model(start, records, base.weights, iterations, near=base)
        if fitted.fit.cost < best.fit.cost:
            best = fitted
    return RefittedEffect(look.effect, look.predicted_reduction, best, look.blocked_reduction)


HALFWAY = 0.5
"""Part of the base model's error below which an effect is promising: what it leaves may be of a side valley."""


def search_lower_minimum(
    base: FittedModel, candidate: RefittedEffect, records: Sequence[PreparedRecord], of_contact: bool = False
) -> RefittedEffect:
    """A promising effect on a driven stage, its fit gone on to the lowest valley near; any other as it is.

    Args:
        base: the fitted base model.
        candidate: an effect on top of it.
        records: those fitted.
        of_contact: it acts between tip and stage: one round over its numbers, promising or not.
    """
    if not of_contact and root_mean_huber(candidate.fitted.fit.residual) > HALFWAY * root_mean_huber(base.fit.residual):
        return candidate
    lowest = lowest_minimum(candidate.fitted, records, 1 if of_contact else ROUNDS)
    return candidate if lowest is candidate.fitted else replace(candidate, fitted=lowest)


def screen_and_refit(
    base: FittedModel,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    basis: np.ndarray,
    target: np.ndarray,
    starts: int = 2,
    iterations: int = 15,
) -> RefittedEffect | None:
    """Score an effect over its grid, refit it from the best few points, keep the best."""
    look = screen_candidate(base, effect, records, scales, basis, target)
    return refit_candidate(base, look, records, scales, starts, iterations) if look is not None else None


def as_screened(look: ScreeningFit, records: Sequence[PreparedRecord]) -> RefittedEffect:
    """The effect as the first look left it."""
    return RefittedEffect(
        look.effect, look.predicted_reduction, with_final_jacobian(look.fitted, records), look.blocked_reduction
    )


def _spread(scores: list[ScoreStatistic], count: int) -> list[ScoreStatistic]:
    """The best score, and further ones that begin elsewhere on the grid."""
    picked = [scores[0]]
    for score in scores[1:]:
        if len(picked) >= count:
            break
        if score.predicted_reduction > 0.5 * scores[0].predicted_reduction and all(
            _apart(score.start, other.start) for other in picked
        ):
            picked.append(score)
    return picked


def _apart(a: dict[str, float], b: dict[str, float]) -> bool:
    return any(abs(a[k] - b.get(k, 0.0)) > 0.3 * max(abs(a[k]), abs(b.get(k, 0.0))) for k in a)
