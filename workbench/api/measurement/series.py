"""Measured, predicted and simulated channels of an experiment as tables. SI units; index `record`, `time`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
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
    own = record.time
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


def free_run_table(problem: Problem, model: Model) -> pd.DataFrame:
    """Logged and simulated channels of every record, `CHANNEL` and `CHANNEL_simulated`."""
    import pandas as pd

    from sysid.prediction.simulation_error import free_runs

    tables = {}
    for name, (time, run) in free_runs(problem, model).items():
        columns = {}
        for channel, (logged, simulated) in run.items():
            columns[channel], columns[f"{channel}_simulated"] = logged, simulated
        tables[name] = pd.DataFrame(columns, index=pd.Index(time, name="time"))
    return pd.concat(tables, names=["record"])


def prediction_error_table(problem: Problem, model: Model, horizons: Sequence[float]) -> pd.DataFrame:
    """Errors of simulations over each horizon (s) and of the free run; index `horizon`, `records`, `channel`."""
    import pandas as pd

    from stagecad.parameters.errors import InputError
    from sysid.prediction.simulation_error import simulation_errors

    if any(not length > 0.0 for length in horizons):
        raise InputError(f"prediction_errors: horizons {list(horizons)}: lengths above zero are required, in s")
    found = simulation_errors(problem, model, {f"{length:g} s": length for length in horizons})
    if found.note:
        raise InputError(found.note)
    rows = [
        {
            "horizon": horizon,
            "records": PARTS[part],
            "channel": channel,
            "rms": error.rms,
            "fit_percent": error.fit_percent,
        }
        for horizon, errors in {**found.horizon, "free run": found.free_run}.items()
        for part, channels in errors.items()
        for channel, error in channels.items()
    ]
    columns = ["horizon", "records", "channel", "rms", "fit_percent"]
    return pd.DataFrame(rows, columns=columns).set_index(columns[:3])


def part_of(table: pd.DataFrame, problem: Problem, ending: str) -> pd.DataFrame:
    """The columns `CHANNEL_ENDING` of an overlay under the names of their channels."""
    import pandas as pd

    columns = {f"{channel}_{ending}": channel for channel in channels_of(problem)}
    found = pd.DataFrame({channel: table[label] for label, channel in columns.items()})
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
