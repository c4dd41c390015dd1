"""Jobs of the measurement view: `compare`, `diagnose`, `add`, `suggest` of the Python interface, and their curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.diagnosis.residual_maps import ResidualMap
from sysid.estimation.identifiability import public_key
from sysid.estimation.misfit import misfit
from sysid.experiment.experiment import find_experiment
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from sysid.report import channel_unit, parameter_unit
from workbench.api.comparison import Comparison
from workbench.api.design import Design
from workbench.api.experiment import Experiment
from workbench.options import Run
from workbench.page.curves import write_curves
from workbench.page.job_process import Report

LEAST_SHARE = 0.005
"""Share of the residual's variance from which a map is shown."""
MOST_SAMPLES = 3_000_000
"""Samples of all records up to which candidates are predicted on every record; above it, on the first of each role."""
USUAL_SHARE = 0.97
"""Share of the samples that the scale of the residual shows: a few next to reversals would hide all others."""
MOVED = "moved"
"""Name of the prediction with values that the user has changed."""

_kept: dict[str, tuple[str, Comparison]] = {}
"""The last comparison of each experiment in this process, with the text of its file."""


def compare(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Fit the model as it stands: the document of `stagecad compare --json`, overlays, maps, statement, report."""
    from workbench.report.page import write_comparison

    report("fitting the model", 0, 2)
    found = _compared(experiment, params)
    report("report", 1, 2)
    page = write_comparison(_run(out), found.found, found.to_json())
    return {**_comparison(found, Path(folder)), "report": str(page)}


def predict(
    experiment: str,
    values: Mapping[str, float],
    record: str,
    channel: str,
    params: str | None,
    out: str,
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """The fitted model with other values of its parameters: its overlay on one channel of a record, and its errors."""
    file = find_experiment(experiment).path
    text, found = _kept.get(experiment, ("", None))
    if found is None or text != file.read_text("utf-8"):
        report("fitting the model", 0, 0)
        found = _compared(experiment, params)
    problem, fitted = found.problem, found.fitted.model
    moved = fitted.at({key: value for key, value in values.items() if key in fitted.values})
    models = {"model": fitted, MOVED: moved}
    errors = {
        role: {name: one.over_noise for name, one in misfit(moved, records).items()}
        for role, records in (("fit", problem.fit_records), ("validate", problem.validate_records))
    }
    return {"overlays": _overlays(problem, models, Path(folder), (record, channel)), "over_noise": errors}


def diagnose(
    experiment: str, all_effects: bool, params: str | None, out: str, folder: str, report: Report
) -> dict[str, Any]:
    """The document of `stagecad diagnose --json`; overlays with the prediction of each candidate fitted in full."""
    from workbench.api.diagnosis import diagnose as diagnose_model
    from workbench.identification.statements import (
        diagnosis_statement,
        equivalence_statement,
        next_step_statement,
        replacement_statements,
        unphysical_statements,
    )
    from workbench.report.page import write_diagnosis

    report("fitting the model", 0, 0)
    result = diagnose_model(_experiment(experiment, params), all_effects, progress=report)
    report("report", 0, 0)
    found, document = result.found, result.to_json()
    models: dict[str, Model] = {"model": found.base.fitted.model}
    for trial in found.trials[: found.reported_in_full]:
        models[trial.public_name] = trial.fitted.model
    return {
        "document": document,
        **_stated(found.problem),
        "statement": diagnosis_statement(found),
        "ties": equivalence_statement(found),
        "remarks": [
            *replacement_statements(found),
            *unphysical_statements(found),
            *([next_step_statement(found)] if found.best is None and next_step_statement(found) else []),
        ],
        "overlays": _overlays(found.problem, models, Path(folder)),
        "maps": _maps(found.problem, found.maps),
        "report": str(write_diagnosis(_run(out), found, document)),
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
    from workbench.api.growth import add as add_effects
    from workbench.api.growth import ladder
    from workbench.report.page import write_ladder

    report(f"fitting with {', '.join(effects)}" if effects else "fitting", 0, 0)
    step = add_effects(_experiment(experiment, params), *effects, drop=tuple(drop))
    report("residual maps", 0, 0)
    rungs = ladder(step.experiment).to_json()
    return {
        "document": step.to_json(),
        "comparison": _comparison(_compared(experiment, params), Path(folder)),
        "report": str(write_ladder(_run(out), step.experiment.name, rungs)),
    }


def undo(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Go back one rung, and fit the model that then stands."""
    from sysid.experiment.history import undo as undo_last

    rung, kept = undo_last(find_experiment(experiment))
    report("fitting the model", 0, 0)
    document = {"schema": 1, "rung": rung.number, "effects": list(rung.effects), "kept": str(kept)}
    return {"document": document, "comparison": _comparison(_compared(experiment, params), Path(folder))}


def suggest(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """The document of `stagecad suggest --json`, and its statements; the motions are written as CSV files."""
    from workbench.api.suggestion import suggest as suggest_motions
    from workbench.identification.statements import suggestion_statements
    from workbench.report.page import write_motions, write_suggestion

    found = suggest_motions(_experiment(experiment, params), progress=report).found
    motions = write_motions(_run(out), found)
    return {
        "document": motions,
        "statements": suggestion_statements(found),
        "report": str(write_suggestion(_run(out), found, motions)),
    }


def _run(out: str) -> Run:
    return Run(None, (), Path(out), None)


def _experiment(path: str, params: str | None) -> Experiment:
    return Experiment.load(path, None if params is None else Design(Path(params), rules=False))


def _compared(experiment: str, params: str | None) -> Comparison:
    """The stated model, fitted; kept for predictions with other values."""
    from workbench.api.comparison import compare as compare_model

    text = find_experiment(experiment).path.read_text("utf-8")
    found = compare_model(_experiment(experiment, params))
    _kept.clear()
    _kept[experiment] = text, found
    return found


def _comparison(result: Comparison, folder: Path) -> dict[str, Any]:
    from workbench.identification.statements import comparison_statement, is_adequate

    found = result.found
    return {
        "document": result.to_json(),
        **_stated(found.problem),
        "statement": comparison_statement(found),
        "adequate": is_adequate(found),
        "sliders": _sliders(found.problem, result.fitted.model),
        "overlays": _overlays(found.problem, {"model": result.fitted.model}, folder),
        "maps": _maps(found.problem, found.maps),
    }


def _sliders(problem: Problem, model: Model) -> list[dict[str, Any]]:
    """Fitted parameters with the range of a slider, SI: half to one and a half times the value, within its bounds."""
    found = []
    for one in model.unknowns:
        if one.key in model.nuisances:
            continue
        value = model.values[one.key]
        reach = 0.5 * abs(value) or one.size
        low, high = max(value - reach, one.low), min(value + reach, one.high)
        if high > low:
            unit = parameter_unit(problem, one.key)
            found.append(
                {"key": one.key, "name": public_key(one.key), "value": value, "low": low, "high": high, "unit": unit}
            )
    return found


def _stated(problem: Problem) -> dict[str, Any]:
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


def _overlays(
    problem: Problem, models: Mapping[str, Model], folder: Path, only: tuple[str, str] | None = None
) -> list[dict[str, Any]]:
    """Measured and predicted signal of each channel of each record, written as curves; held-out records first.

    `only` is the record and the channel wanted; all of them when left out.
    """
    from workbench.report.figures import curve_of

    roles = (("validate", problem.validate_records), ("fit", problem.fit_records))
    samples = sum(record.size for record in problem.records) * len(models)
    overlays: list[dict[str, Any]] = []
    for role, records in roles:
        for record in records if only or samples <= MOST_SAMPLES else records[:1]:
            for channel in record.measured:
                if only not in (None, (record.name, channel)):
                    continue
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
                        "largest": _quantile(curve.measured, 1.0),
                        "usual": _quantile(series["residual:model"], USUAL_SHARE),
                        "models": list(models),
                        "motion": motion,
                    }
                )
    return overlays


def _quantile(values: np.ndarray, share: float) -> float:
    """Quantile of the absolute values; 0 without any number."""
    sizes = np.abs(values[np.isfinite(values)])
    return float(np.quantile(sizes, share)) if sizes.size else 0.0


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
