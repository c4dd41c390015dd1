"""The bootstrap of `stagecad compare --bootstrap`: many refits in parallel, and their intervals."""

from __future__ import annotations

from functools import partial
from typing import Any

from stagecad.processes import parallel_map
from sysid.estimation.bootstrap import Bootstrap, bootstrap_of, refit_of, refitted
from sysid.estimation.fit import FittedModel
from sysid.estimation.identifiability import public_key
from sysid.prediction.problem import Problem
from sysid.report import parameter_unit
from workbench.cli.options import Run


def bootstrap_case(
    run: Run, problem: Problem, fitted: FittedModel, draws: int, seed: int, scheduler: str | None
) -> Bootstrap:
    """Refit a problem `draws` times, on the local cores or on a cluster; the same values either way.

    Raises:
        InputError: nothing to fit, too few refits that settled, or no cluster.
    """
    refit = refit_of(problem, fitted)
    with run.progress() as progress:
        task = progress.add_task("refits", total=draws)
        seeds = [(seed, k) for k in range(draws)]
        found = parallel_map(
            partial(refitted, refit),
            seeds,
            progress=lambda seed: progress.update(task, advance=1),
            scheduler=scheduler,
        )
    return bootstrap_of(refit, found)


def bootstrap_json(problem: Problem, drawn: Bootstrap, seed: int) -> dict[str, Any]:
    """Values with the deviation and the 95 % band of the refits."""
    (low, high), std = drawn.band, drawn.std
    return {
        "draws": drawn.requested,
        "settled": int(drawn.values.shape[0]),
        "seed": seed,
        "parameters": {
            public_key(key): {
                "value": float(drawn.best[k]),
                "unit": parameter_unit(problem, key),
                "std": float(std[k]),
                "low": float(low[k]),
                "high": float(high[k]),
            }
            for k, key in enumerate(drawn.keys)
        },
    }
