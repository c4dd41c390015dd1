"""Jobs of the measurement view: the commands `compare`, `diagnose`, `add`, `suggest` and their curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.compare import Comparison
from sysid.compare import compare as compare_model
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from sysid.report import channel_unit, comparison_json, diagnosis_json
from workbench.identification.design_values import design_values
from workbench.options import Run
from workbench.page.curves import write_curves
from workbench.page.job_process import Report

LEAST_SHARE = 0.005
"""Share of the residual's variance from which a map is shown."""
MOST_SAMPLES = 3_000_000
"""Samples of all records up to which candidates are predicted on every record; above it, on the first of each role."""


def compare(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Fit the model as it stands: the document of `stagecad compare --json`, overlays, maps, statement, report."""
    from workbench.identification.statements import comparison_statement, is_adequate
    from workbench.report.page import write_comparison

    run = _run(params, out)
    report("fitting the model", 0, 2)
    found = compare_model(experiment, design_values(run))
    report("report", 1, 2)
    document = comparison_json(found)
    return {
        "document": document,
        **_experiment(found.problem),
        "statement": comparison_statement(found),
        "adequate": is_adequate(found),
        "overlays": _overlays(found.problem, {"model": found.base.fitted.model}, Path(folder)),
        "maps": _maps(found.problem, found.maps),
        "report": str(write_comparison(run, found, document)),
    }


def diagnose(
    experiment: str, all_effects: bool, params: str | None, out: str, folder: str, report: Report
) -> dict[str, Any]:
    """The document of `stagecad diagnose --json`; overlays with the prediction of each candidate fitted in full."""
    from sysid.diagnose import diagnose as diagnose_model
    from workbench.identification.statements import (
        diagnosis_statement,
        equivalence_statement,
        next_step_statement,
        replacement_statements,
        unphysical_statements,
    )
    from workbench.report.page import write_diagnosis

    run = _run(params, out)
    report("fitting the model", 0, 0)
    found = diagnose_model(experiment, all_effects, design_values(run), report)
    report("report", 0, 0)
    document = diagnosis_json(found)
    models: dict[str, Model] = {"model": found.base.fitted.model}
    for trial in found.trials[: found.reported_in_full]:
        models[trial.public_name] = trial.fitted.model
    return {
        "document": document,
        **_experiment(found.problem),
        "statement": diagnosis_statement(found),
        "ties": equivalence_statement(found),
        "remarks": [
            *replacement_statements(found),
            *unphysical_statements(found),
            *([next_step_statement(found)] if found.best is None and next_step_statement(found) else []),
        ],
        "overlays": _overlays(found.problem, models, Path(folder)),
        "maps": _maps(found.problem, found.maps),
        "report": str(write_diagnosis(run, found, document)),
    }


def add(
    experiment: str,
    effects: Sequence[str],
    drop: Sequence[str],
    params: str | None,
    out: str,
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """Add effects and fit: the document of `stagecad add --json`, with the overlays and maps of the new model."""
    from sysid.ladder import add_effects, addition_json, ladder_json
    from workbench.report.page import write_ladder

    run = _run(params, out)
    report(f"fitting with {', '.join(effects)}" if effects else "fitting", 0, 0)
    step = add_effects(experiment, effects, design_values(run), drop)
    report("residual maps", 0, 0)
    found = compare_model(experiment, design_values(run))
    rungs = ladder_json(found.problem.experiment)
    return {
        "document": addition_json(step),
        "comparison": _comparison(found, Path(folder)),
        "report": str(write_ladder(run, step.problem.experiment.folder.name, rungs)),
    }


def undo(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Go back one rung, and fit the model that then stands."""
    from sysid.experiment.experiment import find_experiment
    from sysid.experiment.history import undo as undo_last

    rung, kept = undo_last(find_experiment(experiment))
    run = _run(params, out)
    report("fitting the model", 0, 0)
    found = compare_model(experiment, design_values(run))
    document = {"schema": 1, "rung": rung.number, "effects": list(rung.effects), "kept": str(kept)}
    return {"document": document, "comparison": _comparison(found, Path(folder))}


def suggest(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """The document of `stagecad suggest --json`, and its statements; the motions are written as CSV files."""
    from sysid.experiment_design.t_optimal_design import suggest as suggest_motions
    from workbench.identification.statements import suggestion_statements
    from workbench.report.page import write_motions, write_suggestion

    run = _run(params, out)
    found = suggest_motions(experiment, design_values(run), report)
    motions = write_motions(run, found)
    return {
        "document": motions,
        "statements": suggestion_statements(found),
        "report": str(write_suggestion(run, found, motions)),
    }


def _run(params: str | None, out: str) -> Run:
    return Run(Path(params) if params is not None else None, (), Path(out), None)


def _comparison(found: Comparison, folder: Path) -> dict[str, Any]:
    from workbench.identification.statements import comparison_statement, is_adequate

    return {
        "document": comparison_json(found),
        **_experiment(found.problem),
        "statement": comparison_statement(found),
        "adequate": is_adequate(found),
        "overlays": _overlays(found.problem, {"model": found.base.fitted.model}, folder),
        "maps": _maps(found.problem, found.maps),
    }


def _experiment(problem: Problem) -> dict[str, Any]:
    """Stated model, rig and records of an experiment."""
    from workbench.identification.statements import noise_text

    rig = problem.experiment.rig
    return {
        "stated": list(problem.experiment.effects),
        "rig": {"kind": rig.kind, "rotary": rig.rotary},
        "noise": noise_text(problem),
        "records": [
            {
                "name": record.name,
                "role": record.role,
                "rows": record.size,
                "seconds": float(record.time[-1] - record.time[0]),
                "channels": list(record.channels),
                "notes": list(record.notes),
            }
            for record in problem.records
        ],
    }


def _overlays(problem: Problem, models: Mapping[str, Model], folder: Path) -> list[dict[str, Any]]:
    """Measured and predicted signal of each channel of each record, written as curves; held-out records first."""
    from workbench.report.figures import curve_of

    roles = (("validate", problem.validate_records), ("fit", problem.fit_records))
    samples = sum(record.size for record in problem.records) * len(models)
    overlays: list[dict[str, Any]] = []
    for role, records in roles:
        for record in records if samples <= MOST_SAMPLES else records[:1]:
            for channel in record.measured:
                curve = curve_of(record, channel, channel_unit(problem, channel), models)
                series = {"time": curve.time, "measured": curve.measured, **curve.predicted}
                series |= {f"residual:{m}": curve.measured - values for m, values in curve.predicted.items()}
                motion = {name: unit for name, (_, unit) in curve.motion.items()}
                series |= {f"motion:{name}": values for name, (values, _) in curve.motion.items()}
                stored = write_curves(folder, len(overlays), series)
                overlays.append(
                    {
                        **stored,
                        "record": curve.record,
                        "role": role,
                        "channel": channel,
                        "unit": curve.unit,
                        "noise": curve.noise,
                        "models": list(models),
                        "motion": motion,
                    }
                )
    return overlays


def _maps(problem: Problem, maps: Sequence[ResidualMap]) -> list[dict[str, Any]]:
    """Residual over each coordinate, in standard deviations of the noise; empty cells as null."""
    from workbench.report.map_figures import coordinate_unit

    drawable = [m for m in maps if m.centres.size > 1 and np.ptp(m.centres) > 0.0]
    chosen = [m for m in drawable if m.share > LEAST_SHARE][:9] or drawable[:3]
    rotary, tip = problem.experiment.rig.rotary, problem.kind == "actuator-tip"
    return [
        {
            "coordinate": m.coordinate,
            "unit": coordinate_unit(m.coordinate, rotary, tip),
            "share": m.share,
            "p_value": m.p_value,
            "centres": m.centres.tolist(),
            "forward": _filled(m.forward),
            "backward": _filled(m.backward),
            "forward_error": m.forward_error.tolist(),
            "backward_error": m.backward_error.tolist(),
        }
        for m in chosen
    ]


def _filled(values: np.ndarray) -> list[float | None]:
    """A cell that no sample fell into holds an exact zero."""
    return [None if value == 0.0 else float(value) for value in values]
