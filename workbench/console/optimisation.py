"""The outcome of an optimisation in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.markup import escape

from designcalc.checks.analysis.report import counted, shown, shown_margin
from workbench.cli.console import plain_table
from workbench.cli.options import Run
from workbench.machine.levels import level_rows, never_met, price_rows

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.optimise import Outcome
    from designcalc.optimisation.reached_levels import Levels


def print_outcome(run: Run, outcome: Outcome, evaluator: Evaluator, after: Sequence[Check] | None) -> None:
    """Changes with reasons and margins before and after; conflicts and what to relax."""
    if run.json_target is not None:
        return
    if outcome.interrupted:
        run.echo("stopped; the best design so far:")
    if not outcome.complete:
        run.echo(f"the search ended after {outcome.evaluations} designs; more --evaluations or --time may find more")
    if not outcome.feasible:
        run.echo(f"no design within the ranges meets all {len(outcome.required)} requirements")
        _print_conflicts(run, outcome)
    if after is None:
        run.echo("no change is needed" if outcome.feasible else "no design was found")
        return
    table = plain_table("changes", "parameter", "from", "to", "reason", left=("parameter", "reason"))
    for change in outcome.changes:
        table.add_row(change.key, change.before, change.after, escape(change.reason))
    run.console.print(table)
    margins = plain_table("margins that change", "check", "before", "after", "verdict", left=("check", "verdict"))
    new = {check.name: check for check in after}
    for check in evaluator.checks:
        other = new.get(check.name)
        if other is None or (other.margin == check.margin and other.verdict == check.verdict):
            continue
        verdict = other.verdict if other.verdict == check.verdict else f"{check.verdict} -> {other.verdict}"
        margins.add_row(check.name, shown_margin(check), shown_margin(other), verdict)
    run.console.print(margins)
    run.echo(f"before: {counted(evaluator.checks)}; after: {counted(after)}; {outcome.evaluations} designs evaluated")


def _print_conflicts(run: Run, outcome: Outcome) -> None:
    certain = [conflict.names[0] for conflict in outcome.conflicts if conflict.fixed]
    if certain:
        run.echo(f"\nThese checks read no free parameter, so they fail in every design ({len(certain)}):")
        for name in certain:
            run.echo(f"- {name}")
    if outcome.left_out:
        run.echo(f"\nLeft out, since the best compromise fails them ({len(outcome.left_out)}):")
        for name in outcome.left_out:
            run.echo(f"- {name}")
    columns = ("requirement", "limit", "reached", "margin", "together with")
    table = plain_table("what cannot be met", *columns, left=("requirement", "together with"))
    for one in outcome.relax:
        if one.name in certain:
            continue
        table.add_row(
            one.name,
            shown(one.limit, one.unit),
            shown(one.needed, one.unit),
            f"{100 * one.margin:+.3g} %",
            "; ".join(one.keeping) or "(by itself)",
        )
    if table.row_count:
        run.console.print(table)


def print_levels(run: Run, levels: Levels) -> None:
    """Levels of Table 1 that can be met, and what its values make fail."""
    if run.json_target is not None:
        return
    headings, rows = level_rows(levels)
    table = plain_table("levels that can be met", *headings, left=("requirement",))
    for row in rows:
        table.add_row(*row)
    run.console.print(table)
    for line in never_met(levels):
        run.echo(f"met at no level: {line}")
    if levels.prices:
        columns = ("requirement", "check", "value", "limit")
        prices = plain_table("what the values of Table 1 make fail", *columns, left=("requirement", "check"))
        for row in price_rows(levels):
            prices.add_row(*row)
        run.console.print(prices)
    run.echo(f"{levels.evaluations} designs evaluated")
