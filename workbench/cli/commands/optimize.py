"""`stagecad optimize`: the nearest design without violated rules and failed checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options, without_rules

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.optimise import Outcome
    from stagecad.parameters.mass_properties import BodyMasses
    from workbench.machine.optimisation import Effort


@dataclass(frozen=True)
class Options:
    """Options of the command, as given."""

    freed: tuple[str, ...]
    keep: tuple[str, ...]
    target: Path | None
    relax: bool
    budget: int
    evaluations: int
    limit: str | None
    seed: int
    solids: bool
    figures: bool
    scheduler: str | None
    levels: bool


@click.command("optimize")
@click.option(
    "--free",
    "freed",
    multiple=True,
    metavar="KEY=LOW:HIGH",
    help="Let a parameter change within a range, or among choices KEY=A|B, besides those marked free in the file.",
)
@click.option(
    "--keep",
    multiple=True,
    metavar="CHECK",
    help="Require these checks only: a name, a pattern with *, or 'Table 1: speed'.",
)
@click.option("--write", "target", type=click.Path(path_type=Path), metavar="FILE.toml", help="Write the design found.")
@click.option(
    "--relax", is_flag=True, help="Write the design that meets all requirements except those that cannot be met."
)
@click.option(
    "--budget",
    type=click.IntRange(20, 100_000),
    default=600,
    show_default=True,
    help="Largest number of designs in each search.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(50, 10_000_000),
    default=6000,
    show_default=True,
    help="Largest number of designs in all searches together.",
)
@click.option(
    "--time", "limit", metavar="TIME", help="Time limit of all searches together, such as '5 min' (default: none)."
)
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the random numbers.")
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures/--no-figures", default=True, help="Draw the Pareto fronts of the conflicts.")
@click.option(
    "--levels",
    is_flag=True,
    help="Show instead how far Table 1 can be met: each requirement alone, all together, and the Pareto fronts.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Run searches from several seeds on a dask cluster.")
@common_options
@without_rules
def command(run: Run, **given: Any) -> int:
    """Find the design nearest to the present one that violates no rule and fails no check.

    If there is none: irreducible sets of requirements that contradict each other, and how far each must be relaxed.
    """
    from designcalc.optimisation.optimise import outcome_document
    from stagecad.parameters.rules.registry import violations
    from workbench.cli.commands.check import masses_of_solids
    from workbench.console.optimisation import print_outcome
    from workbench.machine.optimisation import Effort, optimised, unverified, verified_checks, written
    from workbench.report.optimisation import optimisation_report

    options = Options(**given)
    target, relax = options.target, options.relax
    if target is not None and target.exists():
        raise InputError(f"{target}: is there already; name a new file")
    # A design that violates a rule may have no solids.
    masses = masses_of_solids(run) if options.solids and not violations(run.design.values) else None
    effort = Effort(options.budget, options.evaluations, _seconds(options.limit), options.seed)
    if options.levels:
        return _levels(run, options, effort, masses)
    evaluator, outcome = optimised(run, options.freed, options.keep, effort, masses, options.scheduler)
    found = outcome.design if outcome.feasible or relax else None
    after: list[Check] | None = None
    if outcome.design is not None and outcome.changes:
        after = verified_checks(evaluator, outcome, masses is not None)
    print_outcome(run, outcome, evaluator, after)
    wrong = unverified(outcome, after or [])
    if wrong:
        run.note(f"with the masses of its own solids the design fails: {', '.join(wrong)}; repeat with --params on it")
    document = outcome_document(outcome, evaluator, after)
    if after is not None:
        document["verified"] = not wrong
    report = optimisation_report(outcome, evaluator.checks, after, run.design.values.file)
    atomic_write_text(run.out / "optimize" / "report.md", report)
    if target is not None and found is not None and after is not None:
        written(run, outcome, target)
        atomic_write_text(target.with_suffix(".md"), report)
        document["written"] = str(target)
        run.note(f"written: {target} and {target.with_suffix('.md')}")
    elif target is not None:
        run.note(
            f"{target} is not written: no design meets all requirements (--relax leaves out those of the conflicts)"
        )
    if options.figures:
        document["figures"] = _figures(run, outcome, evaluator)
    run.emit(document)
    return 130 if outcome.interrupted else 0


def _levels(run: Run, options: Options, effort: Effort, masses: BodyMasses | None) -> int:
    """The study of the levels of Table 1: tables, report, figure."""
    from workbench.console.optimisation import print_levels
    from workbench.machine.levels import levels_document
    from workbench.machine.optimisation import studied_levels
    from workbench.report.optimisation import levels_report

    if options.target is not None or options.keep:
        raise InputError("--levels: --keep and --write are not used with it")
    levels = studied_levels(run, options.freed, effort, masses)
    print_levels(run, levels)
    atomic_write_text(run.out / "optimize" / "levels.md", levels_report(levels, run.design.values.file))
    document = levels_document(levels)
    if options.figures:
        from workbench.report.design_figures import fronts_figure

        path = run.out / "optimize" / "levels.png"
        fronts_figure(levels, path)
        document["figures"] = [str(path)]
        run.echo(f"figure {path}")
    run.emit(document)
    return 0


def _seconds(text: str | None) -> float:
    from stagecad.parameters.units import parse_quantity

    if text is None:
        return math.inf
    seconds = parse_quantity(text, "s", "--time")
    if not seconds > 0:
        raise InputError(f"--time '{text}': must be above 0")
    return seconds


def _figures(run: Run, outcome: Outcome, evaluator: Evaluator) -> list[str]:
    from workbench.report.design_figures import pareto_figure

    drawn = []
    for number, conflict in enumerate((one for one in outcome.conflicts if len(one.names) > 1), start=1):
        path = run.out / "optimize" / f"conflict_{number}.png"
        pareto_figure(evaluator, conflict.names, path)
        drawn.append(str(path))
        run.echo(f"figure {path}")
    return drawn
