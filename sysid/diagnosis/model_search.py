"""Search over models: the base model with effects added, removed or replaced, each refitted and evaluated once.

Candidates are screened by the score test; the most promising are refitted in full and compared on the held-out records
(`sysid/diagnosis/candidate.py`). The moves are

- one effect added (`step`), in its best variant and channel, also a further copy of a periodic one;
- two effects added at once (`pairs`), chosen by their joint score, where neither shows alone;
- a free curve of one coordinate added (`with_curves`);
- an effect removed (`without`), and another one in its place (`step` on top of that).
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from sim.effects.catalogue import rigid_friction
from sim.effects.effect import Effect
from stagecad.processes import map_items
from sysid.diagnosis.candidate import Candidate, Reference, one_per_family
from sysid.diagnosis.candidate_screening import Progress, ScoredPair, ScreeningResult, scored_pairs, screen_all
from sysid.diagnosis.free_curves import free_curves, with_curve
from sysid.diagnosis.held_out import HeldOut, held_out
from sysid.estimation import variant_selection
from sysid.estimation.driven_stage_search import lowest_minimum, truncated
from sysid.estimation.fit import FittedModel, fit_model, with_final_jacobian
from sysid.estimation.reference_fit import ReferenceFit, has_shape, reference_fit
from sysid.estimation.screening import ScreeningFit, refit_candidate, search_lower_minimum
from sysid.prediction.model import Model, Scales, in_contact, public_name, with_effect
from sysid.prediction.problem import Problem

REFITTED = 10
"""Candidates refitted in full, in the order of the screening. The others keep their screening fit."""

IN_FULL = 3
"""Number of these candidates refitted to the whole of long records; the others keep the fit to their beginnings."""

PAIRS_REFITTED = 6
"""Pairs refitted, in the order of the joint score."""

ON_TOP = 3
"""Effects refitted on top of a model other than the stated one, each in its best variant."""

SCREENED_ON_TOP = 10
"""Effects, in every variant, with a short fit on top of it, in the order of the score test."""

PROMISE_IN_PLACE = 0.5
"""Part of the reduction by an effect that another one must promise to be tried in its place, where it has to gain more:
an effect is taken to remove at least half of what it does at its minimum at some point of its shape grid."""

CONVERGED = 40
"""Steps of the fit of a model that is reported."""

CURVE_STEPS = 8
"""Steps of the fit of a free curve: its values enter linearly."""

NOISE_LOSS = 1.1
"""Held-out loss up to which no further minimum or variant is searched."""


@dataclass(eq=False)
class ModelSearch:
    """Candidate models of one problem, computed on first access: of all effects of the library, or of those with public
    names, or of the `options` only."""

    problem: Problem
    base: ReferenceFit
    all_effects: bool = False
    progress: Progress | None = None
    options: Sequence[Effect] | None = None

    def __post_init__(self) -> None:
        self.reference = Reference.of(self.problem, self.base)
        self._steps: dict[tuple[str, ...], list[Candidate]] = {}
        self._curves: dict[tuple[str, ...], dict[str, Candidate]] = {}
        self._without: dict[tuple[str, ...], Candidate | None] = {}
        self._converged: set[Candidate] = set()

    @cached_property
    def stated(self) -> Candidate:
        """The stated model as a candidate without added effects."""
        found = self.reference.evaluate(self.base.fitted, ())
        assert found is not None
        return found

    @cached_property
    def screening(self) -> ScreeningResult:
        """Screening of every candidate effect on top of the base model."""
        return screen_all(self.problem, self.base, self.all_effects, self.progress, options=self.options)

    @cached_property
    def singles(self) -> list[Candidate]:
        """The base model with one effect, every variant, lowest held-out loss first."""
        problem, base = self.problem, self.base
        fits = self.screening.fits
        fitted, records = truncated(base.fitted, problem.fit_records)

        def evaluate(numbered: tuple[int, ScreeningFit]) -> Candidate | None:
            k, fit = numbered
            if k >= REFITTED:
                refitted = with_final_jacobian(fit.fitted, records)
            else:
                refitted = refit_candidate(fitted, fit, records, problem.scales).fitted
            return self.reference.evaluate(refitted, (fit.effect,), reductions=fit.reductions)

        found = self._map(evaluate, list(enumerate(fits)), [*(fit.effect for fit in fits), *fitted.model.effects])
        found.sort(key=lambda c: c.held_out.loss)
        if fitted is not base.fitted:
            for k, one in enumerate(found[:IN_FULL]):
                whole = fit_model(one.fitted.model, problem.fit_records, base.fitted.weights)
                found[k] = self._like(one, whole) or one
        found = sorted(self._with_lower_minima(found), key=lambda c: c.held_out.loss)
        # The variants and shapes of the effects of the model, with the best one, are searched again.
        return [*map(self._with_searched_effects, found[:1]), *found[1:]]

    @cached_property
    def ranked(self) -> list[Candidate]:
        """The best variant of each effect, lowest held-out loss first."""
        return one_per_family(self.singles)

    def in_place(self, model: Candidate, below: Candidate) -> list[Candidate]:
        """A model with another effect in the place of one, without which it is `below`, best first."""
        reached = 0.0 if model.implausible else 1.0 - model.fit_loss / below.fit_loss
        return self.step(below, PROMISE_IN_PLACE * max(reached, 0.0))

    def step(self, model: Candidate, least: float = 0.0) -> list[Candidate]:
        """A model with one more effect, best first; of the first one the variant that predicts the held-out records.
        Those that are predicted to remove less than the share `least` of the squared residual may be left out."""
        if not model.added and not model.removed:
            return self.ranked
        key = model.names if model.names in self._steps or not least else (*model.names, "in place")
        if key not in self._steps:
            records, scales = self.problem.fit_records, self.problem.scales
            below = reference_fit(self.problem, model.fitted, self.base.weights)
            known, most = self.screening, SCREENED_ON_TOP
            screening = screen_all(self.problem, below, self.all_effects, promising=most, known=known, least=least)

            def refit(fit: ScreeningFit) -> Candidate | None:
                fitted = refit_candidate(model.fitted, fit, records, scales).fitted
                return self.reference.evaluate(fitted, (*model.added, fit.effect), model.removed)

            best: dict[str, ScreeningFit] = {}
            for one in screening.fits:
                best.setdefault(public_name(one.effect.name), one)
            best.pop(model.removed, None)

            def refitted(fits: list[ScreeningFit]) -> list[Candidate]:
                return self._map(refit, fits, [*(fit.effect for fit in fits), *model.fitted.model.effects])

            found = refitted([*best.values()][:ON_TOP])
            first = min(found, key=lambda c: c.held_out.loss, default=None)
            if first is not None and first.held_out.loss > NOISE_LOSS:
                # Variants that fit alike may predict the held-out records differently.
                family = public_name(first.added[-1].name)
                others = [f for f in screening.fits if public_name(f.effect.name) == family and f is not best[family]]
                found = one_per_family([*found, *refitted(others)])
            self._steps[key] = sorted(found, key=lambda c: c.held_out.loss)
        return self._steps[key]

    @cached_property
    def pairs(self) -> list[Candidate]:
        """The base model with two effects, chosen by their joint score, best first."""
        base = self.base.fitted

        def fit(pair: ScoredPair) -> Candidate | None:
            start = pair.start(base.model, self.problem.scales)
            fitted = fit_model(start, self.problem.fit_records, base.weights, near=base)
            return self.reference.evaluate(fitted, pair.effects)

        pairs = scored_pairs(base, self.screening, PAIRS_REFITTED)
        return sorted(self._map(fit, pairs, [e for pair in pairs for e in pair.effects]), key=lambda c: c.held_out.loss)

    @cached_property
    def curves(self) -> list[Candidate]:
        """The base model with one free curve, best first."""
        return self.with_curves(self.stated)

    def with_curves(self, model: Candidate, coordinates: Collection[str] | None = None) -> list[Candidate]:
        """A model with one free curve, of any of these coordinates, best first."""
        below, known = model.fitted, self._curves.setdefault(model.names, {})
        effects = [e for e in free_curves(self.problem) if coordinates is None or e.coordinates[0] in coordinates]

        def fit(curve: Effect) -> Candidate | None:
            start = with_curve(below.model, curve, self.problem.scales)
            fitted = fit_model(start, self.problem.fit_records, below.weights, CURVE_STEPS, near=below)
            return self.reference.evaluate(fitted, (*model.added, curve))

        new = [e for e in effects if e.name not in known]
        known.update({c.added[-1].name: c for c in self._map(fit, new, [*new, *below.model.effects])})
        return sorted((known[e.name] for e in effects if e.name in known), key=lambda c: c.held_out.loss)

    def without(self, model: Candidate, name: str) -> Candidate | None:
        """A model without one of its effects, by name, or by public name every effect of it, refitted; a friction state
        model is replaced by rigid friction at the same limit."""
        key = (*model.names, "without", name)
        if key not in self._without:
            kept = tuple(e for e in model.added if name not in (e.name, public_name(e.name)))
            if model.added and not kept:
                self._without[key] = self.stated
                return self.stated
            start = without_added(model.fitted.model, name, self.base.fitted.model, self.problem.scales)
            fitted = fit_model(start, self.problem.fit_records, self.base.fitted.weights, near=model.fitted)
            removed = "" if len(kept) < len(model.added) else name
            self._without[key] = self.reference.evaluate(fitted, kept, removed)
        return self._without[key]

    def before(self, added: Collection[str]) -> HeldOut:
        """Held-out residual of the stated model without effects that were added to it before, by name, refitted."""
        base = self.base.fitted
        present = [effect.name for effect in base.model.effects if effect.name in added]
        if not present:
            return self.reference.held_out
        start = base.model
        for name in present:
            start = without_added(start, name, base.model, self.problem.scales)
        fitted = fit_model(start, self.problem.fit_records, base.weights)
        return held_out(fitted, self.problem.validate_records, self.base.weights, base.model)

    def converged(self, model: Candidate) -> Candidate:
        """A model with its fit continued until it converges, in the lowest minimum nearby, and the variants and shapes
        of the stated effects searched again."""
        if model in self._converged:
            return model
        records = self.problem.fit_records
        lowest = lowest_minimum(model.fitted, records)
        fitted = fit_model(lowest.model, records, self.base.fitted.weights, CONVERGED, near=lowest)
        found = self._with_searched_effects(self._like(model, fitted) or model)
        self._converged.add(found)
        return found

    def exchanged(self, model: Candidate) -> HeldOut | None:
        """Residual on the records of the fit of a model that is fitted to the held-out records; None where it is not
        finite."""
        problem, base = self.problem, self.base
        if not problem.validate_records:
            return None
        fitted = fit_model(model.fitted.model, problem.validate_records, base.weights, CONVERGED)
        found = held_out(fitted, problem.fit_records, base.fitted.weights, base.fitted.model)
        return found if np.isfinite(found.residual).all() else None

    def _map(
        self, function: Callable[[Any], Candidate | None], items: Sequence[Any], identical: Sequence[object]
    ) -> list[Candidate]:
        shared = (*identical, *self.base.fitted.model.effects, self.base.fitted.weights, self.problem)
        return [found for found in map_items(function, items, shared) if found is not None]

    def _like(self, model: Candidate, fitted: FittedModel) -> Candidate | None:
        """The candidate of the same effects with another fit."""
        return self.reference.evaluate(fitted, model.added, model.removed, model.reductions)

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
            own, records = candidate.fitted, self.problem.fit_records
            lower = search_lower_minimum(self.base.fitted, own, records, of_contact=slips)
            further = self._like(candidate, lower) if lower is not own else None
            if further is not None and further.held_out.loss < candidate.held_out.loss:
                found[k] = further
        return found

    @cached_property
    def _reselectable(self) -> tuple[str, ...]:
        """Public names of the effects of the model whose variant the program selects."""
        names = [public_name(name) for name in (*self.base.laws, *variant_selection.reselectable_effects(self.problem))]
        present = {public_name(e.name) for e in self.base.fitted.model.effects}
        return tuple(name for name in dict.fromkeys(names) if name in present)

    def _with_searched_effects(self, candidate: Candidate) -> Candidate:
        """A candidate, with the variants of the model's effects selected again, and their shapes searched again, where
        that lowers its held-out loss: what was selected or fitted while an effect was missing may be wrong."""
        whole = candidate.fitted.fit.residual.size == self.base.fitted.fit.residual.size
        if not whole or candidate.held_out.loss <= NOISE_LOSS:
            return candidate
        other = (*candidate.families, candidate.removed)
        families = [n for n in self._reselectable if n not in other]
        fitted, _ = variant_selection.select_variants(self.problem, candidate.fitted, families)
        free = {u.key.partition(".")[0] for u in fitted.model.unknowns}
        for effect in fitted.model.effects:
            if has_shape(effect) and effect.name in free and public_name(effect.name) not in (*other, *families):
                again = variant_selection.fit_replacement(fitted, effect, self.problem.fit_records, self.problem.scales)
                fitted = again if variant_selection.fits_clearly_better(again, fitted) else fitted
        if fitted is candidate.fitted:
            return candidate
        found = self._like(candidate, fitted)
        return candidate if found is None or found.held_out.loss >= candidate.held_out.loss else found


def without_added(model: Model, name: str, stated: Model, scales: Scales) -> Model:
    """The model without the effect of a name, or every effect of a public name; a friction state model is replaced by
    that of the `stated` model, or rigid friction, at the same friction limit."""
    for effect in [e for e in model.effects if name in (e.name, public_name(e.name))]:
        before = next((e for e in stated.effects if e.friction_state is not None and not in_contact(e)), None)
        core = rigid_friction() if before is None or before.name == effect.name else before
        if effect.friction_state is None or in_contact(effect) or core.name == effect.name:
            model = variant_selection.without_effect(model, effect.name)
            continue
        model = with_effect(model, core, scales)
        known = {u.key: u for u in stated.unknowns if u.key.startswith(f"{core.name}.")}
        values = {key: stated.values[key] for key in known if key != f"{core.name}.force"}
        others = tuple(u for u in model.unknowns if u.key not in known)
        model = replace(model, unknowns=(*others, *known.values())).at({**model.values, **values})
    return model
