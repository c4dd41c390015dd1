"""The bootstrap of `stagecad compare --bootstrap`: many refits side by side, told beside the linear intervals."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sysid.estimation.bootstrap import Bootstrap, bootstrap_of, refit_of, refitted
from sysid.estimation.fit import FittedModel
from sysid.estimation.identifiability import public_key
from sysid.prediction.problem import Problem
from sysid.report import parameter_unit
from workbench.cluster import run_all
from workbench.options import Run


def bootstrap_case(
    run: Run, problem: Problem, fitted: FittedModel, draws: int, seed: int, scheduler: str | None
) -> Bootstrap:
    """Refit a case `draws` times, on the local cores or on a cluster; the same values either way.

    Raises:
        InputError: nothing to fit, too few refits that settled, or no cluster.
    """
    refit = refit_of(problem, fitted)
    with run.progress() as progress:
        task = progress.add_task("refits", total=draws)
        seeds = [(seed, k) for k in range(draws)]
        found = run_all(refitted, seeds, scheduler, lambda: progress.update(task, advance=1), common=refit)
    return bootstrap_of(refit, found)


def bootstrap_json(problem: Problem, drawn: Bootstrap, seed: int) -> dict[str, Any]:
    """Values with the deviation and the 95 % band of the refits."""
    (low, high), std = drawn.band, drawn.std
    return {
        "draws": drawn.asked,
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


def draw_bootstrap(run: Run, problem: Problem, drawn: Bootstrap, document: Mapping[str, Any]) -> Path:
    """A histogram of each value over the refits, with the two intervals under it."""
    from workbench.report.page import report_folder
    from workbench.simulation.figures import save_figure

    folder = report_folder(run, problem.experiment.folder.name)
    folder.mkdir(parents=True, exist_ok=True)
    return save_figure(_figure(drawn, document), folder / "compare_bootstrap.png")


def _figure(drawn: Bootstrap, document: Mapping[str, Any]) -> Any:
    from matplotlib import rc_context

    from workbench.simulation.figures import INK, STYLE, new_figure

    count = len(drawn.keys)
    columns = min(count, 3)
    rows = -(-count // columns)
    with rc_context(STYLE):
        figure, axes = new_figure(rows, columns, 3.4 * columns, 2.4 * rows + 0.5)
        for k, panel in enumerate(axes.flat):
            if k >= count:
                panel.set_axis_off()
                continue
            key = public_key(drawn.keys[k])
            q, linear = document["bootstrap"]["parameters"][key], document["parameters"][key]
            values = drawn.values[:, k]
            bins = min(40, max(10, int(np.sqrt(values.size) * 1.5)))
            counts, _, _ = panel.hist(values, bins=bins, color=INK[0], alpha=0.35)
            unit = counts.max() / 12.0
            panel.plot([q["low"], q["high"]], [-unit, -unit], color=INK[0], linewidth=4, solid_capstyle="butt")
            if linear.get("low") is not None and linear.get("high") is not None:
                ends = [linear["low"], linear["high"]]
                panel.plot(ends, [-2.2 * unit, -2.2 * unit], color=INK[1], linewidth=4, solid_capstyle="butt")
            panel.axvline(q["value"], color="black", linewidth=0.8)
            panel.set_yticks([])
            panel.set_xlabel(f"{key} ({q['unit']})" if q["unit"] != "1" else key)
            panel.locator_params(axis="x", nbins=5)
        figure.suptitle("Refitted values (bars: 95 %; blue by refitting, red linear)", fontsize=10)
    return figure
