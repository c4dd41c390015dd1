"""The design checks as files: Markdown, JSON, and one HTML page that opens without server or network."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from designcalc.checks.analysis import report
from stagecad import __version__
from stagecad.parameters.atomic import atomic_write_text
from workbench.operations.result import finite
from workbench.report.html import embedded, render

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from designcalc.checks.subjects import Studies
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses


def write_check_files(
    checks: Sequence[Check],
    design: Design,
    masses: Masses | None,
    folder: Path,
    figures: Mapping[str, Path] | None = None,
) -> None:
    """Write `checks.md`, `checks.json`, `dynamic_budget.json` and `checks.html`."""
    from designcalc.checks.inputs import DesignInputs
    from designcalc.checks.subjects import subjects_of

    subjects, lowest = subjects_of(design), 1 / design.loop.observation
    found = subjects.studies(DesignInputs(design, masses))
    stated = subjects.requirements
    text = report.markdown(checks, found.suspensions, found.budgets, found.dynamic, lowest, stated)
    atomic_write_text(folder / "checks.md", text)
    dynamic = finite(report.dynamic_document(found.dynamic, lowest))
    atomic_write_text(folder / "dynamic_budget.json", json.dumps(dynamic, indent=1, allow_nan=False) + "\n")
    document = finite([check.as_json() for check in checks])
    atomic_write_text(folder / "checks.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    atomic_write_text(folder / "checks.html", _page(checks, design, found, stated, figures or {}))


def check_rows(checks: Sequence[Check]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Checks by subject, each with its value, limit and margin as text."""
    rows: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        row = {"check": check, "value": report.shown(check.value, check.unit), "limit": report.shown_limit(check)}
        rows.setdefault(check.subject, []).append({**row, "margin": report.shown_margin(check)})
    return list(rows.items())


def _page(
    checks: Sequence[Check],
    design: Design,
    found: Studies,
    stated: Mapping[str, str],
    figures: Mapping[str, Path],
) -> str:
    return render(
        "checks.html",
        title=design.file,
        counted=report.counted(checks),
        failing=sum(check.verdict == "fails" for check in checks),
        subjects=check_rows(checks),
        requirements=[(name, stated[name], bearing) for name, bearing in report.requirements(checks, stated).items()],
        corrections=report.corrections(checks),
        ranking=report.RANKING,
        suspension_headings=report.SUSPENSION_HEADINGS,
        suspensions=[report.suspension_cells(suspension) for suspension in found.suspensions],
        budgets=[(one, report.budget_cells(one)) for one in found.budgets],
        dynamic_headings=report.DYNAMIC_HEADINGS,
        dynamic=[(one, report.dynamic_cells(one, 1 / design.loop.observation)) for one in found.dynamic],
        observation=report.shown(design.loop.observation, "s"),
        figures=[(name, embedded(path)) for name, path in figures.items()],
        digest=design.digest,
        version=__version__,
    )
