"""`stagecad optimize`: the nearest design without violated rules and failed checks."""

import math
from pathlib import Path
from typing import Any

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.units import parse_quantity
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options, without_rules
from workbench.figures.plot import save
from workbench.operations.levels import reached_levels
from workbench.operations.optimise import Search, optimised


@click.command("optimize")
@click.option(
    "--free",
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
@click.option("--write", "target", type=FILE, metavar="FILE.toml", help="Write the design found.")
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
def command(
    run: Run, target: Path | None, relax: bool, limit: str | None, figures: bool, levels: bool, **effort: Any
) -> int:
    """Find the design nearest to the present one that violates no rule and fails no check.

    If there is none: irreducible sets of requirements that contradict each other, and how far each must be relaxed.
    """
    if target is not None and target.exists():
        raise InputError(f"{target}: is there already; name a new file")
    wanted = Search(**effort, seconds=_seconds(limit))
    if levels:
        if target is not None or wanted.keep:
            raise InputError("--levels: --keep and --write are not used with it")
        return _levels(run, wanted, figures)
    with run.reporting() as report:
        result = optimised(run.design, wanted, report)
    document = result.to_json()
    if run.json_target is None:
        show(run, result.lines())
    if result.unverified:
        failing = ", ".join(result.unverified)
        run.note(f"with the masses of its own solids the design fails: {failing}; repeat with --params on it")
    atomic_write_text(run.out / "optimize" / "report.md", result.report())
    if target is not None and result.after is not None and (result.feasible or relax):
        result.write(target)
        document["written"] = str(target)
        run.note(f"written: {target} and {target.with_suffix('.md')}")
    elif target is not None:
        run.note(
            f"{target} is not written: no design meets all requirements (--relax leaves out those of the conflicts)"
        )
    if figures:
        drawn = {f"conflict_{number + 1}": result.plot(number) for number in range(len(result.fronts))}
        document["figures"] = _saved(run, drawn)
    run.emit(document)
    return 130 if result.outcome.interrupted else 0


def _levels(run: Run, wanted: Search, figures: bool) -> int:
    """The study of the levels of Table 1: tables, report, figure."""
    with run.reporting() as report:
        result = reached_levels(run.design, wanted, report)
    if run.json_target is None:
        show(run, result.lines())
    atomic_write_text(run.out / "optimize" / "levels.md", result.report())
    document = result.to_json()
    if figures:
        document["figures"] = _saved(run, {"levels": result.plot()})
    run.emit(document)
    return 0


def _saved(run: Run, figures: dict[str, Any]) -> list[str]:
    paths = []
    for name, figure in figures.items():
        path = run.out / "optimize" / f"{name}.png"
        save(figure, path)
        paths.append(str(path))
        run.echo(f"figure {path}")
    return paths


def _seconds(text: str | None) -> float:
    if text is None:
        return math.inf
    seconds = parse_quantity(text, "s", "--time")
    if not seconds > 0:
        raise InputError(f"--time '{text}': must be above 0")
    return seconds
