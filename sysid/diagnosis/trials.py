"""Effects tried on top of a fitted model: refitted, and measured on the held-out records."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.library.effect import Effect
from stagecad.parallel import fork_map
from sysid.estimation.driven_stage_search import truncated
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import (
    LOSS_CORNER,
    ChannelMisfit,
    blocks,
    huber_square,
    in_stick_phase,
    misfit,
    weighted_residual,
)
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.score_test import EVERY_ROW, GridPoint, candidate_directions, profiled_residual, score_test
from sysid.estimation.screening import (
    RefittedEffect,
    ScoredCandidate,
    ScreeningFit,
    as_screened,
    refit_candidate,
    screen_scored,
    search_lower_minimum,
)
from sysid.estimation.variant_selection import select_variants
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import in_contact, public_name
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import Problem

Progress = Callable[[str, int, int], None]
"""Called with what comes next, how many steps are done, and of how many; once more when all are."""


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """One candidate effect refitted on top of a model, and its errors on the records of the fit and the held-out ones.

    Args:
        refit: the effect, its score statistic, and its fit to the records of the fit.
        error: root mean Huber loss on the held-out records, in standard deviations of the noise.
        gain: reduction of the mean Huber loss on the held-out records.
        significance: z of that reduction: in standard errors, if what the effect leaves were all noise.
        p_value: of that reduction, from a sign-flip test over blocks of time.
        steadiness: t statistic of the mean reduction per block of time.
        share_at_rest: part of the reduction made by displacements in stick phases.
        fit_gain: reduction of the mean Huber loss on the records of the fit.
        residual: of the held-out records, in standard deviations, (n,).
        after_fit, after_validate: misfit by channel, on the records of the fit and on the held-out ones.
        law: name where it is not that of the refitted effect (quantisation of one channel).
    """

    refit: RefittedEffect
    error: float
    gain: float
    significance: float
    fit_gain: float
    residual: np.ndarray
    after_fit: dict[str, ChannelMisfit]
    after_validate: dict[str, ChannelMisfit]
    p_value: float = 1.0
    steadiness: float = 0.0
    share_at_rest: float = 0.0
    law: str = ""

    @property
    def name(self) -> str:
        """Name of the effect, with variant and channel."""
        return self.law or self.refit.effect.name

    @property
    def public_name(self) -> str:
        """Public name of the effect, without variant and channel."""
        return public_name(self.name)

    @property
    def effect(self) -> Effect:
        """The candidate effect."""
        return self.refit.effect

    @property
    def fitted(self) -> FittedModel:
        """The model with the effect, fitted."""
        return self.refit.fitted


REFITTED = 10
"""Effects refitted in full: those that looked best. The others keep what their first look found."""


ONLY_NOISE = 1.05
"""Ranking error of a trial on the held-out records, in deviations, that leaves nothing to look for."""

IN_FULL = 3
"""Of those, effects refitted to the whole of long records; the others keep what their beginnings showed."""


LEAST_PROMISE = 0.02
OF_THE_BEST = 0.1
"""Share of the squared residual, and of the best effect's, below which a score promises too little for a short fit: a
second effect that was there promised 0.05 and more, and 0.4 of the best (generated records)."""

OF_THE_NEEDED = 0.25
"""The same of what it has to take: a fit may find several times what a straight line promises."""

ROWS_SEEN = 5000
"""Rows of the residual, at the least if there are so many, at which it is kept what every effect does."""


@dataclass(frozen=True)
class CandidateJacobians:
    """What effects do to the residual of a model: much the same on top of one that has another effect more or less.

    Args:
        size: of the residual.
        rows: of it that are kept.
        grids: points of the shape grid, by effect.
    """

    size: int
    rows: slice
    grids: Mapping[str, list[GridPoint]]


@dataclass(frozen=True)
class ScreeningResult:
    """Every candidate on top of a fitted model at first sight.

    Args:
        fits: screening fits, best first.
        unfitted: scores of the effects that promised too little for a fit.
        target: residual of the model as the scores took it, (n,).
        jacobians: sensitivities of the residual to each candidate, for screenings on top of this model.
    """

    fits: list[ScreeningFit]
    unfitted: list[ScoredCandidate]
    target: np.ndarray
    jacobians: CandidateJacobians | None = None


@dataclass(frozen=True)
class CandidateSearch:
    """Every candidate tried on top of a fitted model.

    Args:
        trials: best on the held-out records first.
        screening: the screening that they started from.
    """

    trials: list[CandidateFit]
    screening: ScreeningResult


def screen_all(
    problem: Problem,
    base: ReferenceFit,
    present: Sequence[str],
    all_effects: bool = False,
    progress: Progress | None = None,
    promising: int | None = None,
    jacobians: CandidateJacobians | None = None,
    needed: float = 0.0,
) -> ScreeningResult:
    """A first look at every candidate on top of a fitted model.

    Args:
        problem, base: records, and the fitted model.
        present: names of its effects.
        all_effects: try whatever else the library has, too.
        progress: called after each step with the name of the effect, the number of steps before, and their total.
        promising: effects fitted shortly, at the most: those whose scores promise most; all where left out.
        jacobians: what effects do to the residual of a model much like it, for their scores; only what is not there is
            looked at anew.
        needed: share of the squared residual that an effect has to take to be of any use.
    """
    fitted, records = truncated(base.fitted, problem.fit_records)
    size = fitted.fit.residual.size
    if jacobians is not None and (jacobians.size != size or any(isinstance(r, FrictionDriveRecord) for r in records)):
        # One effect more, and a driven stage slips at other times.
        jacobians = None
    rows = EVERY_ROW if jacobians is None else jacobians.rows
    kept = slice(None, None, max(1, size // ROWS_SEEN))
    basis, target = profiled_residual(fitted, rows)
    effects = candidate_effects(problem, present, all_effects)
    shared = (*effects, *fitted.model.effects, fitted.weights)
    _bring_in(problem, effects)

    steps = itertools.count()

    def report(done: Effect | ScoredCandidate) -> None:
        if progress is not None:
            effect = done if isinstance(done, Effect) else done.effect
            progress(effect.name, next(steps), 2 * len(effects))

    def score(effect: Effect) -> tuple[ScoredCandidate, list[GridPoint]]:
        if jacobians is not None and effect.name in jacobians.grids:
            return ScoredCandidate(effect, score_test(effect, jacobians.grids[effect.name], basis, target)), []
        grid = candidate_directions(fitted, effect, records, problem.scales, rows)
        thinned = [replace(point, changes=point.changes[kept].copy()) for point in grid] if jacobians is None else []
        return ScoredCandidate(effect, score_test(effect, grid, basis, target)), thinned

    def look(scored: ScoredCandidate) -> ScreeningFit | None:
        return screen_scored(scored, fitted, records, problem.scales, basis, rows)

    scored = fork_map(score, effects, shared, report)
    grids = {one.effect.name: grid for one, grid in scored}
    known = sorted((one for one, _ in scored), key=lambda one: -one.score)
    # What no linear weight stands for, only a fit can tell.
    best = max((one.score for one in known if one.linear), default=0.0)
    least = max(LEAST_PROMISE, OF_THE_BEST * best, OF_THE_NEEDED * needed)
    fits = [
        promising is None or not one.linear or (k < promising and one.score >= least) for k, one in enumerate(known)
    ]
    fitting = [one for one, fit in zip(known, fits, strict=True) if fit]
    unfitted = [one for one, fit in zip(known, fits, strict=True) if not fit]
    shared = (*shared, *fitting, *(score for one in fitting for score in one.scores))
    found = fork_map(look, fitting, shared, report)
    looks = [one for one in found if one is not None and np.isfinite(one.error)]
    looks.sort(key=lambda look: look.error)
    if jacobians is None:
        jacobians = CandidateJacobians(size, kept, grids)
    return ScreeningResult(looks, unfitted, target, jacobians)


def _bring_in(problem: Problem, effects: Sequence[Effect]) -> None:
    """Have the libraries and compiled loops of what acts on signals, before processes part: each would bring them in.

    The user's own effects are left out: they are called with what they are made for.
    """
    signal = np.linspace(0.0, 1.0, 8)
    for effect in effects:
        if effect.signal is not None and effect not in problem.custom:
            effect.signal(signal, 1.0, effect.values())


def evaluate_all(
    problem: Problem,
    base: ReferenceFit,
    present: Sequence[str],
    all_effects: bool = False,
    progress: Progress | None = None,
) -> CandidateSearch:
    """Try every candidate on top of a fitted model."""
    looked, steps = 0, 0

    def scoring(name: str, count: int, total: int) -> None:
        nonlocal looked, steps
        looked, steps = total, total + min(REFITTED, total)
        if progress is not None:
            progress(name, count, steps)

    first = screen_all(problem, base, present, all_effects, scoring)
    fitted, records = truncated(base.fitted, problem.fit_records)

    def tried(numbered: tuple[int, ScreeningFit]) -> CandidateFit | None:
        k, look = numbered
        if k >= REFITTED:
            return evaluate_candidate(problem, base, as_screened(look, records))
        return evaluate_candidate(problem, base, refit_candidate(fitted, look, records, problem.scales))

    counts = itertools.count(looked)

    def report(numbered: tuple[int, ScreeningFit]) -> None:
        k, look = numbered
        if progress is not None and k < REFITTED:
            progress(f"refitting {look.effect.name}", next(counts), steps)

    shared = (*(look.effect for look in first.fits), *fitted.model.effects, fitted.weights)
    found = fork_map(tried, list(enumerate(first.fits)), shared, report)
    trials = [trial for trial in found if trial is not None]
    if progress is not None:
        progress("", steps, steps)
    trials.sort(key=lambda t: t.error)
    if fitted is not base.fitted:
        full_step_reduction = [
            evaluate_candidate(problem, base, _in_full(base, trial.refit, problem)) for trial in trials[:IN_FULL]
        ]
        trials = sorted([*(t for t in full_step_reduction if t is not None), *trials[IN_FULL:]], key=lambda t: t.error)
    trials = _with_laws_anew(problem, base, _gone_on(problem, base, trials))
    return CandidateSearch(trials, first)


def _gone_on(problem: Problem, base: ReferenceFit, trials: list[CandidateFit]) -> list[CandidateFit]:
    """The trials with the first gone on to the lowest valley near, where it is promising.

    Where the best still leaves more than the noise, those between tip and stage go on too, whatever they promise: what
    a contact holds decides every slip, and a fit that began beside the true one shows little of how it does.
    """
    for k in range(len(trials)):
        trial = trials[k]
        slips = in_contact(trial.effect)
        if k > 0 and (not slips or any(t.public_name == trial.public_name for t in trials[:k])):
            continue
        if min(t.error for t in trials) <= ONLY_NOISE:
            break
        gone_on = search_lower_minimum(base.fitted, trial.refit, problem.fit_records, of_contact=slips)
        further = evaluate_candidate(problem, base, gone_on) if gone_on is not trial.refit else None
        if further is not None and further.error < trial.error:
            trials[k] = further
    return sorted(trials, key=lambda t: t.error)


LAWS_ANEW = 2
"""Effects beside which the laws of the model are chosen anew."""

PART_WITH_LAWS = 0.2
"""Share of the loss above the noise that an effect must take for that."""


def _with_laws_anew(problem: Problem, base: ReferenceFit, trials: list[CandidateFit]) -> list[CandidateFit]:
    """The trials with the laws chosen anew beside the best of them, where the program chose any for the model.

    A law that made up for what was missing may be the wrong one where that is there.
    """
    families = dict.fromkeys(public_name(name) for name in base.laws)
    known = {trial.public_name: trial for trial in reversed(trials)}
    for trial in sorted(known.values(), key=lambda t: t.error)[:LAWS_ANEW] if families else []:
        if trial.error <= ONLY_NOISE or explained_share(base, trial) < PART_WITH_LAWS or trial.public_name in families:
            continue
        if trial.fitted.fit.residual.size != base.fitted.fit.residual.size:
            # Fitted to the beginnings of long records: too little to choose laws by.
            continue
        fitted, _ = select_variants(problem, trial.fitted, list(families))
        anew = evaluate_candidate(problem, base, replace(trial.refit, fitted=fitted))
        if fitted is not trial.fitted and anew is not None and anew.error < trial.error:
            trials = [anew if t is trial else t for t in trials]
    return sorted(trials, key=lambda t: t.error)


def _in_full(base: ReferenceFit, candidate: RefittedEffect, problem: Problem) -> RefittedEffect:
    """A candidate fitted to the beginnings of long records, fitted to the whole of them."""
    return replace(candidate, fitted=fit_model(candidate.fitted.model, problem.fit_records, base.fitted.weights))


def evaluate_candidate(problem: Problem, base: ReferenceFit, candidate: RefittedEffect) -> CandidateFit | None:
    """What a fitted candidate does on the held-out records; none where it predicts no number."""
    residual = weighted_residual(candidate.fitted.model, problem.validate_records, base.weights)
    if not np.isfinite(residual).all():
        return None
    numbers = blocks(problem.validate_records, base.weights)
    count = int(numbers.max()) + 1 if numbers.size else 0
    before = np.bincount(numbers, huber_square(base.residual), minlength=count)
    loss = np.bincount(numbers, huber_square(residual), minlength=count)
    before_fit = root_mean_huber(base.fitted.fit.residual)
    return CandidateFit(
        refit=candidate,
        error=root_mean_huber(residual),
        gain=float((before.sum() - loss.sum()) / max(base.residual.size, 1)),
        significance=significance_of(base.residual, residual, numbers),
        fit_gain=before_fit**2 - root_mean_huber(candidate.fitted.fit.residual) ** 2,
        residual=residual,
        after_fit=misfit(candidate.fitted.model, problem.fit_records),
        after_validate=misfit(candidate.fitted.model, problem.validate_records),
        p_value=_sign_flip_p_value(before - loss),
        steadiness=_steadiness(before - loss),
        share_at_rest=_share_at_rest(base, residual),
    )


def _share_at_rest(base: ReferenceFit, residual: np.ndarray) -> float:
    drops = huber_square(base.residual) - huber_square(residual)
    total = float(drops.sum())
    return float(drops[in_stick_phase(base.weights)].sum()) / total if total > 0.0 else 0.0


def _sign_flip_p_value(drops: np.ndarray, flips: int = 2000) -> float:
    """Chance of so large a total drop, were each block's drop as likely a rise (sign-flip test, (m,) blocks)."""
    rng = np.random.default_rng(0)
    signs = rng.choice([-1.0, 1.0], size=(flips, drops.size))
    return float((1 + np.sum(signs @ drops >= drops.sum())) / (1 + flips))


def _steadiness(drops: np.ndarray) -> float:
    """Mean drop per block of time over its standard error, (m,) blocks: is it one lucky stretch, or throughout?"""
    spread = float(np.std(drops, ddof=1)) if drops.size > 1 else 0.0
    return float(np.mean(drops) / (spread / np.sqrt(drops.size))) if spread > 0 else 0.0


def significance_of(worse: np.ndarray, better: np.ndarray, numbers: np.ndarray) -> float:
    """Drop of the squared residual over its standard error, were the better model's residual all noise.

    The drop of r^2 to (r - d)^2 is 2 r d - d^2; its noise is that of 2 r d, summed within blocks of time so that
    correlated samples count once, and with the residual's own size where d is large, so that a rough spot weighs less.
    Beyond the corner the loss is linear: there d counts up to it, as it does in the drop.
    """
    d = np.clip(worse, -LOSS_CORNER, LOSS_CORNER) - np.clip(better, -LOSS_CORNER, LOSS_CORNER)
    predicted_reduction = float(huber_square(worse).sum() - huber_square(better).sum())
    sums = np.bincount(numbers, d * np.clip(better, -8.0, 8.0))
    # Within a block noise may cancel by luck: no less than independent samples would give.
    floor = float(np.sum((d * np.clip(better, -8.0, 8.0)) ** 2))
    spread = 2.0 * float(np.sqrt(max(float(np.sum(sums**2)), floor)))
    return predicted_reduction / spread if spread > 0 else 0.0


def one_per_family(trials: Sequence[CandidateFit]) -> list[CandidateFit]:
    """The best law of each effect; between laws that differ by chance only, the one with fewer parameters."""
    kept: dict[str, CandidateFit] = {}
    for trial in trials:
        other = kept.get(trial.public_name)
        if other is None or (parameter_count(trial) < parameter_count(other) and trial.error <= 1.01 * other.error):
            kept[trial.public_name] = trial
    return sorted(kept.values(), key=lambda t: t.error)


WHERE = ("phase", "rest_position")
"""Parameters that say where along the axis a law lies: one law is no simpler than another for being told that."""


def parameter_count(trial: CandidateFit) -> int:
    """How many values the model has to fit, but for those that only say where it lies."""
    return sum(unknown.key.rpartition(".")[2] not in WHERE for unknown in trial.fitted.model.unknowns)


def explained_share(base: ReferenceFit, trial: CandidateFit) -> float:
    """Share of the held-out loss above the noise that the effect takes away."""
    return share_of_error(base, trial.error)


def share_of_error(base: ReferenceFit, error: float) -> float:
    """Share of the held-out loss above the noise that is gone where a model's ranking error is `error`."""
    before = root_mean_huber(base.residual) ** 2
    floor = min(1.0, error**2)
    return float((before - error**2) / max(before - floor, 1e-9))
