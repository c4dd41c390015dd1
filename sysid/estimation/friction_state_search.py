"""Search for the minimum of a model with bristles: their stretch and damping together, from the records.

Bristles that are stiffer than the motion shows act as rigid friction, softer ones as a spring: on either side the cost
has minima of its own, and no gradient leads from them to the right one. The stretch is therefore scanned from the
noise of the position to the travel, the damping from nearly none to nearly critical damping of the mass on the
bristles; the other values stay at those of the fit, whose level is that of steady sliding. A fit from each of the
lowest points follows.

Behind a gap the force of a row is all or nothing: the error has a slope in the width of the gap only within a row of
its minimum, where it has a kink. The width is searched by a scan and Brent's method.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from sim.effects.effect import Effect
from stagecad.processes import map_items
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import ResidualWeights, shared_weights, weighted_residual
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, Scales, in_contact
from sysid.prediction.prepared_record import PreparedRecord

AT_THE_NOISE = 1.1
"""Root mean Huber loss at which a fit is not searched around: no other minimum is clearly lower."""

STRETCHES = 14
"""Stretches of the bristles that are tried."""

SHORTEST, LONGEST = 3.0, 0.5
"""Shortest stretch, in standard deviations of the position's noise, and longest, in ranges of the position."""

FEWEST_DECADES = 1e-5
"""Shortest stretch over the range of the position, where the noise of the position is smaller."""

DAMPING_RATIOS = (0.05, 0.5)
"""Damping of the bristles over the critical one that is tried."""

FITS = 3
"""Lowest points of the scan that are fitted."""


def lowest_bristle_fit(
    fitted: FittedModel, records: Sequence[PreparedRecord], scales: Scales, weights: ResidualWeights | None = None
) -> FittedModel:
    """The fit, or one of lower error from other stretches and damping of its bristles; unchanged without bristles.

    With `weights` all fits have these, as candidates that are compared with a base model do.
    """
    if not all(isinstance(record, ForceBalanceRecord) for record in records):
        return fitted

    def cost(trial: Model) -> float:
        return root_mean_huber(weighted_residual(trial, records, fitted.weights))

    if root_mean_huber(fitted.fit.residual) <= AT_THE_NOISE:
        return fitted
    best = fitted
    # All of them: bristles too stiff for the motion predict its noise, and are at the noise for that reason.
    for _, start in bristle_starts(fitted.model, records, scales, cost):
        best = lower_of(best, fit_model(start, records, weights), records)
    return best


def lower_of(fitted: FittedModel, other: FittedModel, records: Sequence[PreparedRecord]) -> FittedModel:
    """The fit whose root mean Huber loss is lower by the weights that both share."""
    weights = shared_weights(fitted.weights, other.weights)
    errors = [root_mean_huber(weighted_residual(one.model, records, weights)) for one in (fitted, other)]
    return other if errors[1] < errors[0] else fitted


def bristle_starts(
    model: Model, records: Sequence[PreparedRecord], scales: Scales, cost: Callable[[Model], float], lost: bool = True
) -> list[tuple[float, Model]]:
    """The points of lowest `cost` of the scan, each at a stretch of its own, local minima first; none without bristles.
    Where the fit may be `lost`, the level and the other values of the bristles begin anew."""
    core = next((e for e in model.effects if e.has_presliding and not in_contact(e)), None)
    if core is None:
        return []
    noise = max((r.prefiltered_noise for r in records if isinstance(r, ForceBalanceRecord)), default=0.0)
    shortest = max(SHORTEST * noise, FEWEST_DECADES * scales.position)
    stretches = np.geomspace(shortest, max(LONGEST * scales.position, 2.0 * shortest), STRETCHES)
    points = [_points(core, model, float(stretch), scales, lost) for stretch in stretches]
    trials = [[model.at(model.bounded(point)) for point in at_one] for at_one in points if at_one]
    costs = iter(map_items(cost, [trial for at_one in trials for trial in at_one]))
    found = [min(((next(costs), trial) for trial in at_one), key=lambda one: one[0]) for at_one in trials]
    lowest = np.array([np.inf, *(value for value, _ in found), np.inf])
    order = sorted(range(len(found)), key=lambda k: (lowest[k + 1] > min(lowest[k], lowest[k + 2]), lowest[k + 1]))
    return [found[k] for k in order[:FITS]]


def _points(core: Effect, model: Model, stretch: float, scales: Scales, lost: bool) -> list[dict[str, float]]:
    """Values of a core at a stretch (m) and each damping; empty where the stretch is no value of the fit."""
    free = {u.key for u in model.unknowns}
    key = next((f"{core.name}.{n}" for n in ("stretch", "stiffness") if f"{core.name}.{n}" in free), None)
    if key is None:
        return []
    level, damping = f"{core.name}.force", f"{core.name}.damping"
    defaults = {f"{core.name}.{parameter.name}": parameter.default for parameter in core.parameters} if lost else {}
    point = {name: value for name, value in defaults.items() if name in free}
    point |= {level: scales.force} if lost and level in free else {}
    stiffness = {**model.values, **point}.get(level, scales.force) / stretch
    point[key] = stretch if key.endswith(".stretch") else stiffness
    if damping not in free:
        return [point]
    critical = 2.0 * float(np.sqrt(stiffness * model.values.get("rig.mass", scales.force * scales.sample**2)))
    return [{**point, damping: ratio * critical} for ratio in DAMPING_RATIOS]


GAPS, GAP_STEPS, GAP_ACCURACY = 9, 1, 1e-3
"""Widths of a gap that are tried, steps of the fit of the other values at each, and relative accuracy of the width."""

LEAST_OF_GAP = 0.02
"""Part of the cost without a gap that one of these widths must remove."""


def lowest_gap_fit(
    base: FittedModel, fitted: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales
) -> FittedModel:
    """The fit, or one of lower error at another width of the gap that an effect opens in an imposed motion of a base
    model. A narrower gap than the true one removes a part of the error, too: where none does, none is searched for."""
    keys = [u.key for u in fitted.model.unknowns if effect.opens_gap and u.key.startswith(f"{effect.name}.")]
    imposed = all(isinstance(record, ForceBalanceRecord) and record.acceleration is None for record in records)
    if len(keys) != 1 or not imposed or root_mean_huber(fitted.fit.residual) <= AT_THE_NOISE:
        return fitted
    key, model = keys[0], fitted.model
    rest = replace(model, unknowns=tuple(u for u in model.unknowns if u.key != key))

    def fit_at(logarithm: float) -> FittedModel:
        start = rest.at({**rest.values, key: float(np.exp(logarithm))})
        return fit_model(start, records, fitted.weights, GAP_STEPS, near=fitted, final_jacobian=False)

    def cost(logarithm: float) -> float:
        return fit_at(logarithm).fit.cost

    widths = np.log(np.geomspace(1e-3 * scales.position, 0.5 * scales.position, GAPS))
    costs = [cost(width) for width in widths]
    if min(costs) > (1.0 - LEAST_OF_GAP) * base.fit.cost:
        return fitted
    k = int(np.argmin(costs))
    ends = widths[max(k - 1, 0)], widths[min(k + 1, GAPS - 1)]
    lowest: Any = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": GAP_ACCURACY})
    found = fit_model(model.at(fit_at(float(lowest.x)).model.values), records, fitted.weights)
    return lower_of(fitted, found, records)
