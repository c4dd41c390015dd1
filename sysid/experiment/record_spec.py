"""`[[record]]` tables: file, role, columns of the channels and time window of each record."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from stagecad.parameters.errors import InputError, nearest, require
from sysid.experiment import column_settings
from sysid.experiment.channels import Source, choose_columns
from sysid.experiment.readers.base import Format, read_format, shown_path
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.rig_kinds.declaration import Balance
from sysid.experiment.rigs import RigKind
from sysid.experiment.toml_table import TomlTable, quantity


@dataclass(frozen=True)
class Bound:
    """An end of the time window: s on the time column, or from its first row if it is relative (`"+2 s"`)."""

    value: float
    relative: bool = False


@dataclass(frozen=True)
class RecordSpec:
    """One `[[record]]` table with the columns of its channels.

    `name` is unique, `file` as written; `start` and `stop` bound the time; `continues` names the record that this one
    continues; `noise` has standard deviations, SI; `balance` computes the channels of a declared kind of rig.
    """

    name: str
    file: str
    path: Path | MemoryTable
    role: Literal["fit", "validate"]
    sources: Mapping[str, Source]
    settings: Format = field(default_factory=Format)
    start: Bound | None = None
    stop: Bound | None = None
    continues: str | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    balance: Balance | None = None
    where: str = ""


def read_record_specs(
    top: TomlTable, kind: RigKind, file: Path, in_memory: Mapping[str, MemoryTable] | None = None
) -> tuple[tuple[RecordSpec, ...], list[tuple[str, bool]]]:
    """Every `[[record]]` with its columns, and whether the axis is rotary according to the units of its columns."""
    tables = top.tables("record")
    require(tables, f"{top.file}: there is no record; write [[record]] with file and role")
    records: list[RecordSpec] = []
    axes: list[tuple[str, bool]] = []
    settings = read_format(top.table("format"))
    common = column_settings.read_channel_settings(top.table("channels"), kind)
    rated = column_settings.rated_values(top.table("rig").table("known"), kind)

    def source_of(written: str) -> Path | MemoryTable:
        return file.parent / written if in_memory is None else in_memory[written]

    for table in tables:
        spec, turns = _read_spec(table, kind, source_of, settings, common, rated)
        records.append(replace(spec, name=_unique_name(table, spec.file, [record.name for record in records])))
        axes += turns
    if all(record.role != "fit" for record in records):
        raise InputError(f"{top.file}: no record has role = 'fit'; the fit needs one")
    return _resolve_continues(records), axes


def _read_spec(
    table: TomlTable,
    kind: RigKind,
    source_of: Callable[[str], Path | MemoryTable],
    settings: Format,
    common: column_settings.ChannelSettings,
    rated: Mapping[str, column_settings.Scale],
) -> tuple[RecordSpec, list[tuple[str, bool]]]:
    """One record, not yet named, and whether the units of its columns are those of a rotary axis."""
    table.allow(("file", "role", "name", "channels", "columns", "units", "sign", "from", "to", "continues", "noise"))
    written = table.text("file")
    role: Any = table.choice("role", ("fit", "validate"))
    source = source_of(written)
    shown_name = shown_path(str(source))
    opened = open_record_file(source, shown_name, settings)
    channels = column_settings.read_record_settings(table, kind, common)
    units = {key: table.table("units").text(key) for key in table.table("units").data}
    untimed = settings.sample_rate is not None
    sources, rotary, notes = choose_columns(
        opened.header, kind, shown_name, channels, units, table.where(), rated, untimed
    )
    if opened.header.remarks:
        notes.insert(0, f"read as: {', '.join(opened.header.remarks)}")
    start, stop = (
        Bound(quantity(table, key, "s"), table.text(key).lstrip().startswith("+")) if key in table.data else None
        for key in ("from", "to")
    )
    if start and stop and start.relative == stop.relative and start.value >= stop.value:
        raise InputError(f"{table.where()}: from = '{table.data['from']}' is not before to = '{table.data['to']}'")
    spec = RecordSpec(
        name=written,
        file=written,
        path=source,
        role=role,
        sources=sources,
        settings=settings,
        start=start,
        stop=stop,
        continues=table.text("continues") if "continues" in table.data else None,
        notes=tuple(notes),
        where=table.where(),
    )
    return spec, [(f"column '{sources[channel].label}' of {written}", turns) for channel, turns in rotary.items()]


def _unique_name(table: TomlTable, written: str, taken: list[str]) -> str:
    if "name" in table.data:
        name = table.text("name")
        if name in taken:
            raise InputError(f"{table.where('name')}: '{name}' names another record already")
        return name
    stem = Path(written).stem
    names = itertools.chain([stem], (f"{stem}#{number}" for number in itertools.count(2)))
    return next(name for name in names if name not in taken)


def _resolve_continues(records: list[RecordSpec]) -> tuple[RecordSpec, ...]:
    names = {record.name: record.name for record in records}
    for record in records:
        names.setdefault(record.file, record.name)
    resolved: list[RecordSpec] = []
    for record in records:
        if record.continues is not None:
            place = f"{record.where}: continues = '{record.continues}'"
            if record.continues not in names:
                raise InputError(f"{place} names no record{nearest(record.continues, names)}")
            other = names[record.continues]
            if other == record.name:
                raise InputError(f"{place}: a record cannot continue itself")
            if other not in [earlier.name for earlier in resolved]:
                raise InputError(f"{place} is defined below; put the earlier record above the later")
            record = replace(record, continues=other)
        resolved.append(record)
    return tuple(resolved)
