"""Sweeps and tolerance studies of the checks, in parallel on the local cores or on a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from stagecad.processes import parallel_map
from workbench.cli.options import Run
from workbench.machine.own_checks import register
from workbench.operations.design import Design as StatedDesign

FEW_POINTS = 30
"""Without solids so few points are quicker in one process than in several, which start first."""

if TYPE_CHECKING:
    from designcalc.checks.analysis.grid import GridPoint
    from designcalc.checks.analysis.sweep import Point, Range
    from designcalc.checks.analysis.tolerance import ToleranceStudy
    from designcalc.checks.check import Check
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses


def evaluated_checks(run: Run, masses: BodyMasses | None) -> list[Check]:
    """Every check of the design, the changes that the failed ones propose evaluated."""
    return evaluated(run.design, run.design.values, masses)


def evaluated(source: StatedDesign, design: Design, masses: BodyMasses | None) -> list[Check]:
    """Like `evaluated_checks`, for the design that `source` gives."""
    from designcalc.checks.analysis.proposals import evaluate_proposals
    from designcalc.checks.run import run_checks

    register(source.check_files)
    return evaluate_proposals(run_checks(design, masses), design, masses, source.further_override())


def swept_point(source: StatedDesign, swept: Range, base: Design, solids: bool, value: float) -> Point:
    """The checks at one value of a sweep, with the masses of its own solids (or of plain volumes)."""
    from designcalc.checks.analysis.sweep import run_point
    from stagecad.friction_stage.assembly.machine import body_masses

    return run_point(swept, value, source.values_with, base, body_masses if solids else _no_solids)


def _no_solids(design: Design) -> None:
    return None


def sweep(run: Run, swept: Range, solids: bool, scheduler: str | None) -> list[Point]:
    """Every point of a sweep.

    Without solids a point takes a tenth of a second: then other local processes would cost more than they save.
    """
    job = partial(swept_point, run.design, swept, run.design.values, solids)
    with run.progress() as progress:
        task = progress.add_task("sweep", total=len(swept.values))
        return parallel_map(
            job,
            swept.values,
            progress=lambda value: progress.update(task, advance=1),
            workers=None if solids else 1,
            scheduler=scheduler,
        )


def grid_point(
    source: StatedDesign, ranges: Sequence[Range], base: Design, solids: bool, values: tuple[float, ...]
) -> GridPoint:
    """The checks at one point of a grid, with the masses of its own solids (or of plain volumes)."""
    from designcalc.checks.analysis.grid import run_grid_point
    from stagecad.friction_stage.assembly.machine import body_masses

    return run_grid_point(ranges, values, source.values_with, base, body_masses if solids else _no_solids)


def grid(run: Run, ranges: Sequence[Range], solids: bool, scheduler: str | None) -> list[GridPoint]:
    """Every point of a grid of several ranges."""
    from designcalc.checks.analysis.grid import combinations

    job = partial(grid_point, run.design, tuple(ranges), run.design.values, solids)
    wanted = combinations(ranges)
    with run.progress() as progress:
        task = progress.add_task("grid", total=len(wanted))
        return parallel_map(
            job,
            wanted,
            progress=lambda values: progress.update(task, advance=1),
            workers=None if solids or len(wanted) > FEW_POINTS else 1,
            scheduler=scheduler,
        )


def tolerance(
    run: Run, masses: BodyMasses | None, samples: int, scheduler: str | None, seed: int = 1
) -> ToleranceStudy:
    """Monte-Carlo study of the margins over the tolerances, the dimensions side by side."""
    from designcalc.checks.analysis.tolerance import tolerance_study

    load = partial(run.design.values_with, rules=False)
    with run.progress() as progress:
        task = progress.add_task("tolerances", total=None)

        def in_parallel(job, keys):
            progress.update(task, total=len(keys))
            return parallel_map(job, keys, progress=lambda key: progress.update(task, advance=1), scheduler=scheduler)

        return tolerance_study(run.design.values, load, masses, samples, seed, run_all=in_parallel)
