"""Optimisation of the run's design: its evaluator, the search with progress, verification, and the new file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.cli.options import Run
from workbench.operations.design import Design as StatedDesign

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.optimise import Outcome
    from designcalc.optimisation.reached_levels import Levels
    from designcalc.optimisation.space import Free
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.parameters.variations import Variations

SAFETY = 0.002
"""Part of its limit by which a check must pass in the search, for the error of the masses without solids."""
SEEDS = 8
"""Searches sent to a cluster."""


@dataclass(frozen=True)
class Effort:
    """Evaluations of each search and of all, time of all, s, and seed of the random numbers."""

    budget: int
    evaluations: int
    seconds: float
    seed: int


def evaluator_of(source: StatedDesign, free: Sequence[Free], masses: BodyMasses | None) -> Evaluator:
    """The evaluator of a design given as text and overrides."""
    from designcalc.optimisation.evaluation import Evaluator

    return Evaluator(_variations(source, ()), free, masses, SAFETY if masses is not None else 0.0)


def _variations(source: StatedDesign, more: Sequence[str]) -> Variations:
    """The design with `more` overrides, and its changes."""
    return source.variations(*more)


def studied_levels(run: Run, freed: Sequence[str], effort: Effort, masses: BodyMasses | None) -> Levels:
    """How far Table 1 can be met by the run's design; arguments as of `optimised`."""
    from designcalc.optimisation.requirement_levels import requirement_levels
    from designcalc.optimisation.space import free_parameters

    source = run.design
    free = free_parameters(source.values_with(rules=False), freed)
    with run.progress() as progress:
        task = progress.add_task("levels", total=None)
        return requirement_levels(
            partial(_variations, source),
            free,
            masses,
            effort.budget,
            seed=effort.seed,
            tell=lambda words: progress.update(task, description=words),
        )


def optimised(
    run: Run,
    freed: Sequence[str],
    keep: Sequence[str],
    effort: Effort,
    masses: BodyMasses | None,
    scheduler: str | None,
) -> tuple[Evaluator, Outcome]:
    """The outcome of the optimisation of the run's design, and the evaluator with all evaluated designs.

    Args:
        run: of the command.
        freed, keep: as given by --free and --keep.
        effort: of the search.
        masses: of the design's solids; None estimates them from plain volumes.
        scheduler: address of a dask cluster, which begins with searches from several seeds.
    """
    from designcalc.optimisation.optimise import optimise, required_checks
    from designcalc.optimisation.space import free_parameters
    from stagecad.processes import parallel_map

    source = run.design
    free = free_parameters(source.values_with(rules=False), freed)
    evaluator = evaluator_of(source, free, masses)
    required = required_checks(evaluator.checks, keep)
    with run.progress() as progress:
        task = progress.add_task("optimize", total=effort.evaluations)
        if scheduler is not None:
            job = partial(seeded_search, source, free, masses, required, effort.budget)
            for values in parallel_map(job, range(effort.seed, effort.seed + SEEDS), scheduler=scheduler):
                if values is not None:
                    evaluator.of(values)
        outcome = optimise(
            evaluator,
            required,
            effort.budget,
            seed=effort.seed,
            evaluations=effort.evaluations,
            seconds=effort.seconds,
            tell=lambda words: progress.update(task, description=words),
            progress=lambda done: progress.update(task, completed=done),
        )
    return evaluator, outcome


def seeded_search(
    source: StatedDesign,
    free: Sequence[Free],
    masses: BodyMasses | None,
    required: Sequence[str],
    budget: int,
    seed: int,
) -> dict[str, object] | None:
    """Values of the free parameters of the nearest satisfying design found from one seed; None for none."""
    from designcalc.optimisation.search import search

    best = search(evaluator_of(source, free, masses), required, budget, seed=seed)
    return dict(best.evaluation.values) if best.satisfied and best.evaluation is not None else None


def verified_checks(evaluator: Evaluator, outcome: Outcome, solids: bool) -> list[Check]:
    """Checks of the design found, with the masses of its own solids."""
    from designcalc.checks.run import run_checks
    from stagecad.friction_stage.assembly.machine import body_masses

    assert outcome.design is not None
    design = evaluator.design(outcome.design.values)
    return run_checks(design, body_masses(design) if solids else None)


def unverified(outcome: Outcome, after: Sequence[Check]) -> list[str]:
    """Requirements that the search met, and that fail with the masses of the design's own solids."""
    conflicting = {name for conflict in outcome.conflicts for name in conflict.names}
    met = set(outcome.required) - conflicting - set(outcome.left_out)
    return [check.name for check in after if check.name in met and check.verdict in ("fails", "out_of_range")]


def written(run: Run, outcome: Outcome, target: Path) -> None:
    """Write the parameter file with the changes, their reasons as origins; comments are kept."""
    from stagecad.parameters.atomic import atomic_write_text

    changes: dict[str, tuple[str | float | bool, str]] = {}
    for change in outcome.changes:
        entry = run.design.values.entry(change.key)
        value = _written(change.after, entry.unit, entry.value)
        changes[change.key] = (value, f"assumed: optimised from {change.before}: {change.reason}")
    atomic_write_text(target, run.design.to_toml(changes, str(target)))


def _written(text: str, unit: str, present: object) -> str | float | bool:
    """The value of an entry as TOML keeps it: numbers without unit and truth values as such."""
    if isinstance(present, bool):
        return text == "true"
    if unit or isinstance(present, str) or text.startswith("="):
        return text
    number = float(text)
    return int(number) if isinstance(present, int) else number
