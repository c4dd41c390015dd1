"""Diagnosis: which physical effect is missing. Candidates are scored, refitted and compared on held-out records."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from sysid.diagnosis.candidate_screening import Progress
from sysid.diagnosis.evidence import Evidence, is_worthwhile
from sysid.diagnosis.pairs import ReducedModels, forward_after_deletion
from sysid.diagnosis.quantised_channel import coarse_steps
from sysid.diagnosis.residual_maps import ResidualMap, compared_with_time, residual_maps
from sysid.diagnosis.structural_modes import detect_structural_mode, prefers_balance_fit, with_structural_mode
from sysid.diagnosis.swaps import Swap, find_swaps
from sysid.diagnosis.trials import (
    CandidateFit,
    CandidateSearch,
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
    """Which effect is missing from a model, and how certain that is.

    Args:
        problem, base: the identification problem and the fitted model.
        trials: every candidate, lowest held-out error first; one variant per effect.
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the candidate named, for `missing-effect`.
        indistinguishable: effects that these records cannot distinguish from it.
        maps: of the residual of the base model.
        unexplained_share: of the variance above the noise that remains with the best effect.
        reason: of the verdict, in words.
        before_fit, before_validate: misfit of the base model by channel, on the records of the fit and held out.
        seconds: run time.
        swaps: effects added earlier that should be removed or replaced.
        detected_by: how the effect was detected, in words, where it was not by a reduction of the error.
        reported_in_full: number of trials reported with their errors and values.
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
        """Public name of the missing effect; none otherwise."""
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
        all_effects: try all effects of the library, not only those with public names.
        design: values of the design for known quantities stated as `"design"`.
        progress: called with a name, a count and a total.

    Raises:
        InputError: a fault in a file.
    """
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    base = fit_stated_model(problem)
    search = evaluate_all(problem, base, [e.name for e in problem.start.effects], all_effects, progress)
    reduced = ReducedModels(problem, base, all_effects, search.screening.jacobians)
    found = judge(search, coarse_steps(problem, base, ADEQUATE_OVER_NOISE[problem.form]), reduced)
    swaps: list[Swap] = []
    if found.effect is None:
        # A missing effect is added first; replacements are searched only where none is missing.
        swaps = find_swaps(reduced, _added(problem), found.verdict == "unexplained")
    return replace(found, swaps=tuple(swaps), seconds=perf_counter() - began)


def _added(problem: Problem) -> list[str]:
    """Effects of the model that were added since the first revision of its history."""
    revisions = read_history(problem.experiment)
    first = {public_name(name) for name in revisions[0].effects} if revisions else set()
    return [e.name for e in problem.start.effects if revisions and public_name(e.name) not in first]


def judge(search: CandidateSearch, quantised: CandidateFit | None, reduced: ReducedModels) -> Diagnosis:
    """The diagnosis of a base model from the candidates evaluated on it.

    Args:
        search: the candidates.
        quantised: quantisation of a channel as a candidate, where it was found.
        reduced: the base model without one of its effects; holds the base model itself.
    """
    problem, base = reduced.problem, reduced.base
    began = perf_counter()
    model = base.fitted.model
    before_fit, before_validate = misfit(model, problem.fit_records), misfit(model, problem.validate_records)
    ranked = _ranked(search, reduced)
    of_model = model, problem.fit_records, base.fitted.weights, problem.validate_records, base.weights
    maps = residual_maps(*of_model)
    added = _added(problem)
    evidence = Evidence(
        problem=problem,
        base=base,
        search=search,
        ranked=ranked,
        over=worst_over_noise(before_fit, before_validate),
        pattern=max((m.split_share for m in maps), default=0.0),
        all_effects=reduced.all_effects,
        added=[e for e in model.effects if e.name in added],
        textured=any(m.coordinate == "position" and m.share >= LEAST_TEXTURE for m in maps),
    )
    found = verdict_on(evidence, quantised)
    if found.best is None:
        found = _structural_mode_verdict(evidence, found) or found
    if found.verdict == "unexplained":
        maps = compared_with_time(maps, *of_model)
    in_full = IN_FULL
    if found.best is not None and found.best not in ranked:
        # The verdict may name another variant than the one with the lowest error.
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


def _structural_mode_verdict(evidence: Evidence, otherwise: Verdict) -> Verdict | None:
    """A structural mode above the filter band of the force balance as the missing effect; none where none is detected.

    Args:
        evidence: of the model without the mode.
        otherwise: the verdict from the force balance alone, which names no effect.
    """
    problem, base = evidence.problem, evidence.base
    mode = detect_structural_mode(problem, base.fitted)
    if mode is None:
        return None
    effect, fitted = with_structural_mode(problem, base.fitted, mode)
    trial = next((t for t in evidence.ranked if t.name == effect.name), None)
    if trial is None or not prefers_balance_fit(trial.fitted, fitted):
        trial = evaluate_candidate(problem, base, RefittedEffect(effect, 0.0, fitted))
    if trial is None or trial.error > HARDLY_MORE * evidence.error:
        return None
    left = evidence.left_by(trial) if otherwise.verdict == "unexplained" else 0.0
    return Verdict("missing-effect", trial, (), left, EXPLAINS_ALL, mode.words)


def _ranked(search: CandidateSearch, reduced: ReducedModels) -> list[CandidateFit]:
    """The best variant of each effect, best first; where none gains much, also with an effect of the model refitted."""
    base = reduced.base
    ranked = one_per_family(search.trials)
    gains = ranked and is_worthwhile(reduced.problem, base, ranked[0])
    little = not gains or explained_share(base, ranked[0]) < SHARE_OF_A_PART
    if little and root_mean_huber(base.residual) > NEARLY_NOISE:
        return one_per_family([*forward_after_deletion(reduced), *search.trials])
    return ranked
