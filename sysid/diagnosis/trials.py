"""Refits of candidate effects on top of a fitted model, and their gain on the held-out records.

After the screening the best candidates are refitted in full. For each one the reduction of the mean Huber loss on the
held-out records is computed, with its z statistic, the t statistic over blocks of time and a sign-flip p value.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.library.effect import Effect
from stagecad.parallel import fork_map
from sysid.diagnosis.candidate_screening import Progress, ScreeningResult, screen_all
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
from sysid.estimation.screening import (
    RefittedEffect,
    ScreeningFit,
    as_screened,
    refit_candidate,
    search_lower_minimum,
)
from sysid.estimation.variant_selection import select_variants
from sysid.prediction.model import in_contact, public_name
from sysid.prediction.problem import Problem


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
"""Candidates refitted in full, in the order of the screening. The others keep their screening fit."""

ONLY_NOISE = 1.05
"""Ranking error, in deviations, up to which no further minimum or variant is searched."""

IN_FULL = 3
"""Of those, candidates refitted to the whole of long records; the others keep the fit to their beginnings."""


@dataclass(frozen=True)
class CandidateSearch:
    """Every candidate evaluated on top of a fitted model.

    Args:
        trials: best on the held-out records first.
        screening: the screening that they started from.
    """

    trials: list[CandidateFit]
    screening: ScreeningResult


def evaluate_all(
    problem: Problem,
    base: ReferenceFit,
    present: Sequence[str],
    all_effects: bool = False,
    progress: Progress | None = None,
) -> CandidateSearch:
    """Screen every candidate on top of a fitted model, refit the best, and evaluate all on the held-out records."""
    screened, steps = 0, 0

    def scoring(name: str, count: int, total: int) -> None:
        nonlocal screened, steps
        screened, steps = total, total + min(REFITTED, total)
        if progress is not None:
            progress(name, count, steps)

    first = screen_all(problem, base, present, all_effects, scoring)
    fitted, records = truncated(base.fitted, problem.fit_records)

    def evaluate(numbered: tuple[int, ScreeningFit]) -> CandidateFit | None:
        k, screening_fit = numbered
        if k >= REFITTED:
            return evaluate_candidate(problem, base, as_screened(screening_fit, records))
        return evaluate_candidate(problem, base, refit_candidate(fitted, screening_fit, records, problem.scales))

    counts = itertools.count(screened)

    def report(numbered: tuple[int, ScreeningFit]) -> None:
        k, screening_fit = numbered
        if progress is not None and k < REFITTED:
            progress(f"refitting {screening_fit.effect.name}", next(counts), steps)

    shared = (*(fit.effect for fit in first.fits), *fitted.model.effects, fitted.weights)
    found = fork_map(evaluate, list(enumerate(first.fits)), shared, report)
    trials = [trial for trial in found if trial is not None]
    if progress is not None:
        progress("", steps, steps)
    trials.sort(key=lambda t: t.error)
    if fitted is not base.fitted:
        in_full = [
            evaluate_candidate(problem, base, _in_full(base, trial.refit, problem)) for trial in trials[:IN_FULL]
        ]
        trials = sorted([*(t for t in in_full if t is not None), *trials[IN_FULL:]], key=lambda t: t.error)
    trials = _with_reselected_variants(problem, base, _with_lower_minima(problem, base, trials))
    return CandidateSearch(trials, first)


def _with_lower_minima(problem: Problem, base: ReferenceFit, trials: list[CandidateFit]) -> list[CandidateFit]:
    """The candidates, the first one refitted from further local minima nearby, where its screening score is large.

    Where the best one leaves more than the noise, effects of the contact of tip and stage are refitted too: the
    friction limit of the contact determines every slip, so a fit from a wrong start is a poor measure of the effect.
    """
    for k in range(len(trials)):
        trial = trials[k]
        slips = in_contact(trial.effect)
        if k > 0 and (not slips or any(t.public_name == trial.public_name for t in trials[:k])):
            continue
        if min(t.error for t in trials) <= ONLY_NOISE:
            break
        lower = search_lower_minimum(base.fitted, trial.refit, problem.fit_records, of_contact=slips)
        further = evaluate_candidate(problem, base, lower) if lower is not trial.refit else None
        if further is not None and further.error < trial.error:
            trials[k] = further
    return sorted(trials, key=lambda t: t.error)


RESELECTED_BESIDE = 2
"""Candidates beside which the variants of the model are selected again."""

LEAST_SHARE_TO_RESELECT = 0.2
"""Least share of the loss above the noise that a candidate must remove for that."""


def _with_reselected_variants(problem: Problem, base: ReferenceFit, trials: list[CandidateFit]) -> list[CandidateFit]:
    """The candidates, with the variants of the model selected again beside the best ones.

    A variant that the program selected while an effect was missing may be the wrong one. Variants named by the user
    stay.
    """
    families = dict.fromkeys(public_name(name) for name in base.laws)
    known = {trial.public_name: trial for trial in reversed(trials)}
    for trial in sorted(known.values(), key=lambda t: t.error)[:RESELECTED_BESIDE] if families else []:
        if (
            trial.error <= ONLY_NOISE
            or explained_share(base, trial) < LEAST_SHARE_TO_RESELECT
            or trial.public_name in families
        ):
            continue
        if trial.fitted.fit.residual.size != base.fitted.fit.residual.size:
            # Fitted to the beginnings of long records: too little data for a selection.
            continue
        fitted, _ = select_variants(problem, trial.fitted, list(families))
        reselected = evaluate_candidate(problem, base, replace(trial.refit, fitted=fitted))
        if fitted is not trial.fitted and reselected is not None and reselected.error < trial.error:
            trials = [reselected if t is trial else t for t in trials]
    return sorted(trials, key=lambda t: t.error)


def _in_full(base: ReferenceFit, candidate: RefittedEffect, problem: Problem) -> RefittedEffect:
    """A candidate fitted to the beginnings of long records, fitted to the whole of them."""
    return replace(candidate, fitted=fit_model(candidate.fitted.model, problem.fit_records, base.fitted.weights))


def evaluate_candidate(problem: Problem, base: ReferenceFit, candidate: RefittedEffect) -> CandidateFit | None:
    """Evaluate a refitted candidate on the held-out records; none where its prediction is not finite."""
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
    """Sign-flip p value of the total reduction, from the reductions of (m,) blocks of time."""
    rng = np.random.default_rng(0)
    signs = rng.choice([-1.0, 1.0], size=(flips, drops.size))
    return float((1 + np.sum(signs @ drops >= drops.sum())) / (1 + flips))


def _steadiness(drops: np.ndarray) -> float:
    """t statistic of the mean reduction per block of time, (m,) blocks."""
    spread = float(np.std(drops, ddof=1)) if drops.size > 1 else 0.0
    return float(np.mean(drops) / (spread / np.sqrt(drops.size))) if spread > 0 else 0.0


def significance_of(worse: np.ndarray, better: np.ndarray, numbers: np.ndarray) -> float:
    """Reduction of the Huber loss over its standard error, if the residual of the better model is only noise.

    The reduction from r^2 to (r - d)^2 is 2 r d - d^2. Its standard error is that of 2 r d, summed within blocks of
    time so that correlated samples count once. Beyond the corner the loss is linear, so residuals are clipped in d.

    Args:
        worse, better: residuals of the two models in deviations, (n,).
        numbers: block of time of each sample, (n,).
    """
    d = np.clip(worse, -LOSS_CORNER, LOSS_CORNER) - np.clip(better, -LOSS_CORNER, LOSS_CORNER)
    predicted_reduction = float(huber_square(worse).sum() - huber_square(better).sum())
    sums = np.bincount(numbers, d * np.clip(better, -8.0, 8.0))
    # Noise may cancel within a block: the spread is at least that of independent samples.
    floor = float(np.sum((d * np.clip(better, -8.0, 8.0)) ** 2))
    spread = 2.0 * float(np.sqrt(max(float(np.sum(sums**2)), floor)))
    return predicted_reduction / spread if spread > 0 else 0.0


def one_per_family(trials: Sequence[CandidateFit]) -> list[CandidateFit]:
    """The best variant of each effect; of variants within 1 % in error the one with fewer parameters."""
    kept: dict[str, CandidateFit] = {}
    for trial in trials:
        other = kept.get(trial.public_name)
        if other is None or (parameter_count(trial) < parameter_count(other) and trial.error <= 1.01 * other.error):
            kept[trial.public_name] = trial
    return sorted(kept.values(), key=lambda t: t.error)


LOCATION_PARAMETERS = ("phase", "rest_position")
"""Parameters that only shift a law along the axis; they do not count as complexity."""


def parameter_count(trial: CandidateFit) -> int:
    """Number of fitted parameters of the model, without those that only shift a law along the axis."""
    return sum(unknown.key.rpartition(".")[2] not in LOCATION_PARAMETERS for unknown in trial.fitted.model.unknowns)


def explained_share(base: ReferenceFit, trial: CandidateFit) -> float:
    """Share of the held-out loss above the noise that the effect removes."""
    return share_of_error(base, trial.error)


def share_of_error(base: ReferenceFit, error: float) -> float:
    """Share of the held-out loss above the noise that a model with ranking error `error` removes."""
    before = root_mean_huber(base.residual) ** 2
    floor = min(1.0, error**2)
    return float((before - error**2) / max(before - floor, 1e-9))
