"""Features of the simulations over the values of one parameter."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from workbench.cluster import run_all
from workbench.machine.margins import Source, source_of
from workbench.options import Run

if TYPE_CHECKING:
    import numpy as np

    from designcalc.checks.analysis.sweep import Range
    from stagecad.parameters.design import Design


@dataclass(frozen=True)
class PointRun(Run):
    """A run whose design is given: one point of a sweep or one draw, in whatever process."""

    point: Design | None = None

    @functools.cached_property
    def design(self) -> Design:
        assert self.point is not None
        return self.point


def run_of(design: Design) -> PointRun:
    """A run on a design that is given."""
    return PointRun(None, (), Path(), None, design)


@dataclass(frozen=True)
class Wanted:
    """What is simulated at each point: experiments, friction models, the mass as given, the stage's studies."""

    names: tuple[str, ...]
    models: tuple[str, ...]
    mass: str | None
    studies: tuple[str, ...]


def simulated_point(source: Source, wanted: Wanted, override: str) -> dict[str, Any] | str:
    """Features of every experiment wanted with one more override, or why the design or motion does not stand."""
    from sim.integration.simulate import SimulationError
    from workbench.simulation.inputs import moving_mass
    from workbench.simulation.jobs import features_document, features_of, simulated

    try:
        run = run_of(source.design(override))
        mass = moving_mass(run, wanted.mass) if set(wanted.names) - {"tip", "stage"} else 1.0
        found = {
            name: features_of(simulated(run, name, wanted.models, mass)) for name in wanted.names if name != "stage"
        }
        if "stage" in wanted.names:
            from sim.experiments.stage import STUDIES, run_serially, stage_drive
            from stagecad.solids.assembly.machine import body_masses

            drive = stage_drive(run.design, body_masses(run.design))
            found["stage"] = features_document({name: STUDIES[name](drive, run_serially) for name in wanted.studies})
        return found
    except (InputError, SimulationError) as refused:
        return " ".join(str(refused).split())


def sweep(run: Run, swept: Range, wanted: Wanted, scheduler: str | None) -> list[dict[str, Any] | str]:
    """Features at every value of the range, side by side on the local cores or on a cluster."""
    whole = isinstance(run.design.value(swept.key), int)
    overrides = [swept.override(int(value) if whole else value) for value in swept.values]
    with run.progress() as progress:
        task = progress.add_task("sweep", total=len(overrides))
        job = partial(simulated_point, source_of(run), wanted)
        return run_all(job, overrides, scheduler, lambda: progress.update(task, advance=1))


def sweep_document(swept: Range, points: Sequence[dict[str, Any] | str]) -> dict[str, Any]:
    """The sweep as a JSON document: its values, and at each what `simulate` gives there (null where it was refused)."""
    from stagecad.parameters.units import to_si

    unit = {"mm": "m", "deg": "rad"}.get(swept.unit, swept.unit) or "1"
    return {
        "key": swept.key,
        "values": [{"value": to_si(value, swept.unit), "unit": unit} for value in swept.values],
        "points": [None if isinstance(point, str) else point for point in points],
        "refused": [point if isinstance(point, str) else None for point in points],
    }


def sweep_columns(swept: Range, points: Sequence[dict[str, Any] | str]) -> dict[str, np.ndarray]:
    """The sweep as a table: the parameter in SI, and a column for every feature."""
    import numpy as np

    from stagecad.parameters.units import to_si

    unit = {"mm": "m", "deg": "rad"}.get(swept.unit, swept.unit) or "1"
    rows = [{} if isinstance(point, str) else dict(_flat(point)) for point in points]
    names = dict.fromkeys(name for row in rows for name in row)
    units = {
        name: next(row[name]["unit"] for row in rows if row.get(name))
        for name in names
        if any(r.get(name) for r in rows)
    }
    columns = {f"{swept.key} [{unit}]": np.array([to_si(value, swept.unit) for value in swept.values])}
    for name, feature_unit in units.items():
        values = [row[name]["value"] if row.get(name) else np.nan for row in rows]
        columns[f"{name} [{feature_unit}]"] = np.array(values, dtype=float)
    return columns


def _flat(document: dict[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """`experiment.model.feature` and its quantity, for every feature."""
    found: list[tuple[str, Any]] = []
    for name, inner in document.items():
        if isinstance(inner, dict) and "unit" not in inner:
            found += _flat(inner, f"{before}{name}.")
        else:
            found.append((f"{before}{name}", inner))
    return found
