"""`add`: effects added to the model of an experiment, fitted, and written with the errors as the next rung."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from sim.effects.catalogue import find, rounding_effects
from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError, nearest
from sysid.diagnose import Diagnosis, diagnose
from sysid.diagnosis.candidate_screening import Progress
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.structural_modes import detect_structural_mode, prefers_balance_fit, with_structural_mode
from sysid.documents import both_json, ledger_json, noise_json, parameter_unit, parameters_json
from sysid.estimation.covariance import intervals
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model, reference_fit, reported_fit
from sysid.estimation.variant_selection import (
    predicts_clearly_better,
    reselectable_effects,
    select_variants,
    without_effect,
)
from sysid.experiment.experiment import DesignValues, Experiment, load_experiment
from sysid.experiment.in_memory import with_revision
from sysid.experiment.ladder import Revision, append_revision, read_history
from sysid.prediction.model import Model, public_name, with_effect
from sysid.prediction.observable import candidate_effects, is_observable, next_copy
from sysid.prediction.problem import Problem, build_problem, load_problem, problem_of


@dataclass(frozen=True)
class Addition:
    """Result of adding effects to the model of an experiment."""

    revision: Revision  # as written
    # problem, base: with the extended model
    problem: Problem
    base: ReferenceFit
    # before_fit, before_validate: misfit by channel of the model before
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    # after_fit, after_validate: misfit by channel of the extended model
    after_fit: dict[str, ChannelMisfit]
    after_validate: dict[str, ChannelMisfit]
    # parameters of the model before whose values left their intervals, with value before and after, SI
    changed: dict[str, tuple[float, float]]
    seconds: float  # run time
    # with the extended model, where it is in memory; the file of another is changed
    experiment: Experiment | None = None


def add_all(
    source: str | Path | Problem, design: DesignValues | None = None, progress: Progress | None = None
) -> tuple[Diagnosis, list[Addition]]:
    """Add every effect that a diagnosis establishes, in the order of its ledger, with one revision for each; arguments
    and errors as of `add_effects`, `progress` is that of the diagnosis."""
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    found = diagnose(problem, progress=progress)
    steps: list[Addition] = []
    for entry in found.ledger.established:
        name = entry.model.law or entry.effect.name
        step = add_effects(problem, [name], design, near=found.ledger.model.fitted.model)
        steps.append(step)
        problem = problem_of(step.experiment or load_experiment(problem.experiment.path, design))
    return found, steps


def add_effects(
    source: str | Path | Problem,
    effects: Sequence[str],
    design: DesignValues | None = None,
    drop: Sequence[str] = (),
    accept: Callable[[Problem, FittedModel], object] = lambda problem, fitted: None,
    near: Model | None = None,
) -> Addition:
    """Add effects to the model of an experiment, fit it, and write the next revision and `experiment.toml`.

    Nothing is written for an experiment in memory. An effect named without variant or channel gets those that fit best:
    the variant of its own name, unless another fits clearly better, or predicts the held-out records clearly better.
    A friction state model replaces the previous one.

    Args:
        source: folder of the experiment, its `experiment.toml`, or a problem already built.
        effects: names of the effects to add.
        design: values of the design for known quantities stated as `"design"`.
        drop: names of effects that are removed first, in the same revision.
        accept: called with the extended model before anything is written; nothing is where it raises.
        near: a fitted model that has the effects: they get its laws as they are, and start from its values.

    Raises:
        InputError: an effect that is unknown, already present (to drop: absent), or not observable on this rig; a fault
            in a file.
    """
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    base = fit_stated_model(problem)
    experiment, free = problem.experiment, reselectable_effects(problem, effects)
    extended, fitted = _extended(problem, base.fitted, effects, drop, near)
    # A variant selected while an effect was missing may be the wrong one now.
    decided = set() if near is None else {effect.name for effect in near.effects}
    decided = {public_name(effect.name) for effect in fitted.model.effects if effect.name in decided}
    undecided = [name for name in free if name not in decided]
    fitted, _ = select_variants(extended, fitted, undecided, partial(predicts_clearly_better, extended))
    extended, reached = reported_fit(extended, reference_fit(extended, fitted))
    problem, base = reported_fit(problem, base)
    fitted = reached.fitted
    before_fit, before_validate = _misfits(problem, base.fitted)
    after_fit, after_validate = _misfits(extended, fitted)
    base_document = _revision_document(problem, base.fitted, before_fit, before_validate)
    document = {**_revision_document(extended, fitted, after_fit, after_validate), "open_laws": list(free)}
    names = [e.name for e in fitted.model.effects] + _quantised(extended, fitted)
    names = [name for name in names if name in effects or not {name, public_name(name)} & set(drop)]
    starts = {
        u.key: (fitted.model.values[u.key], parameter_unit(extended, u.key))
        for u in fitted.model.unknowns
        if not u.key.startswith("rig.")
    }
    hashes = {record.name: record.sha256 for record in problem.records}
    known = {u.key: u.prior for u in fitted.model.unknowns if u.prior is not None}
    accept(extended, fitted)
    if experiment.revisions is None:
        grown = None
        revision = append_revision(experiment, names, starts, document, base_document, hashes, known=known)
    else:
        grown = with_revision(experiment, names, starts, document, base_document, known, design)
        assert grown.revisions
        revision = grown.revisions[-1]
    return Addition(
        revision=revision,
        problem=extended,
        base=reached,
        before_fit=before_fit,
        before_validate=before_validate,
        after_fit=after_fit,
        after_validate=after_validate,
        changed=_changed_parameters(base, problem, fitted.model),
        seconds=perf_counter() - began,
        experiment=grown,
    )


def _extended(
    problem: Problem, fitted: FittedModel, effects: Sequence[str], drop: Sequence[str], near: Model | None
) -> tuple[Problem, FittedModel]:
    """The problem and the fitted model without and with some effects; those of `near` as they are there."""
    laws = {} if near is None else {effect.name: effect for effect in near.effects}
    for name in drop:
        problem, fitted = _without_effect(problem, fitted, name)
    for name in effects:
        if near is None or name not in laws:
            problem, fitted = _with_effect(problem, fitted, name)
            continue
        extended = with_effect(fitted.model, laws[name], problem.scales)
        own = {key: near.values[key] for key in extended.values if key in near.values}
        # The values of the others may belong to a model with effects that are still to come.
        starts = [extended.at(own), extended.at({k: v for k, v in own.items() if k.startswith(f"{name}.")})]
        fits = [fit_model(start, problem.fit_records, fitted.weights, iterations=40) for start in starts]
        fitted = min(fits, key=lambda other: other.fit.cost)
    return problem, fitted


def _misfits(problem: Problem, fitted: FittedModel) -> tuple[dict[str, ChannelMisfit], dict[str, ChannelMisfit]]:
    """Misfit by channel on the records of the fit and the held-out ones."""
    return misfit(fitted.model, problem.fit_records), misfit(fitted.model, problem.validate_records)


def _quantised(problem: Problem, fitted: FittedModel) -> list[str]:
    """Quantisation effects of the problem, which add to the noise floor only and are not part of the fitted model."""
    present = {e.name for e in fitted.model.effects}
    return [n for n in rounding_effects(problem.experiment.effects, problem.custom) if n not in present]


def _without_effect(problem: Problem, fitted: FittedModel, name: str) -> tuple[Problem, FittedModel]:
    """The problem and the fitted model without one effect."""
    experiment = problem.experiment
    names = [e.name for e in fitted.model.effects] + _quantised(problem, fitted)
    dropped = [n for n in names if n == name] or [n for n in names if public_name(n) == name]
    if not dropped:
        raise InputError(f"{experiment.path}: model.effects has no '{name}' to drop{nearest(name, names)}")
    if any(e.name in dropped and e.friction_state is not None for e in fitted.model.effects):
        raise InputError(f"{experiment.path}: '{name}' is the friction state model; add another one in its place")
    if any(find(n, problem.custom).rounds for n in dropped):
        other = build_problem(experiment, problem.records, [n for n in experiment.effects if n not in dropped])
        return other, fit_stated_model(other).fitted
    return problem, fit_model(without_effect(fitted.model, dropped[0]), problem.fit_records, iterations=40)


def _with_effect(problem: Problem, fitted: FittedModel, name: str) -> tuple[Problem, FittedModel]:
    """The problem and the fitted model with one more effect, in the variant and channel that fit best."""
    experiment = problem.experiment
    effect = find(name, problem.custom)
    present = [e.name for e in fitted.model.effects]
    taken = {public_name(p) for p in present if "@" not in p}
    if effect.is_periodic and public_name(name) in taken and "#" not in name:
        name = next_copy(public_name(name), present)
        effect = find(name, problem.custom)
    elif name in present or (":" not in name and "@" not in name and public_name(name) in taken):
        raise InputError(f"{experiment.path}: model.effects has '{name}' already")
    if effect.rounds:
        return _with_quantisation(problem, name)
    search = ModelSearch(problem, reference_fit(problem, fitted), options=_options(problem, effect, present))
    found = sorted(search.singles, key=lambda c: c.fitted.fit.cost * (1.0 + 0.002 * len(c.fitted.model.unknowns)))
    if not found:
        also = ", or its law is not finite there" if effect in problem.custom else ""
        raise InputError(
            f"{experiment.path}: effect '{name}' has no influence on the channels measured in these records{also}"
        )
    best = found[0]
    mode = detect_structural_mode(problem, fitted) if effect.is_mode else None
    if mode is not None:
        with_mode = with_structural_mode(problem, fitted, mode)[1]
        if not prefers_balance_fit(best.fitted, with_mode):
            return problem, with_mode
    named = next((c for c in found if c.effect.name == name), None)
    if named is not None:
        best = next(
            (c for c in found if c is not named and predicts_clearly_better(problem, c.fitted, named.fitted)), named
        )
    extended = search.converged(best).fitted
    return problem, fit_model(extended.model, problem.fit_records, iterations=40)


def _options(problem: Problem, effect: Effect, present: Sequence[str]) -> list[Effect]:
    """The laws and channels of an effect that may be added to a model; those of its public name where it is named
    without variant and channel."""
    name = effect.name
    candidates = candidate_effects(problem, present, all_effects=True)
    options = [c for c in candidates if c.name == name] or [c for c in candidates if public_name(c.name) == name]
    if ":" not in name and "@" not in name:
        options = [c for c in candidates if public_name(c.name) == public_name(name)] or options
    if not options and ":" in name and is_observable(problem, effect):
        # A variant that a diagnosis does not try, since another one contains it, can be added by name.
        options = [effect]
    if not options:
        observable = sorted({public_name(c.name) for c in candidates})
        raise InputError(
            f"{problem.experiment.path}: effect '{name}' is not observable on a {problem.kind} rig with these records"
            f"{nearest(name, observable)}"
        )
    return options


def _with_quantisation(problem: Problem, name: str) -> tuple[Problem, FittedModel]:
    other = build_problem(problem.experiment, problem.records, [*problem.experiment.effects, name])
    if all(n.quantisation_step is None for n in other.noise.values()):
        raise InputError(f"{problem.experiment.path}: effect '{name}': the measured values are not quantised")
    return other, fit_stated_model(other).fitted


def _changed_parameters(base: ReferenceFit, problem: Problem, model: Model) -> dict[str, tuple[float, float]]:
    """Parameters of the base model whose value in `model` is outside their interval: both values by key."""
    found = intervals(base.fitted, problem.fit_records).by_key
    both = {key: (interval, model.values[key]) for key, interval in found.items() if key in model.values}
    return {key: (one.value, now) for key, (one, now) in both.items() if not one.low <= now <= one.high}


def _revision_document(
    problem: Problem, fitted: FittedModel, fit: Mapping[str, ChannelMisfit], validate: Mapping[str, ChannelMisfit]
) -> dict[str, Any]:
    return {
        "effects": [e.name for e in fitted.model.effects] + _quantised(problem, fitted),
        "form": problem.form,
        "noise": noise_json(problem),
        "before": both_json(problem, fit, validate),
        "parameters": parameters_json(problem, fitted),
    }


def addition_json(step: Addition) -> dict[str, Any]:
    """The document of `add`; `file` is null for an experiment in memory."""
    document = step.revision.document
    return {
        "schema": 1,
        "rung": step.revision.number,
        "file": str(step.revision.path) if step.experiment is None else None,
        "form": step.problem.form,
        "effects": list(step.revision.effects),
        "added": list(document["added"]),
        "removed": list(document["removed"]),
        "before": both_json(step.problem, step.before_fit, step.before_validate),
        "after": both_json(step.problem, step.after_fit, step.after_validate),
        "parameters": dict(document["parameters"]),
        "seconds": step.seconds,
    }


def additions_json(found: Diagnosis, steps: Sequence[Addition]) -> dict[str, Any]:
    """The document of `add --all`: the ledger of the diagnosis, and one rung for each effect that it established."""
    return {"schema": 1, "verdict": found.verdict, **ledger_json(found), "rungs": [addition_json(s) for s in steps]}


def ladder_json(experiment: Experiment) -> list[dict[str, Any]]:
    """Revisions of the model of an experiment as JSON; 000 is the model before the first addition.

    `before` holds the errors of the revision itself.
    """
    return [
        {
            "rung": revision.number,
            "effects": list(revision.effects),
            "added": list(revision.document.get("added", ())),
            "removed": list(revision.document.get("removed", ())),
            "before": revision.document.get("before", {}),
            "parameters": revision.document.get("parameters", {}),
            "noise": revision.document.get("noise", {}),
        }
        for revision in read_history(experiment)
    ]
