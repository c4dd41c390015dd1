"""Joint test of two missing effects: pairs of candidates that explain a misfit that no single one explains.

The best single effect need not be one of the two, since an effect partially confounded with both may remove more than
each alone. The score test of a pair uses the sensitivities of its two effects at their best grid points: for each of
some thousand pairs the predicted reduction is the solution of small normal equations. The best pairs are refitted in
full and compared on the held-out records.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from sim.library.effect import Effect
from stagecad.parallel import fork_map
from sysid.diagnosis.candidate_screening import CandidateJacobians, ScreeningResult, screen_all
from sysid.diagnosis.trials import CandidateFit, evaluate_candidate
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import weighted_residual
from sysid.estimation.reference_fit import ReferenceFit, has_shape, reference_fit
from sysid.estimation.score_test import IN_PAIRS, ScoreStatistic, out_of_bounds, profiled_residual, start_for
from sysid.estimation.screening import RefittedEffect, ScoredCandidate, ScreeningFit, refit_candidate, screen_candidate
from sysid.estimation.variant_selection import with_bounds_of, without_public_effect
from sysid.prediction.model import Model, public_name, with_effect
from sysid.prediction.problem import Problem

PAIRS_REFITTED = 6

BESIDE_IT = 0.05
"""Least predicted share of the squared residual of a second effect beside one that is searched again."""


@dataclass(frozen=True)
class Pair:
    """Two effects on top of the base model, refitted.

    Args:
        effects: the two.
        fitted: model with both, and its fit.
        error: ranking error on the held-out records, in deviations.
        residual: of the held-out records, in deviations, (n,).
    """

    effects: tuple[Effect, Effect]
    fitted: FittedModel
    error: float
    residual: np.ndarray

    @property
    def names(self) -> tuple[str, str]:
        """The two, as everyone calls them."""
        return (public_name(self.effects[0].name), public_name(self.effects[1].name))

    @property
    def model(self) -> Model:
        """With both."""
        return self.fitted.model

    def partner(self, family: str) -> str:
        """The other name than this one."""
        return self.names[1] if self.names[0] == family else self.names[0]

    def other(self, family: str) -> Effect:
        """The one of the two that is not of this family."""
        return self.effects[1] if public_name(self.effects[0].name) == family else self.effects[0]


@dataclass(frozen=True)
class _Part:
    known: ScoredCandidate
    score: ScoreStatistic
    columns: slice


def best_pairs(
    problem: Problem,
    base: ReferenceFit,
    first: ScreeningResult,
    wanted: str | None = None,
    given: Model | None = None,
) -> list[Pair]:
    """The pairs of effects that looked best together, refitted, best on the held-out records first.

    Args:
        problem: records and scales.
        base: the fitted model that the looks were taken on.
        first: looks at every effect on top of it.
        wanted: family that must be one of the two.
        given: a model whose bounds, priors and held values stay, where one of the two stood in it before.
    """
    parts, blocks = [], []
    start = 0
    alone = root_mean_huber(base.fitted.fit.residual)
    # A change of the friction state model has no amplitude, so no linear weight represents it: its fit is judged alone.
    able = [look for look in first.fits if look.linear or look.error < alone]
    for known in [*able, *first.unfitted]:
        for score in known.scores[:IN_PAIRS]:
            norms = np.maximum(np.linalg.norm(score.columns, axis=0), 1e-300)
            blocks.append(score.columns / norms)
            parts.append(_Part(known, score, slice(start, start + norms.size)))
            start += norms.size
    if len(parts) < 2:
        return []
    columns = np.hstack(blocks)
    gram, right = columns.T @ columns, columns.T @ first.target
    together = sorted(_pair_drops(parts, gram, right), key=lambda found: -found[0])
    least = 0.0 if wanted is None else _least_with(wanted, parts, first.target)
    chosen: dict[frozenset[str], tuple[_Part, _Part]] = {}
    for predicted_reduction, one, other in together:
        families = frozenset((public_name(one.known.effect.name), public_name(other.known.effect.name)))
        if len(chosen) >= PAIRS_REFITTED or predicted_reduction < least:
            break
        if wanted is None or wanted in families:
            chosen.setdefault(families, (one, other))
    shared = (*(part.known.effect for part in parts), *base.fitted.model.effects, base.fitted.weights)
    found = fork_map(lambda two: _refitted(problem, base, two, gram, right, given), list(chosen.values()), shared)
    return sorted((pair for pair in found if pair is not None), key=lambda pair: pair.error)


def _least_with(wanted: str, parts: Sequence[_Part], target: np.ndarray) -> float:
    """What a pair must take of the squared target for the other to be worth a fit beside an effect that is wanted."""
    total = float(target @ target)
    alone = total * max(
        (p.score.predicted_reduction for p in parts if public_name(p.known.effect.name) == wanted), default=0.0
    )
    return alone + BESIDE_IT * (total - alone)


def _pair_drops(parts: Sequence[_Part], gram: np.ndarray, right: np.ndarray) -> list[tuple[float, _Part, _Part]]:
    """What each two effects of different families take of the squared target together."""
    found = []
    for first, second in combinations(parts, 2):
        a, b = first.known.effect, second.known.effect
        if public_name(a.name) == public_name(b.name) or (
            a.friction_state is not None and b.friction_state is not None
        ):
            continue
        index = np.r_[first.columns, second.columns]
        weights = _weights(gram, right, index)
        count = first.score.columns.shape[1]
        # A Stribeck curve turned over does what a drag does, but no fit will have it.
        if _possible(first, weights[:count]) and _possible(second, weights[count:]):
            found.append((float(right[index] @ weights), first, second))
    return found


def _possible(part: _Part, weights: np.ndarray) -> bool:
    """Whether the weights (k,) of an effect's scaled columns are amplitudes that its bounds allow."""
    norms = np.maximum(np.linalg.norm(part.score.columns, axis=0), 1e-300)
    return not out_of_bounds(part.known.effect, part.score.directions, weights / norms)


def _weights(gram: np.ndarray, right: np.ndarray, index: np.ndarray) -> np.ndarray:
    block = gram[np.ix_(index, index)] + 1e-6 * np.eye(index.size)
    return np.linalg.solve(block, right[index])


def _refitted(
    problem: Problem,
    base: ReferenceFit,
    two: tuple[_Part, _Part],
    gram: np.ndarray,
    right: np.ndarray,
    given: Model | None,
) -> Pair | None:
    weights = _weights(gram, right, np.r_[two[0].columns, two[1].columns])
    model = base.fitted.model
    # A core replaces the one before it and starts from its level: it comes first.
    for part in sorted(two, key=lambda part: part.known.effect.friction_state is None):
        effect, score = part.known.effect, part.score
        own = weights[: score.columns.shape[1]] if part is two[0] else weights[-score.columns.shape[1] :]
        own = own / np.maximum(np.linalg.norm(score.columns, axis=0), 1e-300)
        model = with_effect(model, effect, problem.scales, start_for(effect, score.shape, score.directions, own))
    if given is not None:
        model = with_bounds_of(model, given)
    fitted = fit_model(model, problem.fit_records, base.fitted.weights, near=base.fitted)
    residual = weighted_residual(fitted.model, problem.validate_records, base.weights)
    if not np.isfinite(residual).all():
        return None
    return Pair((two[0].known.effect, two[1].known.effect), fitted, root_mean_huber(residual), residual)


ON_TOP = 3
"""Effects refitted on top of another."""

COULD_EXPLAIN = 0.3
"""Share of the loss above the noise that two effects must take at first sight: a fit in full may find as much again."""

PROMISING = 10
"""Effects fitted shortly to choose those from: the best three were among the first seven by score (17 generated)."""


def pairs_on_top(
    problem: Problem,
    base: ReferenceFit,
    first: RefittedEffect,
    all_effects: bool = False,
    jacobians: CandidateJacobians | None = None,
) -> list[Pair]:
    """Pairs with the second effect looked for on top of the first one's fit, best on the held-out records first.

    What the scores of two together, taken on the base model alone, rank too low: the shape of the one is clear only
    where the other is there.

    Args:
        problem, base: records, and the fitted base model.
        first: effect on top of it.
        all_effects: try whatever else the library has, too.
        jacobians: what effects do to the residual of the base model.
    """
    below = reference_fit(problem, first.fitted, base.weights)
    present = [e.name for e in first.fitted.model.effects]

    def refitted(look: ScreeningFit) -> Pair | None:
        fitted = refit_candidate(first.fitted, look, problem.fit_records, problem.scales).fitted
        residual = weighted_residual(fitted.model, problem.validate_records, base.weights)
        if not np.isfinite(residual).all():
            return None
        return Pair((first.effect, look.effect), fitted, root_mean_huber(residual), residual)

    before = root_mean_huber(base.fitted.fit.residual) ** 2
    enough = before - COULD_EXPLAIN * max(before - 1.0, 0.0)
    needed = 1.0 - enough / max(root_mean_huber(first.fitted.fit.residual) ** 2, 1e-300)
    screening = screen_all(
        problem, below, present, all_effects, promising=PROMISING, jacobians=jacobians, needed=needed
    )
    looks = [look for look in screening.fits if look.error**2 <= enough][:ON_TOP]
    shared = (*(look.effect for look in looks), *first.fitted.model.effects, first.effect, base.fitted.weights)
    found = fork_map(refitted, looks, shared)
    return sorted((pair for pair in found if pair is not None), key=lambda pair: pair.error)


class ReducedModels:
    """Fits of a model without one of its effects, and the candidates screened on top of them, each computed once.

    The search after a deletion and the search for replacements need the same ones.
    """

    def __init__(
        self,
        problem: Problem,
        base: ReferenceFit,
        all_effects: bool = False,
        jacobians: CandidateJacobians | None = None,
    ) -> None:
        """Args:
        problem, base: records, and the fitted model.
        all_effects: screen all effects of the library, not only those with public names.
        jacobians: sensitivities of the model's residual to candidate effects.
        """
        self.problem = problem
        self.base = base
        self.all_effects = all_effects
        self._jacobians = jacobians
        self._fits: dict[str, ReferenceFit] = {}
        self._screenings: dict[str, ScreeningResult] = {}

    def fit(self, name: str) -> ReferenceFit:
        """The fit without every effect of a public name, with the same residual weights."""
        if name not in self._fits:
            model = without_public_effect(self.base.fitted.model, name)
            rest = fit_model(model, self.problem.fit_records, self.base.fitted.weights, near=self.base.fitted)
            self._fits[name] = reference_fit(self.problem, rest, self.base.weights)
        return self._fits[name]

    def screening(self, name: str) -> ScreeningResult:
        """The candidates screened on top of that fit."""
        if name not in self._screenings:
            others = [e.name for e in self.problem.start.effects if public_name(e.name) != name]
            self._screenings[name] = screen_all(
                self.problem, self.fit(name), others, self.all_effects, promising=PROMISING, jacobians=self._jacobians
            )
        return self._screenings[name]


def forward_after_deletion(reduced: ReducedModels) -> list[CandidateFit]:
    """Candidates evaluated together with a refit of one effect of the model from its screening, best first.

    A pitch fitted while another effect was missing may sit in a local minimum; every candidate on top of it then seems
    to gain little.
    """
    problem, base = reduced.problem, reduced.base
    trials = []
    for name in _shaped(base.fitted.model):
        for pair in best_pairs(problem, reduced.fit(name), reduced.screening(name), name, base.fitted.model)[:2]:
            trial = evaluate_candidate(problem, base, RefittedEffect(pair.other(name), 0.0, pair.fitted))
            if trial is not None:
                trials.append(trial)
    return sorted(trials, key=lambda trial: trial.error)


def add_after_deletion(problem: Problem, base: ReferenceFit, options: Sequence[Effect]) -> list[FittedModel]:
    """Fits of the model with one of `options` added, together with a refit of one effect of the model."""
    fits = []
    reduced = ReducedModels(problem, base)
    for name in _shaped(base.fitted.model):
        below = reduced.fit(name)
        basis, target = profiled_residual(below.fitted)
        own = [effect for effect in base.fitted.model.effects if public_name(effect.name) == name]
        found = [
            screen_candidate(below.fitted, e, problem.fit_records, problem.scales, basis, target)
            for e in (*own, *options)
        ]
        screening = ScreeningResult([one for one in found if one is not None], [], target)
        pairs = best_pairs(problem, below, screening, name, base.fitted.model)
        fits += [pair.fitted for pair in pairs[:1]]
    return fits


def _shaped(model: Model) -> list[str]:
    """Public names of the effects of a model that have fitted shape parameters."""
    free = {u.key.partition(".")[0] for u in model.unknowns}
    return [public_name(effect.name) for effect in model.effects if has_shape(effect) and effect.name in free]
