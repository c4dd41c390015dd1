"""One law of an effect put in another's place in a fitted model, its shape searched before it is fitted.

A fit that begins with a wrong shape stays there: a Stribeck curve that starts ten times too wide loses its force, and
with it the gradient of its width.
"""

from __future__ import annotations

from collections.abc import Sequence

from sim.library.effect import Effect
from sysid.estimation.base_fit import Fitted, fit_model, ranking_error
from sysid.estimation.misfit import weighted_residual
from sysid.estimation.score_test import grid_of, linear_scores, target_of
from sysid.estimation.synchronised_fit import led
from sysid.prediction.model import Model, Prepared, Scales, base_name, law_family, with_effect

HELD = 15
"""Steps of a fit held to the measured motion."""


def without_law(model: Model, effect: str) -> Model:
    """The model less one effect and its parameters, whatever law of it the model has on the effect's channel."""
    return _without(model, [e.name for e in model.effects if law_family(e.name) == law_family(effect)])


def without_family(model: Model, family: str) -> Model:
    """The model less every effect of one name, on whatever channel, and their parameters."""
    return _without(model, [e.name for e in model.effects if base_name(e.name) == family])


def _without(model: Model, gone: Sequence[str]) -> Model:
    keep = tuple(e for e in model.effects if e.name not in gone)
    belongs = tuple(f"{name}." for name in gone)
    values = {k: v for k, v in model.values.items() if not k.startswith(belongs)}
    return Model(keep, values, tuple(u for u in model.unknowns if not u.key.startswith(belongs)))


def searched(
    fitted: Fitted, effect: Effect, records: Sequence[Prepared], scales: Scales, place: str | None = None
) -> Fitted:
    """The model with `effect` in place of its family's law (or of the one at `place`, as on another channel), fitted
    from the best point of the effect's grid.

    Bounds, priors and fixed values of the model stay. `effect` is no core. On a driven stage a fit held to the measured
    motion leads there too.
    """
    rest = fit_model(without_law(fitted.model, place or effect.name), records, fitted.weights, near=fitted)
    basis, target = target_of(rest)
    scores = linear_scores(effect, grid_of(rest, effect, records, scales), basis, target)
    start = with_bounds_of(with_effect(rest.model, effect, scales, scores[0].start if scores else None), fitted.model)
    direct = fit_model(start, records)
    fits = [fit_model(other, records) for other in led([start, direct.model], records, direct.weights, HELD)]
    return min([direct, *fits], key=lambda f: ranking_error(weighted_residual(f.model, records, direct.weights)))


def with_bounds_of(model: Model, given: Model) -> Model:
    """The model with bounds and priors as `given` has them, where it has the same unknown."""
    known = {u.key: u for u in given.unknowns}
    fixed = set(given.values) - set(known)
    values = {**model.values, **{key: given.values[key] for key in fixed if key in model.values}}
    unknowns = tuple(known.get(u.key, u) for u in model.unknowns if u.key not in fixed)
    return Model(model.effects, values, unknowns).at(values)
