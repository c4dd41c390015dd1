"""Report of an optimisation as Markdown: changes with reasons, what is not met and why, margins before and after."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from designcalc.checks.analysis.report import counted, shown, shown_margin

if TYPE_CHECKING:
    from designcalc.checks import Check
    from designcalc.optimisation.optimise import Outcome


def optimisation_report(outcome: Outcome, before: Sequence[Check], after: Sequence[Check] | None, name: str) -> str:
    """The report.

    Args:
        outcome: of the optimisation.
        before: checks of the design it began with.
        after: checks of the design found; None without one.
        name: of the file it began with.
    """
    lines = [f"# Optimisation of {name}", ""]
    lines.append(f"{outcome.evaluations} designs evaluated. Before: {counted(before)}.")
    if after is not None:
        lines[-1] += f" After: {counted(after)}."
    if outcome.changes:
        lines += ["", "## Changes", ""]
        rows = [(change.key, change.before, change.after, change.reason) for change in outcome.changes]
        lines += _table(("parameter", "from", "to", "reason"), rows)
    lines += _not_met(outcome)
    if after is not None:
        lines += ["", "## Margins before and after", ""]
        new = {check.name: check for check in after}
        rows = [
            (check.name, shown_margin(check), shown_margin(new[check.name]), new[check.name].verdict.replace("_", " "))
            for check in before
            if check.name in new
        ]
        lines += _table(("check", "before", "after", "verdict"), rows)
    return "\n".join(lines) + "\n"


def _not_met(outcome: Outcome) -> list[str]:
    rows: list[tuple[str, str, str, str]] = []
    reached = {(one.name, one.keeping): one for one in outcome.relax}
    for conflict in outcome.conflicts:
        for member in conflict.names:
            others = tuple(other for other in conflict.names if other != member)
            one = reached.get((member, others))
            why = "reads no free parameter" if conflict.fixed else "; ".join(others) or "none: not met by itself"
            limit, best = ("", "") if one is None else (shown(one.limit, one.unit), shown(one.needed, one.unit))
            rows.append((member, limit, best, why))
    rows += [(name, "", "", "left out of the best compromise") for name in outcome.left_out]
    if not rows:
        return []
    return ["", "## Not met", "", *_table(("requirement", "limit", "best reached", "together with"), rows)]


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    cells = [headings, ["---"] * len(headings), *rows]
    return ["| " + " | ".join(text.replace("|", "\\|") for text in row) + " |" for row in cells]
