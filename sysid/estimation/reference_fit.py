"""Fit of the model of an experiment file: initial values, variants of its effects, and the reference for candidates.

The cost has no useful gradient in a Stribeck velocity or a tooth pitch if the effect is absent or the value is wrong by
more than a fraction of itself. Unless the fit from the stated start is at the noise, shape parameters are searched on a
grid by the score test, bristles by a scan of their stretch, and those of a driven stage by a coarse search and a search
for lower local minima; the stated start is one of the starts.
"""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sim.effects.effect import Effect
from sim.integration.simulate import SimulationError
from stagecad.parameters.errors import InputError
from stagecad.processes import map_items
from sysid.estimation.driven_stage_search import lowest_minimum, rough_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.friction_state_search import AT_THE_NOISE, bristle_starts, lower_of, lowest_bristle_fit
from sysid.estimation.input_hold import follows_motion, with_sampled_input
from sysid.estimation.least_squares import least_squares, robust_scale
from sysid.estimation.misfit import (
    UNEVEN,
    ResidualWeights,
    misfit,
    residual_weights,
    scored_channels,
    weighted_residual,
)
from sysid.estimation.screening import profiled_residual, screen_and_refit
from sysid.estimation.variant_selection import select_variants
from sysid.prediction.force_balance.predict import friction_along, unfiltered_force
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.state_observer import can_be_observed, observed
from sysid.prediction.model import Model, Scales
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem
from sysid.prediction.sensors import PREFIX as SCALE


@dataclass(frozen=True)
class ReferenceFit:
    """A fitted model, and its residual on the held-out records with which candidates are compared."""

    fitted: FittedModel  # model, fit and weights on the records of the fit
    weights: ResidualWeights  # residual weights of the held-out records
    residual: np.ndarray  # of the held-out records, in standard deviations, (n,)
    laws: tuple[str, ...] = ()  # variants that were selected for effects of the model, as `stribeck:rational`


def reference_fit(
    problem: Problem, fitted: FittedModel, weights: ResidualWeights | None = None, laws: tuple[str, ...] = ()
) -> ReferenceFit:
    """A fitted model as the reference of a problem; residual weights of the held-out records are computed from it if
    none are given."""
    if weights is None:
        weights = fitted.weights if problem.crossed else residual_weights(fitted.model, problem.validate_records)
    return ReferenceFit(fitted, weights, weighted_residual(fitted.model, problem.validate_records, weights), laws)


def fit_stated_model(problem: Problem) -> ReferenceFit:
    """Fit of the stated model; for an effect named without a variant, the variant that fits best is selected."""
    given = [key for key, setting in problem.experiment.parameters.items() if setting.start is not None]
    fitted, chosen = select_variants(problem, initial_fit(problem.start, problem.fit_records, problem.scales, given))
    return reference_fit(problem, fitted, laws=chosen)


def initial_fit(model: Model, records: Sequence[PreparedRecord], scales: Scales, given: Collection[str]) -> FittedModel:
    """The fit with the lowest error, from the stated start and from searched starting points."""
    best = fit_model(model, records)
    for start in rough_starts(model, records, given):
        best = lower_of(best, fit_model(start, records), records)
    lower = lowest_minimum(best, records)
    if lower is not best:
        best = fit_model(lower.model, records)
    best = lowest_bristle_fit(best, records, scales)
    if root_mean_huber(best.fit.residual) > AT_THE_NOISE:
        start = _start_from_screening(best.model, records, scales)
        found = best if start is None else lower_of(best, fit_model(start, records), records)
        # The stretch of the bristles that was found belongs to the other shapes before.
        best = best if found is best else lowest_bristle_fit(found, records, scales)
    return best


ROUNDS = 4
"""Largest number of fits with the deviations of the channels estimated again."""

PASSES, SEARCHED = 12, 1e-3
"""Most passes of the velocity of a state observer, and relative fall of the error at which a search with observers
ends: a fit follows."""

MOST_ATTENUATION = 0.3
"""Part of the mass that may be lost by the noise of the acceleration; of more, too little of the rest is known."""

DRAWS = 6
"""Draws of the noise along an observer's motion."""

GAINS_HOLD = 3.0
"""Error over noise up to which the gains of the observer hold, which follow from the noise of force and position alone:
a wrong model has an error of its force beside that noise, and stays along the measured motion."""

CLEARLY_LOWER = 0.9
"""Ratio of the errors below which the fit along the observer's motion is preferred, or where it is at the noise."""


def reported_fit(problem: Problem, base: ReferenceFit) -> tuple[Problem, ReferenceFit]:
    """Problem and fit whose values are reported: of a driven mass with a sampled drive force where the records show
    it, along the motion of a state observer where that is better, and with the mass corrected for the noise of the
    acceleration; of several channels each weighed by its own error."""
    problem, base = _fit_with_sampled_input(problem, base)
    problem, base = fit_with_observer(problem, base)
    return problem, _without_attenuation(problem, _with_balanced_channels(problem, base))


def _with_balanced_channels(problem: Problem, base: ReferenceFit) -> ReferenceFit:
    """The fit with the deviations of each channel multiplied by the ratio of its own error to the smallest of any: a
    channel that the model does not explain leaves the values to the others (feasible generalised least squares, A.
    Zellner, J. Am. Stat. Assoc. 57 (1962) 348)."""
    fitted, channels = base.fitted, scored_channels(base.fitted.weights)
    known = dict.fromkeys(sorted(set(channels.tolist())), 1.0)
    for _ in range(ROUNDS if len(known) > 1 else 0):
        sizes = {c: k * robust_scale(fitted.fit.residual[channels == c]) for c, k in known.items()}
        least = max(min(sizes.values()), 1.0)
        ratio = {c: max(size / least, 1.0) for c, size in sizes.items()}
        if all(UNEVEN**-0.5 < ratio[c] / known[c] < UNEVEN**0.5 for c in known):
            break
        known, fitted = ratio, fit_model(fitted.model, problem.fit_records, base.fitted.weights.scaled(ratio))
    return base if fitted is base.fitted else reference_fit(problem, fitted, laws=base.laws)


def _fit_with_sampled_input(problem: Problem, base: ReferenceFit) -> tuple[Problem, ReferenceFit]:
    """Problem and fit with a drive force that is linear between rows, where the residual shows it and the error does
    not rise above the noise."""
    sampled = with_sampled_input(problem, base.fitted)
    if sampled is None:
        return problem, base
    fitted = fit_model(base.fitted.model, sampled.fit_records)
    models = (base.fitted.model, problem.fit_records), (fitted.model, sampled.fit_records)
    if follows_motion(problem):
        # Both holds leave the same displacements at rest.
        before, after = (misfit(*one)["drive_force"].over_sensor_noise or 0.0 for one in models)
        better = after < before
    else:
        before, after = (_over_all_noise(*one) for one in models)
        better = after <= max(before, AT_THE_NOISE)
    return (sampled, reference_fit(sampled, fitted, laws=base.laws)) if better else (problem, base)


def _without_attenuation(problem: Problem, base: ReferenceFit) -> ReferenceFit:
    """The fit without the bias of a fitted mass by the noise s of the measured acceleration, which is both in its
    column of the Jacobian and in the residual: J^T w r is zero at the estimate, but m sum w s^2 at the true values
    (compensated least squares; Stoica and Soderstrom, Int. J. Control 36 (1982) 257). With a scale that is fitted the
    residual and its deviation are proportional to all forces together, which have no such bias."""
    fitted, fit = base.fitted, base.fitted.fit
    if "rig.mass" not in fit.keys or any(key.startswith(SCALE) for key in fit.keys):
        return base
    total, start = 0.0, 0
    for record, stds in zip(problem.fit_records, fitted.weights.scored_std, strict=True):
        for channel, std in stds.items():
            own = fit.weights[start : start + std.size]
            start += std.size
            # A stage driven by its tip is simulated: no measured acceleration is in its residual.
            if not isinstance(record, ForceBalanceRecord) or record.acceleration is None:
                continue
            if channel == record.force_channel:
                stiffness = fitted.model.values["rig.pull_stiffness"] if channel == "position" else 1.0
                total += float(own @ (record.acceleration_noise / stiffness / std) ** 2)
    moves = np.array([key not in fit.at_bound for key in fit.keys]) & fit.jacobian.any(axis=0)
    columns, at = fit.jacobian[:, moves], np.array([key == "rig.mass" for key in fit.keys])[moves]
    normal = columns.T @ (fit.weights[:, None] * columns) + np.diag(fit.precision[moves])
    if not at.any() or total > MOST_ATTENUATION * normal[at, at].sum():
        return base
    scale = np.sqrt(np.diag(normal))
    shift = np.linalg.pinv(normal / np.outer(scale, scale), hermitian=True) @ (
        np.where(at, fit.values["rig.mass"] * total, 0.0) / scale
    )
    known = np.array(list(fit.values.values()))
    known[moves] += shift / scale
    values = fitted.model.bounded(dict(zip(fit.keys, known.tolist(), strict=True)))
    model = fitted.model.at(values)
    residual = weighted_residual(model, problem.fit_records, fitted.weights)
    found = FittedModel(model, replace(fit, values=values, residual=residual), fitted.weights)
    return reference_fit(problem, found, laws=base.laws)


def fit_with_observer(problem: Problem, base: ReferenceFit) -> tuple[Problem, ReferenceFit]:
    """Problem and fit along the motion of a state observer, where the error of a driven mass along its measured motion
    is above the noise, and that along the observer's clearly lower; otherwise those given.

    Variants that were selected along a blurred motion are kept only if the stated laws do not reach the noise.
    """
    records, found = (*problem.fit_records, *problem.validate_records), base.fitted.model
    least = _over_all_noise(found, problem.fit_records)
    driven = all(isinstance(r, ForceBalanceRecord) and r.acceleration is not None and not r.is_free for r in records)
    if not driven or least <= AT_THE_NOISE or not can_be_observed(found.effects):
        return problem, base
    best, first = None, least
    known = {key.partition(":")[0] + "." + key.rpartition(".")[2]: value for key, value in found.values.items()}
    stated = problem.start.at({u.key: known[u.key] for u in problem.start.unknowns if u.key in known})
    for model, laws in ((stated, ()), (found, base.laws)) if base.laws else ((found, ()),):
        if least <= AT_THE_NOISE:
            break
        # A model that cannot be simulated along one of the records stays along the measured motion.
        with suppress(InputError, SimulationError):
            along, lowest = _lowest_along_observer(problem, model, first)
            error = _over_all_noise(lowest, along.fit_records)
            lower = error < max(CLEARLY_LOWER * least, AT_THE_NOISE)
            over = max(one.over_noise for one in misfit(lowest, along.fit_records).values()) if lower else np.inf
            if over <= GAINS_HOLD:
                best, least = (along, lowest, laws), error
    return (problem, base) if best is None else _fit_with_draws(problem, *best)


def _lowest_along_observer(problem: Problem, model: Model, error: float) -> tuple[Problem, Model]:
    """Problem along the observer's motion, and the model there, by the prediction error method: the values whose own
    observer predicts the records best (Ljung, System Identification (1999), section 7.2).

    What was found along a blurred motion may be a property of the blur, and is searched again: the stretch of bristles
    by the errors of its own observer; other shapes along the motion that was found, where that leaves less than
    `error`, that along the measured motion.
    """
    measured = [replace(record, redrawn=()) for record in problem.fit_records]
    first = [along_observer(one, model) for one in measured]
    weights = residual_weights(model, first)

    def errors(trial: Model, near: Sequence[ForceBalanceRecord]) -> np.ndarray:
        """Errors along the observer of a model, which begins with the motion of one `near` it."""
        try:
            return weighted_residual(trial, [along_observer(one, trial, 1) for one in near], weights)
        except SimulationError:
            return np.full(sum(pick.size for of in weights.samples for pick in of.values()), np.inf)

    def lowest(start: Model) -> tuple[float, Model]:
        keys, near = [u.key for u in start.unknowns], [along_observer(one, start) for one in first]

        def residual(point: np.ndarray) -> np.ndarray:
            return errors(start.at(dict(zip(keys, point.tolist(), strict=True))), near)

        found = least_squares(residual, start.unknowns, tolerance=SEARCHED, final_jacobian=False)
        return root_mean_huber(found.residual), start.at(found.values)

    def cost(trial: Model) -> float:
        return root_mean_huber(errors(trial, first))

    starts = bristle_starts(model, problem.fit_records, problem.scales, cost, lost=False)
    least, found = lowest(min([(cost(model), model), *starts], key=lambda one: one[0])[1])
    along = _along_observer_of(problem, found)
    if AT_THE_NOISE < _over_all_noise(found, along.fit_records) < error:
        searched = _start_from_screening(found, along.fit_records, problem.scales)
        other, shaped = (least, found) if searched is None else lowest(searched)
        along, found = (_along_observer_of(problem, shaped), shaped) if other < least else (along, found)
    return along, found


def _along_observer_of(problem: Problem, model: Model) -> Problem:
    """Problem along the observer's motion under a model."""
    return replace(
        problem,
        fit_records=tuple(along_observer(one, model) for one in problem.fit_records),
        validate_records=tuple(along_observer(one, model) for one in problem.validate_records),
    )


def _over_all_noise(model: Model, records: Sequence[PreparedRecord]) -> float:
    """Largest error of a channel over its noise, and over that of its sensor, which no model changes."""
    return max(max(one.over_noise, one.over_sensor_noise or 0.0) for one in misfit(model, records).values())


def along_observer(record: PreparedRecord, model: Model, passes: int = PASSES) -> ForceBalanceRecord:
    """A record of a driven mass along the motion of the state observer of a model."""
    assert isinstance(record, ForceBalanceRecord)
    laws = {"effects": model.effects, "values": model.values}
    first = 0.0 if record.observer else float(unfiltered_force(record, **laws)[0])
    found = observed(record, **laws, first=first, passes=passes, ideal_friction=partial(friction_along, **laws))
    return replace(found, redrawn=tuple(along_observer(one, model, passes) for one in record.redrawn))


def _fit_with_draws(
    problem: Problem, along: Problem, model: Model, laws: tuple[str, ...]
) -> tuple[Problem, ReferenceFit]:
    """Problem and fit with further draws of the noise of a `problem` in each record along an observer's motion: that of
    a body which sticks changes in a few rows only, so that one draw does not show the variance."""
    measured = (*problem.fit_records, *problem.validate_records)

    def redrawn(pair: tuple[PreparedRecord, PreparedRecord]) -> PreparedRecord:
        record, one = pair
        draws = tuple(_with_noise_of(one, record, k * record.size // DRAWS) for k in range(1, DRAWS))
        with suppress(InputError, SimulationError):
            # Each begins with the motion of the record, which has converged.
            more = tuple(along_observer(draw, model, passes=1) for draw in draws)
            return replace(one, redrawn=(*one.redrawn, *more))
        return one

    rolled = map_items(redrawn, list(zip(measured, (*along.fit_records, *along.validate_records), strict=True)))
    fits = len(problem.fit_records)
    along = replace(along, fit_records=tuple(rolled[:fits]), validate_records=tuple(rolled[fits:]))
    return along, reference_fit(along, fit_model(model, along.fit_records), laws=laws)


def _with_noise_of(record: PreparedRecord, measured: PreparedRecord, shift: int) -> PreparedRecord:
    """A record with the noise added in the first draw of the `measured` one, which begins `shift` rows later: at every
    row another value of the same process."""
    assert isinstance(record, ForceBalanceRecord) and isinstance(measured, ForceBalanceRecord)
    drawn = measured.redrawn[0]

    def noisy(values: np.ndarray | None, noisy: np.ndarray | None, exact: np.ndarray | None) -> np.ndarray:
        assert values is not None and noisy is not None and exact is not None
        return values + np.roll(noisy - exact, shift)

    return replace(
        record,
        acceleration=noisy(record.acceleration, drawn.acceleration, measured.acceleration),
        raw_position=noisy(record.raw_position, drawn.raw_position, measured.raw_position),
        applied=noisy(record.applied, drawn.applied, measured.applied),
        measured={c: noisy(y, drawn.measured[c], measured.measured[c]) for c, y in record.measured.items()},
        redrawn=(),
    )


def _start_from_screening(model: Model, records: Sequence[PreparedRecord], scales: Scales) -> Model | None:
    """The model with shape parameters from the screening of its effects, one after the other; None without effects to
    search."""
    searched = [e for e in model.effects if has_shape(e)]
    if not searched:
        return None
    prefixes = tuple(f"{e.name}." for e in searched)
    rest = replace(
        model,
        effects=tuple(e for e in model.effects if e not in searched),
        unknowns=tuple(u for u in model.unknowns if not u.key.startswith(prefixes)),
    )
    fitted = lowest_bristle_fit(fit_model(rest, records), records, scales)
    for effect in searched:
        found = screen_and_refit(fitted, effect, records, scales, profiled_residual(fitted))
        if found is not None:
            fitted = found.fitted
    return model.at({key: value for key, value in fitted.model.values.items() if key in model.values})


def has_shape(effect: Effect) -> bool:
    """Whether an effect has parameters that are searched on a grid before they are fitted."""
    return effect.friction_state is None and any(
        p.role == "shape" and p.scan is not None and not p.fixed for p in effect.parameters
    )
