"""The design checks as files: Markdown, JSON, and one HTML page that opens without server or network."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stagecad import __version__
from stagecad.parameters.atomic import atomic_write_text
from workbench.options import finite

if TYPE_CHECKING:
    from designcalc.checks import Check
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses


def write_check_files(
    checks: Sequence[Check],
    design: Design,
    masses: BodyMasses | None,
    folder: Path,
    figures: Mapping[str, Path] | None = None,
) -> None:
    """Write `checks.md`, `checks.json` and `checks.html`.

    Args:
        checks: every check, in the order of the report.
        design: what was checked; suspensions and error budgets are worked out on it.
        masses: what its solids weigh, or None.
        folder: where to.
        figures: PNG by title, to be put into the page.
    """
    from designcalc.checks.alternatives import ranking
    from designcalc.checks.analysis.report import markdown
    from designcalc.checks.budget import budgets
    from designcalc.machine.inputs import DesignInputs

    ranked = ranking(DesignInputs(design, masses))
    found = budgets(DesignInputs(design, masses))
    atomic_write_text(folder / "checks.md", markdown(checks, ranked, found))
    document = finite([check.as_json() for check in checks])
    atomic_write_text(folder / "checks.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    atomic_write_text(folder / "checks.html", _page(checks, design, ranked, found, figures or {}))


def _page(checks, design, ranked, found, figures) -> str:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from designcalc.checks.analysis import report

    environment = Environment(
        loader=PackageLoader("workbench"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    rows = [
        {
            "check": check,
            "value": report.shown(check.value, check.unit),
            "limit": report.shown_limit(check),
            "margin": report.shown_margin(check),
        }
        for check in checks
    ]
    subjects = list(dict.fromkeys(check.subject for check in checks))
    return environment.get_template("checks.html").render(
        title=design.file,
        counted=report.counted(checks),
        failing=sum(check.verdict == "fails" for check in checks),
        subjects=[(subject, [row for row in rows if row["check"].subject == subject]) for subject in subjects],
        requirements=[
            (name, report.REQUIREMENTS[name], bearing) for name, bearing in report.requirements(checks).items()
        ],
        corrections=report.corrections(checks),
        ranking=report.RANKING,
        candidate_headings=report.CANDIDATE_HEADINGS,
        candidates=[report.candidate_cells(candidate) for candidate in ranked],
        budgets=[(one, report.budget_cells(one)) for one in found],
        figures=[(name, _embedded(path)) for name, path in figures.items()],
        digest=design.digest,
        version=__version__,
    )


def _embedded(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
