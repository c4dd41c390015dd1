"""Simulations as tables in the records' own form: `name [unit]`, one header row, as CSV or Parquet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sim.integration.simulate import Simulation
from stagecad.parameters.atomic import atomic_path

ROWS = 20_001
"""At most so many rows a table: 1 kHz over the 20 s of a stick-slip run."""


def table_of(run: Simulation, force: str, end: float | None = None, rows: int = ROWS) -> dict[str, np.ndarray]:
    """Columns of one simulation, at most `rows` rows up to `end`, s; `force` names the drive's column."""
    last = run.time[-1] if end is None else end
    # Evenly spaced in time, whatever instants the run was read at besides; the share keeps an ulp from shifting a row.
    wanted = np.linspace(run.time[0], last, rows) - 1e-9 * last / rows
    taken = np.unique(np.minimum(np.searchsorted(run.time, wanted), run.time.size - 1))
    columns = {
        "time [s]": run.time,
        "position [m]": run.position,
        "velocity [m/s]": run.velocity,
        "friction_force [N]": run.friction,
        f"{force} [N]": run.drive,
        "level [N]": run.level,
        "bristle [m]": run.bristle[:, 0] if run.bristle.shape[1] else np.zeros(run.time.size),
        "core_work [J]": run.core_work,
        "other_work [J]": run.other_work,
        "stored [J]": run.stored,
        "kinetic [J]": run.kinetic,
    }
    return {name: values[taken] for name, values in columns.items()}


def write_table(path: Path, columns: Mapping[str, np.ndarray], kinds: tuple[str, ...]) -> list[Path]:
    """Write the columns beside `path` as each of `kinds` (csv, parquet); return the files."""
    import pyarrow

    table = pyarrow.table(dict(columns))
    written = []
    for kind in kinds:
        target = path.with_name(f"{path.name}.{kind}")
        with atomic_path(target) as temporary:
            if kind == "csv":
                from pyarrow import csv

                csv.write_csv(table, temporary, csv.WriteOptions(quoting_style="none"))
            else:
                from pyarrow import parquet

                parquet.write_table(table, temporary)
        written.append(target)
    return written
