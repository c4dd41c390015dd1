"""Which physical effect is missing: every candidate scored and refitted, judged on held-out records."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from sysid.diagnosis.evidence import Evidence, is_worthwhile
from sysid.diagnosis.pairs import forward_after_deletion
from sysid.diagnosis.quantised_channel import coarse_steps
from sysid.diagnosis.residual_maps import ResidualMap, compared_with_time, residual_maps
from sysid.diagnosis.structural_modes import detect_structural_mode, prefers_balance_fit, with_structural_mode
from sysid.diagnosis.swaps import Swap, find_swaps
from sysid.diagnosis.trials import (
    CandidateFit,
    CandidateSearch,
    Progress,
    evaluate_all,
    evaluate_candidate,
    explained_share,
    one_per_family,
)
from sysid.diagnosis.verdict import EXPLAINS_ALL, Verdict, verdict_on
from sysid.diagnosis.verdict_limits import (
    ADEQUATE_OVER_NOISE,
    HARDLY_MORE,
    LEAST_TEXTURE,
    NEARLY_NOISE,
    SHARE_OF_A_PART,
)
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import ChannelMisfit, misfit, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.screening import RefittedEffect
from sysid.experiment.experiment import DesignValues
from sysid.experiment.history import read_history
from sysid.prediction.model import public_name
from sysid.prediction.problem import Problem, load_problem

IN_FULL = 6
"""Candidates whose held-out errors and fitted values are reported, in the order of the ranking."""


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, and how sure that is.

    Args:
        problem, base: what was diagnosed.
        trials: every effect tried, best first; one law per effect.
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the trial named, for `missing-effect`.
        indistinguishable: effects that these records cannot tell from it.
        maps: of the residual that the base model leaves.
        unexplained_share: of the variance above the noise that stays after the best effect.
        reason: why this verdict, in words.
        seconds: taken.
        swaps: effects added earlier that should go, or make place for others.
        told_by: what tells of the effect named, in words, where it is not the error that falls.
    """

    problem: Problem
    base: ReferenceFit
    trials: tuple[CandidateFit, ...]
    verdict: str
    best: CandidateFit | None
    indistinguishable: tuple[str, ...]
    maps: tuple[ResidualMap, ...]
    unexplained_share: float
    reason: str
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    seconds: float
    swaps: tuple[Swap, ...] = ()
    detected_by: str = ""
    reported_in_full: int = IN_FULL

    @property
    def effect(self) -> str | None:
        """The name everyone uses of the effect that is missing; none otherwise."""
        return self.best.public_name if self.best is not None else None


def diagnose(
    source: str | Path | Problem,
    all_effects: bool = False,
    design: DesignValues | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find which effect is missing from the model of an experiment.

    Args:
        source: folder of the experiment, its `experiment.toml`, or a problem already built.
        all_effects: try whatever else the library has besides the names everyone uses.
        design: what a known value of `"design"` stands for.
        progress: called with a name, a count and a total.

    Raises:
        InputError: a fault in a file, in one line.
    """
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    base = fit_stated_model(problem)
    present = [e.name for e in problem.start.effects]
    search = evaluate_all(problem, base, present, all_effects, progress)
    found = judge(
        problem, base, search, coarse_steps(problem, base, ADEQUATE_OVER_NOISE[problem.form]), began, all_effects
    )
    # While something is missing the next round comes first; a model that is enough is asked only what it can spare.
    swaps = (
        []
        if found.effect is not None
        else find_swaps(problem, base, _added(problem), found.verdict == "unexplained", all_effects, search.first.seen)
    )
    return replace(found, swaps=tuple(swaps), seconds=perf_counter() - began)


def _added(problem: Problem) -> list[str]:
    """Effects of the model that its ladder added."""
    rungs = read_history(problem.experiment)
    first = {public_name(name) for name in rungs[0].effects} if rungs else set()
    return [e.name for e in problem.start.effects if rungs and public_name(e.name) not in first]


def judge(
    problem: Problem,
    base: ReferenceFit,
    search: CandidateSearch,
    quantised: CandidateFit | None,
    began: float,
    all_effects: bool = False,
) -> Diagnosis:
    """The diagnosis of a base model by the effects tried on it: how well it does, where it fails, the verdict."""
    before_fit = misfit(base.fitted.model, problem.fit_records)
    before_validate = misfit(base.fitted.model, problem.validate_records)
    ranked = _ranked(problem, base, search, all_effects)
    of_model = base.fitted.model, problem.fit_records, base.fitted.weights, problem.validate_records, base.weights
    maps = residual_maps(*of_model)
    pattern = max((m.pattern for m in maps), default=0.0)
    textured = any(m.coordinate == "position" and m.share >= LEAST_TEXTURE for m in maps)
    added = [e for e in base.fitted.model.effects if e.name in _added(problem)]
    in_full = IN_FULL
    over = worst_over_noise(before_fit, before_validate)
    evidence = Evidence(problem, base, search, ranked, over, pattern, all_effects, added, textured)
    found = verdict_on(evidence, quantised)
    if found.best is None:
        found = _by_ringing(evidence, found) or found
    if found.verdict == "unexplained":
        maps = compared_with_time(maps, *of_model)
    if found.best is not None and found.best not in ranked:
        # Another law of an effect than the one that does most alone.
        others = [trial for trial in ranked if trial.public_name != found.best.public_name]
        in_full = 1 + sum(trial in others for trial in ranked[:IN_FULL])
        ranked = [found.best, *others]
    return Diagnosis(
        problem=problem,
        base=base,
        trials=tuple(ranked),
        verdict=found.verdict,
        best=found.best,
        indistinguishable=found.ties,
        maps=tuple(maps),
        unexplained_share=found.left,
        reason=found.reason,
        before_fit=before_fit,
        before_validate=before_validate,
        seconds=perf_counter() - began,
        detected_by=found.detected_by,
        reported_in_full=in_full,
    )


def _by_ringing(evidence: Evidence, otherwise: Verdict) -> Verdict | None:
    """A mode of the structure, where it rings above what the balance sees; none where none does.

    Args:
        evidence: on the model without it.
        otherwise: the verdict that the balance alone gives, which names no effect.
    """
    problem, base = evidence.problem, evidence.base
    found = detect_structural_mode(problem, base.fitted)
    if found is None:
        return None
    effect, fitted = with_structural_mode(problem, base.fitted, found)
    seen = next((t for t in evidence.ranked if t.name == effect.name), None)
    if seen is not None and prefers_balance_fit(seen.fitted, fitted):
        trial = seen
    else:
        trial = evaluate_candidate(problem, base, RefittedEffect(effect, 0.0, fitted))
    if trial is None or trial.error > HARDLY_MORE * evidence.error:
        return None
    left = evidence.left_by(trial) if otherwise.verdict == "unexplained" else 0.0
    return Verdict("missing-effect", trial, (), left, EXPLAINS_ALL, found.words)


def _ranked(problem: Problem, base: ReferenceFit, search: CandidateSearch, all_effects: bool) -> list[CandidateFit]:
    """The best law of each effect, best first; where none does much, effects of the model are searched for anew too."""
    ranked = one_per_family(search.trials)
    before = root_mean_huber(base.residual)
    nothing = (
        not ranked or not is_worthwhile(problem, base, ranked[0]) or explained_share(base, ranked[0]) < SHARE_OF_A_PART
    )
    if nothing and before > NEARLY_NOISE:
        present = [e.name for e in problem.start.effects]
        again = forward_after_deletion(problem, base, present, all_effects, search.first.seen)
        return one_per_family([*again, *search.trials])
    return ranked
