"""The `[model]` of an experiment: its effects by name, and starts, bounds or fixed values of their parameters."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sim.effects.catalogue import find
from sim.effects.custom import load_all_custom
from sim.effects.effect import Effect, Parameter, rotary_unit
from stagecad.consent import require_consent
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import parse_quantity, parse_uncertain
from sysid.experiment.channels import same_dimension
from sysid.experiment.known import DesignValues, design_value
from sysid.experiment.model_table import flat_settings
from sysid.experiment.rigs import CHANNELS, RigKind
from sysid.experiment.toml_table import TomlTable, check_size, kind_of, shown

ROUNDING = 1e-6
"""Relative excess over a bound that is accepted as rounding."""

_KEYS = ("start", "low", "high", "fixed")


@dataclass(frozen=True)
class Setting:
    """Setting of one parameter in the file, SI; None for what is not given. A fixed one is kept at `start`; `std` is
    the standard deviation of a prior with mean `start` (from `start = "1.2 +- 0.1 N"`, or from the design)."""

    start: float | None = None
    low: float | None = None
    high: float | None = None
    fixed: bool = False
    std: float | None = None


def check_effects(
    names: Sequence[str], custom: Sequence[Path | Effect], rig: RigKind, recorded: set[str], model: TomlTable
) -> dict[str, Effect]:
    """Find every effect of the model."""
    own = load_all_custom(custom, require_consent)
    found: dict[str, Effect] = {}
    for name in names:
        if name in found:
            raise InputError(f"{model.where('effects')}: '{name}' is given twice")
        try:
            found[name] = find(name, own)
        except InputError as error:
            raise InputError(f"{model.where('effects')}: {error}") from None
        channel = name.partition("@")[2]
        if channel and channel not in recorded:
            measured = [other for other in rig.measured_channels if other in recorded]
            raise InputError(
                f"{model.where('effects')}: '{name}': no record holds '{channel}'{nearest(channel, measured)}"
            )
        if name.startswith("contact.") and rig.name != "friction-drive":
            raise InputError(
                f"{model.where('effects')}: '{name}': only a friction-drive has a contact of tip and stage; write "
                f"'{name.removeprefix('contact.')}'"
            )
        _check_core(name, found, model)
    return found


def _check_core(name: str, found: Mapping[str, Effect], model: TomlTable) -> None:
    """Refuse a second friction state model on one channel, since each turns one friction level into one force."""
    if found[name].friction_state is None:
        return
    in_contact = name.startswith("contact.")
    for other, effect in found.items():
        if other != name and effect.friction_state is not None and other.startswith("contact.") == in_contact:
            raise InputError(
                f"{model.where('effects')}: '{other}' and '{name}' are both friction cores, and a model has one"
                f"{' between tip and stage' if in_contact else ''}; leave one out"
            )


def read_settings(
    table: TomlTable, effects: Mapping[str, Effect], rig: RigKind, rotary: bool, design: DesignValues | None = None
) -> dict[str, Setting]:
    """Read `[model.parameters]`; `design` has the values of settings given as `"design"`."""
    settings: dict[str, Setting] = {}
    for key, value in flat_settings(table.data).items():
        where = table.where(key)
        name, _, parameter_name = key.rpartition(".")
        if name not in effects:
            wanted = [f"{effect}.{p.name}" for effect, declared in effects.items() for p in declared.parameters]
            if not name:
                meant = [full for full in wanted if full.endswith(f".{key}")]
                near = f"; did you mean '{meant[0]}'?" if meant else nearest(key, wanted) if wanted else ""
                raise InputError(f"{where}: write 'effect.parameter'{near}")
            raise InputError(f"{where}: the model has no effect '{name}'{nearest(name, effects) if effects else ''}")
        try:
            parameter = effects[name].parameter(parameter_name)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        entry = TomlTable(table.file, f"{table.name}.{key}", value if isinstance(value, dict) else {"start": value})
        settings[key] = _setting(entry, parameter, name, rig, rotary, design)
    return settings


def _setting(
    table: TomlTable, parameter: Parameter, effect: str, rig: RigKind, rotary: bool, design: DesignValues | None
) -> Setting:
    table.allow(_KEYS)
    low, high = (_value(table, key, parameter, effect, rig, rotary)[0] for key in ("low", "high"))
    fixed = table.flag("fixed")
    if table.data.get("start") == "design":
        found = design_value(design, f"{effect}.{parameter.name}", rotary, table.where("start"))
        start, std = found.value, found.std
        low = found.low if low is None else low
        high = found.high if high is None else high
    else:
        start, std = _value(table, "start", parameter, effect, rig, rotary)
    if std is not None and not std > 0.0:
        raise InputError(f"{table.where('start')}: {shown(table.data['start'])}: the uncertainty must be above zero")
    if start is not None:
        check_size(start, shown(table.data["start"]), table.where("start"))
    if fixed and start is None:
        raise InputError(f"{table.where()}: fixed = true needs start, the value it is held at")
    if low is not None and high is not None and low >= high:
        raise InputError(
            f"{table.where()}: low = {_text(table, 'low', low)} is not below high = {_text(table, 'high', high)}"
        )
    if start is not None:
        _within_bounds(table, parameter, start, {"low": low, "high": high}, fixed)
    return Setting(start, low, high, fixed, None if fixed else std)


def _within_bounds(
    table: TomlTable, parameter: Parameter, start: float, given: Mapping[str, float | None], fixed: bool
) -> None:
    """Refuse a start outside the bounds in the file, or outside the effect's own where the file has none; a fixed value
    may be beyond those."""
    # A fitted value at a bound is written with nine digits, so it may exceed the bound by rounding.
    room = ROUNDING * abs(start)
    for key, declared in (("low", parameter.low), ("high", parameter.high)):
        bound = given[key]
        limit = declared if bound is None else bound
        if not (start < limit - room if key == "low" else start > limit + room) or (fixed and bound is None):
            continue
        outside = f"{table.where()}: start = {_text(table, 'start', start)} is outside"
        if bound is not None:
            raise InputError(f"{outside} {key} = {_text(table, key, bound)}")
        raise InputError(f"{outside} the effect's own {key} = {declared:g}; give {key} with it if it is meant")


def _text(table: TomlTable, key: str, value: float) -> str:
    """A value as written in the file; in SI if it comes from the design."""
    return shown(table.data[key]) if table.data.get(key, "design") != "design" else f"{value:g} (the design's)"


def parameter_units(parameter: Parameter, effect: str, rig: RigKind, rotary: bool) -> list[str]:
    """Permitted SI units of a value of `parameter`; for a parameter of a sensor, the unit of its channel."""
    if not parameter.unit.startswith("channel"):
        return [rotary_unit(parameter.unit) if rotary else parameter.unit]
    channel = effect.partition("@")[2]
    channels = [channel] if channel else list(rig.measured_channels)
    tail = parameter.unit.removeprefix("channel")
    return list(dict.fromkeys(f"{CHANNELS[name].si_unit(rotary)}{tail}" for name in channels))


def _value(
    table: TomlTable, key: str, parameter: Parameter, effect: str, rig: RigKind, rotary: bool
) -> tuple[float | None, float | None]:
    """A value and, for a start, its standard deviation; None where not given."""
    if key not in table.data:
        return None, None
    value, where = table.data[key], table.where(key)
    units = parameter_units(parameter, effect, rig, rotary)
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise InputError(f"{where}: {shown(value)} is {kind_of(value)}, a quantity is required, such as '1 {units[0]}'")
    # A dimensionless number and an infinite bound may be written without a unit.
    bare = isinstance(value, int | float)
    if bare and (math.isinf(value) or same_dimension(units[0], "1")):
        return float(value), None
    if bare:
        raise InputError(f"{where}: {value} has no unit; write '{value} {units[0]}'")
    text = str(value).strip()
    if text in ("inf", "+inf", "-inf"):
        return float(text), None
    problem: InputError | None = None
    for unit in units:
        try:
            return parse_uncertain(text, unit, where) if key == "start" else (parse_quantity(text, unit, where), None)
        except InputError as error:
            problem = problem or error
    assert problem is not None
    raise problem
