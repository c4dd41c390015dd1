"""Adding effects one rung at a time: each rung is a fitted model with its errors, and can be gone back to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from sim.effects.catalogue import find
from stagecad.parameters.errors import InputError, nearest
from sysid.diagnosis.pairs import add_after_deletion
from sysid.diagnosis.structural_modes import detect_structural_mode, prefers_balance_fit, with_structural_mode
from sysid.estimation.covariance import intervals
from sysid.estimation.driven_stage_search import lowest_minimum
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.misfit import ChannelMisfit, misfit, residual_weights, weighted_residual
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.score_test import profiled_residual
from sysid.estimation.screening import screen_and_refit
from sysid.estimation.variant_selection import (
    fits_clearly_better,
    predicts_clearly_better,
    select_variants,
    selectable_effects,
    without_effect,
)
from sysid.experiment.experiment import DesignValues, Experiment
from sysid.experiment.history import Revision, append_revision, edited_by_hand, read_history
from sysid.prediction.model import Model, public_name
from sysid.prediction.observable import candidate_effects, is_observable
from sysid.prediction.problem import Problem, build_problem, load_problem
from sysid.report import both_json, noise_json, parameter_unit, parameters_json


@dataclass(frozen=True)
class Step:
    """A rung just added.

    Args:
        rung: as written.
        before_fit, before_validate: misfit of the model as it stood.
        after_fit, after_validate: misfit of the model with the effects added.
        changed: old parameters that moved by more than their interval, with value before and after, SI.
        seconds: taken.
    """

    rung: Revision
    problem: Problem
    base: ReferenceFit
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    after_fit: dict[str, ChannelMisfit]
    after_validate: dict[str, ChannelMisfit]
    changed: dict[str, tuple[float, float]]
    seconds: float


def add_effects(
    source: str | Path, effects: Sequence[str], design: DesignValues | None = None, drop: Sequence[str] = ()
) -> Step:
    """Add effects to the model of an experiment, fit, and write the next rung and `experiment.toml`.

    An effect named without variant or channel takes the law and the channel that fit best, the law of its own name
    unless another is clearly better, or fits as well and predicts the held-out records clearly better; so do the
    effects that the experiment names without a variant, once more. A core takes the place of the core before it.
    Effects to `drop` leave the model first, on the same rung.

    Raises:
        InputError: an effect that is unknown, there already (to drop: not there), or that this rig cannot show; a fault
            in a file.
    """
    began = perf_counter()
    problem = load_problem(source, design)
    base = fit_stated_model(problem)
    experiment = problem.experiment
    before_fit = misfit(base.fitted.model, problem.fit_records)
    before_validate = misfit(base.fitted.model, problem.validate_records)
    base_document = _rung_document(problem, base.fitted, before_fit, before_validate)
    grown_case, fitted = problem, base.fitted
    for name in drop:
        grown_case, fitted = _shrunk(grown_case, fitted, name)
    for name in effects:
        grown_case, fitted = _grow(grown_case, fitted, name)
    # A law that made up for what was missing may be the wrong one now.
    free = _free_laws(problem, effects)
    fitted, _ = select_variants(grown_case, fitted, free, partial(predicts_clearly_better, grown_case))
    after_fit = misfit(fitted.model, grown_case.fit_records)
    after_validate = misfit(fitted.model, grown_case.validate_records)
    document = {**_rung_document(grown_case, fitted, after_fit, after_validate), "open_laws": list(free)}
    names = [e.name for e in fitted.model.effects] + _quantised(grown_case, fitted)
    names = [name for name in names if name in effects or not {name, public_name(name)} & set(drop)]
    starts = {
        u.key: (fitted.model.values[u.key], parameter_unit(grown_case, u.key))
        for u in fitted.model.unknowns
        if not u.key.startswith("rig.")
    }
    hashes = {record.name: record.sha256 for record in problem.records}
    known = {u.key: u.prior for u in fitted.model.unknowns if u.prior is not None}
    rung = append_revision(experiment, names, starts, document, base_document, hashes, known=known)
    weights = residual_weights(fitted.model, grown_case.validate_records)
    residual = weighted_residual(fitted.model, grown_case.validate_records, weights)
    changed = _moved(base, problem, fitted.model)
    return Step(
        rung=rung,
        problem=grown_case,
        base=ReferenceFit(fitted, weights, residual),
        before_fit=before_fit,
        before_validate=before_validate,
        after_fit=after_fit,
        after_validate=after_validate,
        changed=changed,
        seconds=perf_counter() - began,
    )


def _quantised(problem: Problem, fitted: FittedModel) -> list[str]:
    """Quantisation effects of the problem that act on the floor alone, and so stand in no prediction."""
    present = {e.name for e in fitted.model.effects}
    return [n for n in problem.experiment.effects if n.partition("@")[0] == "sensor_quantisation" and n not in present]


def _shrunk(problem: Problem, fitted: FittedModel, name: str) -> tuple[Problem, FittedModel]:
    """The problem and its fit without one effect."""
    experiment = problem.experiment
    names = [e.name for e in fitted.model.effects] + _quantised(problem, fitted)
    gone = [n for n in names if n == name] or [n for n in names if public_name(n) == name]
    if not gone:
        raise InputError(f"{experiment.path}: model.effects has no '{name}' to drop{nearest(name, names)}")
    if any(e.name in gone and e.friction_state is not None for e in fitted.model.effects):
        raise InputError(f"{experiment.path}: '{name}' is the core of the friction; add another core in its place")
    if public_name(name) == "sensor_quantisation":
        other = build_problem(experiment, problem.records, [n for n in experiment.effects if n not in gone])
        return other, fit_stated_model(other).fitted
    return problem, fit_model(without_effect(fitted.model, gone[0]), problem.fit_records, iterations=40)


def _grow(problem: Problem, fitted: FittedModel, name: str) -> tuple[Problem, FittedModel]:
    experiment = problem.experiment
    effect = find(name, problem.custom)
    present = [e.name for e in fitted.model.effects]
    if name in present or (
        ":" not in name and "@" not in name and public_name(name) in {public_name(p) for p in present if "@" not in p}
    ):
        raise InputError(f"{experiment.path}: model.effects has '{name}' already")
    if public_name(name) == "sensor_quantisation":
        return _with_quantisation(problem, name)
    options = [c for c in candidate_effects(problem, present, all_effects=True) if c.name == name]
    if not options:
        options = [c for c in candidate_effects(problem, present, all_effects=True) if public_name(c.name) == name]
    if ":" not in name and "@" not in name:
        family = [
            c for c in candidate_effects(problem, present, all_effects=True) if public_name(c.name) == effect.name
        ]
        options = family or options
    if not options and ":" in name and is_observable(problem, effect):
        # Laws that a diagnosis does not try, since another of the family holds them, can be asked for.
        options = [effect]
    if not options:
        can = sorted({public_name(c.name) for c in candidate_effects(problem, present, all_effects=True)})
        raise InputError(
            f"{experiment.path}: effect '{name}' cannot show on a {problem.kind} rig with these records"
            f"{nearest(name, can)}"
        )
    profiled = profiled_residual(fitted)
    tried = [
        screen_and_refit(fitted, option, problem.fit_records, problem.scales, profiled, starts=3, iterations=40)
        for option in options
    ]
    good = [c for c in tried if c is not None]
    if not good:
        raise InputError(f"{experiment.path}: effect '{name}' changes nothing in what these records measured")
    good.sort(key=lambda c: c.fitted.fit.cost * (1.0 + 0.002 * len(c.fitted.model.unknowns)))
    plain = next((c for c in good if c.effect.name == name), None)
    best = good[0]
    rings = detect_structural_mode(problem, fitted) if public_name(name) == "flexible_mode" else None
    if rings is not None:
        told = with_structural_mode(problem, fitted, rings)[1]
        if not prefers_balance_fit(best.fitted, told):
            return problem, told
    if plain is not None:
        best = next(
            (c for c in good if c is not plain and predicts_clearly_better(problem, c.fitted, plain.fitted)), plain
        )
    grown = lowest_minimum(best.fitted, problem.fit_records)
    weights = residual_weights(fitted.model, problem.validate_records)
    base = ReferenceFit(fitted, weights, weighted_residual(fitted.model, problem.validate_records, weights))
    for other in add_after_deletion(problem, base, [best.effect]):
        # What the model had may have been fitted to the wrong place while this effect was missing.
        if fits_clearly_better(other, grown):
            grown = other
    return problem, fit_model(grown.model, problem.fit_records, iterations=40)


def _free_laws(problem: Problem, added: Sequence[str]) -> tuple[str, ...]:
    """Families whose law is the program's choice: open in the file, named without a law now, or on the last rung."""
    rungs = read_history(problem.experiment)
    before = [] if not rungs or edited_by_hand(problem.experiment, rungs) else rungs[-1].document.get("open_laws", [])
    named = [name for name in added if ":" not in name and "@" not in name]
    families = dict.fromkeys([*selectable_effects(problem), *before, *named])
    return tuple(
        name
        for name in families
        if find(name, problem.custom).variants and find(name, problem.custom).friction_state is None
    )


def _with_quantisation(problem: Problem, name: str) -> tuple[Problem, FittedModel]:
    other = build_problem(problem.experiment, problem.records, [*problem.experiment.effects, name])
    if all(n.quantisation_step is None for n in other.noise.values()):
        raise InputError(f"{problem.experiment.path}: effect '{name}': the measured values lie on no grid")
    return other, fit_stated_model(other).fitted


def _moved(base: ReferenceFit, problem: Problem, model: Model) -> dict[str, tuple[float, float]]:
    found = intervals(base.fitted, problem.fit_records).by_key
    out = {}
    for key, interval in found.items():
        now = model.values.get(key)
        if now is not None and not interval.low <= now <= interval.high:
            out[key] = (interval.value, now)
    return out


def _rung_document(
    problem: Problem, fitted: FittedModel, fit: Mapping[str, ChannelMisfit], validate: Mapping[str, ChannelMisfit]
) -> dict[str, Any]:
    return {
        "effects": [e.name for e in fitted.model.effects] + _quantised(problem, fitted),
        "form": problem.form,
        "noise": noise_json(problem),
        "before": both_json(problem, fit, validate),
        "parameters": parameters_json(problem, fitted),
    }


def ladder_json(experiment: Experiment) -> list[dict[str, Any]]:
    """Rungs of an experiment, 000 the model before anything was added, each with its own error under `before`."""
    rungs = read_history(experiment)
    return [
        {
            "rung": rung.number,
            "effects": list(rung.effects),
            "added": list(rung.document.get("added", ())),
            "removed": list(rung.document.get("removed", ())),
            "before": rung.document.get("before", {}),
            "parameters": rung.document.get("parameters", {}),
            "noise": rung.document.get("noise", {}),
        }
        for rung in rungs
    ]


def current_ladder(experiment: Experiment) -> tuple[list[dict[str, Any]], bool]:
    """The rungs, and whether `[model]` was edited by hand since the last of them."""
    return ladder_json(experiment), edited_by_hand(experiment, read_history(experiment))
