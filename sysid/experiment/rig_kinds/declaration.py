"""Rig kinds in declaration files: a base kind, further channels and known quantities, and the balance between them.

    meaning = "a motor whose current is logged"
    base = "force-drive"

    [channels]                                   # recorded, besides those of the base
    motor_current = "A"

    [known]                                      # keys of [rig.known]
    torque_constant = "N*m/A"
    gear_ratio = {unit = "1", default = "1"}

    [balance]                                    # channels of the base by formulas
    drive_force = "known.gear_ratio * known.torque_constant * channel.motor_current"

In a formula `channel.NAME` is a channel, `known.NAME` a known quantity, `rate.NAME` and `rate2.NAME` the first and
second derivative of a channel with respect to time. `[set]` gives known quantities of the base by formulas.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError, at_place, nearest, require, require_known
from stagecad.parameters.formula import FUNCTIONS, Formula, Functions, Value, parse_formula
from stagecad.parameters.units import DIMENSIONLESS, Dimension, parse_quantity, unit_dimension
from sysid.experiment.known import Known
from sysid.experiment.rigs import ALWAYS_ALLOWED, LISTED, RIGS, Channel, KnownQuantity, RigKind
from sysid.experiment.toml_table import TomlTable, read_toml, shown

FOLDER = Path(__file__).parent
"""Declaration files of the program, each named by its kind."""

SOURCES = ("channel", "rate", "rate2", "known")


def kinds() -> tuple[str, ...]:
    """Names of all kinds of rig."""
    return (*RIGS, *sorted(file.stem for file in FOLDER.glob("*.toml")))


def find_rig(name: str, where: str, folder: Path | None = None) -> RigKind:
    """The rig kind called `name`, or declared in the file `name` in `folder`."""
    if name in RIGS:
        return RIGS[name]
    if name.endswith(".toml") and folder is not None:
        path = folder / name
        if not path.is_file():
            files = [file.name for file in folder.glob("*.toml") if file.name != "experiment.toml"]
            raise InputError(f"{where}: there is no {path}{nearest(name, files) if files else ''}")
        return read_rig(path, str(path))
    if name not in kinds():
        raise InputError(f"{where}: '{name}' is no kind of rig{nearest(name, kinds())}{LISTED}")
    return _packaged(name)


@cache
def _packaged(name: str) -> RigKind:
    return read_rig(FOLDER / f"{name}.toml", f"{name}.toml")


def read_rig(path: Path, shown_name: str) -> RigKind:
    """The kind of rig in a declaration file."""
    return declared_rig(read_toml(path, shown_name)[2], path.stem)


def declared_rig(top: TomlTable, name: str) -> RigKind:
    """The kind of rig called `name` that a table declares. Raises as `read_rig`."""
    top.allow(("meaning", "base", "axis", "channels", "known", "balance", "set"))
    top.text("meaning", "")
    base = RIGS[top.choice("base", tuple(RIGS))]
    defaults: dict[str, str] = {}
    own = {key: _channel(top.table("channels"), key, defaults) for key in top.table("channels").data}
    for key in own:
        if key in base.channels or key == "time":
            raise InputError(f"{top.where('channels')}: '{key}' is a channel of {base.name} already")
    known = {key: _known(top.table("known"), key, defaults) for key in top.table("known").data}
    balance = _formulas(top.table("balance"), base.channels, own, known, base)
    if not balance:
        raise InputError(f"{top.where('balance')}: is missing; a channel of {base.name} by a formula is required")
    constants = _formulas(top.table("set"), base.known, {}, known, base)
    optional = {key.partition(".")[2] for key in defaults if key.startswith("channel.")}
    sensed = {channel: formula for channel, formula in balance.items() if channel in base.measured_channels}
    measured = _recorded(base.measured, balance, sensed, optional)
    imposed = {channel: formula for channel, formula in balance.items() if channel not in sensed}
    required = tuple(g for g in _recorded(base.inputs, balance, imposed, optional) if not set(g) <= _flat(measured))
    taken = _flat(required) | _flat(measured) | balance.keys() | set(ALWAYS_ALLOWED)
    axis = top.choice("axis", ("linear", "rotary"), "") if "axis" in top.data else ""
    return RigKind(
        name=name,
        inputs=required,
        optional_inputs=tuple(name for name in (*own, *base.channels) if name not in taken),
        measured=measured,
        known={**{key: q for key, q in base.known.items() if key not in constants}, **known},
        own=own,
        base=base.name,
        balance=balance,
        constants=constants,
        defaults=defaults,
        rotary={"": None, "linear": False, "rotary": True}[axis],
    )


def _flat(groups: Iterable[Iterable[str]]) -> set[str]:
    return {name for group in groups for name in group}


def _recorded(
    of_base: tuple[tuple[str, ...], ...], balance: dict[str, Formula], computed: dict[str, Formula], optional: set[str]
) -> tuple[tuple[str, ...], ...]:
    """Groups of channels of the base that the balance does not compute, and of those that `computed` ones need."""
    groups = [group for group in of_base if not set(group) & balance.keys()]
    for channel, formula in computed.items():
        for key in formula.keys:
            source, _, name = key.partition(".")
            if source == "known" or name in optional or (name in balance and name != channel):
                continue
            # A velocity that is not recorded is the derivative of the position.
            group = ("velocity", "position") if name == "velocity" else (name,)
            if group not in groups:
                groups.append(group)
    return tuple(groups)


def _unit(table: TomlTable, key: str, default: str | None = None) -> str:
    written = table.text(key, default)
    unit = "" if written == "1" else written
    with at_place(table.where(key)):
        unit_dimension(unit)
    return unit


def _units(table: TomlTable, key: str, source: str, defaults: dict[str, str]) -> tuple[TomlTable, str, str]:
    """The entry under `key`, and its units on a linear and a rotary axis; a default is put into `defaults`."""
    value = table.data[key]
    entry = TomlTable(table.file, f"{table.name}.{key}", {"unit": value} if isinstance(value, str) else value)
    entry.allow(("unit", "rotary_unit", "default", *(["positive"] if source == "known" else [])))
    unit = _unit(entry, "unit")
    rotary = _unit(entry, "rotary_unit", unit)
    if "default" in entry.data:
        defaults[f"{source}.{key}"] = _default(entry, (unit, rotary))
    return entry, unit, rotary


def _channel(table: TomlTable, key: str, defaults: dict[str, str]) -> Channel:
    _, unit, rotary = _units(table, key, "channel", defaults)
    return Channel(key, unit, rotary, shows_axis=unit != rotary)


def _known(table: TomlTable, key: str, defaults: dict[str, str]) -> KnownQuantity:
    entry, unit, rotary = _units(table, key, "known", defaults)
    return KnownQuantity(unit, rotary, entry.flag("positive") if "positive" in entry.data else True)


def _default(entry: TomlTable, units: tuple[str, str]) -> str:
    written = entry.text("default")
    for unit in dict.fromkeys(units):
        try:
            parse_quantity(written, unit)
            return written
        except InputError as error:
            problem = error
    raise InputError(f"{entry.where('default')}: {problem}")


def _formulas(
    table: TomlTable, allowed: Iterable[str], own: dict[str, Channel], known: dict[str, KnownQuantity], base: RigKind
) -> dict[str, Formula]:
    """Formulas by key, with every name in them known."""
    table.allow([name for name in allowed if name != "time"])
    found = {}
    for key in table.data:
        with at_place(f"{table.where(key)}: {shown(table.data[key])}"):
            formula = parse_formula("=" + table.text(key))
        for name in formula.keys:
            source, _, rest = name.partition(".")
            names: Any = {**known, **base.known} if source == "known" else {**own, **dict.fromkeys(base.channels)}
            if source not in SOURCES:
                raise InputError(f"{table.where(key)}: '{name}' begins with none of channel, rate, rate2, known")
            require_known(rest, names, f"{table.where(key)}: there is no '{name}'")
        found[key] = formula
    return found


def default_value(kind: RigKind, key: str, unit: str) -> float | None:
    """SI value of the default of `channel.NAME` or `known.NAME`; None without one."""
    return None if key not in kind.defaults else parse_quantity(kind.defaults[key], unit or "", key)


_SECOND = unit_dimension("s")


def _elementwise(function: Callable[[Any], Any], result: Dimension, *allowed: Dimension) -> Callable[..., Value]:
    def apply(x: Value) -> Value:
        require(x.dimension in allowed, "an angle or a number without unit is needed")
        return Value(function(x.si), result)

    return apply


_ANGLE = unit_dimension("rad")
ARRAY_FUNCTIONS: Functions = {
    **FUNCTIONS,
    **{
        name: (1, 1, _elementwise(function, DIMENSIONLESS, _ANGLE, DIMENSIONLESS))
        for name, function in (("sin", np.sin), ("cos", np.cos), ("tan", np.tan))
    },
    **{
        name: (1, 1, _elementwise(function, _ANGLE, DIMENSIONLESS))
        for name, function in (("asin", np.arcsin), ("acos", np.arccos), ("atan", np.arctan))
    },
}
"""Functions of formulas for arrays (n,)."""

MOTION = ("position", "velocity")
"""Channels of the motion, which goes on while a command is held."""


@dataclass(frozen=True)
class Balance:
    """The formulas of a declared kind of rig with the SI values of its known quantities; `file` stands in messages.

    A drive force that is `held` from each row to the next acts with the motion between them (the back EMF of a motor
    changes while its voltage is held): in its formula position and velocity are means of the row and the next.
    """

    kind: RigKind
    known: Mapping[str, float]
    rotary: bool
    file: str
    held: bool

    @property
    def follows_motion(self) -> bool:
        """Whether the drive force is computed from the motion."""
        formula = self.kind.balance.get("drive_force")
        return formula is not None and any(key.partition(".")[2] in MOTION for key in formula.keys)

    def channels(self, time: np.ndarray, recorded: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The base's channels (n,), SI: recorded ones, and those of the formulas."""
        base = RIGS[self.kind.base]
        found = {name: values for name, values in recorded.items() if name in base.channels}
        for channel, formula in self.kind.balance.items():
            known = {**recorded, **found}
            if self.held and channel == "drive_force":
                known |= {name: _between_rows(known[name]) for name in MOTION if name in known}
            try:
                with np.errstate(all="ignore"):
                    value = formula.evaluate(lambda key: self._value(key, time, known), ARRAY_FUNCTIONS)  # noqa: B023
            except (InputError, ValueError, ArithmeticError) as error:
                raise InputError(f"{self._place(channel, formula)}: {error}") from None
            self._check(channel, formula, value.dimension)
            found[channel] = np.broadcast_to(np.asarray(value.si, dtype=float), time.shape).copy()
        return found

    def noise(
        self, time: np.ndarray, recorded: Mapping[str, np.ndarray], noise: Mapping[str, float]
    ) -> dict[str, float]:
        """Standard deviation by channel of the base, SI: the stated one, or the change of a formula by one draw of the
        `noise` of the kind's own channels."""
        random, own = np.random.default_rng(0), [name for name in self.kind.own if name in noise and name in recorded]
        kept = {name: value for name, value in noise.items() if name not in self.kind.own}
        if not own:
            return kept
        drawn = {name: recorded[name] + random.normal(0.0, noise[name], time.size) for name in own}
        first, second = self.channels(time, recorded), self.channels(time, {**recorded, **drawn})
        changes = {name: float(np.sqrt(np.nanmean((second[name] - first[name]) ** 2))) for name in self.kind.balance}
        return {**{name: change for name, change in changes.items() if change > 0.0}, **kept}

    def _check(self, channel: str, formula: Formula, dimension: Dimension) -> None:
        base = RIGS[self.kind.base]
        units = (base.declared(channel).si_unit(self.rotary), "N*m" if channel == "normal_load" else "")
        if not any(unit and dimension == unit_dimension(unit) for unit in units):
            axis = "rotary" if self.rotary else "linear"
            raise InputError(
                f"{self._place(channel, formula)} is no '{units[0]}', in which {channel} of a {axis} axis is"
            )

    def _place(self, channel: str, formula: Formula) -> str:
        return f"{self.file}: rig.kind = '{self.kind.name}': {channel} = '{formula.text}'"

    def _value(self, key: str, time: np.ndarray, channels: Mapping[str, np.ndarray]) -> Value:
        source, _, name = key.partition(".")
        if source == "known":
            quantity = {**RIGS[self.kind.base].known, **self.kind.known}[name]
            return Value(self.known[name], unit_dimension(quantity.si_unit(self.rotary)))
        unit = self.kind.declared(name).si_unit(self.rotary)
        dimension = unit_dimension(unit)
        values: Any = channels.get(name)
        if values is None and name == "velocity":
            values = np.gradient(channels["position"], time)
        if values is None:
            values = default_value(self.kind, f"channel.{name}", unit)
        for _ in range({"channel": 0, "rate": 1, "rate2": 2}[source]):
            values = np.gradient(values, time) if isinstance(values, np.ndarray) else 0.0
            dimension = tuple(a - b for a, b in zip(dimension, _SECOND, strict=True))
        return Value(values, dimension)


def _between_rows(values: np.ndarray) -> np.ndarray:
    """Means (n,) of each row and the next; the last row itself."""
    return np.append(0.5 * (values[1:] + values[:-1]), values[-1:])


def balance_of(
    kind: RigKind, known: Mapping[str, Known], rotary: bool, file: str, held: bool
) -> tuple[Balance, dict[str, Known]]:
    """The balance of a declared kind, and the known quantities of its base; `held`: a drive force, from row to row."""
    base = RIGS[kind.base]
    values = {name: quantity.value for name, quantity in known.items()}
    for name, quantity in kind.known.items():
        default = default_value(kind, f"known.{name}", quantity.si_unit(rotary))
        if name not in values and default is not None:
            values[name] = default
    for formula in kind.balance.values():
        for key in formula.keys:
            source, _, name = key.partition(".")
            if source == "known" and name not in values:
                unit = {**base.known, **kind.known}[name].si_unit(rotary)
                raise InputError(
                    f"{file}: rig.known.{name} is missing, which '{kind.name}' needs; write it, like "
                    f'{name} = "1{f" {unit}" if unit else ""}"'
                )
    balance = Balance(kind, values, rotary, file, held)
    found = {name: quantity for name, quantity in known.items() if name in base.known}
    for name, formula in kind.constants.items():
        if all(key.partition(".")[2] in values for key in formula.keys):
            unit, values_of = base.known[name].si_unit(rotary), partial(balance._value, time=np.empty(0), channels={})
            found[name] = Known(formula.value(values_of, unit, f"{kind.name}: {name}"))
    return balance, found
