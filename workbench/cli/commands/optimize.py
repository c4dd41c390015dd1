"""`stagecad optimize`: the nearest design without violated rules and failed checks."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from stagecad.parameters.errors import InputError, require
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options, design_trust, given_options, whole_number, without_rules
from workbench.operations.levels import reached_levels
from workbench.operations.optimise import Search, best_so_far, optimised, time_limit

FREE = "Let a parameter change within a range, or among choices KEY=A|B, besides those marked free in the file."
KEEP = "Require these checks only: a name, a pattern with *, or 'Table 1: speed'."
LEVELS = "Show instead how far Table 1 can be met: each requirement alone, all together, and the Pareto fronts."
RELAX = "Write the design that meets all requirements except those that cannot be met."
TIME = "Time limit of all searches together, such as '5 min' (default: none)."


@click.command("optimize")
@click.option("--free", multiple=True, metavar="KEY=LOW:HIGH", help=FREE)
@click.option("--keep", multiple=True, metavar="CHECK", help=KEEP)
@click.option("--write", "target", type=FILE, metavar="FILE.toml", help="Write the design found.")
@click.option("--relax", is_flag=True, help=RELAX)
@whole_number("--budget", 20, 100_000, 600, "Largest number of designs in each search.")
@whole_number("--evaluations", 50, 10_000_000, 6000, "Largest number of designs in all searches together.")
@click.option("--time", "limit", metavar="TIME", help=TIME)
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the random numbers.")
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures/--no-figures", default=True, help="Draw the Pareto fronts of the conflicts.")
@click.option("--levels", is_flag=True, help=LEVELS)
@click.option("--scheduler", metavar="ADDRESS", help="Run searches from several seeds on a dask cluster.")
@design_trust("the folder checks")
@common_options
@without_rules
def command(
    run: Run, target: Path | None, relax: bool, limit: str | None, figures: bool, levels: bool, **effort: Any
) -> int:
    """Find the design nearest to the present one that violates no rule and fails no check.

    If there is none: irreducible sets of requirements that contradict each other, and how far each must be relaxed.
    """
    require(target is None or not target.exists(), f"{target}: is there already; name a new file")
    wanted = Search(**effort, seconds=time_limit(limit))
    if levels and (unused := given_options("keep", "target", "relax", "evaluations", "limit", "scheduler")):
        raise InputError(f"--levels: not used with it: {', '.join(unused)}")
    with run.reporting() as report:
        one = reached_levels if levels else partial(optimised, better=best_so_far(run.note))
        result = one(run.design, wanted, report)
    if run.json_target is None:
        show(run, result.lines())
    document, lines, drawn = result.write_results(run.out / "optimize", figures, target, relax)
    show(run, lines)
    for path in drawn:
        run.echo(f"figure {path}")
    run.emit(document)
    return 130 if result.interrupted else 0
