"""`[[record]]` tables: file, role, column names, units, signs and time window of each record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from stagecad.parameters.errors import InputError, nearest
from sysid.experiment.channels import Source, choose_columns
from sysid.experiment.readers.base import shown_path
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.rigs import RigKind
from sysid.experiment.toml_table import TomlTable, quantity, shown


@dataclass(frozen=True)
class RecordSpec:
    """One `[[record]]` table with the columns of its channels.

    Args:
        name: `name` in the file, else the stem of `file`; unique.
        file: as written.
        path: of the file, or its table in memory.
        role: `fit` or `validate`.
        sources: channel to column.
        sign: channel to 1 or -1.
        start, stop: window on the time column, s; None if unbounded.
        continues: name of the record that this one continues.
        noise: standard deviations of the noise of this record, SI.
        notes: on unused columns.
        where: position in the experiment file, for messages.
    """

    name: str
    file: str
    path: Path | MemoryTable
    role: Literal["fit", "validate"]
    sources: Mapping[str, Source]
    sign: Mapping[str, int] = field(default_factory=dict)
    start: float | None = None
    stop: float | None = None
    continues: str | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    where: str = ""


def read_record_specs(
    top: TomlTable, kind: RigKind, file: Path, in_memory: Mapping[str, MemoryTable] | None = None
) -> tuple[tuple[RecordSpec, ...], list[tuple[str, bool]]]:
    """Every `[[record]]` with its columns, and whether the axis is rotary according to the units of its columns.

    Args:
        top: the experiment file as a table.
        kind: kind of rig.
        file: path of the experiment file; paths of records are relative to its folder.
        in_memory: the records by the `file` of their table, where they are not in files.

    Raises:
        InputError: an error in a table, or in the header of a record's file.
    """
    tables = top.tables("record")
    if not tables:
        raise InputError(f"{top.file}: there is no record; write [[record]] with file and role")
    records: list[RecordSpec] = []
    axes: list[tuple[str, bool]] = []
    for table in tables:
        table.allow(("file", "role", "name", "columns", "units", "sign", "from", "to", "continues", "noise"))
        written = table.text("file")
        role: Any = table.choice("role", ("fit", "validate"))
        source = file.parent / written if in_memory is None else in_memory[written]
        shown_name = shown_path(str(source))
        opened = open_record_file(source, shown_name)
        renamed, units = _texts_by_key(table.table("columns")), _texts_by_key(table.table("units"))
        # Units inside the file are used where the experiment gives none.
        units = {key: unit for key, unit in opened.units.items() if key in (*kind.channels, *opened.labels)} | units
        sources, rotary, notes = choose_columns(opened.labels, kind, shown_name, renamed, units, table.where())
        axes += [
            (f"column '{sources[channel].column.label.strip()}' of {written}", turns)
            for channel, turns in rotary.items()
        ]
        records.append(
            RecordSpec(
                name=_unique_name(table, written, [record.name for record in records]),
                file=written,
                path=source,
                role=role,
                sources=sources,
                sign=_signs(table.table("sign"), kind),
                start=quantity(table, "from", "s") if "from" in table.data else None,
                stop=quantity(table, "to", "s") if "to" in table.data else None,
                continues=table.text("continues") if "continues" in table.data else None,
                notes=tuple(notes),
                where=table.where(),
            )
        )
        last = records[-1]
        if last.start is not None and last.stop is not None and last.start >= last.stop:
            raise InputError(f"{table.where()}: from = '{table.data['from']}' is not before to = '{table.data['to']}'")
    if all(record.role != "fit" for record in records):
        raise InputError(f"{top.file}: no record has role = 'fit'; the fit needs one")
    return _resolve_continues(records), axes


def _unique_name(table: TomlTable, written: str, taken: list[str]) -> str:
    if "name" in table.data:
        name = table.text("name")
        if name in taken:
            raise InputError(f"{table.where('name')}: '{name}' names another record already")
        return name
    stem = Path(written).stem
    name, number = stem, 1
    while name in taken:
        number += 1
        name = f"{stem}#{number}"
    return name


def _resolve_continues(records: list[RecordSpec]) -> tuple[RecordSpec, ...]:
    names = {record.name: record.name for record in records}
    for record in records:
        names.setdefault(record.file, record.name)
    resolved: list[RecordSpec] = []
    for record in records:
        if record.continues is not None:
            if record.continues not in names:
                raise InputError(
                    f"{record.where}: continues = '{record.continues}' names no record"
                    f"{nearest(record.continues, names)}"
                )
            other = names[record.continues]
            if other == record.name:
                raise InputError(f"{record.where}: continues = '{record.continues}': a record cannot continue itself")
            if other not in [earlier.name for earlier in resolved]:
                raise InputError(
                    f"{record.where}: continues = '{record.continues}' is defined below; "
                    "put the earlier record above the later"
                )
            record = replace(record, continues=other)
        resolved.append(record)
    return tuple(resolved)


def _texts_by_key(table: TomlTable) -> dict[str, str]:
    return {key: table.text(key) for key in table.data}


def _signs(table: TomlTable, kind: RigKind) -> dict[str, int]:
    signs = {}
    for key, value in table.data.items():
        if key not in kind.channels:
            raise InputError(f"{table.where()}: '{key}' is no channel of {kind.name}{nearest(key, kind.channels)}")
        if isinstance(value, bool) or value not in (1, -1):
            raise InputError(f"{table.where(key)}: {shown(value)} is not allowed; 1 or -1 is wanted")
        signs[key] = int(value)
    return signs
