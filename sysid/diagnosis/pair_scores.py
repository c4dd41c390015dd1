"""Joint score test of two candidate effects.

For each of some thousand pairs the predicted reduction of the squared residual r is the solution of small normal
equations of the sensitivities D of its effects at their best grid points, with the base parameters projected out,

    reduction = r^T D (D^T D)^-1 D^T r.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from sim.effects.effect import Effect
from sysid.diagnosis.candidate_screening import ScreeningResult
from sysid.estimation.fit import FittedModel, root_mean_huber
from sysid.estimation.score_test import IN_PAIRS, ScoreStatistic, out_of_bounds, start_for
from sysid.estimation.screening import ScoredCandidate
from sysid.prediction.model import Model, Scales, public_name, with_effect

RIDGE = 1e-6
"""Added to the scaled normal equations of two effects."""


@dataclass(frozen=True)
class _Part:
    known: ScoredCandidate
    score: ScoreStatistic
    columns: slice

    @property
    def norms(self) -> np.ndarray:
        """Norms (k,) of the columns of the score."""
        return np.maximum(np.linalg.norm(self.score.columns, axis=0), 1e-300)


@dataclass(frozen=True)
class ScoredPair:
    """Two effects at their best grid points."""

    reduction: float  # predicted reduction of the squared residual
    # the effects with their scores; a friction state model first, since the other starts from its level
    parts: tuple[_Part, _Part]
    weights: tuple[np.ndarray, np.ndarray]  # linear weights of the directions of each part

    @property
    def families(self) -> frozenset[str]:
        """Public names of the two."""
        return frozenset(public_name(part.known.effect.name) for part in self.parts)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The two effects."""
        return tuple(part.known.effect for part in self.parts)

    def start(self, model: Model, scales: Scales) -> Model:
        """The model with both effects at the values of the joint score."""
        for part, weights in zip(self.parts, self.weights, strict=True):
            effect, score = part.known.effect, part.score
            model = with_effect(model, effect, scales, start_for(effect, score.shape, score.directions, weights))
        return model


def scored_pairs(fitted: FittedModel, screening: ScreeningResult, most: int) -> list[ScoredPair]:
    """The pairs of effects of different families with the largest joint scores, one per pair of families."""
    parts, blocks = [], []
    start = 0
    alone = root_mean_huber(fitted.fit.residual)
    # A change of the friction state model has no amplitude and no linear weight: it is judged by its own fit.
    able = [one for one in screening.fits if one.linear or one.error < alone]
    for known in [*able, *screening.unfitted]:
        for score in known.scores[:IN_PAIRS]:
            part = _Part(known, score, slice(start, start + score.columns.shape[1]))
            parts.append(part)
            blocks.append(score.columns / part.norms)
            start += score.columns.shape[1]
    if len(parts) < 2:
        return []
    columns = np.hstack(blocks)
    gram, right = columns.T @ columns, columns.T @ screening.target
    chosen: dict[frozenset[str], ScoredPair] = {}
    for pair in sorted(_pairs(parts, gram, right), key=lambda one: -one.reduction):
        if len(chosen) >= most:
            break
        chosen.setdefault(pair.families, pair)
    return list(chosen.values())


def _pairs(parts: Sequence[_Part], gram: np.ndarray, right: np.ndarray) -> list[ScoredPair]:
    found = []
    for pair in combinations(parts, 2):
        effects = [part.known.effect for part in pair]
        same = public_name(effects[0].name) == public_name(effects[1].name)
        if same or all(effect.friction_state is not None for effect in effects):
            continue
        one, other = sorted(pair, key=lambda part: part.known.effect.friction_state is None)
        index = np.r_[one.columns, other.columns]
        scaled = np.linalg.solve(gram[np.ix_(index, index)] + RIDGE * np.eye(index.size), right[index])
        count = one.score.columns.shape[1]
        weights = scaled[:count] / one.norms, scaled[count:] / other.norms
        # A pair whose best weights are not physical, such as a negative drag, is not an explanation.
        if not any(
            out_of_bounds(part.known.effect, part.score.directions, w)
            for part, w in zip((one, other), weights, strict=True)
        ):
            found.append(ScoredPair(float(right[index] @ scaled), (one, other), weights))
    return found
