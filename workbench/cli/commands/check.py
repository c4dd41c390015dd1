"""`stagecad check`: every design check, with value, limit, margin and what would pass."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from designcalc.checks.analysis.sweep import Range
    from stagecad.parameters.mass_properties import BodyMasses


@click.command("check")
@click.option(
    "--sweep",
    "swept",
    multiple=True,
    metavar="KEY=LOW:HIGH[:N]",
    help="Show the margins over a range of a parameter; several parameters form a grid.",
)
@click.option("--chains", is_flag=True, help="Show the tolerance chains, by worst case and statistically.")
@click.option("--tolerance", is_flag=True, help="Monte-Carlo over the tolerances of the dimensions.")
@click.option(
    "--samples",
    type=click.IntRange(100, 1_000_000),
    default=10_000,
    show_default=True,
    help="Number of samples of --tolerance.",
)
@click.option("--solids/--no-solids", default=True, help="Take mass from the solids, or from plain volumes.")
@click.option("--figures", is_flag=True, help="Draw the figures of the checks, into the report too.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Send --sweep and --tolerance to a dask cluster.",
)
@click.option("--trust", is_flag=True, help="Consent to run the files of the folder checks as they are now.")
@common_options
def command(
    run: Run,
    swept: tuple[str, ...],
    tolerance: bool,
    samples: int,
    scheduler: str | None,
    **asked: bool,
) -> int:
    """Run every design check on the parameter file; exit status 1 when one fails."""
    from designcalc.checks.analysis.grid import combinations
    from designcalc.checks.analysis.sweep import read_range
    from workbench.cli.commands.declared import run_declared
    from workbench.console.checks import print_checks, print_tolerance
    from workbench.machine.declared_machine import declared_machine
    from workbench.machine.margin_studies import evaluated_checks
    from workbench.report.check_figures import tolerance_figure
    from workbench.report.checks import write_check_files

    if scheduler is not None and not swept and not tolerance:
        raise InputError("--scheduler: only --sweep and --tolerance have many independent runs")
    declaration = declared_machine(run)
    if declaration is not None:
        refused = [*swept, *(word for word in ("--tolerance",) if tolerance)]
        return run_declared(run, declaration, ("checks",), asked["trust"], refused=refused)
    design = run.design.values
    if asked["trust"]:
        trust_own_checks(run)
    wanted = [read_range(text, design) for text in swept]
    if len(wanted) > 1:
        combinations(wanted)
    masses = masses_of_solids(run) if asked["solids"] else None
    checks = evaluated_checks(run, masses)
    folder = run.out / "checks"
    drawn = draw_figures(run, masses, folder) if asked["figures"] else {}
    print_checks(run, checks)
    document: Any = [check.as_json() for check in checks]
    if wanted or tolerance or asked["chains"]:
        document = {"checks": document}
    if asked["chains"]:
        from designcalc.friction_stage.physics.tolerance_chains import chains as chains_of
        from workbench.console.checks import print_chains

        found = chains_of(design)
        print_chains(run, found)
        document["chains"] = [chain.as_json() for chain in found]
    if len(wanted) == 1:
        document["sweep"] = _swept(run, wanted[0], masses is not None, scheduler, drawn)
    elif wanted:
        document["grid"] = _gridded(run, wanted, masses is not None, scheduler, drawn)
    if tolerance:
        from workbench.machine.margin_studies import tolerance as tolerance_study

        study = tolerance_study(run, masses, samples, scheduler)
        document["tolerance"] = study.as_json()
        print_tolerance(run, study)
        tolerance_figure(study, folder / "tolerance.png")
        drawn["what the tolerances use up"] = folder / "tolerance.png"
    for path in drawn.values():
        run.echo(f"figure {path}")
    write_check_files(checks, design, masses, folder, drawn)
    run.emit(document)
    return 1 if any(check.verdict == "fails" for check in checks) else 0


def trust_own_checks(run: Run) -> None:
    """Consent to run the user's own checks as they are now, and name them."""
    from workbench.machine.own_checks import register

    files = run.design.check_files
    register(files, trust=True)
    for name in files:
        run.note(f"trusted as it is now: {name}")


def _swept(run: Run, wanted: Range, solids: bool, scheduler: str | None, drawn: dict[str, Path]) -> dict[str, Any]:
    from designcalc.checks.analysis.sweep import table
    from workbench.console.checks import print_sweep
    from workbench.machine.margin_studies import sweep
    from workbench.report.check_figures import sweep_figure

    points = sweep(run, wanted, solids, scheduler)
    names = print_sweep(run, wanted, points)
    if names:
        path = run.out / "checks" / f"sweep_{wanted.key.replace('.', '_')}.png"
        sweep_figure(wanted, points, names, path)
        drawn[f"margins over {wanted.key}"] = path
    return table(wanted, points)


def _gridded(
    run: Run, wanted: list[Range], solids: bool, scheduler: str | None, drawn: dict[str, Path]
) -> dict[str, Any]:
    from designcalc.checks.analysis.grid import grid_table
    from workbench.console.checks import print_grid
    from workbench.machine.margin_studies import grid
    from workbench.report.design_figures import grid_figure

    points = grid(run, wanted, solids, scheduler)
    print_grid(run, wanted, points)
    if len(wanted) == 2:
        path = run.out / "checks" / f"grid_{'_'.join(one.key.replace('.', '_') for one in wanted)}.png"
        grid_figure(wanted, points, path)
        drawn[f"failed checks over {wanted[0].key} and {wanted[1].key}"] = path
    return grid_table(wanted, points)


def masses_of_solids(run: Run) -> BodyMasses | None:
    """Masses of the solids, which are made when missing; None where they cannot be made."""
    from stagecad.friction_stage.assembly.machine import body_masses

    try:
        return body_masses(run.design.values)
    except ImportError as error:
        run.note(f"no solids can be made here ({error}): masses are estimated from plain volumes")
        return None


def draw_figures(run: Run, masses: BodyMasses | None, folder: Path) -> dict[str, Path]:
    """Every figure of the checks that this design has, by title."""
    from workbench.report.check_figures import FIGURES

    drawn: dict[str, Path] = {}
    for title, (name, draw) in FIGURES.items():
        path = folder / f"{name}.png"
        if draw(run.design.values, masses, path):
            drawn[title] = path
    return drawn
