"""Diagnosis: which physical effect is missing. Candidates are scored, refitted and compared on held-out records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from sim.effects.catalogue import rigid_friction
from sim.effects.effect import Effect
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.candidate_screening import Progress
from sysid.diagnosis.consistency import consistency_warnings
from sysid.diagnosis.constants import FORM_ERROR, NOISE_FACTOR
from sysid.diagnosis.decision import Decision, NoiseLevel, decide
from sysid.diagnosis.held_out import evenness
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.quantised_channel import quantised_channel
from sysid.diagnosis.replacements import Replacement, find_replacements
from sysid.diagnosis.residual_maps import ResidualMap, compared_with_time, residual_maps
from sysid.diagnosis.structural_modes import structural_mode_candidate
from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import ChannelMisfit, ResidualWeights, blocks, huber_square, misfit, weighted_residual
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.variant_selection import without_effect
from sysid.experiment.experiment import DesignValues
from sysid.experiment.history import read_history
from sysid.noise.estimate import Noise
from sysid.prediction.model import Model, public_name
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, load_problem

IN_FULL = 6
"""Candidates whose held-out errors and fitted values are reported, in the order of the ranking."""


@dataclass(frozen=True)
class Diagnosis:
    """Which effect is missing from a model, and how certain that is.

    Args:
        problem, base: the identification problem and the fitted model.
        trials: every candidate effect, lowest held-out loss first; one variant per effect.
        decision: the verdict, the effect named, and what these records cannot distinguish from it.
        maps: of the residual of the base model.
        before_fit, before_validate: misfit of the base model by channel, on the records of the fit and held out.
        seconds: run time.
        replacements: effects added earlier that should be removed or replaced.
        reported_in_full: number of trials reported with their errors and values.
        warnings: contradictions in the records, one line each.
    """

    problem: Problem
    base: ReferenceFit
    trials: tuple[Candidate, ...]
    decision: Decision
    maps: tuple[ResidualMap, ...]
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    seconds: float
    replacements: tuple[Replacement, ...] = ()
    reported_in_full: int = IN_FULL
    warnings: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """`missing-effect`, `adequate` or `unexplained`."""
        return self.decision.verdict

    @property
    def best(self) -> Candidate | None:
        """The candidate named, for `missing-effect`."""
        return self.decision.best

    @property
    def effect(self) -> str | None:
        """Public name of the missing effect; none otherwise."""
        return self.best.public_name if self.best is not None else None

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """Effects that these records cannot distinguish from the one named."""
        return self.decision.ties

    @property
    def unexplained_share(self) -> float:
        """Share of the loss above the noise that remains with the effect named."""
        return self.decision.unexplained_share

    @property
    def reason(self) -> str:
        """Reason of the verdict as text."""
        return self.decision.reason


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
    search = ModelSearch(problem, base, all_effects, progress)
    added = _added(problem)
    decision = quantised_channel(search.reference) or decide(
        search, search.reference.held_out, _noise_level(search, added)
    )
    decision = structural_mode_candidate(search.reference, search.ranked, decision) or decision
    replacements: Sequence[Replacement] = ()
    if decision.best is None:
        # A missing effect is added first; replacements are searched only where none is missing.
        replacements = find_replacements(search, added, decision.verdict == "unexplained")
    of_model = base.fitted.model, problem.fit_records, base.fitted.weights, problem.validate_records, base.weights
    maps = residual_maps(*of_model)
    if decision.verdict == "unexplained":
        maps = compared_with_time(maps, *of_model)
    ranked, in_full = search.ranked, IN_FULL
    if decision.best is not None and decision.best not in ranked:
        # The decision may name another variant than the one with the lowest error.
        others = [trial for trial in ranked if trial.public_name != decision.best.public_name]
        in_full = 1 + sum(trial in others for trial in ranked[:IN_FULL])
        ranked = [decision.best, *others]
    before_fit = misfit(base.fitted.model, problem.fit_records)
    after_fit = before_fit if decision.best is None else decision.best.after_fit
    return Diagnosis(
        problem=problem,
        base=base,
        trials=tuple(ranked),
        decision=decision,
        maps=tuple(maps),
        before_fit=before_fit,
        before_validate=misfit(base.fitted.model, problem.validate_records),
        seconds=perf_counter() - began,
        replacements=tuple(replacements),
        reported_in_full=in_full,
        warnings=(*consistency_warnings(problem, after_fit), *_untried(problem, ranked)),
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


def _noise_level(search: ModelSearch, added: Sequence[str]) -> NoiseLevel:
    """What is known of the noise level, and of the form error of the effects added."""
    problem, base = search.problem, search.base
    known = all(_is_known(problem.noise[c]) for c in problem.fit_records[0].measured if c in problem.noise)
    richest = min((c.held_out.loss for c in (*search.ranked, *search.curves)), default=1.0)
    held = _contributions(base.fitted, added, problem.validate_records, base.weights)
    fit = _contributions(base.fitted, added, problem.fit_records, base.fitted.weights)
    fit_block = blocks(problem.fit_records, base.fitted.weights)
    reference = search.reference.held_out
    parts = [(reference.residual, held, reference.block), (base.fitted.fit.residual, fit, fit_block)]
    scaled = [(r / np.sqrt(1.0 + FORM_ERROR**2 * c), block) for r, c, block in parts if r.size]
    losses = [(float(np.mean(huber_square(r))), evenness(r, block)) for r, block in scaled]
    adequate_loss, even = max(losses, default=(1.0, 1.0))
    form_error = FORM_ERROR**2 * float(np.mean(held)) if held.size else 0.0
    return NoiseLevel(
        loss=(1.0 if known else min(1.0, max(richest, NOISE_FACTOR**-2))) + form_error,
        form_error=form_error,
        adequate_loss=adequate_loss,
        evenness=even,
    )


def _is_known(noise: Noise) -> bool:
    """Whether the level of a noise is known: stated, or mostly that of rounding.

    The rounding error of a smooth force is a function of the motion itself, so a rich model may leave less.
    """
    return noise.source == "given" or (noise.quantisation_step or 0.0) ** 2 / 12.0 >= 0.5 * noise.value**2


def _contributions(
    fitted: FittedModel, added: Sequence[str], records: Sequence[PreparedRecord], weights: ResidualWeights
) -> np.ndarray:
    """Sum over the effects added of the squared change (n,) of the residual without the effect, in deviations."""
    model = fitted.model
    residual = weighted_residual(model, records, weights)
    total = np.zeros(residual.size)
    for effect in model.effects:
        if effect.name in added:
            # Without presliding the friction is rigid.
            rest = without_effect(model, effect.name) if effect.friction_state is None else _rigid(model, effect)
            total += (weighted_residual(rest, records, weights) - residual) ** 2
    return total


def _rigid(model: Model, state: Effect) -> Model:
    """The model with rigid friction in place of a friction state model, at the same friction limit."""
    rigid = rigid_friction()
    values = {f"{rigid.name}.{p.name}": p.default for p in rigid.parameters}
    values[f"{rigid.name}.force"] = model.values[f"{state.name}.force"]
    effects = tuple(rigid if effect is state else effect for effect in model.effects)
    return Model(effects, {**model.values, **values}, ())
