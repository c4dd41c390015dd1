"""An experiment: the rig, the stated model, the records and their noise, read from `experiment.toml`."""

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

from sim.effects.catalogue import find
from sim.effects.custom import load_all_custom
from sim.effects.effect import Effect, Parameter, rotary_unit
from stagecad.consent import give_consent, has_consent, require_consent
from stagecad.parameters.errors import InputError, at_place, nearest, require
from stagecad.parameters.units import parse_quantity, parse_uncertain
from sysid.experiment.channels import same_dimension
from sysid.experiment.known import DesignValue, DesignValues, Known, design_value, known_axes, read_known
from sysid.experiment.model_table import flat_settings
from sysid.experiment.readers.base import shown_path
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.readers.open import record_suffix
from sysid.experiment.record_spec import RecordSpec, read_record_specs
from sysid.experiment.rig_kinds.declaration import balance_of, declared_rig, find_rig
from sysid.experiment.rigs import CHANNELS, RIGS, RigKind
from sysid.experiment.toml_table import TomlTable, check_size, kind_of, quantity, read_toml, shown

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
    place = model.where("effects")
    for name in names:
        if name in found:
            raise InputError(f"{place}: '{name}' is given twice")
        with at_place(place):
            found[name] = find(name, own)
        channel = name.partition("@")[2]
        if channel and channel not in recorded:
            measured = [other for other in rig.measured_channels if other in recorded]
            raise InputError(f"{place}: '{name}': no record holds '{channel}'{nearest(channel, measured)}")
        if name.startswith("contact.") and rig.name != "friction-drive":
            raise InputError(
                f"{place}: '{name}': only a friction-drive has a contact of tip and stage; write "
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
    table: TomlTable,
    effects: Mapping[str, Effect],
    rig: RigKind,
    stated: RigKind,
    rotary: bool,
    design: DesignValues | None = None,
) -> dict[str, Setting]:
    """Read `[model.parameters]` of a rig, or of the kind of rig that is `stated` and gives its channels; `design` has
    the values of settings given as `"design"`."""
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
            if name == "rig":
                known = stated.key_of(parameter_name)
                place = f"write it as {known} under [rig.known]" if known else "[rig.known] has no key for it"
                raise InputError(f"{where}: belongs to the rig and to no effect; {place}")
            raise InputError(f"{where}: the model has no effect '{name}'{nearest(name, effects) if effects else ''}")
        with at_place(where):
            parameter = effects[name].parameter(parameter_name)
        entry = TomlTable(table.file, f"{table.name}.{key}", value if isinstance(value, dict) else {"start": value})
        units = parameter_units(parameter, name, rig, rotary)
        settings[key] = _setting(entry, parameter, units, partial(design_value, design, key, rotary))
    return settings


def _setting(
    table: TomlTable, parameter: Parameter, units: Sequence[str], of_design: Callable[[str], DesignValue]
) -> Setting:
    table.allow(_KEYS)
    low, high = (_value(table, key, units)[0] for key in ("low", "high"))
    fixed = table.flag("fixed")
    if table.data.get("start") == "design":
        found = of_design(table.where("start"))
        start, std = found.value, found.std
        low = found.low if low is None else low
        high = found.high if high is None else high
    else:
        start, std = _value(table, "start", units)
    if std is not None and not std > 0.0:
        raise InputError(f"{table.where('start')}: {shown(table.data['start'])}: the uncertainty must be above zero")
    if start is not None:
        check_size(start, shown(table.data["start"]), table.where("start"))
    if fixed and start is None:
        raise InputError(f"{table.where()}: fixed = true needs start, the value it is held at")
    if low is not None and high is not None and low >= high:
        ends = f"low = {_text(table, 'low', low)} is not below high = {_text(table, 'high', high)}"
        raise InputError(f"{table.where()}: {ends}")
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


def _value(table: TomlTable, key: str, units: Sequence[str]) -> tuple[float | None, float | None]:
    """A value in one of these units and, for a start, its standard deviation; None where not given."""
    if key not in table.data:
        return None, None
    value, where = table.data[key], table.where(key)
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


def custom_files(model: TomlTable, folder: Path) -> tuple[Path, ...]:
    """The Python files that `[model] custom` names."""
    found = []
    for item in model.texts("custom"):
        path = folder / item
        with suppress(OSError, ValueError):
            if path.resolve().is_relative_to(folder.resolve()):
                found.append(path)
                continue
        raise InputError(
            f"{model.where('custom')}: {shown(item)} is outside the folder of the experiment; copy the file there"
        )
    return tuple(found)


def python_files(folder: Path) -> list[dict[str, Any]]:
    """The Python files that the experiment in `folder` names: name, text, sha256, and whether they may run."""
    file = folder / "experiment.toml"
    found = []
    for path in custom_files(read_toml(file, shown_path(str(file)))[2].table("model"), folder):
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        name, digest = path.relative_to(folder).as_posix(), hashlib.sha256(data).hexdigest()
        text = data.decode("utf-8", errors="replace")
        found.append({"name": name, "text": text, "sha256": digest, "consented": has_consent(data)})
    return found


SCHEMA = 1
OWN_KIND = "own"
"""Name of a kind of rig that the experiment declares itself, under `[rig.kind]`."""


@dataclass(frozen=True)
class Revision:
    """One rung: its number (0 before anything was added), its file, its `[model]` as plain data, and the content of the
    file: `effects`, `added`, `parameters`, `before` and the other results of the fit."""

    number: int
    path: Path
    model: Mapping[str, Any]
    document: Mapping[str, Any]

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the model on this rung."""
        return tuple(self.model.get("effects", ()))


@dataclass(frozen=True)
class Rig:
    """The rig of an experiment: the name of its kind (of a declared kind, that of its base), known quantities by key
    (an inertia as `mass`), whether the axis is rotary, and how the logged input runs between rows."""

    kind: str
    known: Mapping[str, Known]
    rotary: bool
    input_hold: Literal["zero", "linear"] = "zero"
    states_hold: bool = False

    @property
    def declaration(self) -> RigKind:
        """The kind of rig with its channels."""
        return RIGS[self.kind]


@dataclass(frozen=True)
class Experiment:
    """An experiment as read; parameters are settings by `effect.parameter`, noise is a standard deviation by channel,
    SI.

    `custom` has the user's own effects, as files or declared in memory; `text` is the file with its comments, `sha256`
    that of its bytes; an experiment that is not in files has its `revisions` here.
    """

    folder: Path
    path: Path
    rig: Rig
    effects: tuple[str, ...]
    custom: tuple[Path | Effect, ...]
    parameters: Mapping[str, Setting]
    records: tuple[RecordSpec, ...]
    noise: Mapping[str, float]
    text: str = ""
    sha256: str = ""
    revisions: tuple[Revision, ...] | None = None


@dataclass(frozen=True)
class Place:
    """Folder and file of an experiment, valid or not."""

    folder: Path
    path: Path


def find_experiment(path: str | Path) -> Place:
    """Folder and file of an experiment whose file is TOML, but not necessarily a valid experiment."""
    file = _experiment_file(Path(path))
    read_toml(file, shown_path(str(file)))
    return Place(file.parent, file)


def trust_experiment(path: str | Path) -> tuple[Path, ...]:
    """Store the consent to run the Python files of an experiment with their present content; returns the files."""
    place = find_experiment(path)
    model = read_toml(place.path, shown_path(str(place.path)))[2].table("model")
    files = custom_files(model, place.folder)
    give_consent(files)
    return files


def load_experiment(path: str | Path, design: DesignValues | None = None) -> Experiment:
    """Read an experiment, from its folder or its `experiment.toml`. `design` gives settings stated as `"design"`, SI,
    by name (`mass`, `piezo_spacing`, ..., `coulomb.force`): a table, or a function that is called only for the names in
    the file."""
    file = _experiment_file(Path(path))
    data, text, top = read_toml(file, shown_path(str(file)))
    found = read_experiment(top, file, design)
    return replace(found, text=text, sha256=hashlib.sha256(data).hexdigest())


def read_experiment(
    top: TomlTable,
    file: Path,
    design: DesignValues | None = None,
    in_memory: Mapping[str, MemoryTable] | None = None,
    own: Sequence[Effect] = (),
) -> Experiment:
    """An experiment from the content of its file, without its text. Raises as `load_experiment`."""
    name = top.file
    top.allow(("schema", "rig", "format", "channels", "model", "record", "noise"))
    require("schema" in top.data, f"{top.file}: 'schema' is missing; write schema = {SCHEMA} at the top")
    value = top.data["schema"]
    if isinstance(value, bool) or value != SCHEMA:
        raise InputError(f"{top.where('schema')}: {shown(value)} is not allowed; write schema = {SCHEMA}")
    for key, example in (("rig", "[rig]"), ("model", "[model]"), ("record", "[[record]]")):
        require(key in top.data, f"{name}: '{key}' is missing; write {example}")
    rig_table = top.table("rig")
    rig_table.allow(("kind", "known", "input_hold"))
    if isinstance(rig_table.data.get("kind"), dict):
        kind = declared_rig(rig_table.table("kind"), OWN_KIND)
    else:
        kind = find_rig(rig_table.text("kind"), rig_table.where("kind"), file.parent)
    hold: Any = rig_table.choice("input_hold", ("zero", "linear"), "zero")
    records, axes = read_record_specs(top, kind, file, in_memory)
    known_table = rig_table.table("known")
    told = [] if kind.rotary is None else [(f"rig.kind = '{kind.name}'", kind.rotary)]
    rotary = _axis(told + axes + known_axes(known_table, kind), name)
    known = read_known(known_table, kind, rotary, design)
    measured = {channel for record in records for channel in record.sources} | kind.balance.keys()
    stated = kind
    if kind.base:
        balance, known = balance_of(kind, known, rotary, name, held=hold == "zero")
        records, kind = tuple(replace(record, balance=balance) for record in records), RIGS[kind.base]
    noise = _read_noise(top.table("noise"), kind, stated, rotary)
    records = tuple(
        replace(record, noise=_read_noise(table.table("noise"), kind, stated, rotary))
        for record, table in zip(records, top.tables("record"))
    )
    model = top.table("model")
    model.allow(("effects", "custom", "parameters"))
    if "effects" not in model.data:
        raise InputError(f'{model.where()}: \'effects\' is missing; write effects = ["coulomb", "viscous"], or []')
    effects = model.texts("effects")
    custom = (*custom_files(model, file.parent), *own)
    found = check_effects(effects, custom, kind, measured, model)
    parameters = read_settings(model.table("parameters"), found, kind, stated, rotary, design)
    return Experiment(
        folder=file.parent,
        path=file,
        rig=Rig(kind.name, known, rotary, hold, states_hold="input_hold" in rig_table.data),
        effects=effects,
        custom=custom,
        parameters=parameters,
        records=records,
        noise=noise,
    )


def _experiment_file(path: Path) -> Path:
    name = shown_path(str(path))
    try:
        if path.is_dir():
            file = path / "experiment.toml"
            if not file.is_file():
                meant = _meant("experiment.toml", path) or "; 'stagecad demo' writes one to start from"
                raise InputError(f"{name}: has no experiment.toml{meant}")
            return file
        if path.is_file() and record_suffix(path.name) is not None:
            raise InputError(f"{name}: a record, not an experiment; 'stagecad new experiment FOLDER {name}' makes one")
        if path.is_file():
            return path
        meant = _meant(path.name, path.parent)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    raise InputError(f"{name}: no such folder or file{meant}")


def _meant(name: str, folder: Path) -> str:
    """End of a message that names a file in `folder` with a similar name; empty if there is none."""
    near = nearest(name, [other.name for other in folder.iterdir()]) if folder.is_dir() else ""
    return near if "did you mean" in near else ""


def _axis(axes: list[tuple[str, bool]], name: str) -> bool:
    for place, rotary in axes:
        if rotary != axes[0][1]:
            turning, sliding = (place, axes[0][0]) if rotary else (axes[0][0], place)
            raise InputError(
                f"{name}: {turning} has a rotary unit, {sliding} a linear one; an axis is one or the other "
                "(rad, N*m, kg*m^2, N*m/rad, or m, N, kg, N/m)"
            )
    return bool(axes) and axes[0][1]


def _read_noise(table: TomlTable, kind: RigKind, stated: RigKind, rotary: bool) -> dict[str, float]:
    """Standard deviation by channel, SI, of the base kind, or of the stated kind itself."""
    table.allow(channel for channel in (*kind.channels, *stated.own) if channel != "time")
    return {key: quantity(table, key, stated.declared(key).si_unit(rotary), positive=True) for key in table.data}


QUESTION = "QUESTION:"
"""Mark of a line that the user should look at."""


def unanswered_questions(text: str) -> list[str]:
    """A warning if the text of an experiment file still has marked lines."""
    lines = [str(k) for k, line in enumerate(text.splitlines(), start=1) if QUESTION in line and k > 1]
    if not lines:
        return []
    shown = ", ".join(lines[:12]) + (", ..." if len(lines) > 12 else "")
    many = len(lines) > 1
    return [
        f"{len(lines)} question{'s' * many} of experiment.toml {'are' if many else 'is'} unanswered (line{'s' * many} "
        f"{shown}): what stands there is assumed"
    ]
