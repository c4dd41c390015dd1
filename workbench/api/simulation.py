"""`simulate`: the thesis's experiments on a design, and the model of an experiment on its own inputs or others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from workbench.api.measurement.experiment import Experiment, as_experiment
from workbench.operations.design import Design, load_design
from workbench.operations.progress import ProgressCallback
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from matplotlib.figure import Figure

    from sysid.simulate_experiment import SimulatedExperiment


class Simulation(Result):
    """One of the thesis's experiments, simulated on a design."""

    def __init__(self, name: str, results: Mapping[str, Any]) -> None:
        self.name = name
        self.results = results

    @cached_property
    def columns(self) -> dict[str, dict[str, np.ndarray]]:
        """The simulated motions and forces as arrays, by model (and case) and `name [unit]`."""
        from workbench.simulation.tables import stage_tables, tables_of

        return stage_tables(self.results) if self.name == "stage" else tables_of(self.name, self.results)

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The simulated motions and forces, columns `name [unit]`, by model (and case)."""
        import pandas as pd

        return {name: pd.DataFrame(columns) for name, columns in self.columns.items()}

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

        return finite({self.name: features_of(self.results)})

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

        return finite(simulated_json(self.found, self.seed, ()))

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


def friction_models() -> dict[str, str]:
    """Friction models of the thesis's experiments: title by name."""
    from sim.experiments.friction_models import MODELS, TITLES

    return {model: TITLES[model] for model in MODELS}


def tip_path(piezo_spacing: float, tip_height: float, stroke: float, phase: float) -> Any:
    """Path of the tip about its rest: arrays `x`, `y` (m) and `features()`, as of `simulate tip`.

    Args:
        piezo_spacing, tip_height: D and h, m.
        stroke: amplitude of a piezo, m.
        phase: between the piezos, rad.

    Raises:
        InputError: a length or a phase that is not allowed.
    """
    from sim.experiments.tip import tip_ellipse

    return tip_ellipse(piezo_spacing, tip_height, stroke, phase)


def simulate(
    what: str | Path | Experiment,
    design: Design | None = None,
    models: Sequence[str] = (),
    motion: Any = None,
    seed: int | None = 1,
    studies: Sequence[str] = (),
    progress: ProgressCallback | None = None,
) -> Simulation | SimulatedRecords:
    """Simulate one of the thesis's experiments on a design, or the model of an experiment.

    Args:
        what: `tip`, `presliding`, `hysteresis`, `stick-slip`, `stage` or `passivity`; or an experiment, or its folder.
        design: the packaged machine when left out.
        models: friction models of the thesis's experiments; all of them when left out.
        motion: inputs to simulate an experiment on, a DataFrame or the path of a file; its own when left out.
        seed: of the noise of simulated records; None for none.
        studies: of `stage`, such as `steps` or `hunting`; all of them when left out.
        progress: called with what is simulated, the runs done, and their number.

    Raises:
        InputError: an unknown name, a fault in a file, or a model that cannot be simulated on these inputs.
    """
    from workbench.simulation.experiments import EXPERIMENTS, EXTRA

    names = (*EXPERIMENTS, *EXTRA)
    if isinstance(what, str) and what in names:
        if motion is not None:
            raise InputError(f"simulate: '{what}' has a motion of its own; a motion is for an experiment with records")
        report = progress or (lambda step, done, total: None)
        if what == "stage":
            return _stage(design or load_design(), studies, report)
        return _thesis_experiment(what, design or load_design(), models, report)
    if isinstance(what, str) and not Path(what).exists():
        raise InputError(
            f"simulate: '{what}' is neither an experiment of the thesis nor a folder{nearest(what, names)}"
        )
    return _records(as_experiment(what, design), motion, seed)


def chosen_models(models: Sequence[str]) -> tuple[str, ...]:
    """The friction models named, all of them without any, in the order of the library.

    Raises:
        InputError: no such model.
    """
    known = friction_models()
    for model in models:
        if model not in known:
            raise InputError(f"simulate: no friction model '{model}'{nearest(model, known)}")
    return tuple(model for model in known if not models or model in models)


def _thesis_experiment(name: str, design: Design, models: Sequence[str], report: ProgressCallback) -> Simulation:
    from sim.integration.simulate import SimulationError
    from workbench.simulation.experiments import moving_mass, simulate_experiment

    chosen, done = chosen_models(models), 0

    def advance() -> None:
        nonlocal done
        done += 1
        report(name, done, len(chosen))

    report(name, 0, len(chosen))
    mass = 1.0 if name == "tip" else moving_mass(design.values, None)
    try:
        return Simulation(name, simulate_experiment(design.values, name, chosen, mass, advance))
    except SimulationError as failure:
        raise InputError(str(failure)) from None


def _stage(design: Design, studies: Sequence[str], report: ProgressCallback) -> Simulation:
    from sim.friction_stage.studies import STUDIES, stage_drive
    from stagecad.friction_stage.assembly.machine import body_masses
    from stagecad.processes import fork_map

    for study in studies:
        if study not in STUDIES:
            raise InputError(f"simulate: no study of the stage '{study}'{nearest(study, STUDIES)}")
    drive, found = stage_drive(design.values, body_masses(design.values)), {}
    for study in (one for one in STUDIES if not studies or one in studies):

        def run_cases(function: Callable[[Any], Any], cases: Sequence[Any], study: str = study) -> list[Any]:
            done = 0

            def advance(case: Any) -> None:
                nonlocal done
                done += 1
                report(study.replace("_", " "), done, len(cases))

            report(study.replace("_", " "), 0, len(cases))
            return fork_map(function, cases, progress=advance)

        found[study] = STUDIES[study](drive, run_cases)
    return Simulation("stage", found)


def _records(experiment: Experiment, motion: Any, seed: int | None) -> SimulatedRecords:
    from sysid.experiment.readers.memory import MemoryTable
    from sysid.simulate_experiment import simulate_experiment
    from workbench.api.measurement.statement import columns_of

    in_memory = motion is not None and not isinstance(motion, str | Path)
    inputs = MemoryTable("motion", columns_of(motion, "motion")) if in_memory else motion
    return SimulatedRecords(experiment, simulate_experiment(experiment.problem, motion=inputs), seed)
