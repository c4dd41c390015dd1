"""Sections of the report of an experiment: results of a comparison, a diagnosis, a ladder or a suggestion.

A section is plain data (it is kept as JSON), so a report can be composed again from sections made at other times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.experiment_design.t_optimal_design import Suggestion
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from sysid.report import channel_unit, worst_channel
from workbench.identification.statements import (
    NEAR_NOISE,
    SEPARATED,
    comparison_statement,
    diagnosis_statement,
    equivalence_statement,
    held_out_over_noise,
    is_adequate,
    near_noise,
    next_step_statement,
    noise_text,
    replacement_statements,
    suggestion_statements,
    unphysical_statements,
)
from workbench.identification.tables import (
    correlation_table,
    dependence_table,
    detectable_table,
    error_table,
    ladder_table,
    motion_table,
    over_noise_text,
    parameter_table,
    quantity_text,
    ranking_table,
    simulation_table,
)
from workbench.report.figures import AFTER, BEFORE, MODEL, curve_of, draw_ladder, draw_loops, draw_overlay, worst_record
from workbench.report.map_figures import draw_maps

Section = dict[str, Any]

LEAST_SHARE = 0.005
"""Share of the residual's variance from which a map is drawn."""

MOST_CORRELATED = 14
"""Parameters up to which the matrix of correlations is shown."""


def comparison_section(found: Comparison, document: Mapping[str, Any]) -> Section:
    """Result of `compare`."""
    model = found.base.fitted.model
    return {
        **_experiment(found.problem, model),
        "kind": "compare",
        "title": "The model as it stands",
        "state": "good" if is_adequate(found) else "bad",
        "number": over_noise_text(held_out_over_noise(found.fit, found.validate)),
        "warnings": list(found.warnings),
        "headline": comparison_statement(found),
        "errors": error_table("", document["before"]).as_json(),
        "simulation": simulation_table(document).as_json(),
        "whiteness": correlation_table(document).as_json(),
        "overlays": _overlays(found.problem, {"model": model}, found.validate, (MODEL,)),
        "maps": _maps(found.problem, found.maps),
        "where": dependence_table(document["where"]).as_json(),
        **_parameters(document, "Parameters"),
        "seconds": document["seconds"],
    }


def diagnosis_section(found: Diagnosis, document: Mapping[str, Any]) -> Section:
    """Result of `diagnose`."""
    problem, base = found.problem, found.base.fitted
    best = found.best if found.best is not None else (found.trials[0] if found.trials else None)
    models, inks = {"model": base.model}, (MODEL,)
    if best is not None and found.verdict != "adequate":
        label = f"with {best.public_name}" + ("" if found.best is not None else " (best tried)")
        models, inks = {"before": base.model, label: best.fitted.model}, (BEFORE, AFTER)
    before = held_out_over_noise(found.before_fit, found.before_validate)
    effect = None if found.best is None else found.best.effect
    names = ("name", "meaning", "equation", "shows", "source")
    titles = {"adequate": "Nothing is missing", "unexplained": "Unexplained residual"}
    return {
        **_experiment(problem, base.model),
        "kind": "diagnose",
        "title": titles.get(found.verdict, f"What is missing: {found.effect}"),
        "state": {"missing-effect": "found", "adequate": "good"}.get(found.verdict, "bad"),
        "number": over_noise_text(before),
        "verdict": found.verdict,
        "warnings": list(found.warnings),
        "headline": diagnosis_statement(found),
        "next_step": next_step_statement(found),
        "equivalent": equivalence_statement(found),
        "errors": error_table("", document["before"], document["after"] if found.best is not None else None).as_json(),
        "simulation": simulation_table(document).as_json(),
        "overlays": _overlays(problem, models, found.before_validate, inks),
        "ranking": ranking_table(document["ranking"], len(found.trials), before).as_json(),
        "detectable": detectable_table(document["detectable"] if near_noise(found) else []).as_json(),
        "maps": _maps(problem, found.maps),
        "where": dependence_table(document["where"]).as_json(),
        "effect": None if effect is None else {name: getattr(effect, name) for name in names},
        **_parameters(
            document, f"Parameters of the model {f'with {found.effect}' if found.effect else 'as it stands'}"
        ),
        "remarks": [*replacement_statements(found), *unphysical_statements(found)],
        "seconds": document["seconds"],
    }


def ladder_section(rungs: Sequence[Mapping[str, Any]], png: Path | None = None) -> Section:
    """The ladder so far, its figure written to `png` as well."""
    last, steps = rungs[-1], len(rungs) - 1
    first, now = (_worst_over_noise(rung["before"]) for rung in (rungs[0], last))
    count = "one step" if steps == 1 else f"{steps} steps"
    return {
        "kind": "ladder",
        "title": "The ladder",
        "effects": list(last["effects"]),
        "state": "good" if now <= NEAR_NOISE else "found",
        "number": over_noise_text(now),
        "headline": f"From {over_noise_text(first)} the noise to {over_noise_text(now)}, in {count}.",
        "figure": draw_ladder(rungs, png),
        "rungs": ladder_table(rungs).as_json(),
        "parameters": parameter_table(last.get("parameters", {})).as_json(),
    }


def suggestion_section(found: Suggestion, motions: Sequence[Mapping[str, Any]]) -> Section:
    """Result of `suggest`; `motions` is its document."""
    best = found.motions[0]
    title = "What to measure next"
    if len(found.competing) > 1:
        open_pairs = [p for p in best.pairs if p.effects[1] not in found.inseparable and p.records < SEPARATED]
        title += f": {best.motion.name if open_pairs else 'nothing is left to separate'}"
    return {
        "kind": "suggest",
        "title": title,
        "effects": [e.name for e in found.problem.start.effects],
        "records": {record.name: record.sha256 for record in found.problem.records},
        "state": "good" if found.diagnosis.verdict == "adequate" else "found",
        "number": f"{best.least:.3g} σ" if best.least > 0.0 else "–",
        "headline": " ".join(line[0].upper() + line[1:].rstrip(".") + "." for line in suggestion_statements(found)),
        "motions": motion_table(motions).as_json(),
    }


def _worst_over_noise(errors: Mapping[str, Any]) -> float:
    ratios = [m.get("over_noise") for part in ("fit", "validate") for m in errors.get(part, {}).values()]
    return max((ratio for ratio in ratios if ratio is not None), default=float("nan"))


def _experiment(problem: Problem, model: Model) -> Section:
    rig = problem.experiment.rig
    known = []
    for name, quantity in rig.known.items():
        declared = rig.declaration.known[name]
        unit = declared.rotary_unit if rig.rotary else declared.unit
        known.append(f"{name.replace('_', ' ')} {quantity_text(quantity.value, unit)}")
    return {
        "effects": [e.name for e in model.effects],
        "records": {record.name: record.sha256 for record in problem.records},
        "rig": f"{rig.kind}" + (", rotary" if rig.rotary else "") + (f": {', '.join(known)}" if known else ""),
        "record_list": [_record_text(problem, k) for k in range(len(problem.records))],
        "noise": noise_text(problem),
        "notes": list(problem.notes),
    }


def _record_text(problem: Problem, index: int) -> str:
    record = problem.records[index]
    length = float(record.time[-1] - record.time[0])
    role = "fit" if record.role == "fit" else "held out"
    return f"{record.name} ({role}): {record.size} rows in {length:.4g} s"


def _overlays(
    problem: Problem, models: Mapping[str, Any], by_channel: Mapping[str, Any], inks: Sequence[str]
) -> list[dict[str, str]]:
    """The worst channel on the worst held-out record, then the other channels there."""
    records = problem.validate_records or problem.fit_records
    base = next(iter(models.values()))
    worst = worst_channel(problem, by_channel)
    drawn = []
    for channel in [worst, *(c for c in records[0].measured if c != worst)][:3]:
        curve = curve_of(worst_record(records, channel, base), channel, channel_unit(problem, channel), models)
        figures = {"figure": draw_overlay(curve, inks), "loops": draw_loops(curve, inks)}
        drawn.append({"channel": channel.replace("_", " "), **figures})
    return drawn


def _maps(problem: Problem, maps: Sequence[ResidualMap]) -> str:
    """Figure of the strongest residual maps, empty where there is none."""
    # An axis that never rests has one age of contact: nothing to draw it against.
    drawable = [m for m in maps if m.centres.size > 1 and np.ptp(m.centres) > 0.0]
    shown = [m for m in drawable if m.share > LEAST_SHARE][:6] or drawable[:3]
    return draw_maps(shown, problem.experiment.rig.rotary, problem.kind == "actuator-tip") if shown else ""


def _parameters(document: Mapping[str, Any], title: str) -> dict[str, Any]:
    """Fitted values, what the records do not determine of them, and their correlations."""
    names, matrix = document["correlation"]["keys"], document["correlation"]["matrix"]
    shown = 1 < len(names) <= MOST_CORRELATED
    return {
        "parameters": parameter_table(document["parameters"], title).as_json(),
        "not_identifiable": document["not_identifiable"],
        "correlation": {"names": names, "cells": matrix} if shown else None,
    }
