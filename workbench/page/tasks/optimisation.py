"""Job of the machine view: the nearest design without violated rules and failed checks, with its Pareto fronts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from workbench.machine.design_source import DesignSource
from workbench.page.job_process import Report

if TYPE_CHECKING:
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.optimise import Outcome

MOST_POINTS = 2000
"""Designs of a Pareto figure."""


def optimize(
    text: str | None,
    name: str,
    overrides: list[str],
    freed: list[str],
    keep: list[str],
    budget: int,
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """The document of `stagecad optimize --json`, the changes as the page makes them, and the Pareto fronts."""
    from designcalc.optimisation.optimise import optimise, outcome_document, required_checks
    from designcalc.optimisation.space import free_parameters
    from stagecad.parameters.rules.registry import violations
    from stagecad.solids.assembly.machine import body_masses
    from workbench.machine.optimisation import evaluator_of, unverified, verified_checks

    source = DesignSource(text, name, tuple(overrides))
    design = source.design(rules=False)
    chosen = {one.partition("=")[0].strip() for one in freed}
    # What the file marks as free and the page does not is kept.
    free = [one for one in free_parameters(design, freed) if one.key in chosen]
    report("masses of the solids", 0, 0)
    # A design that violates a rule may have no solids.
    masses = None if violations(design) else body_masses(design)
    evaluator = evaluator_of(source, free, masses)
    step = ""

    def tell(words: str) -> None:
        nonlocal step
        step = words
        report(step, evaluator.count, 0)

    required = required_checks(evaluator.checks, keep)
    outcome = optimise(
        evaluator, required, budget, tell=tell, progress=lambda count: report(f"{step}: {count} designs", count, 0)
    )
    after = None
    if outcome.design is not None and outcome.changes:
        report("masses of its own solids", 0, 0)
        after = verified_checks(evaluator, outcome, masses is not None)
    document = outcome_document(outcome, evaluator, after)
    return {
        "digest": design.digest,
        "document": document,
        "required": len(outcome.required),
        "unverified": unverified(outcome, after or []),
        "changes": {change.key: change.after for change in outcome.changes},
        "fronts": _fronts(evaluator, outcome),
    }


def _fronts(evaluator: Evaluator, outcome: Outcome) -> list[dict[str, Any]]:
    """Margins of the designs evaluated in the two first requirements of each conflict, in parts of the limit."""
    from workbench.report.design_figures import margins_of, pareto_front

    found = []
    for conflict in outcome.conflicts:
        if len(conflict.names) > 1:
            points = margins_of(evaluator, conflict.names[:2])
            front = pareto_front(points)
            kept = points[:: max(len(points) // MOST_POINTS, 1)]
            found.append({"names": list(conflict.names[:2]), "points": kept.T.tolist(), "front": front.T.tolist()})
    return found
