"""Selection of the variant (constitutive law) of each effect of a model, and refits with one effect replaced.

A fit does not recover from a wrong initial shape: for a Stribeck curve ten times too wide the amplitude is fitted to
zero, and the gradient in the width vanishes. A replaced effect therefore starts from the best point of its shape grid
by the score test.
"""

from collections.abc import Callable, Collection, Sequence
from functools import reduce
from typing import TypeAlias

import numpy as np

from sim.effects.catalogue import find, laws_of
from sim.effects.effect import Effect
from sim.effects.friction_state.maxwell_slip import HELD_SHARE, free_stretches
from sim.numerics.elasto_plastic import elements_along
from stagecad.processes import fork_map
from sysid.estimation.driven_stage_search import SYNCHRONISED_STEPS, synchronised_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber, std_ratio
from sysid.estimation.misfit import huber_square, residual_weights, shared_weights, weighted_residual
from sysid.estimation.screening import candidate_directions, profiled_residual, score_test
from sysid.experiment.ladder import edited_by_hand, read_history
from sysid.prediction.model import Model, Scales, public_name, variant_group, with_effect
from sysid.prediction.observable import is_observable
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem

Better: TypeAlias = Callable[[FittedModel, FittedModel], bool]
"""Whether the first fit is so much better than the second that its variant replaces the present one."""

PENALTY = 4.0
"""Cost of one more fitted value when variants are compared: Huber's loss in standard deviations squared."""

CLEARLY_LOWER = 0.97
"""Ratio of costs below which the better fit of another variant is not explained by noise and its additional
values."""

BETTER_HELD_OUT = 0.67
"""Ratio of the held-out losses above the noise level below which another variant is selected for its prediction."""


def without_effect(model: Model, effect: str) -> Model:
    """The model without the effect, or any other variant of it on the same channel, and its parameters."""
    removed = [e.name for e in model.effects if variant_group(e.name) == variant_group(effect)]
    keep = tuple(e for e in model.effects if e.name not in removed)
    prefixes = tuple(f"{name}." for name in removed)
    values = {k: v for k, v in model.values.items() if not k.startswith(prefixes)}
    return Model(keep, values, tuple(u for u in model.unknowns if not u.key.startswith(prefixes)))


def with_bounds_of(model: Model, given: Model) -> Model:
    """The model with the bounds, priors and fixed values of `given` for the unknowns in both models."""
    known = {u.key: u for u in given.unknowns}
    fixed = set(given.values) - set(known)
    values = {**model.values, **{key: given.values[key] for key in fixed if key in model.values}}
    unknowns = tuple(known.get(u.key, u) for u in model.unknowns if u.key not in fixed)
    return Model(model.effects, values, unknowns).at(values)


def fit_replacement(
    fitted: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, place: str | None = None
) -> FittedModel:
    """Fit of the model with `effect` in place of another variant, from the best point of its shape grid.

    Bounds, priors and fixed values of the model are kept. On a driven stage a synchronisation fit gives further
    starting points.
    """
    rest = fit_model(without_effect(fitted.model, place or effect.name), records, fitted.weights, near=fitted)
    scores = score_test(effect, candidate_directions(rest, effect, records, scales), *profiled_residual(rest))
    start = with_bounds_of(with_effect(rest.model, effect, scales, scores[0].start if scores else None), fitted.model)
    direct = fit_model(start, records)
    others = synchronised_starts([start, direct.model], records, direct.weights, SYNCHRONISED_STEPS)
    fits = [direct, *(fit_model(other, records) for other in others)]
    return min(fits, key=lambda f: root_mean_huber(weighted_residual(f.model, records, direct.weights)))


def fits_clearly_better(other: FittedModel, fitted: FittedModel) -> bool:
    """Whether another variant fits so much better that noise and its additional values do not explain it."""
    extra = len(other.model.unknowns) - len(fitted.model.unknowns)
    costs = _shared_costs([other, fitted])
    return costs[0] < CLEARLY_LOWER * costs[1] - PENALTY * max(extra, 0)


def _shared_costs(fits: Sequence[FittedModel]) -> list[float]:
    """Huber's loss of fits to the same records, by weights that all share: a variant whose prediction depends more on
    the noise gains nothing by its larger deviations."""
    shared = reduce(shared_weights, [one.weights for one in fits])
    return [0.5 * float(np.sum(huber_square(one.fit.residual * std_ratio(one.weights, shared)))) for one in fits]


def predicts_clearly_better(problem: Problem, other: FittedModel, fitted: FittedModel) -> bool:
    """Whether another variant fits clearly better and predicts the held-out records no worse or, fitting no worse,
    predicts them clearly better."""
    records = problem.validate_records
    weights = residual_weights(fitted.model, records)
    above = [root_mean_huber(weighted_residual(f.model, records, weights)) ** 2 - 1.0 for f in (other, fitted)]
    if fits_clearly_better(other, fitted):
        return above[0] <= max(above[1], 0.0)
    costs = _shared_costs([other, fitted])
    return costs[0] <= costs[1] and above[1] > 0.5 and above[0] < BETTER_HELD_OUT * above[1]


def selectable_effects(problem: Problem) -> tuple[str, ...]:
    """Effects of the stated model whose variant is selected: those named without variant and without given values."""
    given = {key.rpartition(".")[0] for key in problem.experiment.parameters}
    effects = [e for e in problem.start.effects if e.variants and e.name not in given]
    return tuple(e.name for e in effects if ":" not in e.name)


def reselectable_effects(problem: Problem, added: Sequence[str] = ()) -> tuple[str, ...]:
    """Public names of the effects whose variant the program selects again when the model changes: those named without a
    variant in the file, in the last revision, or among the effects `added` now. Friction state models are left out."""
    history = read_history(problem.experiment)
    edited = not history or edited_by_hand(problem.experiment, history)
    before = [] if edited else history[-1].document.get("open_laws", [])
    named = [name for name in added if ":" not in name and "@" not in name]
    effects = dict.fromkeys([*selectable_effects(problem), *before, *named])
    return tuple(
        name
        for name in effects
        if find(name, problem.custom).variants and find(name, problem.custom).friction_state is None
    )


def select_variants(
    problem: Problem, fitted: FittedModel, names: Collection[str] | None = None, better: Better = fits_clearly_better
) -> tuple[FittedModel, tuple[str, ...]]:
    """A fit in which effects have the variant that fits best.

    The default variant (with the public name of the effect) is kept unless another is better.
    """
    chosen: list[str] = []
    for name in selectable_effects(problem) if names is None else names:
        for place in dict.fromkeys(variant_group(e.name) for e in fitted.model.effects):
            if name in (place, public_name(place)):
                fitted = _best_variant(problem, fitted, place, better)
                if "@" in place and "@" not in name:
                    fitted = _best_channel(problem, fitted, place, better)
                same = [e.name for e in fitted.model.effects if public_name(e.name) == public_name(place)]
                chosen += [effect for effect in same if ":" in effect]
    return fitted, tuple(dict.fromkeys(chosen))


def _lowest(trials: Sequence[FittedModel], fitted: FittedModel) -> FittedModel:
    """The fit of the lowest loss, each fitted value at its cost; the present one if there are no trials."""
    costs = [c + PENALTY * len(f.model.unknowns) for c, f in zip(_shared_costs(trials), trials)] if trials else []
    return trials[int(np.argmin(costs))] if costs else fitted


def _best_variant(problem: Problem, fitted: FittedModel, place: str, better: Better) -> FittedModel:
    """A fit in which one effect has its best variant."""
    effect = find(place, problem.custom)
    before: list[FittedModel] = []
    if place not in {e.name for e in fitted.model.effects}:
        # If another variant was selected before an effect was added, its fit is compared with the new ones.
        before = [fitted]
        fitted = fit_replacement(fitted, effect, problem.fit_records, problem.scales)
    if effect.friction_state is not None:
        trials = core_variant_fits(fitted, effect, problem.fit_records, problem.scales)
    else:
        variants = [law for law in laws_of(place, problem.custom) if is_observable(problem, law)]
        given, shared = fitted, (*variants, *fitted.model.effects)
        trials = fork_map(
            lambda law: fit_replacement(given, law, problem.fit_records, problem.scales), variants, shared
        )
    best = _lowest([*trials, *before], fitted)
    return best if better(best, fitted) else fitted


def _best_channel(problem: Problem, fitted: FittedModel, place: str, better: Better) -> FittedModel:
    """A fit in which a sensor effect acts on its best channel, which may change when effects are added."""
    present = {variant_group(e.name) for e in fitted.model.effects}
    channels = [name for name in problem.fit_records[0].measured if f"{public_name(place)}@{name}" not in present]
    places = [f"{public_name(place)}@{channel}" for channel in channels]
    variants = [law for other in places for law in (find(other, problem.custom), *laws_of(other, problem.custom))]
    trials = [
        fit_replacement(fitted, law, problem.fit_records, problem.scales, place)
        for law in variants
        if is_observable(problem, law)
    ]
    best = _lowest(trials, fitted)
    return best if better(best, fitted) else fitted


SUFFICIENT = 1.2
"""Root mean Huber loss below which the hysteresis curve of a Maxwell-slip core is not refined."""

SPANS = (10.0, 100.0)
"""Ratios of the longest to the shortest yield displacement from which the refined fit starts."""


def core_variant_fits(
    fitted: FittedModel, core: Effect, records: Sequence[PreparedRecord], scales: Scales
) -> list[FittedModel]:
    """Fits of a Maxwell-slip core of given curve with free elements; empty if the given curve is sufficient."""
    if root_mean_huber(fitted.fit.residual) <= SUFFICIENT:
        return []
    free = next((v for v in core.variants if v.friction_state is not None and v.friction_state.free_shares), None)
    if free is None or core.friction_state is None or core.friction_state.springs is None:
        return []
    starts = [
        with_effect(fitted.model, free, scales, _equivalent_elements(fitted.model, core, free, span)) for span in SPANS
    ]
    return [fit_model(with_bounds_of(start, fitted.model), records) for start in starts]


def _equivalent_elements(model: Model, core: Effect, free: Effect, span: float) -> dict[str, float]:
    """Values of the free elements that reproduce the hysteresis curve of the fitted core."""
    stretch, curvature = (model.values[f"{core.name}.{name}"] for name in ("stretch", "curvature"))
    stretches = free_stretches(stretch, span)
    shares = elements_along(stretches, 1.0 - (1.0 - np.minimum(stretches / stretch, 1.0)) ** curvature).weights
    shares = np.maximum(shares, 1e-3 * np.max(shares))
    shares = shares / shares[HELD_SHARE - 1]
    values = {f"{free.name}.share_{k + 1}": float(share) for k, share in enumerate(shares)}
    return {**values, f"{free.name}.stretch": stretch, f"{free.name}.span": span}
