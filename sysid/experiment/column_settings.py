"""`[channels]` of an experiment and of a record: which column a channel is, its unit, sign and scale."""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from stagecad.parameters.errors import InputError, at_place, require_known
from stagecad.parameters.units import SYMBOLS, Dimension, parse_any, to_si, unit_dimension, written_out
from sysid.experiment.rigs import RigKind
from sysid.experiment.toml_table import TomlTable, check_size, kind_of, shown

WORDS = tomllib.loads(Path(__file__).with_name("column_words.toml").read_text("utf-8"))
"""Words of headers and cells; the file says what they mean."""
_SPELLINGS, _WHOLE = (
    {spelling: unit for unit, spellings in WORDS[key].items() for spelling in spellings} for key in ("symbols", "units")
)
_MASS_TIMES_LENGTH = re.compile(
    r"(?P<mass>kg|g|oz|lbs?)\*(?P<length>in|ft|mm|cm|m)|(?P<first>in|ft)\*(?P<last>oz|lbs?)"
)
"""Torques of motors' data sheets, where the pound, ounce or kilogram is a force."""
_GLUED = re.compile(r"((?:[mukcdM]|da)?N|kgf?|gf|ozf?|lbf?)(mm|cm|m|in|ft)|(in|ft)(ozf?|lbf?)")
"""Torques whose two units are written without a sign between them, such as `Nm`."""
_KIND = re.compile(r"(?<=[AV])(?:[\s_]*(?:rms|eff|peak|pk|dc)|_RMS)$")
"""What an electric quantity is the value of: its scale says what that means."""


@cache
def column_unit(text: str) -> str | None:
    """The unit meant by the text of a header, in the symbols of `stagecad.parameters.units`; None if there is none."""
    written = _KIND.sub("", text.strip())
    # Written in capitals, a unit is looked for in small letters, too: but for N*m, which is no nanometre then.
    if not written or written in _WHOLE.values():
        return written or None
    if written.casefold() in _WHOLE and written != "nm":
        return _WHOLE[written.casefold()]
    if written.startswith("%"):  # of full scale or of a rated value
        return "%"
    if _known(written) and not _MASS_TIMES_LENGTH.fullmatch(re.sub("[·⋅]", "*", written)):
        return written
    if (glued := _GLUED.fullmatch(written)) is not None:
        written = "*".join(filter(None, glued.groups()))
    written = unicodedata.normalize("NFKC", written).replace("−", "-").rstrip(".")
    plain = re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", re.sub(r"(?<=[A-Za-z0-9])\s*[.·× -]\s*(?=[A-Za-z])", "*", written))
    plain = re.sub(r"[A-Za-z%]+", lambda match: _symbol(match[0]), plain)
    if (torque := _MASS_TIMES_LENGTH.fullmatch(plain)) is not None:
        mass, length = torque["mass"] or torque["last"], torque["length"] or torque["first"]
        plain = f"{mass.rstrip('s')}f*{length}"
    if not _known(plain) and written.isupper() and len(written) > 1:
        return column_unit(written.lower())
    return plain if _known(plain) else None


def unit_endings(name: str) -> Iterator[tuple[str, str]]:
    """The ways to read a name such as `position_mm` as a name and a unit behind it."""
    parts = re.split(r"[\s_]+", name.strip())
    for k in range(1, len(parts)):
        unit = column_unit("/".join(part for part in parts[k:] if part != "per"))
        if unit is not None:
            yield "_".join(parts[:k]), unit


def _symbol(symbol: str) -> str:
    return symbol if symbol in SYMBOLS else _SPELLINGS.get(symbol) or written_out(symbol) or symbol


def _known(unit: str) -> bool:
    with suppress(InputError):
        return bool(unit_dimension(unit))
    return False


FITTED = "fit"
"""A scale that the fit finds, with its unit behind: `"fit N*m/A"`; in the fit it begins at one of that unit."""

RATED = "rated_"
"""Before the name of a channel, in `[rig.known]`: what 100 % of its column are."""
PARTS = {"%": "percent", "permille": "permille"}
"""Units of a column that is a part of a rated value."""


@dataclass(frozen=True)
class Scale:
    """A factor from the quantity in a column to that of its channel, SI, its text as written, and its standard
    deviation: infinite for one that is fitted without knowing it."""

    value: float
    dimension: Dimension
    text: str
    std: float | None = None


@dataclass(frozen=True)
class Stated:
    """A quantity of a channel that no column holds, as written: one value for all rows, or (`per_row`) the step from
    row to row."""

    text: str
    per_row: bool


@dataclass(frozen=True)
class ColumnSetting:
    """Settings of one column of a channel in the experiment; None is left to the file.

    The column is a name, or a number from 1; its cells may be `increments` from row to row, whose sum is the channel,
    or begin anew after a `period`, in their own unit. A quantity `stated` stands in place of a column. `where` is the
    place in the experiment file, for messages.
    """

    column: str | int | None = None
    unit: str | None = None
    sign: int | None = None
    scale: Scale | None = None
    where: str = ""
    increments: bool | None = None
    period: float | None = None
    stated: Stated | None = None

    def over(self, other: ColumnSetting) -> ColumnSetting:
        """These settings, and those of `other` where these have none."""
        own = {name: value for name, value in vars(self).items() if value not in (None, "")}
        if self.stated is not None or (other.stated is not None and self.column is None):
            own = {"column": None, "unit": None, "scale": None, "increments": None, "period": None, **own}
        elif other.stated is not None:
            own = {"stated": None, **own}
        return replace(other, **own)


ChannelSettings = Mapping[str, tuple[ColumnSetting, ...]]
"""Columns of each channel, whose values are added; most channels have one."""


def read_channel_settings(table: TomlTable, kind: RigKind) -> dict[str, tuple[ColumnSetting, ...]]:
    """The settings in a table `[channels]`.

    An entry is the column's name or number, a table, or a list of tables whose columns are added:
    `position = "x"`, `position = 3`, `drive_force = {column = "i", unit = "A", scale = "0.113 N*m/A", sign = -1}`;
    `time = {column = 1, unit = "s", increments = true}`, `position = {pulses_per_turn = 3}`, `{pitch = "20 um"}`, or
    `drive_force = {value = "0 N"}`.
    """
    settings: dict[str, tuple[ColumnSetting, ...]] = {}
    for channel, value in table.data.items():
        _check_channel(table.where(), channel, kind)
        items = value if isinstance(value, list) else [value]
        if not items:
            raise InputError(f"{table.where(channel)}: the list is empty; a column or a list of columns is required")
        settings[channel] = tuple(_setting(table, channel, item) for item in items)
        if len(items) > 1 and any(setting.stated is not None for setting in settings[channel]):
            raise InputError(f"{table.where(channel)}: columns are added; a value or a step of each row stands alone")
    return settings


def read_record_settings(
    table: TomlTable, kind: RigKind, common: ChannelSettings
) -> dict[str, tuple[ColumnSetting, ...]]:
    """The settings of one record: `[channels]`, under the record's own `channels`, `columns`, `units` and `sign`."""
    merged = dict(common)
    for channel, own in read_channel_settings(table.table("channels"), kind).items():
        before = merged.get(channel, ())
        merged[channel] = (own[0].over(before[0]),) if len(own) == len(before) == 1 else own
    columns = table.table("columns")
    for channel in columns.data:
        _check_channel(columns.where(), channel, kind)
        _put(merged, channel, ColumnSetting(column=columns.text(channel), where=columns.where()))
    signs = table.table("sign")
    for channel, value in signs.data.items():
        _check_channel(signs.where(), channel, kind)
        _put(merged, channel, ColumnSetting(sign=_sign(signs, channel, value), where=signs.where(channel)))
    return merged


def rated_values(known: TomlTable, kind: RigKind) -> dict[str, Scale]:
    """What 100 % of the columns are, by channel: the entries `rated_CHANNEL` of `[rig.known]`."""
    rated = {key.removeprefix(RATED): read_scale(known, key) for key in known.data if key.startswith(RATED)}
    for channel in rated:
        _check_channel(known.where(RATED + channel), channel, kind)
    return rated


def _put(merged: dict[str, tuple[ColumnSetting, ...]], channel: str, setting: ColumnSetting) -> None:
    before: tuple[ColumnSetting, ...] = merged.get(channel, (ColumnSetting(),))
    if len(before) > 1:
        raise InputError(
            f"{setting.where}: '{channel}' is the sum of {len(before)} columns in [channels]; write them again under "
            "channels of the record"
        )
    merged[channel] = tuple(setting.over(other) for other in before)


def _setting(table: TomlTable, channel: str, value: object) -> ColumnSetting:
    where = table.where(channel)
    if isinstance(value, str):
        return ColumnSetting(column=value, where=where)
    if isinstance(value, int) and not isinstance(value, bool):
        return ColumnSetting(column=_column_number(value, where), where=where)
    if not isinstance(value, dict):
        raise InputError(
            f"{where}: {shown(value)} is {kind_of(value)}; a column's name, its number, or a table is required: "
            '{column = "NAME", unit = "A", scale = "0.113 N*m/A", sign = -1}'
        )
    inner = TomlTable(table.file, f"{table.name}.{channel}", value)
    inner.allow(("column", "unit", "sign", "scale", "increments", "period", *STATED))
    sign = _sign(inner, "sign", inner.data["sign"]) if "sign" in inner.data else None
    if stated := _stated(inner, channel):
        return ColumnSetting(sign=sign, where=where, stated=stated)
    if isinstance(inner.data.get("unit"), str) and inner.text("unit").lstrip().startswith("?"):
        raise InputError(f"{inner.where('unit')}: {shown(inner.data['unit'])} is still a question; write what it is")
    column = inner.data.get("column")
    if isinstance(column, int) and not isinstance(column, bool):
        column = _column_number(column, inner.where("column"))
    elif column is not None:
        column = inner.text("column")
    unit, scale = inner.text("unit") if "unit" in inner.data else None, "scale" if "scale" in inner.data else None
    if unit and not scale and unit.strip()[:1].isdigit() and column_unit(unit) is None:
        unit, scale = "count", "unit"  # such as "0.5 um": how much is one count
    return ColumnSetting(
        column=column,
        unit=unit,
        sign=sign,
        scale=read_scale(inner, scale) if scale else None,
        where=where,
        increments=inner.flag("increments") if "increments" in inner.data else None,
        period=_positive(inner, "period") if "period" in inner.data else None,
    )


STATED = ("value", "pitch", "pulses_per_turn")
"""Keys of a channel without a column: its value in all rows, or how far it is from row to row, a pulse in each."""


def _stated(table: TomlTable, channel: str) -> Stated | None:
    """The quantity that stands in place of a column; None without one."""
    given = [key for key in STATED if key in table.data]
    if not given:
        return None
    key = given[0]
    beside = [other for other in table.data if other not in (key, "sign")]
    if beside:
        raise InputError(f"{table.where(key)}: stands in place of a column; leave out '{beside[0]}'")
    if channel == "time":
        raise InputError(f'{table.where(key)}: the time needs a column, or a rate: [format] sample_rate = "1 kHz"')
    if key != "pulses_per_turn":
        return Stated(table.text(key), key == "pitch")
    return Stated(f"{2.0 * math.pi / _positive(table, key)!r} rad", True)


def _positive(table: TomlTable, key: str) -> float:
    value = table.data[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise InputError(f"{table.where(key)}: {shown(value)} is not allowed; a number above zero is required")
    return float(value)


def _column_number(value: int, where: str) -> int:
    if value < 1:
        raise InputError(f"{where}: {value} is not allowed; columns are numbered from 1")
    return value


def _sign(table: TomlTable, key: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int | float) or value not in (1, -1):
        raise InputError(f"{table.where(key)}: {shown(value)} is not allowed; 1 or -1 is required")
    return int(value)


def read_scale(table: TomlTable, key: str = "scale") -> Scale:
    """The factor under `key`: a quantity, perhaps with its uncertainty, or one that is fitted."""
    written = table.data[key]
    if isinstance(written, str) and written.lstrip().startswith("?"):
        example = f"2.5 {written.strip(' ?')}".strip()
        raise InputError(f"{table.where(key)}: {shown(written)} is still a question; write what it is, as '{example}'")
    if isinstance(written, str) and (written.strip() == FITTED or written.strip().startswith(f"{FITTED} ")):
        unit = written.strip().removeprefix(FITTED).strip()
        with at_place(table.where(key)):
            return Scale(to_si(1.0, unit), unit_dimension(unit), written, math.inf)
    with at_place(table.where(key)):
        value, std, dimension = parse_any(written)
    check_size(value, shown(written), table.where(key))
    if value == 0.0:
        raise InputError(f"{table.where(key)}: {shown(written)} must be a finite number other than zero")
    if std is not None and not std > 0.0:
        raise InputError(f"{table.where(key)}: {shown(written)}: the uncertainty must be above zero")
    return Scale(value, dimension, str(written), std)


def _check_channel(where: str, channel: str, kind: RigKind) -> None:
    require_known(channel, kind.channels, f"{where}: '{channel}' is not a channel of {kind.name}")
