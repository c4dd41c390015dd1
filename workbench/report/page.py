"""One HTML report per experiment, from the results of `compare`, `diagnose`, `suggest` and `ladder` so far.

Every command keeps its own section as a JSON file below `OUT/NAME/sections/` and composes the report again from all
sections: one for each command and model, in the order they were first made. Sections made on other records are left
out. The page opens without a server or a network.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.estimation.bootstrap import Bootstrap
from sysid.experiment_design.t_optimal_design import Suggestion, columns_of
from sysid.prediction.problem import Problem
from sysid.report import suggestion_json
from workbench.cli.options import Run
from workbench.operations.result import finite
from workbench.report.figures import bootstrap_figure
from workbench.report.html import render
from workbench.report.sections import (
    Section,
    comparison_section,
    diagnosis_section,
    ladder_section,
    suggestion_section,
)
from workbench.simulation.figures import save_figure

SCHEMA = 5


def write_comparison(run: Run, comparison: Comparison, document: Mapping[str, Any]) -> Path:
    """Figures and report of a comparison below `run.out`; returns the file to open."""
    folder = report_folder(run, comparison.problem.experiment.folder.name)
    section = comparison_section(comparison, document)
    _figures(folder, "compare", section)
    return _keep(folder, section)


def write_diagnosis(run: Run, diagnosis: Diagnosis, document: Mapping[str, Any]) -> Path:
    """Figures and report of a diagnosis below `run.out`; returns the file to open."""
    folder = report_folder(run, diagnosis.problem.experiment.folder.name)
    section = diagnosis_section(diagnosis, document)
    _figures(folder, "diagnose", section)
    return _keep(folder, section)


def write_ladder(run: Run, name: str, rungs: Sequence[Mapping[str, Any]]) -> Path:
    """Figure (`ladder.png`, `ladder.svg`) and report of a ladder below `run.out`; returns the file to open."""
    folder = report_folder(run, name)
    section = ladder_section(rungs, folder / "ladder.png")
    atomic_write_text(folder / "ladder.svg", section["figure"])
    return _keep(folder, section)


def write_bootstrap(run: Run, problem: Problem, drawn: Bootstrap, document: Mapping[str, Any]) -> Path:
    """Figure of the intervals by refitting below `run.out`."""
    return save_figure(
        bootstrap_figure(drawn, document), report_folder(run, problem.experiment.folder.name) / "compare_bootstrap.png"
    )


def write_suggestion(run: Run, found: Suggestion, motions: Sequence[Mapping[str, Any]]) -> Path:
    """Section of a suggestion below `run.out`, `motions` is its document; returns the file to open."""
    return _keep(report_folder(run, found.problem.experiment.folder.name), suggestion_section(found, motions))


def write_motions(run: Run, found: Suggestion) -> list[dict[str, Any]]:
    """Write every motion as a CSV file below `run.out`; returns the document of `suggest`."""
    return suggestion_json(
        found, motion_files(found, report_folder(run, found.problem.experiment.folder.name) / "suggest")
    )


def motion_files(found: Suggestion, folder: Path) -> list[str]:
    """Write every motion as a CSV file into a folder; returns the files."""
    import pandas as pd

    files = []
    for value in found.motions:
        path = folder / (re.sub(r"\W+", "_", value.motion.name) + ".csv")
        table = pd.DataFrame(columns_of(found.problem, value.motion))
        atomic_write_text(path, table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))
        files.append(str(path))
    return files


def report_folder(run: Run, name: str) -> Path:
    """Folder of the report of the experiment called `name`."""
    return run.out / (re.sub(r"[^\w.-]", "_", name) or "experiment")


def _figures(folder: Path, command: str, section: Section) -> None:
    for k, overlay in enumerate(section["overlays"]):
        name = "overlay" if k == 0 else f"overlay_{overlay['channel'].replace(' ', '_')}"
        atomic_write_text(folder / f"{command}_{name}.svg", overlay["figure"])
    if section["maps"]:
        atomic_write_text(folder / f"{command}_where.svg", section["maps"])


def _keep(folder: Path, section: Section) -> Path:
    """Write a section into its folder, then the report with all sections."""
    sections = _read(folder)
    key = section_key(section)
    numbers = {section_key(s): s["number_in_report"] for s in sections}
    section["number_in_report"] = numbers.get(key, 1 + max(numbers.values(), default=0))
    section["schema"] = SCHEMA
    text = json.dumps(finite(section), indent=1, ensure_ascii=False, allow_nan=False)
    atomic_write_text(folder / "sections" / f"{key}.json", text + "\n")
    report = folder / "report.html"
    atomic_write_text(
        report, report_html(folder.name, ordered_sections([*(s for s in sections if section_key(s) != key), section]))
    )
    return report


def section_key(section: Section) -> str:
    """Name of a section's file: the command, and a short hash of the model; there is one ladder only."""
    if section["kind"] == "ladder":
        return "ladder"
    model = "+".join(section["effects"])
    return f"{section['kind']}-{hashlib.sha256(model.encode()).hexdigest()[:10]}"


def _read(folder: Path) -> list[Section]:
    found = []
    for path in sorted((folder / "sections").glob("*.json")):
        try:
            section = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            # The next run of its command writes it again.
            continue
        if isinstance(section, dict) and section.get("schema") == SCHEMA:
            found.append(section)
    return found


def ordered_sections(sections: Sequence[Section]) -> list[Section]:
    """Sections that belong together, in the order they were made: those on the newest one's records, the ladder first.

    The last of `sections` is the newest.
    """
    records = next((s["records"] for s in reversed(sections) if "records" in s), None)
    kept = [s for s in sections if s.get("records", records) == records]
    return sorted(kept, key=lambda s: (s["kind"] != "ladder", s["number_in_report"]))


def report_html(name: str, sections: Sequence[Section]) -> str:
    """The report as one self-contained page."""
    about = next((s for s in reversed(sections) if "rig" in s), None)
    newest = max((s["number_in_report"] for s in sections if s["kind"] != "ladder"), default=0)
    return render("identification.html", name=name, sections=sections, about=about, newest=newest)
