"""Diagnosis: which physical effect is missing. Candidates are scored, refitted and compared on held-out records."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from sysid.diagnosis.candidate import Candidate, Reference
from sysid.diagnosis.candidate_screening import Progress
from sysid.diagnosis.consistency import consistency_warnings
from sysid.diagnosis.decision import Decision, decide, noise_level
from sysid.diagnosis.free_curves import recurring_coordinates
from sysid.diagnosis.ledger import Replacement, find_replacements, make_ledger
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.quantised_channel import QuantisedChannel, quantised_channel
from sysid.diagnosis.residual_maps import ResidualMap, compared_with_time, residual_maps
from sysid.diagnosis.structural_modes import with_mode_above_band
from sysid.estimation.misfit import ChannelMisfit, misfit, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model, reference_fit, reported_fit
from sysid.experiment.experiment import DesignValues
from sysid.experiment.ladder import read_history
from sysid.prediction.model import public_name
from sysid.prediction.problem import Problem, load_problem

IN_FULL = 6
"""Candidates whose held-out errors and fitted values are reported, in the order of the ranking."""


@dataclass(frozen=True, kw_only=True)
class Diagnosis(Decision):
    """Which effect is missing from a model, and how certain that is: the decision, and what it was made from."""

    # problem, base: the identification problem and the fitted model
    problem: Problem
    base: ReferenceFit
    trials: tuple[Candidate, ...]  # every candidate effect, lowest held-out loss first; one variant per effect
    maps: tuple[ResidualMap, ...]  # of the residual of the base model
    # before_fit, before_validate: misfit of the base model by channel, on the records of the fit and held out
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    seconds: float  # run time
    replacements: tuple[Replacement, ...] = ()  # effects added earlier that should be removed or replaced
    warnings: tuple[str, ...] = ()  # contradictions in the records, one line each

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
    """Find which effect is missing from the model of an experiment."""
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    base = fit_stated_model(problem)
    added = _added(problem)
    quantised = quantised_channel(Reference.of(problem, base))
    # Quantisation is part of the noise, so further effects are judged with it.
    stated = (problem, base) if quantised is None else (quantised.candidate.problem, quantised.base)
    search = ModelSearch(*stated, all_effects, progress)
    recurring = recurring_coordinates(problem)
    noise = noise_level(search, added)
    ledger = with_mode_above_band(search, make_ledger(search, noise.loss, added, recurring))
    driven = any(record.acceleration is not None for record in problem.fit_records)
    shown = _reported(ledger.model)
    observed = shown.problem is not ledger.model.problem and not ledger.established
    if observed:
        # Along the measured motion the error of the model is that of the filter of the motion.
        level = worst_over_noise(shown.after_fit, shown.after_validate)
        noise, recurring = replace(noise, adequate_loss=level**2, evenness=1.0), frozenset()
    decision = decide(search, ledger, noise, recurring, driven)
    best = shown if decision.best is ledger.model else decision.best
    decision = replace(decision, best=best, ledger=replace(ledger, model=shown))
    ranked = search.ranked
    if quantised is not None:
        decision = _with_quantisation(decision, quantised)
    replacements: Sequence[Replacement] = ()
    if decision.best is None:
        # A missing effect is added first; replacements are searched only where none is missing.
        replacements = find_replacements(search, added, decision.verdict == "unexplained")
    maps = residual_maps(base.fitted.model, problem, base)
    if decision.verdict == "unexplained":
        maps = compared_with_time(maps, base.fitted.model, problem, base)
    if decision.best is not None and decision.best not in ranked:
        # The decision may name another variant than the one with the lowest error.
        ranked = [decision.best, *(trial for trial in ranked if trial.public_name != decision.best.public_name)]
    sets = (problem.fit_records, problem.validate_records)
    before_fit, before_validate = (misfit(base.fitted.model, records) for records in sets)
    if observed and quantised is None:
        before_fit, before_validate = shown.after_fit, shown.after_validate
    after_fit = before_fit if decision.best is None else decision.best.after_fit
    return Diagnosis(
        **vars(decision),
        problem=problem,
        base=base,
        trials=tuple(ranked),
        maps=tuple(maps),
        before_fit=before_fit,
        before_validate=before_validate,
        seconds=perf_counter() - began,
        replacements=tuple(replacements),
        warnings=(*consistency_warnings(problem, after_fit), *_untried(problem, ranked)),
    )


def _reported(model: Candidate) -> Candidate:
    """A model as `compare` and `add` report it: along the motion of a state observer where that is better."""
    problem, found = reported_fit(model.problem, reference_fit(model.problem, model.fitted))
    return model if found.fitted is model.fitted else replace(model, problem=problem, fitted=found.fitted)


def _with_quantisation(decision: Decision, quantised: QuantisedChannel) -> Decision:
    """A decision with a quantised channel as the first effect."""
    ledger = decision.ledger
    further = ledger.explained if ledger.established else 0.0
    ledger = replace(
        ledger,
        entries=(quantised.entry, *ledger.entries),
        model=ledger.model if ledger.established else quantised.candidate,
        explained=1.0 - (1.0 - quantised.share) * (1.0 - further),
    )
    words = quantised.entry.words
    return replace(
        decision, verdict="missing-effect", best=quantised.candidate, ledger=ledger, reason=words, detected_by=words
    )


def _untried(problem: Problem, ranked: Sequence[Candidate]) -> list[str]:
    """One line for each of the user's own effects that is neither in the model nor among the candidates."""
    known = {public_name(e.name) for e in problem.start.effects} | {c.public_name for c in ranked}
    return [
        f"effect '{effect.name}' of your own was not tried: on these records its law is not finite, or has no "
        f"influence beyond that of the effects in the model, or it is not observable on a {problem.kind} rig"
        for effect in problem.custom
        if public_name(effect.name) not in known
    ]


def _added(problem: Problem) -> list[str]:
    """Effects of the model that were added since the first revision of its history."""
    revisions = read_history(problem.experiment)
    first = {public_name(name) for name in revisions[0].effects} if revisions else set()
    return [e.name for e in problem.start.effects if revisions and public_name(e.name) not in first]
