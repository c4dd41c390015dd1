"""Records as arrays: reading, conversion to SI units, time window, checks, and a held-out part if none is given."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment import time_stamps
from sysid.experiment.experiment import Experiment, RecordSpec
from sysid.experiment.quality import Fault, faults_of, without_faults
from sysid.experiment.readers.base import MOST_ROWS, shown_path
from sysid.experiment.readers.open import RecordFile, open_record_file
from sysid.experiment.record_spec import Bound
from sysid.experiment.rigs import RigKind
from sysid.experiment.toml_table import LARGEST, check_size

MINIMUM_ROWS = 10
"""Least number of rows of a record."""
LONG_AGO = 1e8
"""Time of the first row, s, from which it is a time stamp and the record's time is counted from that row: three years.
A float resolves Unix times to 0.2 us only."""
HELD_OUT_SHARE = 0.3
"""Share of a record's time that is held out if no record has the role `validate`."""


@dataclass(frozen=True)
class Record:
    """One record, ready for comparison.

    `time` (n,), s, increases strictly, as logged or from the first row of time stamps; `channels` are SI values (n,)
    with gaps as NaN, also in the rows of `faults`; `step` is the sampling step, s, `uniform` whether every step equals
    it within 1 %; `continues` names the record that this one continues; `noise` is the stated standard deviation by
    channel, SI; `sha256` is that of the file, `notes` are for the user."""

    name: str
    role: Literal["fit", "validate"]
    file: str
    time: np.ndarray
    channels: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    rotary: bool
    notes: tuple[str, ...]
    sha256: str
    step: float
    uniform: bool
    continues: str | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.time.size)


def load_records(experiment: Experiment) -> list[Record]:
    """Read every record of an experiment.

    Without a record of role `validate`, the last 30 % in time of each record is held out as a separate record that
    continues the first part; the notes of both records state this.
    """
    records = load_whole_records(experiment)
    if all(record.role == "fit" for record in records):
        return _hold_out(records)
    return records


def load_whole_records(experiment: Experiment, logged: bool = False) -> list[Record]:
    """Read every record of an experiment; nothing is held out. Raises as `load_records`. With `logged`, the channels
    are those of the file where a declared kind of rig computes others from them."""
    rig, records = experiment.rig, []
    for spec in experiment.records:
        kind = rig.declaration
        if logged and spec.balance is not None:
            kind, spec = spec.balance.kind, replace(spec, balance=None)
        records += load_runs(spec, kind, rig.rotary, {} if logged else experiment.noise)
    return records


def load_runs(spec: RecordSpec, rig: RigKind, rotary: bool, noise: Mapping[str, float] | None = None) -> list[Record]:
    """Read a file with the columns of a kind of rig: a record for each run; each run starts the time anew."""
    name = shown_path(str(spec.path))
    opened = open_record_file(spec.path, name, spec.settings)
    notes = list(spec.notes)
    time, values, origin = _read_columns(spec, opened, notes)
    _check_rows(time.size, name)
    starts = time_stamps.restarts(time)
    parts = [
        slice(start, stop) for start, stop in zip(starts, [*starts[1:], time.size]) if stop - start >= MINIMUM_ROWS
    ]
    if len(starts) > 1:
        notes.append(f"time starts anew {len(starts) - 1} times: {len(parts)} runs, each a record of its own")
    records = []
    for number, rows in enumerate(parts or [slice(0, time.size)], start=1):
        own = replace(spec, name=spec.name if number == 1 else f"{spec.name}#run{number}")
        part = {channel: array[rows] for channel, array in values.items()}
        own = replace(own, noise={**(noise or {}), **spec.noise})
        if spec.balance is not None:
            own = replace(own, noise=spec.balance.noise(time[rows], part, own.noise))
        records.append(_run(own, rig, rotary, opened, time[rows], part, origin, list(notes)))
    return records


def _run(
    spec: RecordSpec,
    rig: RigKind,
    rotary: bool,
    opened: RecordFile,
    time: np.ndarray,
    values: dict[str, np.ndarray],
    origin: float,
    notes: list[str],
) -> Record:
    """One run of a file in its window, its time counted from `origin`, s, as a record, with gaps where its sensors have
    no value of their own."""
    terms = spec.sources["time"].terms
    rounding = time_stamps.stamp_rounding(time, terms[0].factor if terms else 1.0, origin)
    time, values = _check_time(time, values, opened, spec, notes)
    time = time_stamps.sampled_times(time, rounding, notes)
    if spec.balance is not None:
        values = spec.balance.channels(time, values)
    time, values = _window(time, values, spec, origin, opened.name, notes)
    values = _check_values(values, spec, rig, opened.name, notes)
    computed = spec.balance.kind.balance if spec.balance is not None else {}
    units = {
        channel: rig.declared(channel).si_unit(rotary) if channel in computed else spec.sources[channel].si_unit
        for channel in values
    }
    faults = faults_of(time, values, units, [channel for channel in rig.measured_channels if channel in values])
    steps = np.diff(time)
    step = float(np.median(steps))
    uniform = bool(np.all(np.abs(steps - step) <= 0.01 * step))
    notes += [] if uniform else time_stamps.jitter(steps, step)
    return Record(
        name=spec.name,
        role=spec.role,
        file=spec.file,
        time=time,
        channels=without_faults(values, faults),
        units=units,
        rotary=rotary,
        notes=tuple(notes),
        sha256=opened.sha256,
        step=step,
        uniform=uniform,
        continues=spec.continues,
        noise=spec.noise,
        faults=tuple(faults),
    )


def _check_rows(rows: int, name: str) -> None:
    if rows < MINIMUM_ROWS:
        raise InputError(f"{name}: has {rows} row{'s' * (rows != 1)} of numbers; at least {MINIMUM_ROWS} are required")
    if rows > MOST_ROWS:
        raise InputError(f"{name}: has {rows} rows; at most {MOST_ROWS} are read, so keep every n-th one")


def _read_columns(
    spec: RecordSpec, opened: RecordFile, notes: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray], float]:
    """Time and channels in SI units, and the origin (s) from which a time stamp is counted."""
    name = opened.name
    indices = list(dict.fromkeys(term.column.index for source in spec.sources.values() for term in source.terms))
    if any(index >= len(opened.header.labels) for index in indices):
        raise InputError(f"{name}: changed while it was read; run again")
    columns = dict(zip(indices, opened.columns(indices), strict=True))
    last = {term.column.index: channel for channel, source in spec.sources.items() for term in source.terms}
    values: dict[str, np.ndarray] = {}
    origin = 0.0
    for channel, source in spec.sources.items():
        for term in source.terms:
            column = columns[term.column.index]
            notes += [note for note in column.notes if note not in notes]
            part = column.values
            if column.origin and channel != "time":
                part = part + column.origin
            # No rounding for a factor of one: the values are those logged.
            with np.errstate(over="ignore", under="ignore"):
                part = part if term.factor == 1.0 else part * term.factor
                part = part + term.offset if term.offset else part
                part = _summed(part, channel, term.column.label, opened) if term.increments else part
                period = term.period
                if channel == "time" and not (term.increments or period or term.offset):
                    period = term.factor * time_stamps.counter_range(column.values + column.origin)
                    notes += [f"'{term.column.label.strip()}' begins anew after {period:.6g} s"] if period else []
                part = _continued(part, period) if period else part
                values[channel] = values[channel] + part if channel in values else part
            if channel == "time" and column.origin:
                origin = column.origin * term.factor
                notes.append(column.said)
        for term in source.terms:
            if last[term.column.index] == channel:
                # Long columns are not kept twice.
                columns.pop(term.column.index, None)
    rows = next(iter(values.values())).size
    for channel, array in values.items():
        _check_size(array, f"{name}: column '{spec.sources[channel].label}'")
    for channel, source in spec.sources.items():
        if source.step is not None:
            values[channel] = source.step * np.arange(1.0, rows + 1.0)
        elif source.value is not None:
            values[channel] = np.full(rows, source.value)
    if spec.settings.sample_rate is not None:
        values["time"] = np.arange(rows) / spec.settings.sample_rate
        notes.append(f"time of a sampling rate of {spec.settings.sample_rate:g} Hz")
    time = values.pop("time")
    if time.size and not origin and abs(time[0]) > LONG_AGO:
        origin = float(time[0])
        time = time - origin
        notes.append(f"time is counted from its first row, {origin:.6f} s")
    return time, values, origin


def _check_size(values: np.ndarray, what: str) -> None:
    """Refuse values (n,), SI, with whose squares nothing can be computed."""
    largest = max(np.fmax.reduce(values, initial=0.0), -np.fmin.reduce(values, initial=0.0))
    check_size(float(largest), "its largest value", what)


def _continued(values: np.ndarray, period: float) -> np.ndarray:
    """Values (n,) that begin anew after a period, without its jumps; rows without a value stay gaps."""
    known = np.isfinite(values)
    result = values.copy()
    result[known] = np.unwrap(values[known], period=period)
    return result


def _summed(increments: np.ndarray, channel: str, label: str, opened: RecordFile) -> np.ndarray:
    """The channel (n,) whose change from the row before is given; it counts from the row before the first."""
    empty = np.flatnonzero(np.isnan(increments))
    if empty.size:
        raise InputError(
            f"{opened.name}: {opened.row_name(int(empty[0]))}, column '{label}': is empty; '{channel}' is the sum of "
            "this column, so every row needs its increment"
        )
    return np.cumsum(increments)


def _check_time(
    time: np.ndarray, values: dict[str, np.ndarray], opened: RecordFile, spec: RecordSpec, notes: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time and channels without repeated times, by the method that the experiment states; other faults are errors."""

    def refuse(row: int, problem: str) -> InputError:
        label = spec.sources["time"].label
        return InputError(f"{opened.name}: {opened.row_name(row)}, column '{label}': {problem}")

    def clock(row: int, relation: str) -> str:
        return f"time {time[row]:.9g} s {relation} the row before ({time[row - 1]:.9g} s)"

    empty = np.flatnonzero(np.isnan(time))
    if empty.size:
        gap = "is empty or a mark of [format] missing" if spec.settings.missing else "is empty"
        raise refuse(int(empty[0]), f"{gap}; every row needs its time")
    steps = np.diff(time)
    close = np.flatnonzero((steps > 0.0) & (steps < 1.0 / LARGEST))
    if close.size:
        raise refuse(int(close[0]) + 1, f"is less than {1.0 / LARGEST:g} s after the row before")
    falls = np.flatnonzero(steps < 0.0)
    if falls.size:
        row = int(falls[0]) + 1
        raise refuse(row, f"{clock(row, 'falls below')}; time must increase from row to row")
    try:
        return time_stamps.without_repeats(time, values, spec.settings.repeated_time, notes)
    except time_stamps.RepeatedTime as repeat:
        (row,) = repeat.args
        meant = 'write what is meant: [format] repeated_time = "first", "mean" or "spread"'
        raise refuse(row, f"{clock(row, 'repeats')} with other values; {meant}") from None


def _window(
    time: np.ndarray, values: dict[str, np.ndarray], spec: RecordSpec, origin: float, name: str, notes: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    if spec.start is None and spec.stop is None:
        return time, values
    low = -np.inf if spec.start is None else _place(spec.start, time, origin)
    high = np.inf if spec.stop is None else _place(spec.stop, time, origin)
    inside = slice(int(np.searchsorted(time, low, "left")), int(np.searchsorted(time, high, "right")))
    kept = time[inside]
    if kept.size < MINIMUM_ROWS:
        counted = ", counted from its first row" if origin else ""
        raise InputError(
            f"{spec.where}: the window from {low:g} s to {high:g} s holds {kept.size} rows of {name}, which runs from "
            f"{time[0]:g} s to {time[-1]:g} s{counted}; at least {MINIMUM_ROWS} are required"
        )
    notes.append(f"{kept.size} of {time.size} rows lie in the window")
    return kept, {channel: array[inside] for channel, array in values.items()}


def _place(bound: Bound, time: np.ndarray, origin: float) -> float:
    """A bound on `time`, s, which is counted from `origin`; an absolute one may be given with the origin in it."""
    if bound.relative:
        # A sum of decimal numbers is rounded: a row at the bound itself belongs to the window.
        return float(time[0]) + bound.value
    return bound.value - origin if origin and abs(bound.value) > 0.5 * abs(origin) else bound.value


def _check_values(
    values: dict[str, np.ndarray], spec: RecordSpec, rig: RigKind, name: str, notes: list[str]
) -> dict[str, np.ndarray]:
    kept: dict[str, np.ndarray] = {}
    stated = {channel for channel, source in spec.sources.items() if source.value is not None}
    zero = spec.balance.kind.zero_channels if spec.balance is not None else frozenset()
    for channel, array in values.items():
        if channel in zero:
            continue
        label = spec.sources[channel].label if channel in spec.sources else channel
        _check_size(array, f"{name}: {label}")
        gaps = int(np.count_nonzero(np.isnan(array)))
        if gaps == array.size:
            # An optional channel may be empty; a required one only if its alternative is recorded.
            notes.append(f"column '{label}' contains no numbers; left out")
            continue
        if gaps:
            notes.append(f"column '{label}' has {gaps} gap{'s' if gaps > 1 else ''} in {array.size} rows")
        elif np.ptp(array) == 0.0 and channel not in stated:
            notes.append(f"column '{label}' never changes")
        kept[channel] = array
    _check_common_rows(kept, rig, name)
    for group in (*rig.inputs, *rig.measured):
        if not any(channel in kept or channel in zero for channel in group):
            columns = " and ".join(f"'{spec.sources[c].label}'" for c in group if c in spec.sources)
            raise InputError(f"{name}: column {columns}: contains no numbers; {rig.name} needs it")
    return kept


def _check_common_rows(kept: Mapping[str, np.ndarray], rig: RigKind, name: str) -> None:
    """Refuse rows that hold either what is imposed or what is measured, as of two loggers in one file."""
    groups = [[key for key in group if key in kept] for group in (*rig.inputs, rig.measured_channels)]
    filled = [np.logical_or.reduce([~np.isnan(kept[key]) for key in group]) for group in groups if group]
    if len(filled) > 1 and not np.logical_and.reduce(filled).any():
        labels = " and ".join(f"'{key}'" for group in groups for key in group)
        raise InputError(
            f"{name}: no row holds {labels} together; bring them to common times, such as by "
            "interpolate(method='index') of pandas"
        )


def _hold_out(records: list[Record]) -> list[Record]:
    split: list[Record] = []
    for record in records:
        cut = record.time[0] + (1.0 - HELD_OUT_SHARE) * (record.time[-1] - record.time[0])
        first = int(np.searchsorted(record.time, cut, "right"))
        if first < MINIMUM_ROWS or record.size - first < 3:
            raise InputError(
                f"{record.file}: too short to hold out its last {HELD_OUT_SHARE:.0%}; "
                "add a record with role = 'validate'"
            )
        note = f"no record validates, so its last {HELD_OUT_SHARE:.0%} in time (from {cut:.6g} s) is held out"
        split += [_part(record, rows, note) for rows in (slice(0, first), slice(first, None))]
        split[-1] = replace(split[-1], role="validate", name=f"{record.name}#held-out", continues=record.name)
    return split


def _part(record: Record, rows: slice, note: str) -> Record:
    return replace(
        record,
        time=record.time[rows],
        channels={channel: array[rows] for channel, array in record.channels.items()},
        notes=(*record.notes, note),
        faults=tuple(part for fault in record.faults if (part := fault.within(rows)).rows.any()),
    )
