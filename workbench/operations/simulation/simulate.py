"""`simulate`: the thesis's experiments and the stage's studies on a design, and the model of an experiment on its own
inputs or others."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from designcalc.checks.check import DesignInputs
from sim.experiments.friction_models import MODELS, Friction
from sim.experiments.friction_models import TITLES as TITLES
from sim.experiments.hysteresis import CASES, hysteresis
from sim.experiments.limit_cycles import STIFFNESSES, limit_cycles
from sim.experiments.passivity import MOTIONS, audit, passive_below
from sim.experiments.presliding import presliding
from sim.experiments.stick_slip import stick_slip
from sim.experiments.tip import PHASES, STROKES, tip_ellipse
from sim.integration.simulate import SimulationError
from sim.stage.studies import ON_REQUEST, STUDY_NAMES
from stagecad.deferred import pd, tomlkit
from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.design import Design as Values
from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import as_json, parse_quantity
from stagecad.processes import fork_map, parallel_map
from sysid.experiment.experiment import find_experiment
from sysid.experiment.readers.memory import MemoryTable
from sysid.simulate_experiment import SimulatedExperiment
from sysid.simulate_experiment import simulate_experiment as simulate_records
from workbench.figures import Plot
from workbench.figures import identification as record_figures
from workbench.figures import plot as drawing
from workbench.figures import simulation as simulation_figures
from workbench.operations.design import Design, load_design
from workbench.operations.measurement.experiment import Experiment, as_experiment, columns_of, results_key
from workbench.operations.measurement.tables import make_table, quantity_text
from workbench.operations.result import Line, Note, ProgressCallback, Result, counted, finite, frame, silent
from workbench.operations.simulation.tables import Columns, feature_table, stage_tables, tables_of, write_table

EXPERIMENTS = ("tip", "presliding", "hysteresis", "stick-slip", "stage")
EXTRA = ("passivity", "limit-cycles")
"""Run only when named."""

NO_MODEL = "simulate: no friction model '{}'"

FeaturePath = tuple[str, ...]
"""Experiment, model or study, perhaps case, and feature."""


@dataclass(frozen=True)
class Selection:
    """Selection of the simulations: experiments, friction models, the moving mass as given, the stage's studies."""

    names: tuple[str, ...]
    models: tuple[str, ...]
    mass: str | None
    studies: tuple[str, ...]

    @property
    def friction_experiments(self) -> tuple[str, ...]:
        """The experiments on one body with friction: those that need a mass."""
        return tuple(name for name in self.names if name not in ("tip", "stage"))

    def reads(self, key: str) -> bool:
        """Whether any of the experiments may depend on a parameter of the design."""
        if key == "friction.mass" and self.mass is not None:
            return False
        return any(reads(name, key) for name in self.names)

    def remarks(self, design: Values) -> list[Line]:
        """What holds for the whole selection: the moving mass, and where a model is passive."""
        lines: list[Line] = []
        if self.friction_experiments:
            lines.append(f"mass {moving_mass(design, self.mass):.6g} kg")
        if "passivity" in self.names:
            below = passive_below(friction_of(design))
            lines.append(f"lugre is passive at any stretch below 4 Fc/a1 = {below * 1e3:.2f} mm/s")
        return lines


def read_selection(
    names: Sequence[str],
    models: Sequence[str],
    mass: str | None,
    studies: Sequence[str],
    scheduler: str | None,
    swept: str | None,
    draws: int | None,
) -> Selection:
    """The simulations that the options of the command select."""
    chosen = chosen_names(names, (*EXPERIMENTS, *EXTRA), "no experiment '{}'") if names else EXPERIMENTS
    friction = chosen_names(models, MODELS, "--model {}: no such friction model")
    of_stage = chosen_names(studies, STUDY_NAMES, "--study {}: no such study of the stage", ON_REQUEST)
    if mass is not None and mass != "design":
        parse_mass(mass)
    require(not studies or "stage" in chosen, "--study: only the experiment 'stage' has studies; name it")
    if scheduler is not None and "stage" not in chosen and swept is None and draws is None:
        raise InputError("--scheduler: only 'stage', --sweep and --draws have many independent runs")
    require(swept is None or draws is None, "--sweep and --draws: one or the other")
    return Selection(chosen, friction, mass, of_stage)


def reads(experiment: str, key: str) -> bool:
    """Whether an experiment may depend on a parameter: the friction ones on their table, the stage on all."""
    if experiment == "tip":
        return key in ("actuator.piezo_spacing", "actuator.tip_height")
    return experiment == "stage" or key.startswith("friction.")


def friction_of(design: Values) -> Friction:
    """The design's table `friction` (the thesis's Table 3 unless set otherwise), SI."""
    return Friction(**{field.name: getattr(design.friction, field.name) for field in dataclasses.fields(Friction)})


def moving_mass(design: Values, given: str | None) -> float:
    """Mass of the body in the friction experiments, kg: `friction.mass`, that of the design's moving body with its
    payload where `design` is given, or a quantity."""
    if given is None:
        return design.friction.mass
    if given != "design":
        return parse_mass(given)
    from designcalc.friction_stage.physics.loads import moved_mass
    from stagecad.solids.assembly.built_machine import packaged_masses

    return moved_mass(DesignInputs(design, packaged_masses(design)))


def parse_mass(text: str) -> float:
    """Mass written as a quantity, kg."""
    mass = parse_quantity(text, "kg", "--mass")
    require(0.0 < mass < float("inf"), f"--mass {text}: must be positive and finite")
    return mass


def simulate_experiment(
    design: Values, name: str, models: tuple[str, ...], mass: float, advance: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Results of one experiment (not `stage`): by model (and case or motion); those of `tip` by stroke and phase."""
    results: dict[str, Any] = {}
    if name == "tip":
        spacing, height = design.actuator.piezo_spacing * 1e-3, design.actuator.tip_height * 1e-3
        for stroke, size in STROKES.items():
            results[stroke] = {phase: tip_ellipse(spacing, height, size, lag) for phase, lag in PHASES.items()}
        advance()
        return results
    friction = friction_of(design)
    runs: dict[str, Callable[[str], Any]] = {
        "presliding": lambda model: presliding(friction, model, mass),
        "stick-slip": lambda model: stick_slip(friction, model, mass),
        "hysteresis": lambda model: {case: hysteresis(friction, model, case) for case in CASES},
        "limit-cycles": lambda model: {k: limit_cycles(friction, model, v, mass) for k, v in STIFFNESSES.items()},
        "passivity": lambda model: {motion: audit(friction, model, motion) for motion in MOTIONS},
    }
    for model in models:
        results[model] = runs[name](model)
        advance()
    return results


def simulate_studies(
    design: Values, studies: Sequence[str], masses: Any, run_all: Callable[..., list[Any]]
) -> dict[str, Any]:
    """Results of studies of the driven stage; `run_all(study, function, cases)` runs the cases of one."""
    from sim.friction_stage.studies import STUDIES, stage_drive
    from stagecad.solids.assembly.built_machine import packaged_masses

    drive = stage_drive(design, masses or packaged_masses(design))
    return {study: STUDIES[study](drive, partial(run_all, study)) for study in studies}


def run_parallel(
    scheduler: str | None, progress: ProgressCallback, study: str, function: Callable[[Any], Any], cases: Sequence[Any]
) -> list[Any]:
    """The cases of a study in parallel, on the local cores or on a cluster."""
    steps = counted(progress, f"stage: {study.replace('_', ' ')}", len(cases))
    if scheduler is None and sys.platform == "linux":
        # A forked process has the compiled kernels; a new one would load them, for each study.
        return fork_map(function, cases, progress=steps)
    return parallel_map(function, cases, progress=steps, scheduler=scheduler)


def simulate_selection(design: Values, selection: Selection, masses: Masses | None = None) -> dict[str, Any]:
    """Results of all selected experiments in this process, by experiment."""
    mass = moving_mass(design, selection.mass) if selection.friction_experiments else 1.0
    return {
        name: simulate_studies(design, selection.studies, masses, lambda _, function, cases: list(map(function, cases)))
        if name == "stage"
        else simulate_experiment(design, name, selection.models, mass)
        for name in selection.names
    }


def features_of(results: Mapping[str, Any]) -> dict[str, Any]:
    """Features of results, nested as they are, as JSON quantities; None where a result has no such feature."""
    return {
        name: features_of(result)
        if isinstance(result, Mapping)
        else {
            key: None if feature is None else {"value": feature[0], "unit": feature[1]}
            for key, feature in result.features().items()
        }
        for name, result in results.items()
    }


def flat_features(features: Mapping[str, Any], before: FeaturePath = ()) -> dict[FeaturePath, Any]:
    """Every feature, a quantity or None, by its path."""
    flat: dict[FeaturePath, Any] = {}
    for name, inner in features.items():
        if isinstance(inner, Mapping) and "unit" not in inner:
            flat |= flat_features(inner, (*before, name))
        else:
            flat[(*before, name)] = inner
    return flat


class Simulation(Result):
    """One of the thesis's experiments, simulated on a design."""

    def __init__(self, name: str, results: Mapping[str, Any]) -> None:
        self.name = name
        self.results = results

    @cached_property
    def columns(self) -> dict[str, Columns]:
        """The simulated motions and forces as arrays, by model (and case) and `name [unit]`."""
        return stage_tables(self.results) if self.name == "stage" else tables_of(self.name, self.results)

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The simulated motions and forces, columns `name [unit]`, by model (and case)."""
        return {name: pd.DataFrame(columns) for name, columns in self.columns.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """The features, SI: a row for each model (and case) and feature."""
        rows = [
            (" ".join(path[:-1]), path[-1], *((None, None) if q is None else (q["value"], q["unit"])))
            for path, q in flat_features(self.to_json()[self.name]).items()
        ]
        return frame(rows, "of", "feature", columns=["of", "feature", "value", "unit"])

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad simulate NAME --json`."""
        return finite({self.name: features_of(self.results)})

    def plot(self, table: str | None = None) -> Plot:
        """Motions and forces of one table over its time; the first table when left out.

        Raises:
            InputError: no such table.
        """
        shown = {
            name: {label: values for label, values in columns.items() if not label.endswith("[J]")}
            for name, columns in self.columns.items()
        }
        return record_figures.motion_figure(shown, table)

    def figures(self) -> dict[str, Plot]:
        """The figures of the command, by the names of their files."""
        if self.name == "stage":
            from workbench.figures.stage import stage_figures

            return dict(stage_figures(self.results))
        return dict(simulation_figures.experiment_figures(self.name, self.results))

    def write(self, folder: Path, formats: tuple[str, ...] = ("csv",), figures: bool = True) -> list[Path]:
        """Write tables and figures into a folder as `stagecad simulate` does; returns the files."""
        written = []
        for name, columns in self.columns.items() if formats else ():
            written += write_table(folder / name, columns, formats)
        if figures:
            written += drawing.save_figures(folder, self.figures())
        return written

    def lines(self) -> Iterator[Line]:
        """What `stagecad simulate` prints: tables of features."""
        features = features_of(self.results)
        if self.name == "stage":
            for study, values in features.items():
                yield feature_table(f"stage: {study.replace('_', ' ')}", {"value": values}, by_column=True)
            return
        rows: dict[str, Any] = {}
        for model, values in features.items():
            if all(feature is None or "unit" in feature for feature in values.values()):
                rows[model] = values
            else:
                rows |= {f"{model}  {case}": inner for case, inner in values.items()}
        if rows:
            yield feature_table(self.name, rows)

    def __repr__(self) -> str:
        return f"<Simulation '{self.name}': {', '.join(self.results)}>"


class SimulatedRecords(Result):
    """Records simulated from the model of an experiment, with the noise of each sensor."""

    def __init__(
        self, experiment: Experiment, computed: SimulatedExperiment, seed: int | None, files: tuple[str, ...] = ()
    ) -> None:
        self.experiment = experiment
        self.computed = computed
        self.seed = seed
        self.files = files

    @cached_property
    def _logged(self) -> dict[str, Any]:
        """Columns of each record with noise, by its name."""
        tables = self.computed.logged(self.seed)
        return {record.name: table for record, table in zip(self.computed.records, tables, strict=True)}

    @cached_property
    def records(self) -> dict[str, pd.DataFrame]:
        """The records with noise, columns `name [unit]`, by name."""
        return {name: pd.DataFrame(table) for name, table in self._logged.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """All records below each other; index `record`, `row`."""
        return pd.concat(self.records, names=["record", "row"])

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad simulate EXPERIMENT --json`; without files where they were not written."""
        simulated = self.computed
        noise = {name: sensor.to_json() for name, sensor in simulated.noise.items()}
        return finite(
            {
                "schema": 1,
                "effects": [effect.name for effect in simulated.model.effects],
                "parameters": {
                    key: {**as_json(value, unit), "from": origin} for key, value, unit, origin in simulated.parameters()
                },
                "noise": noise if self.seed is not None else {},
                "seed": self.seed,
                "records": [{"name": r.name, "role": r.role, "rows": int(r.time.size)} for r in simulated.records],
                "files": list(self.files),
            }
        )

    def write(
        self, folder: Path, formats: tuple[str, ...] = ("csv",), inputs: str = "its own inputs"
    ) -> SimulatedRecords:
        """Write the records, and the `experiment.toml` that compares them with the model; returns it with its files.

        Args:
            folder: to write to.
            formats: of the records: csv, parquet or both.
            inputs: that the model was simulated on, in words.
        """
        simulated, files = self.computed, []
        for record in simulated.records:
            files += write_table(folder / record.file, self._logged[record.name], formats)
        for name, path in simulated.custom.items():
            atomic_write_bytes(folder / name, path.read_bytes())
            files.append(folder / name)
        files.append(folder / "experiment.toml")
        added = "without noise" if self.seed is None else f"with noise of seed {self.seed}"
        head = f"# Simulated from the model of {self.experiment.name} on {inputs}, {added}.\n"
        atomic_write_text(files[-1], head + tomlkit.dumps(simulated.document(formats[0])))
        return SimulatedRecords(self.experiment, simulated, self.seed, tuple(str(file) for file in files))

    def plot(self, record: str | None = None) -> Plot:
        """The channels of a record over time; the first record when left out.

        Raises:
            InputError: no such record.
        """
        return record_figures.motion_figure(self._logged, record)

    def lines(self) -> Iterator[Line]:
        """What `stagecad simulate EXPERIMENT` prints: values and noise of the simulation, and the files."""
        document = self.to_json()
        yield from (Note(f"note: {note}") for note in self.computed.problem.notes)
        yield f"model: {', '.join(document['effects']) or 'no effects'}"
        shown = {key: q for key, q in document["parameters"].items() if q["from"] != "default"}
        rows = [(key, quantity_text(q["value"], q["unit"]), q["from"]) for key, q in shown.items()]
        yield make_table("Values", "parameter:code|value:n strong|from", rows)
        for channel, noise in document["noise"].items():
            correlation = f", autocorrelation {noise['autocorrelation']:.2f}" if "autocorrelation" in noise else ""
            yield f"noise of {channel}: {quantity_text(noise['value'], noise['unit'])} ({noise['from']}{correlation})"
        yield from (f"{record['name']} ({record['role']}): {record['rows']} rows" for record in document["records"])
        yield f"wrote {', '.join(self.files)}"

    def __repr__(self) -> str:
        effects = ", ".join(effect.name for effect in self.computed.model.effects)
        rows = sum(record.time.size for record in self.computed.records)
        noise = "without noise" if self.seed is None else f"noise of seed {self.seed}"
        return f"<SimulatedRecords of '{self.experiment.name}', model {effects}: {rows} rows, {noise}>"


def simulate(
    what: str | Path | Experiment,
    design: Design | None = None,
    models: Sequence[str] = (),
    motion: Any = None,
    seed: int | None = 1,
    studies: Sequence[str] = (),
    progress: ProgressCallback = silent,
) -> Simulation | SimulatedRecords:
    """Simulate one of the thesis's experiments on a design, or the model of an experiment.

    Args:
        what: `tip`, `presliding`, `hysteresis`, `stick-slip`, `stage`, `passivity` or `limit-cycles`; or an
            experiment, or its folder.
        design: the packaged machine when left out.
        models: friction models of the thesis's experiments; all of them when left out.
        motion: inputs to simulate an experiment on, a DataFrame or the path of a file; its own when left out.
        seed: of the noise of simulated records; None for none.
        studies: of `stage`, such as `steps` or `hunting`; all but `tip_motion` when left out.
        progress: called with what is simulated, the runs done, and their number.

    Raises:
        InputError: an unknown name, a fault in a file, or a model that cannot be simulated on these inputs.
    """
    names = (*EXPERIMENTS, *EXTRA)
    if isinstance(what, str) and what in names:
        if motion is not None:
            raise InputError(f"simulate: '{what}' has a motion of its own; a motion is for an experiment with records")
        of_stage = chosen_names(studies, STUDY_NAMES, "simulate: no study of the stage '{}'", ON_REQUEST)
        selection = Selection((what,), chosen_names(models, MODELS, NO_MODEL), None, of_stage)
        return simulate_one(what, (design or load_design()).values, selection, progress=progress)
    if isinstance(what, str) and not Path(what).exists():
        raise InputError(
            f"simulate: '{what}' is neither an experiment of the thesis nor a folder{nearest(what, names)}"
        )
    experiment = as_experiment(what, design)
    in_memory = motion is not None and not isinstance(motion, str | Path)
    inputs = MemoryTable("motion", columns_of(motion, "motion")) if in_memory else motion
    return SimulatedRecords(experiment, simulate_records(experiment.problem, motion=inputs), seed)


def named_experiment(names: Sequence[str], options: Mapping[str, Any], of_experiment: Mapping[str, Any]) -> Path | None:
    """The EXPERIMENT that is named; None for the thesis's experiments. Options of the other are refused."""
    # A name of the thesis's experiments is not that of a folder.
    others = [name for name in names if name not in (*EXPERIMENTS, *EXTRA)]
    if not any(name.endswith(".toml") or "/" in name or "\\" in name or Path(name).is_dir() for name in others):
        for option, given in of_experiment.items():
            require(not given, f"--{option}: only for an EXPERIMENT; name its folder")
        return None
    require(len(names) == 1, f"{' '.join(names)}: one EXPERIMENT at a time, without other names")
    for option in ("mass", "models", "studies", "swept", "draws", "scheduler"):
        if options[option]:
            flag = {"models": "model", "studies": "study", "swept": "sweep"}.get(option, option)
            raise InputError(f"--{flag}: not for an EXPERIMENT, whose model is in its experiment.toml")
    return Path(names[0])


def simulate_into(
    out: Path, experiment: Path, design: Any, motion: Path | None, seed: int | None, formats: tuple[str, ...]
) -> SimulatedRecords:
    """Simulate the model of an experiment into OUT/simulate, by its path."""
    require(formats, "--format none: the records of an EXPERIMENT are its only result; allowed: csv, parquet, both")
    place = find_experiment(experiment)
    stated = Experiment.load(place.path, design)
    simulated = SimulatedRecords(stated, simulate_records(stated.problem, motion=motion), seed)
    folder = out / "simulate" / results_key(out, place.folder)
    return simulated.write(folder, formats, "its own inputs" if motion is None else motion.name)


def simulate_one(
    name: str, design: Values, selection: Selection, scheduler: str | None = None, progress: ProgressCallback = silent
) -> Simulation:
    """One experiment of a selection on a design."""
    try:
        if name == "stage":
            run_all = partial(run_parallel, scheduler, progress)
            return Simulation(name, simulate_studies(design, selection.studies, None, run_all))
        mass = 1.0 if name == "tip" else moving_mass(design, selection.mass)
        steps = counted(progress, name, 1 if name == "tip" else len(selection.models))
        return Simulation(name, simulate_experiment(design, name, selection.models, mass, steps))
    except SimulationError as failure:
        raise InputError(str(failure)) from None


def chosen_names(
    names: Sequence[str], known: Sequence[str], refusal: str, on_request: Sequence[str] = ()
) -> tuple[str, ...]:
    """The names chosen of the known ones and those on request, in their order; all of the known ones without any."""
    allowed = (*known, *on_request)
    for name in names:
        if name not in allowed:
            raise InputError(refusal.format(name) + nearest(name, allowed))
    return tuple(name for name in allowed if name in (names or known))
