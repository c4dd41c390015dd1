"""The design checks as files: Markdown, JSON, and one HTML page that opens without server or network."""

from __future__ import annotations

import base64
import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from designcalc.checks import report
from stagecad import __version__
from stagecad.parameters.atomic import atomic_write_text
from workbench.operations.result import finite

if TYPE_CHECKING:
    from jinja2 import Template

    from designcalc.checks.check import Check
    from designcalc.checks.run import Studies
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses


def render(template: str, **values: Any) -> str:
    """A page from a packaged template; an unknown name in the template is an error."""
    return compiled(template).render(**values)


@cache
def compiled(template: str) -> Template:
    """A packaged template; compiling it takes longer than to fill it in."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("workbench"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template)


@cache
def templates_digest() -> str:
    """Sha256 of the packaged templates of pages."""
    digest = hashlib.sha256()
    for path in sorted((Path(__file__).resolve().parents[1] / "templates").glob("*.html")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def data_url(png: bytes) -> str:
    """A PNG as an address that contains it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def embedded(path: Path) -> str:
    """A PNG file as an address that contains it."""
    return data_url(path.read_bytes())


def link(file: Path, page: Path) -> dict[str, str]:
    """Name and relative address of a file for a page."""
    return {"name": file.name, "href": Path(os.path.relpath(file, page.parent)).as_posix()}


def write_check_files(
    checks: Sequence[Check],
    design: Design,
    masses: Masses | None,
    folder: Path,
    figures: Mapping[str, Path] | None = None,
) -> None:
    """Write `checks.md`, `checks.json`, `dynamic_budget.json` and `checks.html`."""
    from designcalc.checks.check import DesignInputs
    from designcalc.checks.run import subjects_of

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
    checks: Sequence[Check], design: Design, found: Studies, stated: Mapping[str, str], figures: Mapping[str, Path]
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
