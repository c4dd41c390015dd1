"""An experiment: rig, model and records, from a folder or from data in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError, nearest
from sysid.experiment.experiment import Experiment as StatedExperiment
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.experiment.in_memory import experiment_in_memory
from sysid.experiment.known import DesignValues
from sysid.experiment.model_table import model_of
from workbench.api.measurement.statement import Model, Record, Rig, RigKind
from workbench.operations.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from sysid.prediction.problem import Problem
    from workbench.operations.design import Design


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
        return cls(load_experiment(path, design_source(design)), design)

    @classmethod
    def from_dataframes(
        cls,
        records: Mapping[str, Any],
        rig: Rig | str,
        model: Model | Sequence[str | Effect],
        noise: Mapping[str, str] | None = None,
        validate: Sequence[str] = (),
        design: Design | None = None,
        name: str = "experiment",
    ) -> Experiment:
        """An experiment of data in memory; no file is read or written.

        Args:
            records: by name, a DataFrame with columns `name [unit]`, a mapping of arrays, or a `Record` for one with
                settings of its own, such as the units of columns that name none.
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
        model = model if isinstance(model, Model) else Model(model)
        stated = {label: given if isinstance(given, Record) else Record(given) for label, given in records.items()}
        for label in validate:
            if label not in stated:
                raise InputError(f"{name}: validate: no record '{label}'{nearest(label, stated)}")
            stated[label] = replace(stated[label], role="validate")
        document = {
            "schema": 1,
            "rig": rig.table(),
            "model": model.table(),
            "record": [record.table(label) for label, record in stated.items()],
            "noise": dict(noise or {}),
        }
        arrays = {label: record.arrays(label) for label, record in stated.items()}
        return cls(experiment_in_memory(document, arrays, model.own, design_source(design), name), design)

    @property
    def name(self) -> str:
        """Name: of the folder, or as given."""
        return self.stated.folder.resolve().name if self.in_files else str(self.stated.folder)

    @property
    def in_files(self) -> bool:
        """Whether the experiment is a folder; otherwise it is in memory."""
        return self.stated.revisions is None

    @property
    def rig(self) -> Rig:
        """The rig as stated."""
        import tomllib

        table = tomllib.loads(self.stated.text)["rig"]
        kind = RigKind.from_table(table["kind"]) if isinstance(table["kind"], dict) else table["kind"]
        return Rig(kind, table.get("known", {}), self.stated.rig.input_hold)

    @property
    def model(self) -> Model:
        """The model as stated."""
        stated = model_of(self.stated.text)
        names = list(stated.get("effects", ()))
        own = {effect.name: effect for effect in self.stated.custom if isinstance(effect, Effect)}
        rest = [effect for name, effect in own.items() if name not in names]
        effects: list[str | Effect] = list(names)
        for place, name in enumerate(names):
            effects[place] = own.get(name, effects[place])
        return Model(effects, stated.get("parameters", {}), rest)

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
        import pandas as pd

        tables = {}
        for record in self.problem.records:
            table = pd.DataFrame(dict(record.channels), index=pd.Index(record.time, name="time"))
            table.attrs["units"] = dict(record.units)
            tables[record.name] = table
        return tables

    def to_dataframe(self) -> pd.DataFrame:
        """All records below each other, SI; index `record`, `time`."""
        import pandas as pd

        return pd.concat(self.records, names=["record"])

    def to_json(self) -> dict[str, Any]:
        """The content of `experiment.toml`, as plain data."""
        import tomllib

        return tomllib.loads(self.stated.text)

    def plot(self) -> Figure:
        """Every channel of every record over time."""
        from workbench.api.figures.results import records_figure

        return records_figure(self)

    def save(self, folder: str | Path) -> Experiment:
        """Write an experiment in memory to a new folder, its records as Parquet; returns the one loaded from there.

        Raises:
            InputError: the folder has an experiment already, or an effect of the model is declared in memory.
        """
        from workbench.api.measurement.saving import save

        return Experiment.load(save(self, Path(folder)), self.design)

    def __repr__(self) -> str:
        effects = ", ".join(self.stated.effects) or "without effects"
        rows = sum(record.size for record in self.problem.records)
        count = len(self.stated.records)
        records = f"{count} record{'s' if count != 1 else ''} of {rows} rows"
        return f"<Experiment '{self.name}': {self.stated.rig.kind}, model {effects}, {records}>"

    def summary(self) -> list[tuple[str, str]]:
        """Facts of the experiment, by their names."""
        from workbench.identification.statements import noise_text

        return [
            ("rig", repr(self.rig)),
            ("model", ", ".join(self.stated.effects) or "without effects"),
            ("noise", noise_text(self.problem)),
            *(("note", note) for note in self.problem.notes),
        ]

    def _table(self) -> pd.DataFrame:
        import pandas as pd

        rows = [
            {
                "record": r.name,
                "role": "held out" if r.role == "validate" else "fit",
                "rows": r.size,
                "seconds": round(float(r.time[-1] - r.time[0]), 6),
                "channels": ", ".join(r.channels),
            }
            for r in self.problem.records
        ]
        return pd.DataFrame(rows).set_index("record")


def as_experiment(source: Experiment | str | Path, design: Design | None = None) -> Experiment:
    """An experiment, or the one in a folder.

    Raises:
        InputError: neither of the two, or a fault in the file.
    """
    if isinstance(source, Experiment):
        return source
    if isinstance(source, str | Path):
        return Experiment.load(source, design)
    raise InputError(f"an Experiment or its folder is required, not {type(source).__name__}")


def design_source(design: Design | None) -> DesignValues:
    """Values of settings stated as `"design"`; those of the packaged machine where no design is given."""
    from workbench.identification.design_values import design_values
    from workbench.operations.design import load_design

    # Read when a value is needed.
    return lambda key: design_values(design or load_design())(key)
