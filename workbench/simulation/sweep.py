"""Features of the simulations over the values of one parameter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import to_si
from stagecad.processes import parallel_map
from workbench.cli.options import Run
from workbench.operations.design import Design as StatedDesign
from workbench.simulation.experiments import Selection, features_of, flat_features, simulate_selection

if TYPE_CHECKING:
    import numpy as np

    from designcalc.checks.analysis.sweep import Range

Point = dict[str, Any] | str
"""Features at one value, or why the design or motion is refused."""


def simulate_point(source: StatedDesign, selection: Selection, override: str) -> Point:
    """Features of every selected experiment with one more override."""
    from sim.integration.simulate import SimulationError

    try:
        return features_of(simulate_selection(source.values_with(override), selection))
    except (InputError, SimulationError) as refused:
        return " ".join(str(refused).split())


def sweep(run: Run, swept: Range, selection: Selection, scheduler: str | None) -> list[Point]:
    """Features at every value of the range, in parallel on the local cores or on a cluster."""
    whole = isinstance(run.design.values.value(swept.key), int)
    overrides = [swept.override(int(value) if whole else value) for value in swept.values]
    with run.progress() as progress:
        task = progress.add_task("sweep", total=len(overrides))
        job = partial(simulate_point, run.design, selection)
        return parallel_map(
            job, overrides, progress=lambda override: progress.update(task, advance=1), scheduler=scheduler
        )


def sweep_document(swept: Range, points: Sequence[Point]) -> dict[str, Any]:
    """The sweep as a JSON document: its values, and at each what `simulate` gives there (null where it was refused)."""
    unit = {"mm": "m", "deg": "rad"}.get(swept.unit, swept.unit) or "1"
    return {
        "key": swept.key,
        "values": [{"value": to_si(value, swept.unit), "unit": unit} for value in swept.values],
        "points": [None if isinstance(point, str) else point for point in points],
        "refused": [point if isinstance(point, str) else None for point in points],
    }


def sweep_columns(swept: Range, points: Sequence[Point]) -> dict[str, np.ndarray]:
    """The sweep as a table: the parameter in SI, and a column for every feature."""
    import numpy as np

    unit = {"mm": "m", "deg": "rad"}.get(swept.unit, swept.unit) or "1"
    rows = [{} if isinstance(point, str) else flat_features(point) for point in points]
    columns = {f"{swept.key} [{unit}]": np.array([to_si(value, swept.unit) for value in swept.values])}
    for name in dict.fromkeys(name for row in rows for name in row):
        cells = [row.get(name) for row in rows]
        feature_unit = next((cell["unit"] for cell in cells if cell), None)
        if feature_unit is not None:
            values = [cell["value"] if cell else np.nan for cell in cells]
            columns[f"{'.'.join(name)} [{feature_unit}]"] = np.array(values, dtype=float)
    return columns
