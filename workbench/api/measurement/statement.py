"""What a user states of an experiment: the rig, the model, and the records, as objects that are put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError
from sysid.experiment.readers.memory import MemoryTable

Setting = str | float | Mapping[str, Any]
"""A start (`"1.2 N"`, `"1.2 +- 0.1 N"`, `0.8`), or a table with `start`, `low`, `high`, `fixed`."""


Declared = str | Mapping[str, Any]
"""A unit, or a table with `unit`, `rotary_unit` and `default`."""


@dataclass(frozen=True)
class RigKind:
    """A kind of rig of the user's own: the channels of a built-in kind, made by formulas of what is recorded.

    Args:
        base: `velocity-drive`, `spring-pull`, `force-drive`, `actuator-tip` or `friction-drive`.
        channels: recorded, besides those of the base: unit by name, or a table with `unit`, `rotary_unit`, `default`.
        balance: formula by channel of the base, of `channel.NAME`, `known.NAME`, `rate.NAME` and `rate2.NAME`.
        known: keys of what may be known of the rig: unit by name, or a table as of a channel.
        constants: formula by known quantity of the base.
        axis: `linear` or `rotary`, where the units of the channels do not tell.
        meaning: in one line.

    >>> coil = RigKind("force-drive", {"current": "A"}, {"drive_force": "known.k * channel.current"}, {"k": "N/A"})
    >>> Rig(coil, {"k": "8 N/A", "mass": "1 kg"})
    Rig(RigKind('force-drive', channels=['current'], balance=['drive_force']), k='8 N/A', mass='1 kg')
    """

    base: str
    channels: Mapping[str, Declared] = field(default_factory=dict)
    balance: Mapping[str, str] = field(default_factory=dict)
    known: Mapping[str, Declared] = field(default_factory=dict)
    constants: Mapping[str, str] = field(default_factory=dict)
    axis: Literal["linear", "rotary"] | None = None
    meaning: str = ""

    def __repr__(self) -> str:
        return f"RigKind({self.base!r}, channels={list(self.channels)}, balance={list(self.balance)})"

    def table(self) -> dict[str, Any]:
        """The content of its declaration file, or the table `[rig.kind]` of an `experiment.toml`."""
        axis = {} if self.axis is None else {"axis": self.axis}
        maps = {"channels": self.channels, "known": self.known, "balance": self.balance, "set": self.constants}
        tables = {
            name: {key: dict(one) if isinstance(one, Mapping) else one for key, one in given.items()}
            for name, given in maps.items()
            if given
        }
        return {"meaning": self.meaning, "base": self.base, **axis, **tables}

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> RigKind:
        """The kind of a table as of `table()`."""
        named = {key: value for key, value in table.items() if key != "set"}
        return cls(**named, constants=table.get("set", {}))


@dataclass(frozen=True)
class Rig:
    """A rig: its kind, and what is known of it.

    Args:
        kind: a name (`velocity-drive`, `spring-pull`, `force-drive`, `actuator-tip`, `friction-drive`, or one of the
            declared kinds such as `motor-current`), or a `RigKind` of the user's own.
        known: quantities as text with a unit, perhaps with a deviation; what is not here is fitted.
        input_hold: course of the logged input between rows: held (`zero`) or `linear`.

    >>> Rig("force-drive", {"mass": "1.79 +- 0.01 kg"})
    Rig('force-drive', mass='1.79 +- 0.01 kg')
    """

    kind: str | RigKind
    known: Mapping[str, str] = field(default_factory=dict)
    input_hold: Literal["zero", "linear"] = "zero"

    def __repr__(self) -> str:
        known = "".join(f", {name}={value!r}" for name, value in self.known.items())
        hold = f", input_hold={self.input_hold!r}" if self.input_hold != "zero" else ""
        return f"Rig({self.kind!r}{known}{hold})"

    def table(self) -> dict[str, Any]:
        """The table `[rig]` of an `experiment.toml`."""
        kind = self.kind if isinstance(self.kind, str) else self.kind.table()
        return {"kind": kind, "input_hold": self.input_hold, "known": dict(self.known)}


@dataclass(frozen=True)
class Model:
    """A model: effects by name, or effects of the user's own, and what is stated of their parameters.

    Args:
        effects: names of effects of the library (`"stribeck"`, `"presliding:lugre"`), and `Effect` objects.
        parameters: by `effect.parameter`: a start with its unit, or a table with `start`, `low`, `high`, `fixed`.
        custom: effects of the user's own that are not in the model, but that `diagnose` tries and `add` can add.

    A model and further effects are a model: `Model(["coulomb"]) + "viscous"`.

    >>> Model(["coulomb", "viscous"]) + "stribeck"
    Model(['coulomb', 'viscous', 'stribeck'])
    """

    effects: Sequence[str | Effect] = ()
    parameters: Mapping[str, Setting] = field(default_factory=dict)
    custom: Sequence[Effect] = ()

    def __post_init__(self) -> None:
        if isinstance(self.effects, str | Effect):
            raise InputError(f"Model({self.effects!r}): a list of effects is required: Model([...])")

    def __repr__(self) -> str:
        settings = f", parameters={dict(self.parameters)!r}" if self.parameters else ""
        return f"Model({list(self.names)!r}{settings})"

    def __add__(self, other: str | Effect | Model) -> Model:
        if isinstance(other, Model):
            parameters = {**self.parameters, **other.parameters}
            return Model((*self.effects, *other.effects), parameters, (*self.custom, *other.custom))
        return replace(self, effects=(*self.effects, other))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(effect if isinstance(effect, str) else effect.name for effect in self.effects)

    @property
    def own(self) -> tuple[Effect, ...]:
        """Effects of the user's own, in the model or not."""
        return (*(effect for effect in self.effects if isinstance(effect, Effect)), *self.custom)

    def table(self) -> dict[str, Any]:
        """The table `[model]` of an `experiment.toml`."""
        settings = {key: dict(s) if isinstance(s, Mapping) else s for key, s in self.parameters.items()}
        return {"effects": list(self.names), **({"parameters": settings} if settings else {})}


@dataclass(frozen=True, eq=False)
class Record:
    """One record in memory.

    Args:
        data: a pandas DataFrame, or arrays by column; columns are `name [unit]`, or `name` with the unit in `units`.
            The time is a column, or the index of the DataFrame.
        role: `fit`, or `validate` for a record held out.
        units: unit by channel or column.
        columns: column by channel, where the names differ.
        sign: 1 or -1 by channel.
        channels: what `[channels]` of a file says: by channel its column, a table with `column`, `unit`, `scale`,
            `increments`, `pitch`, `pulses_per_turn` or `value`, or a list of those that are added.
        window: first and last instant, such as `("2 s", "20 s")`; None for an open end.
        continues: name of the record that this one continues.
        noise: standard deviation by channel, where it differs from that of the experiment.
    """

    data: Any
    role: Literal["fit", "validate"] = "fit"
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)
    sign: Mapping[str, int] = field(default_factory=dict)
    window: tuple[str | None, str | None] = (None, None)
    continues: str | None = None
    noise: Mapping[str, str] = field(default_factory=dict)
    channels: Mapping[str, Any] = field(default_factory=dict)

    def table(self, name: str) -> dict[str, Any]:
        """The table `[[record]]` of an `experiment.toml`, for the record called `name`."""
        table: dict[str, Any] = {"file": name, "name": name, "role": self.role}
        start, stop = self.window
        optional = {"from": start, "to": stop, "continues": self.continues}
        table |= {key: value for key, value in optional.items() if value is not None}
        maps: dict[str, Mapping[str, Any]] = {
            "units": self.units,
            "columns": self.columns,
            "sign": self.sign,
            "noise": self.noise,
            "channels": self.channels,
        }
        return table | {key: dict(value) for key, value in maps.items() if value}

    def arrays(self, name: str) -> MemoryTable:
        """The columns as arrays, for the record called `name`.

        Raises:
            InputError: no table of columns, or columns of several lengths.
        """
        return MemoryTable(name, columns_of(self.data, name))


def columns_of(data: Any, name: str) -> dict[str, np.ndarray]:
    """Arrays by label of a DataFrame (its index too, if it is named or of times) or of a mapping.

    Raises:
        InputError: neither of the two.
    """
    if isinstance(data, Mapping):
        return {str(label): np.asarray(values) for label, values in data.items()}
    if not hasattr(data, "columns") or not hasattr(data, "index"):
        raise InputError(f"{name}: is {type(data).__name__}; a DataFrame or a mapping of arrays is required")
    columns = {}
    kind = data.index.dtype.kind
    if kind in "mM":
        seconds = (data.index - data.index[0]) / np.timedelta64(1, "s")
        columns["time [s]"] = np.asarray(seconds, dtype=float)
    elif data.index.name is not None:
        columns[str(data.index.name)] = data.index.to_numpy()
    return columns | {str(label): data[label].to_numpy() for label in data.columns}
