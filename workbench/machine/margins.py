"""Sweeps and tolerance studies of the checks as jobs that can be sent to other processes, here or on a cluster."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.cluster import run_all
from workbench.options import Run

if TYPE_CHECKING:
    from designcalc.checks.analysis.sweep import Point, Range
    from designcalc.checks.analysis.tolerance import ToleranceStudy
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses


@dataclass(frozen=True)
class Source:
    """A parameter file by its text, so that a worker elsewhere needs no file of ours."""

    text: str | None
    """none: the packaged thesis design"""
    name: str
    overrides: tuple[str, ...]

    def design(self, *more: str, rules: bool = True) -> Design:
        """The design with `more` overrides `KEY=VALUE`."""
        from stagecad.parameters.load import design_from_text, load_design

        overrides = (*self.overrides, *more)
        if self.text is None:
            return load_design(None, overrides, rules=rules)
        return design_from_text(self.text, self.name, overrides, rules=rules)


def source_of(run: Run) -> Source:
    """What the run's own design was read from."""
    path = run.params
    if path is None and Path("stage.toml").is_file():
        path = Path("stage.toml")
    if path is None:
        return Source(None, "", run.overrides)
    return Source(path.read_text("utf-8"), path.name, run.overrides)


def swept_point(source: Source, swept: Range, base: Design, solids: bool, value: float) -> Point:
    """The checks at one value of a sweep, weighed anew on its own solids (or on plain volumes)."""
    from designcalc.checks.analysis.sweep import run_point
    from stagecad.solids.assembly.machine import body_masses

    return run_point(swept, value, source.design, base, body_masses if solids else _unweighed)


def _unweighed(design: Design) -> None:
    return None


def sweep(run: Run, swept: Range, solids: bool, scheduler: str | None) -> list[Point]:
    """Every point of a sweep, side by side.

    Without solids a point takes a tenth of a second: then other local processes would cost more than they save.
    """
    job = partial(swept_point, source_of(run), swept, run.design, solids)
    with run.progress() as progress:
        task = progress.add_task("sweep", total=len(swept.values))
        return run_all(
            job, swept.values, scheduler, lambda: progress.update(task, advance=1), workers=None if solids else 1
        )


def tolerance(
    run: Run, masses: BodyMasses | None, samples: int, scheduler: str | None, seed: int = 1
) -> ToleranceStudy:
    """Monte-Carlo study of the margins over the tolerances, the dimensions side by side."""
    from designcalc.checks.analysis.tolerance import tolerance_study

    load = partial(source_of(run).design, rules=False)
    with run.progress() as progress:
        task = progress.add_task("tolerances", total=None)

        def side_by_side(job, keys):
            progress.update(task, total=len(keys))
            return run_all(job, keys, scheduler, lambda: progress.update(task, advance=1))

        return tolerance_study(run.design, load, masses, samples, seed, run_all=side_by_side)
