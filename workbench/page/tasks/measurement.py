"""Jobs of the measurement view: `compare`, `diagnose`, `add`, `suggest` of the Python interface, and their curves."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import require
from stagecad.parameters.units import attributes
from workbench.figures.curves import coordinate_unit, curves, drawn_maps
from workbench.operations.design import Design
from workbench.operations.measurement import add as additions
from workbench.operations.measurement.compare import Comparison
from workbench.operations.measurement.compare import compare as compare_model
from workbench.operations.measurement.diagnose import diagnose as diagnose_model
from workbench.operations.measurement.experiment import Experiment
from workbench.operations.measurement.export import export as export_model
from workbench.operations.measurement.fitted import FittedResult
from workbench.operations.measurement.suggest import suggest as suggest_motions
from workbench.page.curves import write_curves
from workbench.page.job_process import Report

MOVED = "moved"
"""Name of the prediction with values that the user has changed."""
MOST_MAPS = 9
"""Residual maps that are shown."""
MOST_MODELS = 12
"""Models that can be drawn over one record."""

_kept: dict[str, Comparison] = {}
"""The last comparison in this process, by the path of its experiment."""


def compare(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Fit the model as it stands: the document of `stagecad compare --json`, overlays, maps, statement, report."""
    report("fitting the model", 0, 2)
    found = _compared(experiment, params)
    report("report", 1, 2)
    page = found.write_report(out)
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
    found = _kept.get(experiment)
    if found is None or found.experiment.stated.text != _experiment(experiment, params).stated.text:
        report("fitting the model", 0, 0)
        found = _compared(experiment, params)
    moved, over_noise = found.with_values(values)
    overlays = _overlays(found, {"model": found.fitted.model, MOVED: moved}, Path(folder), (record, channel))
    require(overlays, f"{record}: no such record with the channel {channel}")
    return {"overlays": overlays, "over_noise": over_noise}


def diagnose(
    experiment: str, all_effects: bool, params: str | None, out: str, folder: str, report: Report
) -> dict[str, Any]:
    """The document of `stagecad diagnose --json`; overlays with the prediction of each candidate fitted in full."""
    report("fitting the model", 0, 0)
    result = diagnose_model(_experiment(experiment, params), all_effects, progress=report)
    report("report", 0, 0)
    return {
        "document": result.to_json(),
        **result.experiment.facts,
        **attributes(result, "title", "statement", "ties", "remarks"),
        **_drawn(result, result.candidates, Path(folder)),
        "report": str(result.write_report(out)),
    }


def add(
    experiment: str, effects: list[str], drop: list[str], params: str | None, out: str, folder: str, report: Report
) -> dict[str, Any]:
    """Add effects, or without any to add or drop all that a diagnosis establishes, and fit: the document of `stagecad
    add --json`, with the overlays and maps of the new model."""
    if effects or drop:
        report(f"fitting with {', '.join(effects)}" if effects else "fitting", 0, 0)
        step = last = additions.add(_experiment(experiment, params), *effects, drop=tuple(drop))
    else:
        step = additions.add_all(_experiment(experiment, params), progress=report)
        last = step.steps[-1] if step.steps else None
    report("residual maps", 0, 0)
    return {
        "document": step.to_json(),
        "comparison": _comparison(_compared(experiment, params), Path(folder)),
        "report": str(last.write_report(out)) if last is not None else None,
    }


def undo(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Go back one rung, and fit the model that then stands."""
    restored = additions.undo(experiment, _design(params))
    restored.write_report(out)
    report("fitting the model", 0, 0)
    return {"document": restored.to_json(), "comparison": _comparison(_compared(experiment, params), Path(folder))}


def suggest(experiment: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """The document of `stagecad suggest --json`, and its statements; the motions are written as CSV files."""
    found = suggest_motions(_experiment(experiment, params), progress=report).write_below(out)
    return {"document": found.to_json(), "statements": found.statements, "report": str(found.write_report(out))}


def export(experiment: str, to: str, params: str | None, out: str, folder: str, report: Report) -> dict[str, Any]:
    """Write the fitted model in another language: the document of `stagecad export --json`, and the names of files."""
    report("fitting the model", 0, 0)
    document = export_model(_experiment(experiment, params), to, out).to_json()
    return {**document, "names": [Path(file).name for file in document["files"]]}


def _experiment(path: str, params: str | None) -> Experiment:
    return Experiment.load(path, _design(params))


def _design(params: str | None) -> Design | None:
    return None if params is None else Design(Path(params), rules=False)


def _compared(experiment: str, params: str | None) -> Comparison:
    """The stated model, fitted; kept for predictions with other values."""
    found = compare_model(_experiment(experiment, params))
    _kept.clear()
    _kept[experiment] = found
    return found


def _comparison(result: Comparison, folder: Path) -> dict[str, Any]:
    return {
        "document": result.to_json(),
        **result.experiment.facts,
        **attributes(result, "statement", "adequate"),
        "sliders": result.free_values,
        **_drawn(result, {"model": result.fitted.model}, folder),
    }


def _drawn(result: FittedResult, models: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Curves of the fitted model, of others and of those of other rungs; maps of the residual of each."""
    models = dict(list({**models, **result.earlier}.items())[:MOST_MODELS])
    others = {name: _maps(result, result.maps_of(model)) for name, model in models.items() if name != "model"}
    return {
        "overlays": _overlays(result, models, folder),
        "maps": _maps(result, result.computed.maps),
        "maps_of": others,
    }


def _overlays(
    result: FittedResult, models: Mapping[str, Any], folder: Path, only: tuple[str, str] | None = None
) -> list[dict[str, Any]]:
    """Measured and predicted signals, written as curves; `only` is the record and the channel wanted."""
    overlays = []
    for number, curve in enumerate(curves(result.problem, models, only)):
        series = {"time": curve.time, "measured": curve.measured, **curve.predicted}
        series |= {f"residual:{name}": values for name, values in curve.residuals.items()}
        series |= {f"motion:{name}": values for name, (values, _) in curve.motion.items()}
        overlays.append(
            {
                **write_curves(folder, number, series),
                **attributes(curve, "record", "role", "channel", "unit", "noise"),
                "begins": float(curve.time[np.argmax(np.isfinite(curve.measured))]),
                **attributes(curve, "largest", "usual"),
                "models": list(models),
                "motion": {name: unit for name, (_, unit) in curve.motion.items()},
            }
        )
    return overlays


def _maps(result: FittedResult, maps: Sequence[Any]) -> list[dict[str, Any]]:
    """Residual over each coordinate, in standard deviations of the noise; empty cells as None."""
    found = []
    for m in drawn_maps(maps, MOST_MAPS):
        values = attributes(m, "centres", "forward", "backward", "forward_error", "backward_error")
        cells = {name: array.tolist() for name, array in values.items()}
        # A cell that no sample fell into holds an exact zero.
        cells |= {side: [value or None for value in cells[side]] for side in ("forward", "backward")}
        place = {"coordinate": m.coordinate, "unit": coordinate_unit(result.problem, m.coordinate)}
        found.append({**place, **attributes(m, "share", "p_value"), **cells})
    return found
