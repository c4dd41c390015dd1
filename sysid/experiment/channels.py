"""Columns of a record: names, units, and assignment to channels."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from stagecad.parameters.errors import InputError, at_place, nearest, require
from stagecad.parameters.units import format_quantity, parse_quantity, to_si, unit_dimension
from sysid.experiment.column_settings import (
    PARTS,
    RATED,
    ChannelSettings,
    ColumnSetting,
    Scale,
    column_unit,
    unit_endings,
)
from sysid.experiment.readers.base import Header
from sysid.experiment.rigs import Channel, RigKind
from sysid.experiment.toml_table import check_size

SHOWN_LABELS = 6
"""Columns that a note on several names."""

LONGEST_LABEL = 200
"""Longest header cell that may hold a unit; the search takes a time that grows with the square of the length."""
_LABEL = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[\s*(?P<unit>[^\[\]]*?)\s*\]\s*)?")
_OTHER_LABELS = (
    re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*)\)\s*"),
    re.compile(r"(?P<name>.*?)\s*/\s*(?P<unit>[^\s/][^\s]*)\s*"),
    re.compile(r"(?P<name>.*?),?\s+in\s+(?P<unit>\S+)\s*"),
)
_FORM_OF_TIME = re.compile(r"(?=.*(?::|yy))[dmyhsft]+(?:[:./\- ]+[dmyhsft]+)+", re.IGNORECASE)
"""What stands in the place of a unit above times of day, durations and dates, such as `hh:mm:ss.fff`."""


@dataclass(frozen=True)
class Column:
    """One column of a file: its place from 0, its header as written, the text before the unit, and the unit, if any."""

    index: int
    label: str
    name: str
    unit: str | None


@dataclass(frozen=True)
class Term:
    """A column and the conversion of its cells to the SI unit of a channel (value * factor + offset), with the
    relative standard deviation of the factor (infinite: it is fitted) and its text where it is uncertain. Cells that
    are increments are summed from the first row on; those that begin anew after a `period`, SI, are continued."""

    column: Column
    unit: str
    factor: float
    offset: float = 0.0
    deviation: float = 0.0
    scale: str = ""
    increments: bool = False
    period: float = 0.0


@dataclass(frozen=True)
class Source:
    """Columns of a channel, whose converted values are added; none for a time that is made of the sampling rate, and
    for a channel of which the experiment states the value of all rows, or the step from row to row, SI."""

    channel: str
    terms: tuple[Term, ...]
    si_unit: str
    value: float | None = None
    step: float | None = None

    @property
    def label(self) -> str:
        """The columns as written, for a message."""
        return " + ".join(term.column.label.strip() for term in self.terms) or self.channel


def parse_label(index: int, label: str) -> Column:
    """Name and unit of a header cell: `name [unit]`, `name (unit)`, `name/unit` or `name in unit`.

    Brackets hold the unit whatever it is; in the other forms it must be a known one, else it is part of the name. So
    are unclosed brackets.
    """
    if len(label) > LONGEST_LABEL:
        return Column(index, label, label.strip(), None)
    match = _LABEL.fullmatch(label)
    if match is not None and match["unit"] is not None:
        unit = None if _FORM_OF_TIME.fullmatch(match["unit"]) else match["unit"]
        return Column(index, label, match["name"], unit)
    for form in _OTHER_LABELS:
        found = form.fullmatch(label.strip())
        if found is not None and found["name"] and column_unit(found["unit"]) is not None:
            return Column(index, label, found["name"], found["unit"])
    return Column(index, label, label.strip(), None)


@cache
def conversion(unit: str, si_unit: str) -> tuple[float, float]:
    """Factor and offset with value_si = factor * value + offset."""
    offset = parse_quantity(f"0 {unit}", si_unit, unit)
    return parse_quantity(f"1 {unit}", si_unit, unit) - offset, offset


def same_dimension(unit: str, other: str) -> bool:
    """Whether two units have the same dimension, where the radian counts as a dimension."""
    return unit_dimension(unit) == unit_dimension(other)


def unit_for(unit: str, linear: str, rotary: str, where: str) -> tuple[str, bool | None]:
    """The SI unit that `unit` converts to, and whether the axis is rotary (None if the unit does not determine it)."""
    with at_place(where):
        if same_dimension(unit, linear):
            return linear, None if linear == rotary else False
        if same_dimension(unit, rotary):
            return rotary, True
    wanted = f"{linear}' or a multiple of it" if linear == rotary else f"{linear}' or '{rotary}' or a multiple of it"
    raise InputError(f"{where}: unit '{unit}' has the wrong dimension; wanted '{wanted}")


def choose_columns(
    header: Header,
    rig: RigKind,
    file: str,
    settings: ChannelSettings,
    units: Mapping[str, str],
    where: str,
    rated: Mapping[str, Scale],
    untimed: bool = False,
) -> tuple[dict[str, Source], dict[str, bool], list[str]]:
    """Assign the columns of a file to the channels of the rig; columns in percent are parts of the `rated` values."""
    columns = [parse_label(index, label) for index, label in enumerate(header.labels)]
    notes: list[str] = []
    names = {column.name for column in columns}
    for channel in units:
        if channel not in rig.channels and channel not in names:
            known = nearest(channel, rig.channels)
            raise InputError(f"{where}.units: '{channel}' is not a channel of {rig.name}{known}")
    chosen: dict[str, list[tuple[Column, ColumnSetting]]] = {}
    sources = {"time": Source("time", (), "s")} if untimed else {}
    rotary: dict[str, bool] = {}
    for channel in rig.channels:
        if channel == "time" and untimed:
            continue
        for setting in settings.get(channel, (ColumnSetting(),)):
            if setting.stated is not None:
                sources[channel] = _stated_source(rig.declared(channel), setting, rotary, notes)
                continue
            found = _find(channel, setting, columns, rig, file, notes)
            if found is not None:
                chosen.setdefault(channel, []).append((found, setting))
    _check_present({**chosen, **sources}, rig, columns, file, header.numbered)
    require(chosen, f"{file}: no channel has a column; how many rows it has is not known")
    used = {column.index: channel for channel, terms in chosen.items() for column, _ in terms}
    idle = [c for c in columns if c.index not in {*used, *header.dates} and c.name and c.name not in chosen]
    for what, ours in (("used by this kind of rig", True), ("known", False)):
        labels = [f"'{column.label.strip()}'" for column in idle if (column.name in rig.all_channels) == ours]
        more = f" and {len(labels) - SHOWN_LABELS} more" * (len(labels) > SHOWN_LABELS)
        subject = (
            f"columns {', '.join(labels[:SHOWN_LABELS])}{more} are" if labels[1:] else f"column {''.join(labels)} is"
        )
        notes += [f"{subject} not {what}; left out"] if labels else []
    for channel, terms in chosen.items():
        declared = rig.declared(channel)
        converted = [
            _term(declared, column, setting, rated.get(channel), header, units, file) for column, setting in terms
        ]
        if len({unit for _, unit, _ in converted}) > 1:
            unlike = " and ".join(unit for _, unit, _ in converted)
            raise InputError(f"{terms[0][1].where}: the columns of '{channel}' are {unlike}, which cannot be added")
        sources[channel] = Source(channel, tuple(term for term, _, _ in converted), converted[0][1])
        summed = [term.column.label.strip() for term in sources[channel].terms if term.increments]
        notes += [f"'{channel}' is the sum of the increments in column '{label}'" for label in summed]
        if converted[0][2] is not None and declared.shows_axis:
            rotary[channel] = converted[0][2]
    return sources, rotary, notes


def _stated_source(declared: Channel, setting: ColumnSetting, rotary: dict[str, bool], notes: list[str]) -> Source:
    """A channel without a column; whether the axis is rotary is put into `rotary` where its unit determines it."""
    stated, sign = setting.stated, setting.sign or 1
    assert stated is not None
    torque = "N*m" if declared.name == "normal_load" else declared.rotary_unit
    problem = ""
    for si_unit, turns in dict.fromkeys(((declared.unit, False), (torque, True))):
        try:
            value = sign * parse_quantity(stated.text, si_unit, setting.where)
        except InputError as error:
            problem = problem or str(error)
            continue
        if declared.shows_axis and declared.unit != torque:
            rotary[declared.name] = turns
        check_size(value, f"'{stated.text}'", setting.where)
        if stated.per_row and value == 0.0:
            raise InputError(f"{setting.where}: '{stated.text}' must be finite, and a step from row to row not zero")
        if stated.per_row:
            notes.append(f"'{declared.name}' moves by {format_quantity(value, si_unit)} from row to row")
            return Source(declared.name, (), si_unit, step=value)
        return Source(declared.name, (), si_unit, value=value)
    raise InputError(problem)


def _find(
    channel: str, setting: ColumnSetting, columns: Sequence[Column], rig: RigKind, file: str, notes: list[str]
) -> Column | None:
    """The column of a channel; None where the file has none of its name and the experiment names none."""
    if isinstance(setting.column, int):
        if setting.column > len(columns):
            raise InputError(f"{setting.where}: column {setting.column}, but {file} has {len(columns)} columns")
        return columns[setting.column - 1]
    wanted = channel if setting.column is None else setting.column
    found = [column for column in columns if wanted in (column.name, column.label.strip())]
    # A variable inside a MAT structure may also be named by its full path.
    found = found or [column for column in columns if column.name and wanted.endswith(f".{column.name}")]
    if len(found) > 1:
        notes.append(f"column '{wanted}' is given {len(found)} times; the first is used")
    if not found:
        declared = rig.declared(channel)
        found = [other for column in columns if (other := _written_otherwise(column, wanted, declared)) is not None]
        if len(found) > 1:
            labels = " and ".join(f"'{column.label.strip()}'" for column in found)
            raise InputError(
                f"{file}: columns {labels} may both be '{wanted}'; write which: "
                f'[channels] {channel} = "{found[0].label.strip()}"'
            )
        notes += [f"column '{column.label.strip()}' is taken as '{wanted}'" for column in found]
    if not found and setting.column is not None:
        raise InputError(
            f"{setting.where}: {channel} = '{wanted}', but {file} has no such column"
            f"{nearest(wanted, [column.name for column in columns])}"
        )
    return found[0] if found else None


def _written_otherwise(column: Column, wanted: str, declared: Channel) -> Column | None:
    """The column if its name is the wanted one in other letters, or with a unit of the channel's dimension behind."""

    def plain(text: str) -> str:
        return re.sub(r"[\s_-]+", "_", text.strip()).casefold()

    if plain(column.name) == plain(wanted):
        return column
    endings = unit_endings(column.name) if column.unit is None and len(column.name) <= LONGEST_LABEL else ()
    for name, unit in endings:
        fits = any(same_dimension(unit, si) for si in (declared.unit, declared.rotary_unit))
        if plain(name) == plain(wanted) and fits:
            return Column(column.index, column.label, name, unit)
    return None


def _term(
    declared: Channel,
    column: Column,
    setting: ColumnSetting,
    rated: Scale | None,
    header: Header,
    units: Mapping[str, str],
    file: str,
) -> tuple[Term, str, bool | None]:
    """A column of a channel, the SI unit it is converted to, and whether the axis is rotary (None if not known)."""
    channel, place = declared.name, f"{file}: column '{column.label.strip()}'"
    stated = units.get(channel, units.get(column.name, setting.unit))
    stated = stated or header.units.get(column.label, header.units.get(channel)) or column.unit
    sign = setting.sign or 1
    # A load on a rotary axis may be a force or a torque: its unit does not determine the kind of axis.
    torque = "N*m" if channel == "normal_load" else declared.rotary_unit
    if column.label in header.texts:
        cell = header.texts[column.label]
        stamps = '; if these are time stamps, name their form, such as [format] time_format = "%d.%m.%Y %H:%M:%S.%f"'
        hint = stamps if re.search(r"\d", cell) else ", numbers are required"
        raise InputError(f"{place} holds text, such as '{cell}'{hint}")
    if not stated and setting.scale is None:
        key = str(column.index + 1) if header.numbered else f'"{column.name}"'
        raise InputError(
            f"{place} has no unit; write '{column.name} [{declared.unit}]' in the header, or "
            f'[channels] {channel} = {{column = {key}, unit = "{declared.unit}"}} in the experiment'
        )
    unit = column_unit(stated) or stated if stated else "count"
    scale = setting.scale or (rated if unit in PARTS else None)
    if scale is None and unit in PARTS:
        raise InputError(
            f"{place} is in {PARTS[unit]}; state its rated value (100 %), such as [rig.known] {RATED}{channel} = "
            f'"1 {declared.unit}"'
        )
    summed, period = bool(setting.increments), setting.period or 0.0
    if scale is None:
        si_unit, is_rotary = unit_for(unit, declared.unit, torque, place)
        factor, offset = conversion(unit, si_unit)
        offset = 0.0 if summed else offset
        return Term(column, unit, sign * factor, sign * offset, 0.0, "", summed, factor * period), si_unit, is_rotary
    with at_place(place):
        dimension = tuple(a + b for a, b in zip(unit_dimension(unit), scale.dimension, strict=True))
    for si_unit, is_rotary in ((declared.unit, False), (torque, True)):
        if dimension == unit_dimension(si_unit):
            factor = sign * to_si(1.0, unit) * scale.value
            deviation = (scale.std or 0.0) / abs(scale.value)
            told = None if declared.unit == torque else is_rotary
            text = scale.text if deviation else ""
            return Term(column, unit, factor, 0.0, deviation, text, summed, abs(factor) * period), si_unit, told
    raise InputError(
        f"{setting.where or place}: '{unit}' times scale = '{scale.text}' is no '{declared.unit}'"
        + (f" or '{torque}'" if torque != declared.unit else "")
    )


def _check_present(found: Mapping[str, object], rig: RigKind, columns: list[Column], file: str, numbered: bool) -> None:
    names = [column.name for column in columns]
    groups = (("time",), *rig.inputs, *rig.measured)
    for group in [group for group in groups if not any(channel in found for channel in group)]:
        wanted = " or ".join(f"'{channel}'" for channel in group)
        if numbered:
            needed = [name for name in ("time", *(g[0] for g in (*rig.inputs, *rig.measured))) if name not in found]
            units = {name: rig.declared(name).unit for name in needed}
            entries = ", ".join(f'{n} = {{column = {k}, unit = "{u}"}}' for k, (n, u) in enumerate(units.items(), 1))
            raise InputError(
                f"{file}: has no header, and {len(columns)} columns; name them by their numbers: [channels] {entries}"
            )
        spare = [name for name in names if name and name not in found]
        near = [nearest(channel, spare) for channel in group] if spare else []
        near = [text for text in near if "did you mean" in text]
        has = f"; it has: {', '.join(names[:12])}" if any(names) else ""
        if has and spare:
            has += f'; if one is it under another name: [channels] {group[0]} = "NAME"'
        has += '; without one: [format] sample_rate = "1 kHz"' if group == ("time",) else ""
        raise InputError(f"{file}: no column {wanted}, which {rig.name} needs{near[0] if near else has}")
