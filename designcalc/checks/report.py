"""The checks as text: one table, each formula with its numbers, and the requirements traced to the checks."""

from __future__ import annotations

import math
from collections.abc import Sequence

from designcalc.checks.candidates import Candidate
from designcalc.checks.check import Check
from stagecad.parameters.quantities import format_quantity

VERDICTS = ("fails", "out_of_range", "undecidable", "passes")
"""Worst first."""


def counted(checks: Sequence[Check]) -> str:
    """`30 pass, 12 fail`, and what else there is."""
    words = {"passes": "pass", "fails": "fail", "out_of_range": "out of range", "undecidable": "undecidable"}
    numbers = {verdict: sum(c.verdict == verdict for c in checks) for verdict in words}
    return ", ".join(f"{n} {words[v]}" for v, n in numbers.items() if n or v in ("passes", "fails"))


def shown(value: float | None, unit: str) -> str:
    """A number of the table; a dash where there is none."""
    return "-" if value is None else format_quantity(value, unit, 4)


def shown_limit(check: Check) -> str:
    """The limit with its sense."""
    if check.limit is None:
        return "-"
    return f"{'at most' if check.at_most else 'at least'} {shown(check.limit, check.unit)}"


def shown_margin(check: Check) -> str:
    """The margin in percent of the limit (as a distance where the limit is zero)."""
    if check.margin is None:
        return "-"
    if check.limit == 0:
        return shown(check.margin, check.unit)
    percent = 100 * check.margin
    return f"{percent:+.0f} %" if abs(percent) < 1e4 else f"{percent:+.1e} %"


def requirements(checks: Sequence[Check]) -> dict[str, list[Check]]:
    """Entries of the thesis's Tables 1 and 2, each with the checks that bear on it."""
    traced: dict[str, list[Check]] = {}
    for check in checks:
        if check.requirement:
            traced.setdefault(check.requirement, []).append(check)
    return dict(sorted(traced.items()))


def corrections(checks: Sequence[Check]) -> list[Check]:
    """Checks that say where the thesis is wrong or differs."""
    return [check for check in checks if check.thesis]


def markdown(checks: Sequence[Check], candidates: Sequence[Candidate] = (), title: str = "Design checks") -> str:
    """Every check as Markdown: summary, requirements, the suspensions ranked, then each check in full, worst first."""
    ordered = sorted(checks, key=lambda c: VERDICTS.index(c.verdict))
    lines = [f"# {title}", "", counted(checks) + ".", ""]
    lines += ["| check | value | limit | margin | verdict |", "| --- | --- | --- | --- | --- |"]
    for check in checks:
        cells = (check.name, shown(check.value, check.unit), shown_limit(check), shown_margin(check), check.verdict)
        lines.append("| " + " | ".join(_cell(text) for text in cells) + " |")
    lines += ["", "## Requirements", "", "| requirement | checks |", "| --- | --- |"]
    for requirement, bearing in requirements(checks).items():
        listed = "; ".join(f"{c.name}: {c.verdict}" for c in bearing)
        lines.append(f"| {_cell(requirement)} | {_cell(listed)} |")
    lines += ["", "## Where the thesis differs", ""]
    lines += [f"- {check.name}: {check.thesis}. {check.substituted}" for check in corrections(checks)]
    if candidates:
        lines += ["", "## Suspensions by rank", "", "| suspension | stiffness | smoothness | stable | why |"]
        lines.append("| --- | --- | --- | --- | --- |")
        for c in candidates:
            smooth = "-" if c.smoothness == math.inf else shown(c.smoothness, "m")
            cells = (c.name, shown(c.stiffness, "N/m"), smooth, "yes" if c.stable else "no", c.why)
            lines.append("| " + " | ".join(_cell(text) for text in cells) + " |")
    lines += ["", "## Each check", ""]
    for check in ordered:
        lines += _in_full(check)
    return "\n".join(lines) + "\n"


def _in_full(check: Check) -> list[str]:
    lines = [f"### {check.name}: {check.verdict}", ""]
    lines.append(f"- value {shown(check.value, check.unit)}, {shown_limit(check)}, margin {shown_margin(check)}")
    for label, words in (
        ("formula", f"`{check.formula}`" if check.formula else ""),
        ("numbers", check.substituted),
        ("source", check.source),
        ("thesis", check.thesis),
        ("proposal", check.proposal),
        ("note", check.note),
    ):
        if words:
            lines.append(f"- {label}: {words}")
    lines += [f"  - {name} = {item.text()} ({item.origin})" for name, item in check.inputs.items()]
    return [*lines, ""]


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
