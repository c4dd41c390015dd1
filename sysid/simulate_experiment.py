"""Simulated records of an experiment (`stagecad simulate EXPERIMENT`): its model on its inputs or on another motion.

    logged = sensed channel + noise,   noise_k = r noise_(k-1) + sqrt(1 - r^2) e_k,   r = exp(-step / correlation time)

with the stated or estimated standard deviation of each measured channel, rounded to the quantisation step where
`sensor_quantisation` is in the model. The inputs are exact, but for those whose noise is stated. Channels of the
records whose scale is fitted are in the unit that the fitted scale gives, and so is their noise.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sim.effects.catalogue import rounding_effects
from sim.integration.simulate import SimulationError
from stagecad.parameters.errors import InputError
from sysid.documents import parameter_unit
from sysid.estimation.covariance import public_key
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.channels import choose_columns
from sysid.experiment.experiment import DesignValues, Experiment
from sysid.experiment.readers.base import shown_path
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.readers.open import open_record_file
from sysid.experiment.record import Record, load_runs, load_whole_records
from sysid.experiment.record_spec import RecordSpec
from sysid.experiment.rigs import CHANNELS
from sysid.noise.estimate import LEAST, Noise, noise_by_channel, with_quantisation
from sysid.prediction.effect_terms import split_channel
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem, load_problem
from sysid.prediction.rig_model import Start
from sysid.prediction.sensors import PREFIX as SCALE
from sysid.prediction.sensors import noise_of_scale, scale_ratio, unscaled
from sysid.prediction.simulation import simulated_channels
from sysid.signals import GaussianFilter, filled

SMOOTHING_STEPS = 4.0
"""Width in steps of the filter of a noisy position that serves as the true motion of a velocity drive."""


@dataclass(frozen=True)
class SimulatedExperiment:
    """Simulated records of an experiment."""

    problem: Problem  # of the experiment
    model: Model  # with the values used
    fitted: tuple[str, ...]  # keys of the values that were fitted to the records of the experiment
    records: tuple[Record, ...]  # without noise, at a uniform step; `file` is without suffix
    noise: Mapping[str, Noise]  # of each channel to which it is added
    exact: tuple[str, ...]  # channels known without noise whose noise would be estimated otherwise

    def logged(self, seed: int | None) -> list[dict[str, np.ndarray]]:
        """Columns `name [unit]` of each record, (n,), with noise; without for a `seed` of None."""
        random = np.random.default_rng(seed)
        rotary = self.problem.experiment.rig.rotary
        tables = []
        for record in self.records:
            table = {"time [s]": record.time}
            for name, values in record.channels.items():
                noise = self.noise.get(name)
                if noise is not None and seed is not None:
                    values = values + noise_signal(noise, record.time, random)
                step = _quantisation_step(self.model, name, noise)
                values = values if step is None else step * np.round(values / step)
                table[f"{name} [{CHANNELS[name].si_unit(rotary)}]"] = values
            tables.append(table)
        return tables

    def parameters(self) -> list[tuple[str, float, str, str]]:
        """Key, value (SI), unit and origin of every value used: fitted, given, or default."""
        stated = {key for key, setting in self.problem.experiment.parameters.items() if setting.start is not None}
        rig = self.problem.experiment.rig
        stated |= {f"rig.{rig.declaration.parameter_of(key)}" for key in rig.known}
        origins = {**dict.fromkeys(stated, "given"), **dict.fromkeys(self.fitted, "fitted")}
        return [
            (public_key(key), value, parameter_unit(self.problem, key), origins.get(key, "default"))
            for key, value in self.model.values.items()
        ]

    @property
    def custom(self) -> dict[str, Path]:
        """The user's own effects: each file by its place beside the `experiment.toml` of the simulated records."""
        experiment = self.problem.experiment
        return {
            path.resolve().relative_to(experiment.folder.resolve()).as_posix(): path
            for path in experiment.custom
            if isinstance(path, Path)
        }

    def document(self, suffix: str = "csv") -> dict[str, Any]:
        """Content of the `experiment.toml` of the simulated records, in files with this suffix; the values used are the
        starts of its fit."""
        problem = self.problem
        experiment, rig = problem.experiment, problem.experiment.rig
        known = {}
        for name, given in rig.known.items():
            deviation = f" +- {given.std:.4g}" if given.std else ""
            known[name] = f"{given.value:.12g}{deviation} {rig.declaration.known[name].si_unit(rig.rotary)}"
        names = [*(e.name for e in self.model.effects), *rounding_effects(experiment.effects, problem.custom)]
        model: dict[str, Any] = {"effects": list(dict.fromkeys(names))}
        if self.custom:
            model["custom"] = list(self.custom)
        model["parameters"] = {key: self._setting(key) for key in self.model.values if not key.startswith("rig.")}
        rounded = {name.partition("@")[2] for name in rounding_effects(experiment.effects, problem.custom)}
        noise = {
            name: self._quantity(_added(found) if rounded & {"", name} else found.value, found.unit)
            for name, found in self.noise.items()
        }
        for name in self.exact:
            largest = max(float(np.max(np.abs(record.channels[name]))) for record in self.records)
            noise[name] = self._quantity(LEAST * largest or LEAST, CHANNELS[name].si_unit(rig.rotary))
        return {
            "schema": 1,
            "rig": {"kind": rig.kind, "input_hold": rig.input_hold, "known": known},
            "model": model,
            "record": [{"file": f"{r.file}.{suffix}", "role": r.role} for r in self.records],
            "noise": noise,
        }

    def _setting(self, key: str) -> dict[str, Any]:
        unit = parameter_unit(self.problem, key)
        given = self.problem.experiment.parameters.get(key)
        setting: dict[str, Any] = {"start": self._quantity(self.model.values[key], unit)}
        for bound in ("low", "high"):
            if (value := getattr(given, bound, None)) is not None:
                setting[bound] = self._quantity(value, unit)
        if key not in {u.key for u in self.problem.start.unknowns}:
            setting["fixed"] = True
        return setting

    @staticmethod
    def _quantity(value: float, unit: str) -> str | float:
        return float(f"{value:.12g}") if unit in ("", "1") else f"{value:.12g} {unit}"


def simulate_experiment(
    source: str | Path | Problem,
    design: DesignValues | None = None,
    motion: str | Path | MemoryTable | None = None,
    advance: Callable[[str], None] = lambda name: None,
) -> SimulatedExperiment:
    """Simulate the model of an experiment on the inputs of its records, or on those of another file.

    Values stated in `[model.parameters]` or `[rig.known]` are used as they are; the others are fitted to the records
    first.
    """
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    experiment = problem.experiment
    given = {key for key, setting in experiment.parameters.items() if setting.start is not None}
    known = {u.key for u in problem.start.unknowns if u.prior is not None and not u.key.startswith(SCALE)}
    free = tuple(u for u in problem.start.unknowns if u.key not in given | known)
    model, fitted = problem.start, ()
    if any(not _is_auxiliary(problem, u.key) for u in free):
        held = replace(problem, start=replace(problem.start, unknowns=free))
        model = fit_stated_model(held).fitted.model
        fitted = tuple(u.key for u in model.unknowns)
    advance("fit")
    own = motion is None
    inputs = load_whole_records(experiment) if motion is None else [read_motion(experiment, motion)]
    noise, exact = _noise(problem, model)
    records = []
    for record in inputs:
        if own:
            record = _true_motion(replace(record, channels=unscaled(record.channels, model.values)), noise)
        records.append(_simulated(problem, model, record, _start(problem, record) if own else None))
        advance(record.name)
    return SimulatedExperiment(problem, model, fitted, tuple(records), noise, exact)


def read_motion(experiment: Experiment, motion: str | Path | MemoryTable) -> Record:
    """The inputs of the experiment's kind of rig: a record of the fit without measured channels."""
    rig = experiment.rig.declaration
    rig = replace(rig, measured=(), optional_measured=())
    file = motion if isinstance(motion, MemoryTable) else Path(motion)
    name = shown_path(str(file))
    sources, rotary, notes = choose_columns(open_record_file(file, name).header, rig, name, {}, {}, name, {})
    for channel, turns in rotary.items():
        if turns != experiment.rig.rotary:
            kinds = ("rotary", "linear") if turns else ("linear", "rotary")
            raise InputError(f"{name}: column '{channel}' has a {kinds[0]} unit; the experiment's axis is {kinds[1]}")
    spec = RecordSpec(Path(str(file)).stem, str(file), file, "fit", sources, notes=tuple(notes))
    return load_runs(spec, rig, experiment.rig.rotary)[0]


def noise_signal(noise: Noise, time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Noise (n,) of one channel at a uniform step: white and autoregressive, stationary from its first value."""
    step, white = float(time[1] - time[0]), noise.spectrum.white
    kept = float(np.exp(-step / noise.correlation_time)) if noise.correlation_time > 0.0 else 0.0
    drawn = np.sqrt(1.0 - kept**2) * random.standard_normal(time.size)
    drawn[0] /= np.sqrt(1.0 - kept**2)
    # Loading scipy.signal takes longer than the start of the other commands.
    from scipy.signal import lfilter

    coloured = np.asarray(lfilter([1.0], [1.0, -kept], drawn))
    if white > 0.0 and kept > 0.0:
        coloured = np.sqrt(1.0 - white) * coloured + np.sqrt(white) * random.standard_normal(time.size)
    return _added(noise) * coloured


def _added(noise: Noise) -> float:
    """Standard deviation of the noise before the sensor's quantisation."""
    return noise.value if noise.without_quantisation is None else noise.without_quantisation


def _quantisation_step(model: Model, channel: str, noise: Noise | None) -> float | None:
    """Step of a channel, in its unit: as found in the records, or as given in the model."""
    if noise is None or noise.without_quantisation is not None:
        return None if noise is None else noise.quantisation_step
    for effect in model.effects:
        if effect.rounds and split_channel(effect.name)[1] in (None, channel):
            return noise.quantisation_step or model.values[f"{effect.name}.step"]
    return None


def _is_auxiliary(problem: Problem, key: str) -> bool:
    """Whether a value is fitted besides those that its effect declares as free: it need not be known to simulate."""
    name, _, parameter = key.rpartition(".")
    effect = next((e for e in problem.start.effects if e.name == name), None)
    return effect is not None and (effect.parameter(parameter).fixed or effect.parameter(parameter).role == "reference")


def _noise(problem: Problem, model: Model) -> tuple[dict[str, Noise], tuple[str, ...]]:
    """Noise to be added by channel, and the channels with an estimated noise to which none is added. An input is exact
    unless its noise is stated; in the experiment's own records its log has that noise already, and it serves as the
    true input."""
    rig, stated = problem.experiment.rig.declaration, problem.experiment.noise
    # That of the rows as logged: long records are prepared as means over many rows.
    noise, _ = noise_by_channel(problem.experiment, problem.records)
    noise = with_quantisation(noise, rounding_effects(problem.experiment.effects, problem.custom))
    noise = {n: noise_of_scale(found, scale_ratio(model.values, n)) for n, found in noise.items()}
    added = {n: found for n, found in noise.items() if n in rig.measured_channels or n in stated}
    return added, tuple(name for name in noise if name not in added)


def _true_motion(record: Record, noise: Mapping[str, Noise]) -> Record:
    """The record with an imposed position smoothed that is stated to be noisy, and no velocity is given."""
    if "friction_force" not in record.channels or "velocity" in record.channels or "position" not in noise:
        return record
    position = filled(record.channels["position"])[0]
    smooth = GaussianFilter(SMOOTHING_STEPS * record.step, record.step, position.size)(position)
    return replace(record, channels={**record.channels, "position": smooth})


def _start(problem: Problem, record: Record) -> Start:
    """Position and velocity at the first row of a record of a driven mass."""
    prepared = next((p for p in (*problem.fit_records, *problem.validate_records) if p.name == record.name), None)
    if not isinstance(prepared, ForceBalanceRecord):
        return Start(0.0)
    return Start(float(prepared.axis.position[0]), float(prepared.axis.velocity[0]))


def _simulated(problem: Problem, model: Model, record: Record, start: Start | None) -> Record:
    experiment = problem.experiment
    try:
        time, channels = simulated_channels(experiment.rig, record, model.effects, model.values, start)
    except SimulationError as failure:
        raise InputError(f"{record.file}: {failure}") from None
    recorded = set().union(*(r.channels for r in problem.records))
    kept = {name: values for name, values in channels.items() if name in record.channels or name in recorded}
    file, step = re.sub(r"[^\w.#-]", "_", record.name), float(time[1] - time[0])
    return replace(record, file=file, time=time, step=step, uniform=True, channels=kept)
