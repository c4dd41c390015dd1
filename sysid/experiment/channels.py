"""Columns of a record: names, units, and assignment to channels."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import parse_quantity, unit_dimension
from sysid.experiment.rigs import CHANNELS, RigKind

LONGEST_LABEL = 200
"""Longest header cell that may hold a unit; the pattern takes a time that grows with the square of the length."""
_LABEL = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[\s*(?P<unit>[^\[\]]*?)\s*\]\s*)?")


@dataclass(frozen=True)
class Column:
    """One column of a file.

    Args:
        index: position in the file, from 0.
        label: header as written.
        name: text before the unit.
        unit: text in brackets; none without brackets.
    """

    index: int
    label: str
    name: str
    unit: str | None


@dataclass(frozen=True)
class Source:
    """Column of a channel, and the conversion of its cells to SI units (value * factor + offset)."""

    channel: str
    column: Column
    unit: str
    si_unit: str
    factor: float
    offset: float


def parse_label(index: int, label: str) -> Column:
    """Name and unit of a header cell `name [unit]`; unclosed brackets are part of the name."""
    match = _LABEL.fullmatch(label) if len(label) <= LONGEST_LABEL else None
    if match is None:
        return Column(index, label, label.strip(), None)
    return Column(index, label, match["name"], match["unit"])


@cache
def conversion(unit: str, si_unit: str) -> tuple[float, float]:
    """Factor and offset with value_si = factor * value + offset.

    Raises:
        InputError: unknown unit, or another dimension than `si_unit`.
    """
    offset = parse_quantity(f"0 {unit}", si_unit, unit)
    return parse_quantity(f"1 {unit}", si_unit, unit) - offset, offset


def same_dimension(unit: str, other: str) -> bool:
    """Whether two units have the same dimension, where the radian counts as a dimension.

    Raises:
        InputError: unknown unit.
    """
    return unit_dimension(unit) == unit_dimension(other)


def unit_for(unit: str, linear: str, rotary: str, where: str) -> tuple[str, bool | None]:
    """The SI unit that `unit` converts to, and whether the axis is rotary (None if the unit does not determine it).

    Raises:
        InputError: names `where`, the unit, and the permitted units.
    """
    try:
        if same_dimension(unit, linear):
            return linear, None if linear == rotary else False
        if same_dimension(unit, rotary):
            return rotary, True
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    wanted = f"{linear}' or a multiple of it" if linear == rotary else f"{linear}' or '{rotary}' or a multiple of it"
    raise InputError(f"{where}: unit '{unit}' has the wrong dimension; wanted '{wanted}")


def choose_columns(
    labels: Sequence[str],
    rig: RigKind,
    file: str,
    renamed: Mapping[str, str],
    units: Mapping[str, str],
    where: str,
) -> tuple[dict[str, Source], dict[str, bool], list[str]]:
    """Assign the columns of a file to the channels of the rig.

    Args:
        labels: header cells, or variable names.
        rig: kind of rig.
        file: shown in messages.
        renamed: `columns` of the record, channel to column name.
        units: `units` of the record, channel (or column name) to unit.
        where: the record's place in the experiment file, for messages about `columns` and `units`.

    Returns:
        The source of each channel; whether the axis is rotary, for channels whose unit determines it; notes on unused
        columns.

    Raises:
        InputError: a required channel is missing, or a column has no unit or one of another dimension.
    """
    columns = [parse_label(index, label) for index, label in enumerate(labels)]
    notes: list[str] = []
    _check_keys(renamed, units, rig, columns, where)
    by_channel: dict[str, Column] = {}
    for channel in rig.channels:
        wanted = renamed.get(channel, channel)
        found = [column for column in columns if wanted in (column.name, column.label.strip())]
        # A variable inside a MAT structure may also be named by its full path.
        found = found or [column for column in columns if column.name and wanted.endswith(f".{column.name}")]
        if channel in renamed and not found:
            raise InputError(
                f"{where}.columns: {channel} = '{wanted}', but {file} has no such column"
                f"{nearest(wanted, [column.name for column in columns])}"
            )
        if len(found) > 1:
            notes.append(f"column '{wanted}' is given {len(found)} times; the first is used")
        if found:
            by_channel[channel] = found[0]
    _check_present(by_channel, rig, columns, file)
    used = {column.index for column in by_channel.values()}
    for column in columns:
        if column.index not in used and column.name not in by_channel:
            what = "is not used by this kind of rig" if column.name in CHANNELS else "is not known"
            notes.append(f"column '{column.label.strip()}' {what}; left out")
    sources: dict[str, Source] = {}
    rotary: dict[str, bool] = {}
    for channel, column in by_channel.items():
        unit = units.get(channel, units.get(column.name, column.unit))
        if not unit:
            example = CHANNELS[channel].unit
            raise InputError(
                f"{file}: column '{column.label.strip()}' has no unit; write '{column.name} [{example}]' in the header"
                f', or units = {{{channel} = "{example}"}} in the experiment'
            )
        declared = CHANNELS[channel]
        place = f"{file}: column '{column.label.strip()}'"
        # A load on a rotary axis may be a force or a torque: its unit does not determine the kind of axis.
        torque = "N*m" if channel == "normal_load" else declared.rotary_unit
        si_unit, is_rotary = unit_for(unit, declared.unit, torque, place)
        if is_rotary is not None and declared.shows_axis:
            rotary[channel] = is_rotary
        factor, offset = conversion(unit, si_unit)
        sources[channel] = Source(channel, column, unit, si_unit, factor, offset)
    return sources, rotary, notes


def _check_keys(
    renamed: Mapping[str, str], units: Mapping[str, str], rig: RigKind, columns: list[Column], where: str
) -> None:
    for channel in renamed:
        if channel not in rig.channels:
            raise InputError(
                f"{where}.columns: '{channel}' is no channel of {rig.name}{nearest(channel, rig.channels)}"
            )
    names = {column.name for column in columns}
    for channel in units:
        if channel not in rig.channels and channel not in names:
            raise InputError(f"{where}.units: '{channel}' is no channel of {rig.name}{nearest(channel, rig.channels)}")


def _check_present(found: Mapping[str, Column], rig: RigKind, columns: list[Column], file: str) -> None:
    names = [column.name for column in columns]
    for group in (("time",), *rig.inputs, *rig.measured):
        if not any(channel in found for channel in group):
            wanted = " or ".join(f"'{channel}'" for channel in group)
            spare = [name for name in names if name and name not in found]
            near = [nearest(channel, spare) for channel in group] if spare else []
            near = [text for text in near if "did you mean" in text]
            has = f"; it has: {', '.join(names[:12])}" if any(names) else ""
            if has and spare:
                has += f'; if one is it under another name: columns = {{{group[0]} = "NAME"}}'
            raise InputError(f"{file}: no column {wanted}, which {rig.name} needs{near[0] if near else has}")
