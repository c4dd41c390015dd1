"""Report of an optimisation as Markdown: changes with reasons, what is not met and why, margins before and after."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from designcalc.checks.analysis.report import counted, shown, shown_limit, shown_margin
from workbench.machine.levels import level_rows, never_met, price_rows

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from designcalc.optimisation.optimise import Outcome
    from designcalc.optimisation.reached_levels import Levels


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
    lines += _not_met(outcome, after if after is not None else before)
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


def _not_met(outcome: Outcome, checks: Sequence[Check]) -> list[str]:
    """Table of the requirements that are not met: the best value reached with the others of their conflict satisfied,
    or else the value in the design of `checks`."""
    rows: list[tuple[str, str, str, str]] = []
    present = {check.name: check for check in checks}
    reached = {(one.name, one.keeping): one for one in outcome.relax}

    def add(name: str, why: str, others: tuple[str, ...] = ()) -> None:
        check, relaxed = present[name], reached.get((name, others))
        value = check.value if relaxed is None else relaxed.needed
        rows.append((name, shown_limit(check), shown(value, check.unit), why))

    for conflict in outcome.conflicts:
        for member in conflict.names:
            others = tuple(other for other in conflict.names if other != member)
            why = "reads no free parameter" if conflict.fixed else "; ".join(others) or "none: not met by itself"
            add(member, why, others)
    for name in outcome.left_out:
        add(name, "left out of the best compromise")
    if not rows:
        return []
    return ["", "## Not met", "", *_table(("requirement", "limit", "reached", "together with"), rows)]


def levels_report(levels: Levels, name: str) -> str:
    """The study of Table 1 as Markdown; `name`: of the parameter file."""
    lines = [f"# How far {name} meets Table 1", "", f"{levels.evaluations} designs evaluated.", ""]
    headings, rows = level_rows(levels)
    lines += _table(headings, rows)
    if never := never_met(levels):
        lines += ["", "Met at no level:", "", *(f"- {line}" for line in never)]
    if levels.prices:
        lines += ["", "## What the values of Table 1 make fail", ""]
        lines += _table(("requirement", "check", "value", "limit"), price_rows(levels))
    return "\n".join(lines) + "\n"


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    cells = [headings, ["---"] * len(headings), *rows]
    return ["| " + " | ".join(text.replace("|", "\\|") for text in row) + " |" for row in cells]
