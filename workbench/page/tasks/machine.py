"""Jobs on a design: solids, drawings, the nearest design without violated rules and failed checks, and simulations."""

import json
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from workbench.operations.design import Design
from workbench.operations.drawings import sheets as sheets_of
from workbench.operations.optimise import BestSoFar, Search, optimised
from workbench.operations.parts import solids as solids_of
from workbench.operations.simulation.simulate import Simulation
from workbench.operations.simulation.simulate import simulate as simulate_design
from workbench.page.curves import write_curves
from workbench.page.job_process import Report


def solids(design: Design, folder: str, report: Report) -> dict[str, Any]:
    """The parts and where they stand in the machine; the mesh of a part is in the cache under its key."""
    return solids_of(design.with_rules(), report)


def drawings(design: Design, subject: str, folder: str, report: Report) -> dict[str, Any]:
    """The sheets of one subject: a part, the assembly, or the procedure."""
    digest = design.with_rules().values.digest
    report("drawing", 0, 0)
    return {"subject": subject, "digest": digest, "sheets": sheets_of(design, [subject])}


STOP, BEST = "stop", "best.json"
"""Files of a running search: a wish that it ends, and the best design so far."""
MOST_POINTS = 2000
"""Designs of a Pareto figure."""


def optimize(design: Design, search: dict[str, Any], folder: str, report: Report) -> dict[str, Any]:
    """The document of `stagecad optimize --json`, the changes as the page makes them, and the Pareto fronts."""
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


STAGE = "stage-"
"""Begins the name of a study of the driven stage."""


def simulate(design: Design, experiment: str, models: list[str], folder: str, report: Report) -> dict[str, Any]:
    """One experiment: the document of `stagecad simulate --json`, and its curves."""
    if experiment.startswith(STAGE):
        study = experiment.removeprefix(STAGE)
        found = simulate_design("stage", design.with_rules(), studies=[study], progress=report)
        prefix = f"stage_{study}_"
    else:
        found = simulate_design(experiment, design, models, progress=report)
        prefix = f"{experiment}_"
    assert isinstance(found, Simulation)
    curves = [
        {**write_curves(Path(folder), number, columns), "title": title.removeprefix(prefix)}
        for number, (title, columns) in enumerate(found.columns.items())
    ]
    return {"experiment": experiment, "document": found.to_json(), "curves": curves}
