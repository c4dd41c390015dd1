"""All channels of an experiment as they are logged, with what is wrong in them, before any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.deferred import pd
from stagecad.parameters.units import attributes, format_quantity
from sysid.diagnosis.consistency import record_warnings
from sysid.experiment.experiment import Experiment, find_experiment, read_experiment
from sysid.experiment.readers.base import shown_path
from sysid.experiment.record import Record, load_whole_records
from sysid.experiment.rigs import CHANNELS
from sysid.experiment.toml_table import TomlTable, read_toml
from workbench.figures import Plot
from workbench.figures import identification as record_figures
from workbench.operations.design import Design
from workbench.operations.measurement.design_values import as_design_values
from workbench.operations.result import Result, finite, frame


class Look(Result):
    """The records of an experiment before any fit.

    Args:
        experiment: as read.
        records: every record as it was logged, with gaps where a sensor has no value of its own.
        assumed: what is shown in a unit that is still a question, one line each.
    """

    def __init__(self, experiment: Experiment, records: tuple[Record, ...], assumed: Sequence[str] = ()) -> None:
        self.experiment, self.records, self.assumed = experiment, records, assumed

    @cached_property
    def warnings(self) -> list[str]:
        """What is wrong, one line each."""
        records = self.records
        if any(spec.balance for spec in self.experiment.records):
            computed = load_whole_records(self.experiment)
            records = [replace(whole, faults=logged.faults) for whole, logged in zip(computed, records, strict=True)]
        return [*self.assumed, *record_warnings(self.experiment, records)]

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each channel of each record: range, gaps, rows of each fault; SI."""
        rows = [{"record": r.name, "channel": name, **row} for r in self.records for name, row in _channels(r).items()]
        return frame(rows, "record", "channel")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad look --json`."""
        records = [
            {
                **attributes(record, "name", "role", "file", "uniform", "sha256"),
                "rows": record.size,
                "seconds": float(record.time[-1] - record.time[0]),
                "step": {"value": record.step, "unit": "s"},
                "notes": list(record.notes),
                "channels": {
                    channel: {**row, **{end: {"value": row[end], "unit": unit} for end in ("low", "high")}}
                    for channel, row in _channels(record).items()
                    if (unit := row.pop("unit"))
                },
            }
            for record in self.records
        ]
        return finite({"schema": 1, "records": records, "warnings": self.warnings})

    def lines(self) -> list[str]:
        """The records and their channels as text."""
        shown = []
        for record in self.records:
            span = format_quantity(float(record.time[-1] - record.time[0]), "s", 4)
            shown.append(f"{record.name} ({record.role}): {record.size} rows, {span}, {record.file}")
            for channel, row in _channels(record).items():
                ends = " .. ".join(format_quantity(row[end], row["unit"], 4) for end in ("low", "high"))
                counted = [f"{count} {kind}" for kind, count in row.items() if isinstance(count, int) and count]
                shown.append("; ".join([f"  {channel}: {ends}", *counted]))
        return shown

    def plot(self) -> Plot:
        """All raw channels over time, with the faults marked."""
        return record_figures.records_figure(self.records, faults=True)

    def __repr__(self) -> str:
        return f"<Look at {len(self.records)} records: {len(self.warnings)} warnings>"


KINDS = ("gaps", "clipped", "frozen", "dropped")
"""What is counted of every channel; other faults are where there are some."""


def _channels(record: Record) -> dict[str, dict[str, Any]]:
    """Unit, range, gaps and rows of each fault of each channel, SI."""
    found = {}
    for channel, values in record.channels.items():
        counts: dict[str, int] = dict.fromkeys(KINDS, 0)
        for fault in record.faults:
            counts |= {fault.kind: int(fault.rows.sum())} if fault.channel == channel else {}
        counts["gaps"] = int(np.isnan(values).sum()) - sum(counts.values())
        ends = {"low": float(np.nanmin(values)), "high": float(np.nanmax(values))}
        found[channel] = {"unit": record.units[channel], **ends, **counts}
    return found


def look(experiment: str | Path | Experiment, design: Design | None = None) -> Look:
    """Read every record of an experiment, and look at its rows.

    Args:
        experiment: the folder, its `experiment.toml`, or an experiment as read.
        design: where the file states a value as `"design"`.

    Raises:
        InputError: one line with file, row and column.
    """
    assumed: list[str] = []
    if not isinstance(experiment, Experiment):
        place, values = find_experiment(experiment), as_design_values(design)
        _, text, top = read_toml(place.path, shown_path(str(place.path)))
        assumed = _answer_units(top)
        experiment = replace(read_experiment(top, place.path, values), text=text)
    return Look(experiment, tuple(load_whole_records(experiment, logged=True)), assumed)


def _answer_units(top: TomlTable) -> list[str]:
    """Put one unit where the scale or the unit of a channel is still a question, and say so, a line each."""
    said: list[str] = []
    for table in (top, *top.tables("record")):
        for channel, stated in table.table("channels").data.items():
            for item in (item for item in (stated if isinstance(stated, list) else [stated]) if isinstance(item, dict)):
                for key in [key for key in ("scale", "unit") if str(item.get(key, "")).lstrip().startswith("?")]:
                    unit = CHANNELS[channel].unit if key == "unit" and channel in CHANNELS else item[key].strip(" ?")
                    item[key] = unit if key == "unit" else f"1 {unit}"
                    said.append(f"{channel}: its {key} is a question; shown with {item[key]}")
    return said
