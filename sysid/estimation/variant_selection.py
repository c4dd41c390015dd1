"""One law of an effect put in another's place in a fitted model, its shape searched before it is fitted.

A fit that begins with a wrong shape stays there: a Stribeck curve that starts ten times too wide loses its force, and
with it the gradient of its width.

Which law the bristles of a model's core follow: those with free shares begin where the fitted law ended."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.friction_state.maxwell_slip import HELD_SHARE, free_shares, free_stretches
from sim.library.effect import Effect
from sysid.estimation.driven_stage_search import synchronised_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import weighted_residual
from sysid.estimation.score_test import candidate_directions, profiled_residual, score_test
from sysid.prediction.model import Model, PreparedRecord, Scales, public_name, variant_group, with_effect

HELD = 15
"""Steps of a fit held to the measured motion."""


def without_effect(model: Model, effect: str) -> Model:
    """The model less one effect and its parameters, whatever law of it the model has on the effect's channel."""
    return _without(model, [e.name for e in model.effects if variant_group(e.name) == variant_group(effect)])


def without_public_effect(model: Model, family: str) -> Model:
    """The model less every effect of one name, on whatever channel, and their parameters."""
    return _without(model, [e.name for e in model.effects if public_name(e.name) == family])


def _without(model: Model, gone: Sequence[str]) -> Model:
    keep = tuple(e for e in model.effects if e.name not in gone)
    belongs = tuple(f"{name}." for name in gone)
    values = {k: v for k, v in model.values.items() if not k.startswith(belongs)}
    return Model(keep, values, tuple(u for u in model.unknowns if not u.key.startswith(belongs)))


def fit_replacement(
    fitted: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, place: str | None = None
) -> FittedModel:
    """The model with `effect` in place of its family's law (or of the one at `place`, as on another channel), fitted
    from the best point of the effect's grid.

    Bounds, priors and fixed values of the model stay. `effect` is no core. On a driven stage a fit held to the measured
    motion leads there too.
    """
    rest = fit_model(without_effect(fitted.model, place or effect.name), records, fitted.weights, near=fitted)
    basis, target = profiled_residual(rest)
    scores = score_test(effect, candidate_directions(rest, effect, records, scales), basis, target)
    start = with_bounds_of(with_effect(rest.model, effect, scales, scores[0].start if scores else None), fitted.model)
    direct = fit_model(start, records)
    fits = [
        fit_model(other, records) for other in synchronised_starts([start, direct.model], records, direct.weights, HELD)
    ]
    return min([direct, *fits], key=lambda f: root_mean_huber(weighted_residual(f.model, records, direct.weights)))


def with_bounds_of(model: Model, given: Model) -> Model:
    """The model with bounds and priors as `given` has them, where it has the same unknown."""
    known = {u.key: u for u in given.unknowns}
    fixed = set(given.values) - set(known)
    values = {**model.values, **{key: given.values[key] for key in fixed if key in model.values}}
    unknowns = tuple(known.get(u.key, u) for u in model.unknowns if u.key not in fixed)
    return Model(model.effects, values, unknowns).at(values)


WORTH_A_SEARCH = 1.2
"""Ranking error, in deviations, up to which the law of a core is good enough."""

SPANS = (10.0, 100.0)
"""Longest stretch over the shortest, where the search begins."""


def core_variant_fits(
    fitted: FittedModel, core: Effect, records: Sequence[PreparedRecord], scales: Scales
) -> list[FittedModel]:
    """Fits with the bristles of the model's core, Maxwell-slip of a given curve, left free; none where it fits."""
    if root_mean_huber(fitted.fit.residual) <= WORTH_A_SEARCH:
        return []
    free = next(
        (v for v in core.variants if v.friction_state is not None and v.friction_state.name == "free_maxwell_slip"),
        None,
    )
    if free is None or core.friction_state is None or core.friction_state.name != "maxwell_slip":
        return []
    starts = [
        with_effect(fitted.model, free, scales, _equivalent_elements(fitted.model, core, free, span)) for span in SPANS
    ]
    return [fit_model(with_bounds_of(start, fitted.model), records) for start in starts]


def _equivalent_elements(model: Model, core: Effect, free: Effect, span: float) -> dict[str, float]:
    """Values of the free law with which it yields as the fitted core does."""
    stretch, curvature = (model.values[f"{core.name}.{name}"] for name in ("stretch", "curvature"))
    stretches = free_stretches(stretch, span)
    shares = free_shares(stretches, 1.0 - (1.0 - np.minimum(stretches / stretch, 1.0)) ** curvature)
    shares = np.maximum(shares, 1e-3 * np.max(shares))
    shares = shares / shares[HELD_SHARE - 1]
    values = {f"{free.name}.share_{k + 1}": float(share) for k, share in enumerate(shares)}
    return {**values, f"{free.name}.stretch": stretch, f"{free.name}.span": span}
