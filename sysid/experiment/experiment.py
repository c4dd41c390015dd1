"""An experiment: the rig, the stated model, the records and their noise, read from `experiment.toml`."""

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from sim.effects.effect import Effect
from stagecad.consent import give_consent, has_consent
from stagecad.parameters.errors import InputError, nearest
from sysid.experiment.known import DesignValues, Known, known_axes, read_known
from sysid.experiment.readers.base import shown_path
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.record_spec import RecordSpec, read_record_specs
from sysid.experiment.rig_kinds.balance import balance_of
from sysid.experiment.rig_kinds.declaration import declared_rig, find_rig
from sysid.experiment.rigs import CHANNELS, RIGS, RigKind
from sysid.experiment.settings import Setting, check_effects, read_settings
from sysid.experiment.toml_table import TomlTable, quantity, read_toml, shown


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
    text: str
    sha256: str
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
    _check_schema(top)
    for key, example in (("rig", "[rig]"), ("model", "[model]"), ("record", "[[record]]")):
        if key not in top.data:
            raise InputError(f"{name}: '{key}' is missing; write {example}")
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
    if kind.base:
        balance, known = balance_of(kind, known, rotary, name)
        records, kind = tuple(replace(record, balance=balance) for record in records), RIGS[kind.base]
    noise = _read_noise(top.table("noise"), kind, rotary)
    records = tuple(_with_noise(record, table, kind, rotary) for record, table in zip(records, top.tables("record")))
    model = top.table("model")
    model.allow(("effects", "custom", "parameters"))
    if "effects" not in model.data:
        raise InputError(f'{model.where()}: \'effects\' is missing; write effects = ["coulomb", "viscous"], or []')
    effects = model.texts("effects")
    custom = (*custom_files(model, file.parent), *own)
    found = check_effects(effects, custom, kind, measured, model)
    parameters = read_settings(model.table("parameters"), found, kind, rotary, design)
    return Experiment(
        folder=file.parent,
        path=file,
        rig=Rig(kind.name, known, rotary, hold),
        effects=effects,
        custom=custom,
        parameters=parameters,
        records=records,
        noise=noise,
        text="",
        sha256="",
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


def _check_schema(top: TomlTable) -> None:
    if "schema" not in top.data:
        raise InputError(f"{top.file}: 'schema' is missing; write schema = {SCHEMA} at the top")
    value = top.data["schema"]
    if isinstance(value, bool) or value != SCHEMA:
        raise InputError(f"{top.where('schema')}: {shown(value)} is not allowed; write schema = {SCHEMA}")


def _axis(axes: list[tuple[str, bool]], name: str) -> bool:
    for place, rotary in axes:
        if rotary != axes[0][1]:
            turning, sliding = (place, axes[0][0]) if rotary else (axes[0][0], place)
            raise InputError(
                f"{name}: {turning} has a rotary unit, {sliding} a linear one; an axis is one or the other "
                "(rad, N*m, kg*m^2, N*m/rad, or m, N, kg, N/m)"
            )
    return bool(axes) and axes[0][1]


def _read_noise(table: TomlTable, kind: RigKind, rotary: bool) -> dict[str, float]:
    noise = {}
    channels = tuple(channel for channel in kind.channels if channel != "time")
    table.allow(channels)
    for key in table.data:
        declared = CHANNELS[key]
        unit = declared.si_unit(rotary)
        noise[key] = quantity(table, key, unit, positive=True)
    return noise


def _with_noise(record: RecordSpec, table: TomlTable, kind: RigKind, rotary: bool) -> RecordSpec:
    return replace(record, noise=_read_noise(table.table("noise"), kind, rotary))
