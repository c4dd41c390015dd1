"""The first fit of a model as an experiment states it: shape parameters that nobody gave a start are searched for.

A Stribeck velocity or a tooth's pitch has no gradient where its effect is still absent, or is off by more than a
fraction of itself. A fit that starts anywhere stays there, finds no amplitude, and an effect that the model has would
seem to be missing from it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from sim.library.effect import Effect
from sysid.estimation.base_fit import Fitted, fit_model, ranking_error
from sysid.estimation.driven_stage_minima import lowest_valley
from sysid.estimation.driven_stage_starts import rough_starts
from sysid.estimation.misfit import weighted_residual
from sysid.estimation.score_test import target_of
from sysid.estimation.screening import try_effect
from sysid.prediction.model import Model, Prepared, Scales


def first_fit(model: Model, records: Sequence[Prepared], scales: Scales, given: Collection[str]) -> Fitted:
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
        before = ranking_error(direct.fit.residual)
        if ranking_error(weighted_residual(other.model, records, direct.weights)) < before:
            model, direct = start, other
    lower = lowest_valley(direct, records)
    if lower is not direct:
        direct = fit_model(lower.model, records)
    start = _searched(model, records, scales, given)
    if start is None:
        return direct
    other = fit_model(start, records)
    before = ranking_error(direct.fit.residual)
    after = ranking_error(weighted_residual(other.model, records, direct.weights))
    return other if after < before else direct


def _searched(model: Model, records: Sequence[Prepared], scales: Scales, given: Collection[str]) -> Model | None:
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
        basis, target = target_of(fitted)
        found = try_effect(fitted, effect, records, scales, basis, target)
        if found is not None:
            fitted = found.fitted
    return model.at({key: value for key, value in fitted.model.values.items() if key in model.values})


def has_shape(effect: Effect) -> bool:
    """Whether an effect has parameters that are searched on a grid before they are fitted."""
    return effect.core is None and any(
        p.role == "shape" and p.scan is not None and not p.fixed for p in effect.parameters
    )
