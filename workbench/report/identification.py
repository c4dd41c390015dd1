"""One HTML report per experiment, from the results of `compare`, `diagnose`, `suggest` and `ladder` so far.

A section is plain data: every command keeps its own as a JSON file below `OUT/NAME/sections/` and composes the report
again from all of them: one for each command and model, in the order they were first made. Sections made on other
records are left out. The page opens without a server or a network.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from stagecad import __version__
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.input_file import read_input
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.documents import worst_channel
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from workbench.figures import identification as figures
from workbench.figures.curves import curve_of, worst_record
from workbench.figures.plot import save_figures
from workbench.operations.measurement import statements, tables
from workbench.operations.measurement.add import Addition, Ladder, Restoration, ladder
from workbench.operations.measurement.compare import Comparison
from workbench.operations.measurement.diagnose import Diagnosis
from workbench.operations.measurement.experiment import noise_text
from workbench.operations.measurement.suggest import Suggestion
from workbench.operations.result import Reported, json_text, render

SCHEMA = 7
REPORT = "report.html"
"""Name of the report in its folder."""
WIDTH = 8.4
"""Inches of a figure of the report."""
MOST_CORRELATED = 14
"""Parameters up to which the matrix of correlations is shown."""
PRESENT = "present"
"""File of what is stated now, beside the sections."""
MOST_RECORDS = 6
"""Records whose channels are drawn as logged."""
MOST_OVERLAYS = 3
"""Channels of which an overlay is drawn."""
STATES = {"missing-effect": "found", "adequate": "good"}
"""State of the section of a diagnosis by its verdict; `bad` otherwise."""

Section = dict[str, Any]


def write_report(result: Reported, out: Path) -> Path:
    """Write the section of a result, and its figures, below the folder `out`; then the report, which is returned."""
    folder, stated = result.experiment.results_in(out), result.experiment.stated
    # The model as it stands now, which sections of other models do not have.
    atomic_write_text(folder / "sections" / PRESENT, json.dumps({"text": stated.text, "effects": list(stated.effects)}))
    if isinstance(result, Addition | Restoration):
        return refresh_ladder(folder, ladder(result.experiment))
    if isinstance(result, Ladder):
        return write_ladder(folder, result)
    if isinstance(result, Suggestion):
        return keep_section(folder, suggestion_section(result))
    assert isinstance(result, Comparison | Diagnosis)
    section = comparison_section(result) if isinstance(result, Comparison) else diagnosis_section(result)
    for k, overlay in enumerate(section["overlays"]):
        file = "overlay" if k == 0 else f"overlay_{overlay['channel'].replace(' ', '_')}"
        atomic_write_text(folder / f"{section['kind']}_{file}.svg", overlay["figure"])
    if section["maps"]:
        atomic_write_text(folder / f"{section['kind']}_where.svg", section["maps"])
    if isinstance(result, Diagnosis):
        refresh_ladder(folder, ladder(result.experiment))
    return keep_section(folder, section)


def write_ladder(folder: Path, rungs: Ladder) -> Path:
    """Figure (`ladder.png`, `ladder.svg`) and section of a ladder; returns the report."""
    figure = rungs.plot()
    save_figures(folder, {"ladder": figure})
    section = ladder_section(rungs, figure.svg("ladder"))
    atomic_write_text(folder / "ladder.svg", section["figure"])
    return keep_section(folder, section)


def refresh_ladder(folder: Path, rungs: Ladder) -> Path:
    """Bring the ladder of the report to its present rungs; without one above the first it is left out."""
    stored = next((section for section in _read(folder) if section["kind"] == "ladder"), None)
    if len(rungs.rungs) > 1:
        table = json.loads(json.dumps(tables.ladder_table(rungs.rungs).as_json()))
        return folder / REPORT if stored and stored["rungs"] == table else write_ladder(folder, rungs)
    if stored is not None:
        (folder / "sections" / "ladder.json").unlink()
        _compose(folder, _read(folder))
    return folder / REPORT


def comparison_section(comparison: Comparison) -> Section:
    """Result of `compare`."""
    computed, model = comparison.computed, comparison.fitted.model
    return {
        **_fitted(comparison.problem, model, comparison.document, "Parameters"),
        **_figures(comparison.problem, {"model": model}, computed.validate, computed.maps),
        "summary": statements.summary_sentence(comparison.document["before"]),
        "kind": "compare",
        "title": "The model as it stands",
        "state": "good" if comparison.adequate else "bad",
        "number": tables.over_noise_text(statements.held_out_over_noise(computed.fit, computed.validate)),
        "headline": comparison.statement,
        "whiteness": tables.correlation_table(comparison.document).as_json(),
    }


def diagnosis_section(diagnosis: Diagnosis) -> Section:
    """Result of `diagnose`."""
    computed, document = diagnosis.computed, diagnosis.document
    problem, best, effect = diagnosis.problem, computed.best, diagnosis.effect
    before = statements.held_out_over_noise(computed.before_fit, computed.before_validate)
    parameters = f"Parameters of the model {f'with {effect}' if effect else 'as it stands'}"
    after = None if best is None else document["after"]
    names = ("name", "meaning", "equation", "shows", "source")
    sizes = document["detectable"] if statements.near_noise(computed) else []
    return {
        **_fitted(problem, computed.base.fitted.model, document, parameters, after),
        **_figures(problem, diagnosis.drawn_models, computed.before_validate, computed.maps),
        "summary": statements.summary_sentence(document["before"], f"{diagnosis.title}."),
        "kind": "diagnose",
        "title": diagnosis.title,
        "state": STATES.get(diagnosis.verdict, "bad"),
        "number": tables.over_noise_text(before),
        "verdict": diagnosis.verdict,
        "headline": diagnosis.statement,
        "next_step": statements.next_step_statement(computed),
        "equivalent": diagnosis.ties,
        "ranking": tables.ranking_table(document["ranking"], len(computed.trials), before).as_json(),
        "detectable": tables.detectable_table(sizes).as_json(),
        "effect": None if best is None else {name: getattr(best.effect, name) for name in names},
        "remarks": diagnosis.changes,
    }


def ladder_section(grown: Ladder, figure: str) -> Section:
    """The ladder so far."""
    last, steps = grown.rungs[-1], len(grown.rungs) - 1
    first, now = (
        max(tables.worst_over_noise(r["before"].get(part, {})) for part in tables.PARTS) for r in (grown.rungs[0], last)
    )
    count = "one step" if steps == 1 else f"{steps} steps"
    return {
        "summary": statements.summary_sentence(last["before"]),
        "kind": "ladder",
        "title": "The ladder",
        "effects": list(last["effects"]),
        "state": "good" if now <= statements.NEAR_NOISE else "found",
        "number": tables.over_noise_text(now),
        "headline": f"From {tables.over_noise_text(first)} the noise to {tables.over_noise_text(now)}, in {count}.",
        "figure": figure,
        "rungs": tables.ladder_table(grown.rungs).as_json(),
        "parameters": tables.parameter_table(last.get("parameters", {})).as_json(),
    }


def suggestion_section(suggestion: Suggestion) -> Section:
    """Result of `suggest`."""
    computed = suggestion.computed
    best, title = computed.motions[0], "What to measure next"
    if len(computed.competing) > 1:
        pairs = [p for p in best.pairs if p.effects[1] not in computed.inseparable and p.records < statements.SEPARATED]
        title += f": {best.motion.name if pairs else 'nothing is left to separate'}"
    return {
        "kind": "suggest",
        "title": title,
        "effects": [e.name for e in computed.problem.start.effects],
        "records": {record.name: record.sha256 for record in computed.problem.records},
        "state": "good" if computed.diagnosis.verdict == "adequate" else "found",
        "number": f"{best.least:.3g} σ" if best.least > 0.0 else "–",
        "headline": " ".join(line[0].upper() + line[1:].rstrip(".") + "." for line in suggestion.statements),
        "motions": tables.motion_table(suggestion.to_json()).as_json(),
    }


def _fitted(problem: Problem, model: Model, document: Mapping[str, Any], title: str, after: Any = None) -> Section:
    """Experiment, errors and parameters of a document of `compare` or `diagnose`; `title` is that of the parameters."""
    names, matrix = document["correlation"]["keys"], document["correlation"]["matrix"]
    shown = 1 < len(names) <= MOST_CORRELATED
    return {
        "effects": [e.name for e in model.effects],
        "records": {record.name: record.sha256 for record in problem.records},
        "rig": _rig_text(problem),
        "record_list": [
            f"{r.name} ({'fit' if r.role == 'fit' else 'held out'}): {r.size} rows in {r.time[-1] - r.time[0]:.4g} s, "
            f"sha256 {r.sha256[:12]}"
            for r in problem.records
        ],
        "noise": noise_text(problem),
        "channels": figures.records_figure(problem.records[:MOST_RECORDS], faults=True).svg("channels as logged"),
        "text": problem.experiment.text,
        "notes": list(problem.notes),
        "warnings": list(document["warnings"]),
        "errors": tables.error_table("", document["before"], after).as_json(),
        "simulation": tables.simulation_table(document).as_json(),
        "where": tables.dependence_table(document["where"]).as_json(),
        "parameters": tables.parameter_table(document["parameters"], title).as_json(),
        "not_identifiable": document["not_identifiable"],
        "correlation": {"names": names, "cells": matrix} if shown else None,
        "seconds": document["seconds"],
    }


def _rig_text(problem: Problem) -> str:
    rig = problem.experiment.rig
    known = []
    for name, quantity in rig.known.items():
        unit = rig.declaration.known[name].si_unit(rig.rotary)
        known.append(f"{name.replace('_', ' ')} {tables.quantity_text(quantity.value, unit)}")
    return f"{rig.kind}" + (", rotary" if rig.rotary else "") + (f": {', '.join(known)}" if known else "")


def _figures(
    problem: Problem, models: Mapping[str, Model], by_channel: Mapping[str, Any], maps: Sequence[ResidualMap]
) -> Section:
    """Overlays of the worst channel on the worst held-out record and of other channels there, and residual maps."""
    records = problem.validate_records or problem.fit_records
    worst, first = worst_channel(problem, by_channel), next(iter(models.values()))
    overlays = []
    for channel in [worst, *(c for c in records[0].measured if c != worst)][:MOST_OVERLAYS]:
        curve = curve_of(problem, worst_record(records, channel, first), channel, models)
        of = f"{curve.record} {curve.channel}"
        overlays.append(
            {
                "channel": curve.words,
                "figure": figures.overlay_figure(curve, WIDTH).svg(f"overlay {of}"),
                "loops": figures.loops_figure(curve, WIDTH).svg(f"loops {of}") if curve.motion else "",
            }
        )
    try:
        drawn = figures.maps_figure(maps, problem, WIDTH).svg("maps " + " ".join(m.coordinate for m in maps))
    except InputError:
        drawn = ""
    return {"overlays": overlays, "maps": drawn}


def keep_section(folder: Path, section: Section) -> Path:
    """Write a section into its folder, then the report with all sections."""
    sections = _read(folder)
    key = section_key(section)
    numbers = {section_key(s): s["number_in_report"] for s in sections}
    section["number_in_report"] = numbers.get(key, 1 + max(numbers.values(), default=0))
    section["schema"] = SCHEMA
    atomic_write_text(folder / "sections" / f"{key}.json", json_text(section, 1, ensure_ascii=False) + "\n")
    return _compose(folder, [*(s for s in sections if section_key(s) != key), section])


def _compose(folder: Path, sections: Sequence[Section]) -> Path:
    """Write the report of sections, the newest last."""
    now = json.loads((folder / "sections" / PRESENT).read_text("utf-8"))
    atomic_write_text(folder / REPORT, report_html(folder.name, ordered_sections(sections), now))
    return folder / REPORT


def section_key(section: Section) -> str:
    """Name of a section's file: the command, and a short hash of the model; there is one ladder only."""
    if section["kind"] == "ladder":
        return "ladder"
    model = "+".join(section["effects"])
    return f"{section['kind']}-{hashlib.sha256(model.encode()).hexdigest()[:10]}"


def _read(folder: Path) -> list[Section]:
    sections = []
    for path in sorted((folder / "sections").glob("*.json")):
        try:
            section = json.loads(read_input(path))
        except (OSError, ValueError):
            # The next run of its command writes it again.
            continue
        if isinstance(section, dict) and section.get("schema") == SCHEMA:
            sections.append(section)
    return sections


def ordered_sections(sections: Sequence[Section]) -> list[Section]:
    """Sections that belong together, in the order they were made: those on the newest one's records, the ladder first.

    The last of `sections` is the newest.
    """
    records = next((s["records"] for s in reversed(sections) if "records" in s), None)
    kept = [s for s in sections if s.get("records", records) == records]
    return sorted(kept, key=lambda s: (s["kind"] != "ladder", s["number_in_report"]))


def report_html(name: str, sections: Sequence[Section], now: Mapping[str, Any]) -> str:
    """The report as one self-contained page; `now` is the text of the experiment and its effects."""
    about = next((s | {"text": now["text"]} for s in reversed(sections) if "rig" in s), None)
    newest = max((s["number_in_report"] for s in sections if s["kind"] != "ladder"), default=0)
    made = f"stagecad {__version__}, {date.today().isoformat()}"
    values = {"sections": sections, "about": about, "newest": newest, "made": made}
    return render("identification.html", name=name, summary=summary_of(sections, now["effects"]), **values)


def summary_of(sections: Sequence[Section], model: Sequence[str]) -> str:
    """The sentence of the present model: that of its diagnosis, of the ladder, or of another section on it."""
    # The law of a name is that of the rig where the file names none.
    names = [name.partition(":")[0] for name in model]
    told = [s for s in sections if s.get("summary") and [e.partition(":")[0] for e in s["effects"]] == names]
    return next((s["summary"] for s in sorted(told, key=lambda s: s["kind"] != "diagnose")), "")
