"""`simulate`: the thesis's experiments on a design, and the model of an experiment on its own inputs or others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from workbench.api.design import Design, load_design
from workbench.api.experiment import Experiment, as_experiment
from workbench.api.result import Result, finite_json

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from sysid.simulate_experiment import SimulatedExperiment


class Simulation(Result):
    """One of the thesis's experiments, simulated on a design."""

    def __init__(self, name: str, results: Mapping[str, Any]) -> None:
        self.name = name
        self.results = results

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The simulated motions and forces, columns `name [unit]`, by model (and case)."""
        import pandas as pd

        from workbench.simulation.tables import stage_tables, tables_of

        tables = stage_tables(self.results) if self.name == "stage" else tables_of(self.name, self.results)
        return {name: pd.DataFrame(columns) for name, columns in tables.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """The features, SI: a row for each model (and case) and feature."""
        import pandas as pd

        from workbench.simulation.experiments import flat_features

        rows = [
            {
                "of": " ".join(path[:-1]),
                "feature": path[-1],
                "value": None if quantity is None else quantity["value"],
                "unit": None if quantity is None else quantity["unit"],
            }
            for path, quantity in flat_features(self.to_json()[self.name]).items()
        ]
        return pd.DataFrame(rows).set_index(["of", "feature"])

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad simulate NAME --json`."""
        from workbench.simulation.experiments import features_of

        return finite_json({self.name: features_of(self.results)})

    def plot(self, table: str | None = None) -> Figure:
        """Motions and forces of one table over its time; the first table when left out.

        Raises:
            InputError: no such table.
        """
        from workbench.api.figures.results import motion_figure

        shown = {
            name: columns.drop(columns=[label for label in columns if str(label).endswith("[J]")])
            for name, columns in self.tables.items()
        }
        return motion_figure(shown, table)

    def __repr__(self) -> str:
        return f"<Simulation '{self.name}': {', '.join(self.results)}>"


class SimulatedRecords(Result):
    """Records simulated from the model of an experiment, with the noise of each sensor."""

    def __init__(self, experiment: Experiment, found: SimulatedExperiment, seed: int | None) -> None:
        self.experiment = experiment
        self.found = found
        self.seed = seed

    @cached_property
    def records(self) -> dict[str, pd.DataFrame]:
        """The records with noise, columns `name [unit]`, by name."""
        import pandas as pd

        logged = self.found.logged(self.seed)
        return {record.name: pd.DataFrame(table) for record, table in zip(self.found.records, logged, strict=True)}

    def to_dataframe(self) -> pd.DataFrame:
        """All records below each other; index `record`, `row`."""
        import pandas as pd

        return pd.concat(self.records, names=["record", "row"])

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad simulate EXPERIMENT --json`, without files."""
        from workbench.simulation.records import simulated_json

        return finite_json(simulated_json(self.found, self.seed, ()))

    def plot(self, record: str | None = None) -> Figure:
        """The channels of a record over time; the first record when left out.

        Raises:
            InputError: no such record.
        """
        from workbench.api.figures.results import motion_figure

        return motion_figure(self.records, record)

    def __repr__(self) -> str:
        effects = ", ".join(effect.name for effect in self.found.model.effects)
        rows = sum(record.time.size for record in self.found.records)
        noise = "without noise" if self.seed is None else f"noise of seed {self.seed}"
        return f"<SimulatedRecords of '{self.experiment.name}', model {effects}: {rows} rows, {noise}>"


def simulate(
    what: str | Path | Experiment,
    design: Design | None = None,
    models: Sequence[str] = (),
    motion: Any = None,
    seed: int | None = 1,
) -> Simulation | SimulatedRecords:
    """Simulate one of the thesis's experiments on a design, or the model of an experiment.

    Args:
        what: `tip`, `presliding`, `hysteresis`, `stick-slip`, `stage` or `passivity`; or an experiment, or its folder.
        design: the packaged machine when left out.
        models: friction models of the thesis's experiments; all of them when left out.
        motion: inputs to simulate an experiment on, a DataFrame or the path of a file; its own when left out.
        seed: of the noise of simulated records; None for none.

    Raises:
        InputError: an unknown name, a fault in a file, or a model that cannot be simulated on these inputs.
    """
    from workbench.simulation.experiments import EXPERIMENTS, EXTRA

    names = (*EXPERIMENTS, *EXTRA)
    if isinstance(what, str) and what in names:
        if motion is not None:
            raise InputError(f"simulate: '{what}' has a motion of its own; a motion is for an experiment with records")
        return _thesis_experiment(what, design or load_design(), models)
    if isinstance(what, str) and not Path(what).exists():
        raise InputError(
            f"simulate: '{what}' is neither an experiment of the thesis nor a folder{nearest(what, names)}"
        )
    return _records(as_experiment(what, design), motion, seed)


def _thesis_experiment(name: str, design: Design, models: Sequence[str]) -> Simulation:
    from sim.experiments.friction_models import MODELS
    from sim.integration.simulate import SimulationError
    from sim.stage.studies import STUDY_NAMES
    from workbench.simulation.experiments import Selection, simulate_selection

    for model in models:
        if model not in MODELS:
            raise InputError(f"simulate: no friction model '{model}'{nearest(model, MODELS)}")
    chosen = Selection((name,), tuple(models) or tuple(MODELS), None, STUDY_NAMES)
    try:
        return Simulation(name, simulate_selection(design.values, chosen)[name])
    except SimulationError as failure:
        raise InputError(str(failure)) from None


def _records(experiment: Experiment, motion: Any, seed: int | None) -> SimulatedRecords:
    from sysid.experiment.readers.memory import MemoryTable
    from sysid.simulate_experiment import simulate_experiment
    from workbench.api.statement import columns_of

    in_memory = motion is not None and not isinstance(motion, str | Path)
    inputs = MemoryTable("motion", columns_of(motion, "motion")) if in_memory else motion
    return SimulatedRecords(experiment, simulate_experiment(experiment.problem, motion=inputs), seed)
