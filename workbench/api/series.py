"""Measured, predicted and simulated channels of an experiment as tables. SI units; index `record`, `time`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.model import Model, PreparedRecord, predict
from sysid.prediction.problem import Problem, averaged
from sysid.report import channel_unit

if TYPE_CHECKING:
    import pandas as pd

PARTS = {"fit": "fit", "validate": "held out"}


def prepared_records(problem: Problem) -> list[PreparedRecord]:
    """All prepared records: those of the fit, then the held-out ones."""
    return [*problem.fit_records, *problem.validate_records]


def time_of(problem: Problem, record: PreparedRecord) -> np.ndarray:
    """Time (n,) of a prepared record as logged, s."""
    logged = next(r for r in averaged(problem.experiment, problem.records)[1] if r.name == record.name)
    own = record.time if isinstance(record, TipRecord) else record.axis.time
    return logged.time[0] + own


def overlay_table(problem: Problem, model: Model) -> pd.DataFrame:
    """Measured and predicted values and residuals of every channel, as compared.

    Columns: `role`, and for each channel `CHANNEL`, `CHANNEL_predicted` and `CHANNEL_residual`, which is empty where it
    is not scored (next to ends and gaps). On a driven mass the channels are filtered as the comparison filters them.
    """
    import pandas as pd

    tables = {}
    for record in prepared_records(problem):
        predicted = predict(record, model.effects, model.values)
        columns: dict[str, object] = {"role": PARTS["fit" if record.role == "fit" else "validate"]}
        for channel, measured in record.measured.items():
            columns[channel] = measured
            columns[f"{channel}_predicted"] = predicted[channel]
            columns[f"{channel}_residual"] = np.where(record.valid[channel], measured - predicted[channel], np.nan)
        tables[record.name] = pd.DataFrame(columns, index=pd.Index(time_of(problem, record), name="time"))
    table = pd.concat(tables, names=["record"])
    table.attrs["units"] = {c: channel_unit(problem, c) for c in channels_of(problem)}
    return table


def part_of(table: pd.DataFrame, problem: Problem, ending: str) -> pd.DataFrame:
    """The columns `CHANNEL_ENDING` of an overlay under the names of their channels."""
    columns = {f"{channel}_{ending}": channel for channel in channels_of(problem)}
    found = table[list(columns)].rename(columns=columns)
    found.attrs.update(table.attrs)
    return found


def channels_of(problem: Problem) -> list[str]:
    """The compared channels of any record."""
    return list(dict.fromkeys(c for record in prepared_records(problem) for c in record.measured))


def record_named(problem: Problem, name: str | None, channel: str, model: Model) -> PreparedRecord:
    """The prepared record called `name`; without a name the one with the largest error, a held-out one if there is one.

    Raises:
        InputError: no such record.
    """
    from stagecad.parameters.errors import InputError, nearest
    from workbench.report.figures import worst_record

    records: Sequence[PreparedRecord] = prepared_records(problem)
    if name is None:
        return worst_record(problem.validate_records or problem.fit_records, channel, model)
    for record in records:
        if record.name == name:
            return record
    raise InputError(f"no record '{name}'{nearest(name, [record.name for record in records])}")


def channel_named(problem: Problem, name: str | None) -> str:
    """The channel called `name`; without a name the one whose error is reported first.

    Raises:
        InputError: no such channel.
    """
    from stagecad.parameters.errors import InputError, nearest
    from sysid.report import headline_channel

    if name is None:
        return headline_channel(problem)
    if name not in channels_of(problem):
        raise InputError(f"no channel '{name}'{nearest(name, channels_of(problem))}")
    return name
