"""Job of the machine view: the nearest design without violated rules and failed checks, with its Pareto fronts."""

from typing import Any

from workbench.operations.optimise import optimize as optimize_design
from workbench.page.job_process import Report
from workbench.page.tasks.machine import design_of

MOST_POINTS = 2000
"""Designs of a Pareto figure."""


def optimize(
    text: str | None,
    name: str,
    overrides: dict[str, str],
    free: dict[str, str],
    keep: list[str],
    budget: int,
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """The document of `stagecad optimize --json`, the changes as the page makes them, and the Pareto fronts."""
    design = design_of(text, name, overrides, rules=False)

    def tell(step: str, done: int, total: int) -> None:
        report(f"{step}: {done} designs" if done else step, done, total)

    # What the file marks as free and the page does not is kept.
    found = optimize_design(design, free, keep, only=True, budget=budget, progress=tell)
    return {
        "digest": design.values.digest,
        "document": found.to_json(),
        "required": len(found.outcome.required),
        "unverified": found.unverified,
        "changes": found.changes,
        "fronts": [
            {
                "names": list(one.names),
                "points": one.points[:: max(len(one.points) // MOST_POINTS, 1)].T.tolist(),
                "front": one.front.T.tolist(),
            }
            for one in found.fronts
        ],
    }
