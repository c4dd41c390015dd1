"""The model of a problem at its best fit, with the law of each effect that fits best.
The first fit of a model as an experiment states it: shape parameters that nobody gave a start are searched for.

A Stribeck velocity or a tooth's pitch has no gradient where its effect is still absent, or is off by more than a
fraction of itself. A fit that starts anywhere stays there, finds no amplitude, and an effect that the model has would
seem to be missing from it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sim.effects.catalogue import find, laws_of
from sim.library.effect import Effect
from stagecad.parallel import fork_map
from sysid.estimation.driven_stage_search import lowest_minimum
from sysid.estimation.driven_stage_starts import rough_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import ResidualWeights, residual_weights, weighted_residual
from sysid.estimation.score_test import profiled_residual
from sysid.estimation.screening import screen_and_refit
from sysid.estimation.variant_selection import core_variant_fits, fit_replacement
from sysid.prediction.model import Model, PreparedRecord, Scales, public_name, variant_group
from sysid.prediction.observable import is_observable
from sysid.prediction.problem import Problem


@dataclass(frozen=True)
class ReferenceFit:
    """The model of a problem at its best, and what the comparison with others needs.

    Args:
        fitted: model, fit and weights on the records of the fit.
        weights: deviations and samples of the held-out records.
        residual: of the held-out records, in deviations, (n,).
        laws: effects of the model whose law was chosen among variants, as `stribeck:rational`.
        memo: searches on top of this fit that more than one question needs, by what they are.
    """

    fitted: FittedModel
    weights: ResidualWeights
    residual: np.ndarray
    laws: tuple[str, ...] = ()
    memo: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)


def fit_stated_model(problem: Problem, model: Model | None = None) -> ReferenceFit:
    """Fit the problem's model; an effect named without a variant takes the law of its family that fits best."""
    chosen: tuple[str, ...] = ()
    if model is not None:
        fitted = fit_model(model, problem.fit_records)
    else:
        given = [key for key, setting in problem.experiment.parameters.items() if setting.start is not None]
        fitted = initial_fit(problem.start, problem.fit_records, problem.scales, given)
        fitted, chosen = select_variants(problem, fitted)
    weights = residual_weights(fitted.model, problem.validate_records)
    residual = weighted_residual(fitted.model, problem.validate_records, weights)
    return ReferenceFit(fitted, weights, residual, chosen)


def fits_clearly_better(other: FittedModel, fitted: FittedModel) -> bool:
    """Whether another law of an effect fits so much better that chance and its extra values do not explain it."""
    extra = len(other.model.unknowns) - len(fitted.model.unknowns)
    # Law by law the cost of a wrong curve is far above the noise; chance is not.
    return other.fit.cost < 0.97 * fitted.fit.cost - 4.0 * max(extra, 0)


BETTER_HELD_OUT = 0.67
"""Part of the held-out loss above the noise below which another law of an effect is taken for that alone."""


def predicts_clearly_better(problem: Problem, other: FittedModel, fitted: FittedModel) -> bool:
    """Whether another law of an effect fits clearly better or, fitting no worse, predicts the held-out records so."""
    if fits_clearly_better(other, fitted):
        return True
    weights = residual_weights(fitted.model, problem.validate_records)
    errors = [
        root_mean_huber(weighted_residual(m, problem.validate_records, weights)) for m in (other.model, fitted.model)
    ]
    above = [error**2 - 1.0 for error in errors]
    return other.fit.cost <= fitted.fit.cost and above[1] > 0.5 and above[0] < BETTER_HELD_OUT * above[1]


def select_variants(
    problem: Problem,
    fitted: FittedModel,
    families: Collection[str] | None = None,
    better: Callable[[FittedModel, FittedModel], bool] = fits_clearly_better,
) -> tuple[FittedModel, tuple[str, ...]]:
    """A fit in which effects have the best law of their family.

    The law of the family's own name is taken unless another is better.

    Args:
        problem: whose records are fitted.
        fitted: the model as it stands, with any law of each family.
        families: names of the effects whose law is open; those of `open_laws` where left out.
        better: whether one fit is so much better than another that its law is taken.

    Returns:
        The fit, and the names of the laws that took their family's place.
    """
    chosen: list[str] = []
    for name in selectable_effects(problem) if families is None else families:
        for place in dict.fromkeys(variant_group(e.name) for e in fitted.model.effects):
            if name in (place, public_name(place)):
                fitted = _best_law(problem, fitted, place, better)
                if "@" in place and "@" not in name:
                    fitted = _best_channel(problem, fitted, place, better)
                chosen += [
                    e.name for e in fitted.model.effects if public_name(e.name) == public_name(place) and ":" in e.name
                ]
    return fitted, tuple(dict.fromkeys(chosen))


def _best_law(
    problem: Problem, fitted: FittedModel, place: str, better: Callable[[FittedModel, FittedModel], bool]
) -> FittedModel:
    """A fit in which one effect, named without a variant, has its best law."""
    effect = find(place, problem.custom)
    before: list[FittedModel] = []
    if place not in {e.name for e in fitted.model.effects}:
        # Another law was chosen while the model still lacked something; its fit may be better than any begun anew.
        before = [fitted]
        fitted = fit_replacement(fitted, effect, problem.fit_records, problem.scales)
    if effect.friction_state is not None:
        trials = core_variant_fits(fitted, effect, problem.fit_records, problem.scales)
    else:
        shown = [law for law in laws_of(place, problem.custom) if is_observable(problem, law)]
        given, shared = fitted, (*shown, *fitted.model.effects)
        trials = fork_map(lambda law: fit_replacement(given, law, problem.fit_records, problem.scales), shown, shared)
    best = min([*trials, *before], key=lambda t: t.fit.cost + 4.0 * len(t.model.unknowns), default=fitted)
    return best if better(best, fitted) else fitted


def _best_channel(
    problem: Problem, fitted: FittedModel, place: str, better: Callable[[FittedModel, FittedModel], bool]
) -> FittedModel:
    """A fit in which a sensor's effect acts on the channel where it does best: which, what was missing may have hid."""
    present = {variant_group(e.name) for e in fitted.model.effects}
    channels = [name for name in problem.fit_records[0].measured if f"{public_name(place)}@{name}" not in present]
    places = [f"{public_name(place)}@{channel}" for channel in channels]
    laws = [law for other in places for law in (find(other, problem.custom), *laws_of(other, problem.custom))]
    trials = [
        fit_replacement(fitted, law, problem.fit_records, problem.scales, place)
        for law in laws
        if is_observable(problem, law)
    ]
    best = min(trials, key=lambda t: t.fit.cost + 4.0 * len(t.model.unknowns), default=fitted)
    return best if better(best, fitted) else fitted


def selectable_effects(problem: Problem) -> tuple[str, ...]:
    """Effects whose law is for the fit to choose: named without a variant, and with no value given by the user."""
    given = {key.rpartition(".")[0] for key in problem.experiment.parameters}
    return tuple(
        e.name for e in problem.start.effects
        if ":" not in e.name and e.variants and e.name not in given
    )  # fmt: skip


def initial_fit(model: Model, records: Sequence[PreparedRecord], scales: Scales, given: Collection[str]) -> FittedModel:
    """Fit of a model from its stated start, and from one that is searched for, whichever ends better.

    Args:
        model: as the experiment states it.
        records: those fitted.
        scales: of the records.
        given: keys of parameters whose start the experiment states; effects with any of these are not searched.
    """
    direct = fit_model(model, records)
    for start in rough_starts(model, records, given):
        other = fit_model(start, records)
        before = root_mean_huber(direct.fit.residual)
        if root_mean_huber(weighted_residual(other.model, records, direct.weights)) < before:
            model, direct = start, other
    lower = lowest_minimum(direct, records)
    if lower is not direct:
        direct = fit_model(lower.model, records)
    start = _start_from_screening(model, records, scales, given)
    if start is None:
        return direct
    other = fit_model(start, records)
    before = root_mean_huber(direct.fit.residual)
    after = root_mean_huber(weighted_residual(other.model, records, direct.weights))
    return other if after < before else direct


def _start_from_screening(
    model: Model, records: Sequence[PreparedRecord], scales: Scales, given: Collection[str]
) -> Model | None:
    """The model with shape parameters from a search, one effect on top of the other; none where nothing is sought."""
    sought = [e for e in model.effects if has_shape(e) and not any(key.startswith(f"{e.name}.") for key in given)]
    if not sought:
        return None
    gone = tuple(f"{e.name}." for e in sought)
    rest = replace(
        model,
        effects=tuple(e for e in model.effects if e not in sought),
        unknowns=tuple(u for u in model.unknowns if not u.key.startswith(gone)),
    )
    fitted = fit_model(rest, records)
    for effect in sought:
        basis, target = profiled_residual(fitted)
        found = screen_and_refit(fitted, effect, records, scales, basis, target)
        if found is not None:
            fitted = found.fitted
    return model.at({key: value for key, value in fitted.model.values.items() if key in model.values})


def has_shape(effect: Effect) -> bool:
    """Whether an effect has parameters that are searched on a grid before they are fitted."""
    return effect.friction_state is None and any(
        p.role == "shape" and p.scan is not None and not p.fixed for p in effect.parameters
    )
