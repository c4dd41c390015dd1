"""An experiment: rig, model and records, from a folder or from data in memory."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sim.effects.effect import Effect
from stagecad.consent import store_consent
from stagecad.deferred import pd, pyarrow, tomlkit
from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.errors import InputError, require, require_known
from stagecad.parameters.input_file import read_named
from stagecad.parameters.names import file_stem
from stagecad.parameters.units import format_quantity
from sysid.experiment.experiment import Experiment as StatedExperiment
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.experiment.experiment import python_files as python_files
from sysid.experiment.in_memory import experiment_in_memory
from sysid.experiment.model_table import model_of
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.toml_table import read_toml
from sysid.signals import BAND
from workbench.figures import Plot
from workbench.figures import identification as record_figures
from workbench.operations.design import Design
from workbench.operations.measurement.design_values import as_design_values
from workbench.operations.result import Result, frame
from workbench.operations.simulation.tables import write_table

if TYPE_CHECKING:
    from sysid.prediction.problem import Problem

OWNERS = ".experiments"
"""Folder beside the results of experiments that are elsewhere: the path of each, under the name of its results."""
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
        return cls(**{key: value for key, value in table.items() if key != "set"}, constants=table.get("set", {}))


@dataclass(frozen=True)
class Rig:
    """A rig: its kind, and what is known of it.

    Args:
        kind: a name (`velocity-drive`, `spring-pull`, `force-drive`, `actuator-tip`, `friction-drive`, or one of the
            declared kinds such as `motor-current`), or a `RigKind` of the user's own.
        known: quantities as text with a unit, perhaps with a deviation; what is not here is fitted.
        input_hold: course of the logged input between rows: held (`zero`) or `linear`; None: held, unless the records
            show the other.

    >>> Rig("force-drive", {"mass": "1.79 +- 0.01 kg"})
    Rig('force-drive', mass='1.79 +- 0.01 kg')
    """

    kind: str | RigKind
    known: Mapping[str, str] = field(default_factory=dict)
    input_hold: Literal["zero", "linear"] | None = None

    def __repr__(self) -> str:
        known = "".join(f", {name}={value!r}" for name, value in self.known.items())
        hold = f", input_hold={self.input_hold!r}" if self.input_hold is not None else ""
        return f"Rig({self.kind!r}{known}{hold})"

    def table(self) -> dict[str, Any]:
        """The table `[rig]` of an `experiment.toml`."""
        kind = self.kind if isinstance(self.kind, str) else self.kind.table()
        hold = {} if self.input_hold is None else {"input_hold": self.input_hold}
        return {"kind": kind, **hold, "known": dict(self.known)}


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
    def declared(self) -> tuple[Effect, ...]:
        """The user's effects, in the model or not."""
        return (*(effect for effect in self.effects if isinstance(effect, Effect)), *self.custom)

    def table(self) -> dict[str, Any]:
        """The table `[model]` of an `experiment.toml`."""
        settings = {key: dict(s) if isinstance(s, Mapping) else s for key, s in self.parameters.items()}
        return {"effects": list(self.names), **({"parameters": settings} if settings else {})}


@dataclass(frozen=True, eq=False)
class Record:
    """One record in memory.

    Args:
        data: a DataFrame of pandas or polars, an xarray Dataset, or arrays by column; columns are `name [unit]`, or
            `name` with the unit in `units`. The time is a column, or the index of the DataFrame.
        role: `fit`, or `validate` for a record held out.
        units: unit by channel or column.
        columns: column by channel, where the names differ.
        sign: 1 or -1 by channel.
        channels: what `[channels]` of a file says: by channel its column, a table with `column`, `unit`, `scale`,
            `increments`, `period`, `pitch`, `pulses_per_turn` or `value`, or a list of those that are added.
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
        file_stem(name, f"record {name!r}")
        table: dict[str, Any] = {"file": name, "name": name, "role": self.role}
        start, stop = self.window
        optional = {"from": start, "to": stop, "continues": self.continues}
        table |= {key: value for key, value in optional.items() if value is not None}
        maps = ("units", "columns", "sign", "noise", "channels")
        return table | {name: dict(value) for name in maps if (value := getattr(self, name))}


def columns_of(data: Any, name: str) -> dict[str, np.ndarray]:
    """Arrays by label of a DataFrame (its index too, if it is named or of times), of a mapping, of rows as mappings, of
    a table with Arrow's interface (polars) or of an xarray Dataset, whose attribute `units` is the unit.

    Values that a mask or a nullable type leaves out are gaps (NaN). Times are seconds from the first row."""
    kind = type(data)
    if issubclass(kind, list | tuple) and all(isinstance(row, Mapping) for row in data):
        data = pd.DataFrame(list(data))
    elif hasattr(kind, "data_vars"):
        units = {name: one.attrs["units"] for name, one in data.variables.items() if "units" in one.attrs}
        labels = {name: f"{name} [{unit}]" for name, unit in units.items() if "[" not in str(name)}
        data = data.to_dataframe().reset_index().rename(columns=labels)
    elif hasattr(kind, "__arrow_c_stream__") and hasattr(kind, "columns") and not hasattr(kind, "index"):
        data = pyarrow.table(data).to_pandas()
    columns: dict[Any, Any] = {}
    if isinstance(data, Mapping):
        columns = dict(data)
    elif hasattr(type(data), "columns") and hasattr(type(data), "index"):
        frame: Any = data
        if frame.index.dtype.kind in "mM":
            columns["time"] = frame.index
        elif frame.index.name is not None:
            columns[frame.index.name] = frame.index
        columns |= {label: frame[label] for label in frame.columns}
    else:
        raise InputError(f"{name}: is {type(data).__name__}; a DataFrame or a mapping of arrays is required")
    return dict(_column(str(label), values, name) for label, values in columns.items())


def _column(label: str, values: Any, name: str) -> tuple[str, np.ndarray]:
    """A column as an array, and its label, with the unit of times."""
    dtype = getattr(values, "dtype", None)
    kind = getattr(dtype, "kind", "")
    if getattr(dtype, "tz", None) is not None:
        values = values.to_numpy(dtype="datetime64[ns]")
    elif isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(float), np.nan) if kind in "biuf" else np.ma.filled(values)
    elif hasattr(dtype, "na_value") and kind in "biuf":
        values = values.to_numpy(dtype=float, na_value=np.nan)
    array = np.asarray(values)
    if array.dtype.kind not in "mM":
        return label, array
    if np.isnat(array).any():
        raise InputError(f"{name}: column '{label}': row {int(np.argmax(np.isnat(array))) + 1} has no time")
    return f"{label.partition('[')[0].strip()} [s]", (array - array[:1]) / np.timedelta64(1, "s")


class Experiment(Result):
    """An experiment: a rig, a model, and records. It never changes: `add` gives a new one.

    `Experiment.load` reads a folder, `Experiment.from_dataframes` takes data in memory.
    """

    def __init__(self, stated: StatedExperiment, design: Design | None = None) -> None:
        self.stated = stated
        self.design = design

    @classmethod
    def load(cls, path: str | Path, design: Design | None = None, trust: bool = False) -> Experiment:
        """Read an experiment from its folder, or its `experiment.toml`.

        Args:
            path: of the folder or the file.
            design: where the file states a value as `"design"`.
            trust: consent to run the Python files that the experiment names, with their present content.

        Raises:
            InputError: one line with file, key, value, and what is allowed.
        """
        if trust:
            trust_experiment(path)
        return cls(load_experiment(path, as_design_values(design)), design)

    @classmethod
    def from_dataframes(
        cls,
        records: Mapping[str, Any] | Sequence[Any],
        rig: Rig | str,
        model: Model | Sequence[str | Effect],
        noise: Mapping[str, str] | None = None,
        validate: Sequence[str] = (),
        design: Design | None = None,
        name: str = "experiment",
    ) -> Experiment:
        """An experiment of data in memory; no file is read or written.

        Args:
            records: by name, or in a list (`record_1`, `record_2`, ...), a DataFrame with columns `name [unit]`, a
                mapping of arrays, or a `Record` for one with settings of its own, such as the units of columns that
                name none.
            rig: the rig, or its kind.
            model: the model, or its effects: names, and `Effect` objects of the user's own.
            noise: standard deviation by channel, as text with a unit; estimated where left out.
            validate: names of the records held out; without any, the last 30 % in time of each record.
            design: where a value is stated as `"design"`.
            name: of the experiment.

        Raises:
            InputError: one line with key, value, and what is allowed.

        >>> import numpy as np
        >>> t = np.linspace(0.0, 10.0, 2001)
        >>> log = {"time [s]": t, "position [mm]": np.sin(t), "friction_force [N]": np.sign(np.cos(t))}
        >>> Experiment.from_dataframes({"sine": log}, rig="velocity-drive", model=["coulomb"])
        <Experiment 'experiment': velocity-drive, model coulomb, 1 record of 2001 rows>
        """
        rig = Rig(rig) if isinstance(rig, str) else rig
        model = Model(model) if isinstance(model, list | tuple) else model
        listed = isinstance(records, list | tuple)
        tables: Any = {f"record_{k}": table for k, table in enumerate(records, start=1)} if listed else records
        for what, given, kinds, wanted in (
            ("name", name, str, "a text"),
            ("rig", rig, Rig, "a Rig, or the name of its kind,"),
            ("model", model, Model, "a Model, or a list of effects,"),
            ("records", tables, Mapping, "a list of tables, or a mapping of them by name,"),
            ("noise", noise or {}, Mapping, "a mapping of texts by channel"),
        ):
            require(isinstance(given, kinds), f"{name}: {what}: is {type(given).__name__}; {wanted} is required")
        assert isinstance(model, Model)
        stated = {label: given if isinstance(given, Record) else Record(given) for label, given in tables.items()}
        for label in validate:
            require_known(label, stated, f"{name}: validate: no record '{label}'")
            stated[label] = replace(stated[label], role="validate")
        document = {
            "schema": 1,
            "rig": rig.table(),
            "model": model.table(),
            "record": [record.table(label) for label, record in stated.items()],
            "noise": dict(noise or {}),
        }
        arrays = {label: MemoryTable(label, columns_of(record.data, label)) for label, record in stated.items()}
        return cls(experiment_in_memory(document, arrays, model.declared, as_design_values(design), name), design)

    @property
    def name(self) -> str:
        """Name: of the folder, or as given."""
        return self.stated.folder.resolve().name if self.in_files else str(self.stated.folder)

    def results_in(self, out: str | Path) -> Path:
        """Folder below `out` for report and files of results."""
        if self.in_files:
            return Path(out) / results_key(out, self.stated.folder)
        return Path(out) / (re.sub(r"[^\w.-]", "_", self.name) or "experiment")

    def has_report(self, out: str | Path) -> bool:
        """Whether there is a report of earlier results below `out`."""
        return Path(out).is_dir() and (self.results_in(out) / "report.html").is_file()

    @property
    def in_files(self) -> bool:
        """Whether the experiment is a folder; otherwise it is in memory."""
        return self.stated.revisions is None

    @property
    def rig(self) -> Rig:
        """The rig as stated."""
        table = tomllib.loads(self.stated.text)["rig"]
        kind = RigKind.from_table(table["kind"]) if isinstance(table["kind"], dict) else table["kind"]
        return Rig(kind, table.get("known", {}), table.get("input_hold"))

    @property
    def model(self) -> Model:
        """The model as stated."""
        stated = model_of(self.stated.text)
        names: list[str] = list(stated.get("effects", ()))
        declared = {effect.name: effect for effect in self.stated.custom if isinstance(effect, Effect)}
        rest = [effect for name, effect in declared.items() if name not in names]
        return Model([declared.get(name, name) for name in names], stated.get("parameters", {}), rest)

    @cached_property
    def problem(self) -> Problem:
        """The identification problem: the records read, their noise, and the model before any fit.

        Raises:
            InputError: a fault in a record.
        """
        from sysid.prediction.problem import problem_of

        return problem_of(self.stated)

    @property
    def records(self) -> dict[str, pd.DataFrame]:
        """The records as read, by name: columns in SI, the time as index."""
        tables = {}
        for record in self.problem.records:
            table = pd.DataFrame(dict(record.channels), index=pd.Index(record.time, name="time"))
            table.attrs["units"] = dict(record.units)
            tables[record.name] = table
        return tables

    @property
    def facts(self) -> dict[str, Any]:
        """Stated model, text of the file, rig, noise and records, as plain data."""
        rig = self.stated.rig
        return {
            "stated": list(self.stated.effects),
            "text": self.stated.text,
            "rig": {"kind": rig.kind, "rotary": rig.rotary},
            "noise": noise_text(self.problem),
            "records": [
                {
                    "name": record.name,
                    "role": record.role,
                    "rows": record.size,
                    "seconds": float(record.time[-1] - record.time[0]),
                    "channels": list(record.channels),
                    "notes": list(record.notes),
                }
                for record in self.problem.records
            ],
        }

    def to_dataframe(self) -> pd.DataFrame:
        """All records below each other, SI; index `record`, `time`."""
        return pd.concat(self.records, names=["record"])

    def to_json(self) -> dict[str, Any]:
        """The content of `experiment.toml`, as plain data."""
        return tomllib.loads(self.stated.text)

    def plot(self) -> Plot:
        """Every channel of every record over time."""
        return record_figures.records_figure(self.problem.records)

    def save(self, folder: str | Path) -> Experiment:
        """Write an experiment in memory to a new folder, its records as Parquet; returns the one loaded from there.

        Raises:
            InputError: the folder has an experiment already, or an effect of the model is declared in memory.
        """
        folder = Path(folder)
        require(not self.in_files, f"{self.stated.path}: is in a folder already")
        declared = [effect.name for effect in self.stated.custom if isinstance(effect, Effect)]
        if declared:
            raise InputError(
                f"{folder}: effect '{declared[0]}' is declared in memory; put it into a Python file, save without it, "
                "and name the file under [model] custom"
            )
        target = folder / "experiment.toml"
        require(not target.exists(), f"{target}: is there already; name a new folder")
        document = self.to_json()
        for table, spec in zip(document["record"], self.stated.records, strict=True):
            assert isinstance(spec.path, MemoryTable)
            (written,) = write_table(folder / table["file"], spec.path.columns, ("parquet",))
            table["file"] = written.name
        atomic_write_text(target, tomlkit.dumps(document))
        return Experiment.load(folder, self.design)

    def __repr__(self) -> str:
        effects = ", ".join(self.stated.effects) or "without effects"
        rows = sum(record.size for record in self.problem.records)
        count = len(self.stated.records)
        records = f"{count} record{'s' if count != 1 else ''} of {rows} rows"
        return f"<Experiment '{self.name}': {self.stated.rig.kind}, model {effects}, {records}>"

    def summary(self) -> list[tuple[str, str]]:
        """Facts of the experiment, by their names."""
        return [
            ("rig", repr(self.rig)),
            ("model", ", ".join(self.stated.effects) or "without effects"),
            ("noise", noise_text(self.problem)),
            *(("note", note) for note in self.problem.notes),
        ]

    def _table(self) -> pd.DataFrame:
        records = ((one, "held out" if one.role == "validate" else "fit") for one in self.problem.records)
        rows = [
            (one.name, role, one.size, round(float(one.time[-1] - one.time[0]), 6), ", ".join(one.channels))
            for one, role in records
        ]
        return frame(rows, "record", columns=("record", "role", "rows", "seconds", "channels"))


def noise_text(problem: Problem) -> str:
    """The noise by channel, the form of the residual, and the band it is compared in."""
    measured = {*problem.fit_records[0].measured, "position"}
    parts = [
        f"{channel} {format_quantity(noise.value, noise.unit)} ({noise.source})"
        for channel, noise in problem.noise.items()
        if channel in measured
    ]
    band = getattr(problem.fit_records[0], "whole", None)
    text = f"{', '.join(parts)}; residual as {problem.form.replace('_', ' ')}"
    if band is not None and band.width > 0:
        text += f", below {BAND / band.width:.3g} Hz: the band that the position's noise allows"
    return text


def as_experiment(source: Experiment | str | Path, design: Design | None = None) -> Experiment:
    """An experiment, or the one in a folder."""
    if isinstance(source, Experiment):
        return source
    if isinstance(source, str | Path):
        return Experiment.load(source, design)
    raise InputError(f"an Experiment or its folder is required, not {type(source).__name__}")


def results_key(out: str | Path, experiment: Path, working: Path | None = None) -> Path:
    """Folder of an experiment's results relative to that of all results, `out`.

    Its path in `out`, else in the working folder, so that `a/rig` and `b/rig` have results of their own; its last name
    if it is elsewhere, with a number where that has the results of another. A note says whose results they are.
    """
    folder = experiment.resolve()
    bases = [one for one in (Path(out).resolve(), (working or Path.cwd()).resolve()) if one in folder.parents]
    first = name = folder.relative_to(bases[0]) if bases else Path(folder.name)
    wanted, number = b"" if bases else os.fsencode(folder), 1
    while True:
        note = Path(out) / OWNERS / name
        if wanted and not (note.exists() or (Path(out) / name).exists()):
            atomic_write_bytes(note, wanted)
        if (read_named(note) if note.is_file() else b"") == wanted:
            return name
        number += 1
        name = first.with_name(f"{first.name}_{number}")


def named_files(folder: str | Path) -> tuple[tuple[str, ...], bool]:
    """The record files that `experiment.toml` names, and whether it names Python code; nothing of it is run."""
    path = Path(folder) / "experiment.toml"
    data = read_toml(path, path.parent.name + "/" + path.name)[2].data
    records, model = data.get("record", ()), data.get("model", {})
    named = (
        tuple(record.get("file") for record in records if isinstance(record, dict)) if isinstance(records, list) else ()
    )
    return tuple(file for file in named if isinstance(file, str)), isinstance(model, dict) and bool(model.get("custom"))


def consent(folder: str | Path, hashes: Mapping[str, str]) -> None:
    """Let Python files of an experiment run with the content that was read."""
    folder = Path(folder)
    present = [file for file in python_files(folder) if file["name"] in hashes]
    for file in present:
        if hashes[file["name"]] != file["sha256"]:
            raise InputError(f"{folder.name}/{file['name']}: has changed since it was shown; read it again")
    for file in present:
        store_consent(folder / file["name"], file["sha256"])
