"""One HTML report per experiment, from the sections that `compare`, `diagnose`, `suggest` and `ladder` made so far.

A section is plain data: every command keeps its own as a JSON file below `OUT/NAME/sections/` and composes the report
again from all of them: one for each command and model, in the order they were first made. Sections made on other
records are left out. The page opens without a server or a network.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from workbench.operations.result import finite
from workbench.report.html import render

SCHEMA = 5
WIDTH = 9.6
"""Inches of a figure of the report."""

Section = dict[str, Any]


def report_folder(out: Path, name: str) -> Path:
    """Folder of the report of the experiment called `name`."""
    return out / (re.sub(r"[^\w.-]", "_", name) or "experiment")


def keep_section(out: Path, name: str, section: Section) -> Path:
    """Write a section, and its figures as SVG, below `out`; then the report with all sections, which is returned."""
    folder = report_folder(out, name)
    command = section["kind"]
    for k, overlay in enumerate(section.get("overlays", ())):
        file = "overlay" if k == 0 else f"overlay_{overlay['channel'].replace(' ', '_')}"
        atomic_write_text(folder / f"{command}_{file}.svg", overlay["figure"])
    if section.get("maps"):
        atomic_write_text(folder / f"{command}_where.svg", section["maps"])
    sections = _read(folder)
    key = section_key(section)
    numbers = {section_key(s): s["number_in_report"] for s in sections}
    section["number_in_report"] = numbers.get(key, 1 + max(numbers.values(), default=0))
    section["schema"] = SCHEMA
    text = json.dumps(finite(section), indent=1, ensure_ascii=False, allow_nan=False)
    atomic_write_text(folder / "sections" / f"{key}.json", text + "\n")
    report = folder / "report.html"
    others = [s for s in sections if section_key(s) != key]
    atomic_write_text(report, report_html(folder.name, ordered_sections([*others, section])))
    return report


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
            section = json.loads(path.read_text(encoding="utf-8"))
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


def report_html(name: str, sections: Sequence[Section]) -> str:
    """The report as one self-contained page."""
    about = next((s for s in reversed(sections) if "rig" in s), None)
    newest = max((s["number_in_report"] for s in sections if s["kind"] != "ladder"), default=0)
    return render("identification.html", name=name, sections=sections, about=about, newest=newest)
