"""Search over models: the base model with effects added, removed or replaced, each refitted and evaluated once.

Candidates are screened by the score test; the most promising are refitted in full and compared on the held-out records
(`sysid/diagnosis/candidate.py`). The moves are

- one effect added, in its best variant and channel;
- two effects added, chosen by their joint score, or the second one on top of the fit of the first;
- one effect added together with a new search of the shape of an effect of the model, which may be in a local minimum;
- a free curve of one coordinate added;
- an effect of the model removed, or replaced by another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

from sim.effects.effect import Effect
from stagecad.processes import fork_map
from sysid.diagnosis.candidate import Candidate, Reference, one_per_family
from sysid.diagnosis.candidate_screening import Progress, ScreeningResult, screen_all
from sysid.diagnosis.constants import SUFFICIENT_SHARE
from sysid.diagnosis.free_curves import free_curves, with_curve
from sysid.diagnosis.pair_scores import ScoredPair, scored_pairs
from sysid.estimation.driven_stage_search import truncated
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.reference_fit import ReferenceFit, has_shape, reference_fit
from sysid.estimation.score_test import profiled_residual
from sysid.estimation.screening import (
    RefittedEffect,
    ScreeningFit,
    as_screened,
    refit_candidate,
    screen_candidate,
    search_lower_minimum,
)
from sysid.estimation.variant_selection import (
    reselectable_effects,
    select_variants,
    with_bounds_of,
    without_public_effect,
)
from sysid.prediction.model import Model, in_contact, public_name
from sysid.prediction.problem import Problem

REFITTED = 10
"""Candidates refitted in full, in the order of the screening. The others keep their screening fit."""

IN_FULL = 3
"""Number of these candidates refitted to the whole of long records; the others keep the fit to their beginnings."""

PAIRS_REFITTED = 6
"""Pairs refitted, in the order of the joint score."""

ON_TOP = 3
"""Effects refitted on top of another one."""

SCREENED_ON_TOP = 10
"""Effects with a short fit on top of another one, in the order of the score test."""

REPLACEMENTS = 4
"""Candidates refitted in the place of an effect of the model."""

CURVE_STEPS = 8
"""Steps of the fit of a free curve: its values enter linearly."""

NOISE_LOSS = 1.1
"""Held-out loss up to which no further minimum or variant is searched."""


class ModelSearch:
    """Candidate models of one problem, computed on first access.

    Args:
        problem: records and scales.
        base: the fitted stated model.
        all_effects: try all effects of the library, not only those with public names.
        progress: called with a name, a count and a total.
    """

    def __init__(
        self, problem: Problem, base: ReferenceFit, all_effects: bool = False, progress: Progress | None = None
    ) -> None:
        self.problem = problem
        self.base = base
        self.all_effects = all_effects
        self.reference = Reference.of(problem, base)
        self._progress = progress
        self._on_top: dict[str, list[Candidate]] = {}
        self._without: dict[str, Candidate | None] = {}

    @cached_property
    def screening(self) -> ScreeningResult:
        """Screening of every candidate effect on top of the base model."""
        present = [effect.name for effect in self.problem.start.effects]
        return screen_all(self.problem, self.base, present, self.all_effects, self._report)

    @cached_property
    def singles(self) -> list[Candidate]:
        """The base model with one effect, every variant, lowest held-out loss first."""
        problem, base = self.problem, self.base
        fits = self.screening.fits
        fitted, records = truncated(base.fitted, problem.fit_records)

        def evaluate(numbered: tuple[int, ScreeningFit]) -> Candidate | None:
            k, fit = numbered
            if k >= REFITTED:
                return self._evaluate(as_screened(fit, records))
            return self._evaluate(refit_candidate(fitted, fit, records, problem.scales))

        found = self._map(evaluate, list(enumerate(fits)), [*(fit.effect for fit in fits), *fitted.model.effects])
        found.sort(key=lambda c: c.held_out.loss)
        if fitted is not base.fitted:
            found[:IN_FULL] = [self._refitted(c, problem, base) or c for c in found[:IN_FULL]]
        return self._with_best_reselected(self._with_lower_minima(found))

    @cached_property
    def ranked(self) -> list[Candidate]:
        """The best variant of each effect, lowest held-out loss first; where none is sufficient, also with the shape of
        an effect of the model searched again, or with its variants as stated."""
        ranked, before = one_per_family(self.singles), self.reference.held_out.loss
        least = ranked[0].held_out.loss if ranked else before
        if before > NOISE_LOSS and before - least < SUFFICIENT_SHARE * (before - 1.0):
            return one_per_family([*self.reshaped(), *self.on_stated_variants(), *self.singles])
        return ranked

    @cached_property
    def pairs(self) -> list[Candidate]:
        """The base model with two effects, by their joint score and on top of the best single one, best first."""
        pairs = scored_pairs(self.base, self.screening, PAIRS_REFITTED)
        found = self._map(lambda pair: self._fit_pair(pair, self.base.fitted.model), pairs, self._effects_of(pairs))
        best = self.ranked[:1]
        return sorted([*found, *(self.on_top(best[0]) if best else [])], key=lambda c: c.held_out.loss)

    def on_top(self, first: Candidate) -> list[Candidate]:
        """Pairs whose second effect is screened on top of the fit of the first, best first."""
        if first.name not in self._on_top:
            problem = self.problem
            below = reference_fit(problem, first.fitted, self.base.weights)
            present = [effect.name for effect in first.fitted.model.effects]
            screening = screen_all(
                problem,
                below,
                present,
                self.all_effects,
                promising=SCREENED_ON_TOP,
                jacobians=self.screening.jacobians,
            )

            def refit(fit: ScreeningFit) -> Candidate | None:
                fitted = refit_candidate(first.fitted, fit, problem.fit_records, problem.scales).fitted
                return self.reference.evaluate(fitted, (first.effect, fit.effect))

            fits = screening.fits[:ON_TOP]
            found = self._map(refit, fits, [*(fit.effect for fit in fits), *first.fitted.model.effects])
            self._on_top[first.name] = sorted(found, key=lambda c: c.held_out.loss)
        return self._on_top[first.name]

    def on_stated_variants(self) -> list[Candidate]:
        """One effect added to the model with the variants as stated, best first: a variant that the program selected
        while an effect was missing may substitute for it, so that the effect explains nothing further."""
        if not self.base.laws:
            return []
        problem = self.problem
        stated = fit_model(problem.start, problem.fit_records, self.base.fitted.weights)
        below = reference_fit(problem, stated, self.base.weights)
        names = [effect.name for effect in problem.start.effects]
        screening = screen_all(problem, below, names, self.all_effects, promising=SCREENED_ON_TOP)

        def refit(fit: ScreeningFit) -> Candidate | None:
            return self._evaluate(refit_candidate(stated, fit, problem.fit_records, problem.scales))

        fits = screening.fits[:ON_TOP]
        found = self._map(refit, fits, [*(fit.effect for fit in fits), *stated.model.effects])
        return self._with_best_reselected(found)

    def reshaped(self, option: Effect | None = None) -> list[Candidate]:
        """One effect added, and the shape of an effect of the model searched again at the same time, best first."""
        given, found = self.base.fitted.model, []
        selected = [public_name(name) for name in self.base.laws]
        for name in dict.fromkeys([*shaped_effects(given), *selected]):
            below = self.without(name)
            if below is None:
                continue
            screening = self._screening_without(below) if option is None else self._screening_of(below, option)
            pairs = scored_pairs(reference_fit(self.problem, below.fitted, self.base.weights), screening, 2, name)
            fit = partial(self._fit_pair, model=below.fitted.model, given=given)
            for candidate in self._map(fit, pairs, self._effects_of(pairs)):
                others = tuple(e for e in candidate.added if public_name(e.name) != name)
                found.append(replace(candidate, added=others or candidate.added))
        return sorted(found, key=lambda c: c.held_out.loss)

    @cached_property
    def curves(self) -> list[Candidate]:
        """The base model with one free curve, best first."""
        below, effects = self.base.fitted, free_curves(self.problem)

        def fit(curve: Effect) -> Candidate | None:
            model = with_curve(below.model, curve, self.problem.scales)
            fitted = fit_model(model, self.problem.fit_records, below.weights, CURVE_STEPS, near=below)
            return self.reference.evaluate(fitted, (curve,))

        found = self._map(fit, effects, [*effects, *below.model.effects])
        return sorted(found, key=lambda c: c.held_out.loss)

    def without(self, name: str) -> Candidate | None:
        """The model without every effect of a public name."""
        if name not in self._without:
            model = without_public_effect(self.base.fitted.model, name)
            fitted = fit_model(model, self.problem.fit_records, self.base.fitted.weights, near=self.base.fitted)
            self._without[name] = self.reference.evaluate(fitted, (), removed=name)
        return self._without[name]

    def replacements(self, name: str) -> list[Candidate]:
        """The model with another effect in the place of one of its own, best first."""
        below = self.without(name)
        if below is None:
            return []
        problem = self.problem
        fits = [fit for fit in self._screening_without(below).fits if public_name(fit.effect.name) != name]

        def refit(fit: ScreeningFit) -> Candidate | None:
            fitted = refit_candidate(below.fitted, fit, problem.fit_records, problem.scales).fitted
            return self.reference.evaluate(fitted, (fit.effect,), removed=name)

        fits = fits[:REPLACEMENTS]
        found = self._map(refit, fits, [*(fit.effect for fit in fits), *below.fitted.model.effects])
        return sorted((self._with_reselected_variants(c) for c in found), key=lambda c: c.held_out.loss)

    def _map(
        self, function: Callable[[Any], Candidate | None], items: Sequence[Any], identical: Sequence[object]
    ) -> list[Candidate]:
        shared = (*identical, *self.base.fitted.model.effects, self.base.fitted.weights, self.problem)
        return [found for found in fork_map(function, items, shared) if found is not None]

    def _evaluate(self, refit: RefittedEffect) -> Candidate | None:
        return self.reference.evaluate(
            refit.fitted,
            (refit.effect,),
            predicted_reduction=refit.predicted_reduction,
            blocked_reduction=refit.blocked_reduction,
        )

    def _fit_pair(self, pair: ScoredPair, model: Model, given: Model | None = None) -> Candidate | None:
        start = pair.start(model, self.problem.scales)
        if given is not None:
            start = with_bounds_of(start, given)
        fitted = fit_model(start, self.problem.fit_records, self.base.fitted.weights, near=self.base.fitted)
        return self.reference.evaluate(fitted, tuple(part.known.effect for part in pair.parts))

    def _screening_without(self, below: Candidate) -> ScreeningResult:
        names = [e.name for e in self.problem.start.effects if public_name(e.name) != below.removed]
        base = reference_fit(self.problem, below.fitted, self.base.weights)
        return screen_all(
            self.problem,
            base,
            names,
            self.all_effects,
            promising=SCREENED_ON_TOP,
            jacobians=self.screening.jacobians,
        )

    def _screening_of(self, below: Candidate, option: Effect) -> ScreeningResult:
        """Screening of an effect and of those removed, on top of a model without them."""
        problem = self.problem
        basis, target = profiled_residual(below.fitted)
        own = [e for e in self.base.fitted.model.effects if public_name(e.name) == below.removed]
        found = [
            screen_candidate(below.fitted, effect, problem.fit_records, problem.scales, basis, target)
            for effect in (*own, option)
        ]
        return ScreeningResult([one for one in found if one is not None], [], target)

    def _refitted(self, candidate: Candidate, problem: Problem, base: ReferenceFit) -> Candidate | None:
        """A candidate fitted to the beginnings of long records, fitted to the whole of them."""
        fitted = fit_model(candidate.fitted.model, problem.fit_records, base.fitted.weights)
        return self._evaluate(_refit_of(candidate, fitted))

    def _with_lower_minima(self, found: list[Candidate]) -> list[Candidate]:
        """The candidates, the first one refitted from further local minima nearby, and those of the contact of tip and
        stage: the friction limit of the contact determines every slip, so a fit from a wrong start is a poor measure of
        the effect."""
        for k, candidate in enumerate(found):
            slips = in_contact(candidate.effect)
            known = {other.public_name for other in found[:k]}
            if k > 0 and (not slips or candidate.public_name in known):
                continue
            if min(c.held_out.loss for c in found) <= NOISE_LOSS:
                break
            own = _refit_of(candidate, candidate.fitted)
            lower = search_lower_minimum(self.base.fitted, own, self.problem.fit_records, of_contact=slips)
            further = self._evaluate(lower) if lower is not own else None
            if further is not None and further.held_out.loss < candidate.held_out.loss:
                found[k] = further
        return found

    def _with_best_reselected(self, found: list[Candidate]) -> list[Candidate]:
        """The candidates, lowest held-out loss first, the best one with the variants of the model selected again."""
        found = sorted(found, key=lambda c: c.held_out.loss)
        if found:
            found[0] = self._with_reselected_variants(found[0])
        return found

    @cached_property
    def _reselectable(self) -> tuple[str, ...]:
        """Public names of the effects of the model whose variant the program selects."""
        names = [public_name(name) for name in (*self.base.laws, *reselectable_effects(self.problem))]
        present = {public_name(e.name) for e in self.base.fitted.model.effects}
        return tuple(name for name in dict.fromkeys(names) if name in present)

    def _with_reselected_variants(self, candidate: Candidate) -> Candidate:
        """A candidate, with the variants of the model selected again beside it where that lowers its held-out loss: a
        variant that was selected while an effect was missing, or a wrong one present, may be the wrong one."""
        families = [n for n in self._reselectable if n not in (*candidate.families, candidate.removed)]
        whole = candidate.fitted.fit.residual.size == self.base.fitted.fit.residual.size
        if not families or not whole or candidate.held_out.loss <= NOISE_LOSS:
            return candidate
        fitted, _ = select_variants(self.problem, candidate.fitted, families)
        if fitted is candidate.fitted:
            return candidate
        other = self.reference.evaluate(
            fitted,
            candidate.added,
            candidate.removed,
            candidate.predicted_reduction,
            candidate.blocked_reduction,
        )
        return candidate if other is None or other.held_out.loss >= candidate.held_out.loss else other

    def _effects_of(self, pairs: Sequence[ScoredPair]) -> list[Effect]:
        return [part.known.effect for pair in pairs for part in pair.parts]

    def _report(self, name: str, count: int, total: int) -> None:
        if self._progress is not None:
            self._progress(name, count, total)


def shaped_effects(model: Model) -> list[str]:
    """Public names of the effects of a model that have fitted shape parameters."""
    free = {u.key.partition(".")[0] for u in model.unknowns}
    return [public_name(effect.name) for effect in model.effects if has_shape(effect) and effect.name in free]


def _refit_of(candidate: Candidate, fitted: FittedModel) -> RefittedEffect:
    """A candidate as the refit of its effect, with another fit."""
    return RefittedEffect(candidate.effect, candidate.predicted_reduction, fitted, candidate.blocked_reduction)
