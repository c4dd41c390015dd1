"""The improved stage of the examples: its rules, the margins of its report, its solids and sheets."""

import json
import re
from pathlib import Path

import pytest

from designcalc.checks.analysis.report import counted, shown_margin
from designcalc.checks.run import run_checks
from stagecad.parameters.load import load_design
from stagecad.parameters.rules.registry import violations
from workbench.cli import run as stagecad

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "improved_stage"


def _table(title: str) -> list[list[str]]:
    """Rows of a table of the report."""
    text = (FOLDER / "stage.md").read_text("utf-8").partition(f"## {title}\n")[2].partition("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith("| ")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_it_violates_no_rule_and_has_the_changes_of_its_report() -> None:
    design, start = load_design(FOLDER / "stage.toml"), load_design(FOLDER / "start.toml")
    assert violations(design) == []
    changes = _table("Changes")
    assert len(changes) >= 15
    changed = {entry.key for entry in design.entries if entry.value != start.value(entry.key) and not entry.formula}
    assert {row[0] for row in changes} == {key for key in changed if "computed" not in design.entry(key).origin}
    for key, before, after, reason in changes:
        origin = design.entry(key).origin
        assert origin == f"assumed: optimised from {before}: {reason}", (key, after)


def test_the_page_states_the_numbers_of_its_report() -> None:
    text = " ".join((ROOT / "docs" / "design_changes.md").read_text("utf-8").split())
    counts = re.search(
        r"Before: \d+ pass, (\d+) fail. After: \d+ pass, (\d+) fail", (FOLDER / "stage.md").read_text("utf-8")
    )
    assert counts is not None
    before, after = counts.groups()
    stated = f"{len(_table('Changes'))} changes with their reasons, and {after} failed checks instead of {before}"
    assert stated in text


def test_margins_that_do_not_depend_on_masses_are_those_of_the_report() -> None:
    design = load_design(FOLDER / "stage.toml")
    reported = {row[0]: row[2] for row in _table("Margins before and after")}
    checks = {check.name: check for check in run_checks(design)}
    assert checks.keys() == reported.keys()
    # Without solids the masses of stage and tip are estimated.
    free = [one for one in checks.values() if not any("estimated" in item.origin for item in one.inputs.values())]
    free = [one for one in free if "tip.mass_limit" not in one.inputs]
    assert len(free) > 40
    assert {one.name: shown_margin(one) for one in free} == {one.name: reported[one.name] for one in free}


@pytest.mark.slow
def test_margins_with_the_masses_of_its_solids_are_those_of_the_report() -> None:
    from stagecad.solids.assembly.built_machine import body_masses

    for file, column in (("start.toml", 1), ("stage.toml", 2)):
        design = load_design(FOLDER / file)
        checks = run_checks(design, body_masses(design))
        reported = {row[0]: row[column] for row in _table("Margins before and after")}
        assert {check.name: shown_margin(check) for check in checks} == reported
        assert counted(checks) in (FOLDER / "stage.md").read_text("utf-8")


@pytest.mark.slow
def test_it_is_built_and_its_sheets_have_no_lint_hits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert stagecad(["parts", "--params", str(FOLDER / "stage.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["moving_body"]["mass"]["value"] > 2
    assert stagecad(["drawings", "--params", str(FOLDER / "stage.toml"), "--lint", "--json"]) == 0
    assert not any(sheet["hits"] for sheet in json.loads(capsys.readouterr().out)["sheets"].values())
