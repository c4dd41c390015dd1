"""Job of the machine view: the nearest design without violated rules and failed checks, with its Pareto fronts."""

import json
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from workbench.operations.optimise import BestSoFar, Search, optimised
from workbench.operations.result import without_options
from workbench.page.job_process import Report
from workbench.page.tasks.machine import design_of

STOP, BEST = "stop", "best.json"
"""Files of a running search: a wish that it ends, and the best design so far."""
MOST_POINTS = 2000
"""Designs of a Pareto figure."""


def optimize(
    text: str | None,
    name: str,
    overrides: dict[str, str],
    search: dict[str, Any],
    folder: str,
    report: Report,
) -> dict[str, Any]:
    """The document of `stagecad optimize --json`, the changes as the page makes them, and the Pareto fronts."""
    design = design_of(text, name, overrides, rules=False)
    stop = Path(folder) / STOP

    def tell(step: str, done: int, total: int) -> None:
        report(f"{step}: {done} designs" if done else step, done, total)
        if done and stop.is_file():
            # As Ctrl-C does for the command: the search ends, and what it has found is the result.
            stop.unlink()
            raise KeyboardInterrupt

    def keep_best(best: BestSoFar) -> None:
        atomic_write_text(Path(folder) / BEST, json.dumps({**best.to_json(), "digest": design.values.digest}))

    # What the file marks as free and the page does not is kept.
    free = [f"{key}={text}" for key, text in search["free"].items()]
    with without_options():
        found = optimised(design, Search(**{**search, "free": free}, only=True), tell, keep_best)
    return {
        "digest": design.values.digest,
        "document": found.to_json(),
        "required": len(found.outcome.required),
        "ended": "stopped" if found.outcome.interrupted else "" if found.outcome.complete else "out of time",
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
