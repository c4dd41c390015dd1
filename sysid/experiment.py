"""An experiment: the rig, the model as it stands, the records and their noise, read from `experiment.toml`."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.quantities import parse_quantity, parse_uncertain
from sysid.columns import Source, choose_columns
from sysid.effect_settings import Setting, check_effects, read_settings
from sysid.record_file import open_record_file, shown_path
from sysid.rigs import CHANNELS, RigKind, find_rig
from sysid.toml_table import TomlTable, kind_of, read_toml, shown

SCHEMA = 1
DesignValues = Mapping[str, float] | Callable[[str], float]
"""SI values that `"design"` stands for, by the name of the known quantity."""


@dataclass(frozen=True)
class Known:
    """A number known about the rig, SI.

    Args:
        value: the number.
        std: its standard deviation; none where the user gave none.
        origin: `given` in the file, or taken from the `design`.
    """

    value: float
    std: float | None = None
    origin: Literal["given", "design"] = "given"


@dataclass(frozen=True)
class Rig:
    """The rig of an experiment.

    Args:
        kind: name of the kind of rig (`sysid.rigs`).
        known: what is known; `inertia` is filed under `mass`.
        rotary: whether the axis turns.
        input_hold: how the logged input goes from row to row: held, or linear.
    """

    kind: str
    known: Mapping[str, Known]
    rotary: bool
    input_hold: Literal["zero", "linear"] = "zero"

    @property
    def declaration(self) -> RigKind:
        """What this kind of rig imposes and measures."""
        return find_rig(self.kind, "rig.kind")


@dataclass(frozen=True)
class RecordSpec:
    """One `[[record]]` as written, its columns found.

    Args:
        name: `name` in the file, else the stem of `file`; unique.
        file: as written.
        path: where it lies.
        role: `fit` or `validate`.
        sources: channel to column.
        sign: channel to 1 or -1.
        start, stop: window on the time column, s; none where open.
        continues: name of the record whose end this one starts from.
        noise: standard deviations of this record, SI.
        notes: columns not used.
        where: place in the experiment file, for messages.
    """

    name: str
    file: str
    path: Path
    role: Literal["fit", "validate"]
    sources: Mapping[str, Source]
    sign: Mapping[str, int] = field(default_factory=dict)
    start: float | None = None
    stop: float | None = None
    continues: str | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    where: str = ""


@dataclass(frozen=True)
class Experiment:
    """An experiment as read.

    Args:
        folder: where `experiment.toml` lies.
        path: the file.
        rig: kind, known numbers, axis.
        effects: the model's effects in order.
        custom: files of the user's own effects.
        parameters: start, bounds, or fixed value by `effect.parameter`, SI.
        records: the records.
        noise: standard deviation by channel, SI.
        text: the file, to edit it with its comments.
        sha256: of the file's bytes.
    """

    folder: Path
    path: Path
    rig: Rig
    effects: tuple[str, ...]
    custom: tuple[Path, ...]
    parameters: Mapping[str, Setting]
    records: tuple[RecordSpec, ...]
    noise: Mapping[str, float]
    text: str
    sha256: str


def load_experiment(path: str | Path, design: DesignValues | None = None) -> Experiment:
    """Read an experiment.

    Args:
        path: the folder, or its `experiment.toml`.
        design: what a known value of `"design"` stands for, SI, by name (`mass`, `piezo_spacing`, ...): a table, or a
            function that is called only for the names the file asks for.

    Raises:
        InputError: one line with file, key, value, and what would be right.
    """
    file = _experiment_file(Path(path))
    name = shown_path(str(file))
    data, text, top = read_toml(file, name)
    top.allow(("schema", "rig", "model", "record", "noise"))
    _check_schema(top)
    for key, example in (("rig", "[rig]"), ("model", "[model]"), ("record", "[[record]]")):
        if key not in top.data:
            raise InputError(f"{name}: '{key}' is missing; write {example}")
    rig_table = top.table("rig")
    rig_table.allow(("kind", "known", "input_hold"))
    kind = find_rig(rig_table.text("kind"), rig_table.where("kind"))
    hold: Any = rig_table.choice("input_hold", ("zero", "linear"), "zero")
    records, axes = _read_records(top, kind, file)
    known_table = rig_table.table("known")
    rotary = _axis(axes + _known_axes(known_table, kind), name)
    known = _read_known(known_table, kind, rotary, design)
    measured = {channel for record in records for channel in record.sources}
    noise = _read_noise(top.table("noise"), kind, rotary)
    records = tuple(_with_noise(record, table, kind, rotary) for record, table in zip(records, top.tables("record")))
    model = top.table("model")
    model.allow(("effects", "custom", "parameters"))
    if "effects" not in model.data:
        raise InputError(f'{model.where()}: \'effects\' is missing; write effects = ["coulomb", "viscous"], or []')
    effects = model.texts("effects")
    custom = tuple(file.parent / item for item in model.texts("custom"))
    found = check_effects(effects, custom, kind, measured, model)
    parameters = read_settings(model.table("parameters"), found, kind, rotary)
    return Experiment(
        folder=file.parent,
        path=file,
        rig=Rig(kind.name, known, rotary, hold),
        effects=effects,
        custom=custom,
        parameters=parameters,
        records=records,
        noise=noise,
        text=text,
        sha256=hashlib.sha256(data).hexdigest(),
    )


def _experiment_file(path: Path) -> Path:
    name = shown_path(str(path))
    try:
        if path.is_dir():
            file = path / "experiment.toml"
            if not file.is_file():
                others = [other.name for other in path.glob("*.toml")]
                raise InputError(
                    f"{name}: has no experiment.toml{nearest('experiment.toml', others) if others else ''}"
                )
            return file
        if path.is_file():
            return path
        folder = path.parent
        beside = [other.name for other in folder.iterdir()] if folder.is_dir() else []
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    near = nearest(path.name, beside) if beside else ""
    raise InputError(f"{name}: no such folder or file{near if 'did you mean' in near else ''}")


def _check_schema(top: TomlTable) -> None:
    if "schema" not in top.data:
        raise InputError(f"{top.file}: 'schema' is missing; write schema = {SCHEMA} at the top")
    value = top.data["schema"]
    if isinstance(value, bool) or value != SCHEMA:
        raise InputError(f"{top.where('schema')}: {shown(value)} is not allowed; write schema = {SCHEMA}")


def quantity(table: TomlTable, key: str, unit: str, positive: bool = False) -> float:
    """The quantity under `key` in SI.

    Raises:
        InputError: not a text, no quantity, another dimension, or not positive where it must be.
    """
    value = parse_quantity(_quantity_text(table, key, unit), unit, table.where(key))
    _check_value(value, positive, table, key)
    return value


def _quantity_text(table: TomlTable, key: str, unit: str) -> str:
    value = table.data[key]
    if not isinstance(value, str):
        example = (
            f"'{value} {unit}'" if isinstance(value, int | float) and not isinstance(value, bool) else f"'1 {unit}'"
        )
        raise InputError(
            f"{table.where(key)}: {shown(value)} is {kind_of(value)}, a quantity with its unit is wanted, "
            f"such as {example}"
        )
    return value


def _check_value(value: float, positive: bool, table: TomlTable, key: str) -> None:
    if not math.isfinite(value):
        raise InputError(f"{table.where(key)}: '{table.data[key]}' is not finite")
    if positive and value <= 0.0:
        raise InputError(f"{table.where(key)}: '{table.data[key]}' must be above zero")


def _read_records(top: TomlTable, kind: RigKind, file: Path) -> tuple[tuple[RecordSpec, ...], list[tuple[str, bool]]]:
    tables = top.tables("record")
    if not tables:
        raise InputError(f"{top.file}: there is no record; write [[record]] with file and role")
    records: list[RecordSpec] = []
    axes: list[tuple[str, bool]] = []
    for table in tables:
        table.allow(("file", "role", "name", "columns", "units", "sign", "from", "to", "continues", "noise"))
        written = table.text("file")
        role: Any = table.choice("role", ("fit", "validate"))
        shown_name = shown_path(str(file.parent / written))
        opened = open_record_file(file.parent / written, shown_name)
        renamed, units = _texts_by_key(table.table("columns")), _texts_by_key(table.table("units"))
        # Units that a file carries inside serve where the experiment is silent.
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
                path=file.parent / written,
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
                    f"{record.where}: continues = '{record.continues}' stands below; "
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


def _known_axes(table: TomlTable, kind: RigKind) -> list[tuple[str, bool]]:
    table.allow(kind.known)
    if "mass" in table.data and "inertia" in table.data:
        raise InputError(f"{table.where()}: 'mass' and 'inertia' are both given; one of them is wanted")
    axes = []
    for key, value in table.data.items():
        declared = kind.known[key]
        if value == "design" or declared.unit == declared.rotary_unit:
            continue
        text = _quantity_text(table, key, declared.unit)
        try:
            parse_uncertain(text, declared.unit, table.where(key))
            axes.append((f"rig.known.{key}", False))
        except InputError as linear:
            try:
                parse_uncertain(text, declared.rotary_unit, table.where(key))
            except InputError:
                raise linear from None
            axes.append((f"rig.known.{key}", True))
    return axes


def _axis(axes: list[tuple[str, bool]], name: str) -> bool:
    for place, rotary in axes:
        if rotary != axes[0][1]:
            turning, sliding = (place, axes[0][0]) if rotary else (axes[0][0], place)
            raise InputError(
                f"{name}: {turning} has a rotary unit, {sliding} a linear one; an axis is one or the other "
                "(rad, N*m, kg*m^2, N*m/rad, or m, N, kg, N/m)"
            )
    return bool(axes) and axes[0][1]


def _read_known(table: TomlTable, kind: RigKind, rotary: bool, design: DesignValues | None) -> dict[str, Known]:
    known: dict[str, Known] = {}
    for key, value in table.data.items():
        declared = kind.known[key]
        if key == "inertia" and not rotary:
            raise InputError(f"{table.where(key)}: the axis is linear; write mass = '1 kg'")
        unit = declared.rotary_unit if rotary else declared.unit
        filed = "mass" if key == "inertia" else key
        if value == "design":
            known[filed] = Known(_design_value(design, filed, rotary, table.where(key)), None, "design")
            continue
        number, std = parse_uncertain(_quantity_text(table, key, unit), unit, table.where(key))
        _check_value(number, declared.positive, table, key)
        if std is not None and not (math.isfinite(std) and std > 0.0):
            raise InputError(f"{table.where(key)}: '{value}': the uncertainty must be above zero")
        known[filed] = Known(number, std)
    return known


def _design_value(design: DesignValues | None, key: str, rotary: bool, where: str) -> float:
    if design is None:
        raise InputError(f"{where}: 'design' needs a parameter file, and none is at hand; write the quantity")
    if rotary:
        raise InputError(f"{where}: the design is of a linear axis; write the quantity")
    if callable(design):
        try:
            return float(design(key))
        except InputError as error:
            # What the design has to say about a key of this file is said with the file.
            file = where.partition(": ")[0] + ": " if str(error).startswith("rig.") else ""
            raise InputError(f"{file}{error}") from None
    if key not in design:
        raise InputError(f"{where}: the design has no '{key}'{nearest(key, design)}")
    return float(design[key])


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
