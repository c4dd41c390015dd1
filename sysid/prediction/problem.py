"""The identification problem of an experiment: prepared records, noise and stated model."""

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from sim.effects.catalogue import find, rounding_effects
from sim.effects.custom import load_all_custom
from sim.effects.effect import Effect
from stagecad.consent import require_consent
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import DesignValues, Experiment, Rig, load_experiment
from sysid.experiment.known import Prior
from sysid.experiment.record import Record, load_records, load_whole_records
from sysid.noise import estimate
from sysid.prediction.effect_terms import Values
from sysid.prediction.model import Model, Scales, scales_of, with_effect
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.rig_model import RigModel
from sysid.prediction.sensors import put_scales
from sysid.prediction.simulation import RIG_MODELS


@dataclass(frozen=True)
class Problem:
    """An identification problem."""

    experiment: Experiment  # as read
    records: tuple[Record, ...]  # as read
    noise: Mapping[str, estimate.Noise]  # by measured channel
    fit_records: tuple[PreparedRecord, ...]  # prepared
    validate_records: tuple[PreparedRecord, ...]  # prepared
    scales: Scales  # sizes set by the records of the fit
    custom: tuple[Effect, ...]  # the user's own effects
    start: Model  # the model as the experiment states it, before any fit
    notes: tuple[str, ...]  # for the user
    # whether the held-out records are those of the fit, and parts of them are left out of it in turn
    crossed: bool = False

    def __repr__(self) -> str:
        return f"<Problem '{self.experiment.folder.name}': {self.kind}, {len(self.records)} records>"

    @property
    def kind(self) -> str:
        """Kind of rig."""
        return self.experiment.rig.kind

    @property
    def rig(self) -> RigModel:
        """Model of the kind of rig."""
        return RIG_MODELS[self.kind]

    @property
    def noise_is_known(self) -> bool:
        """Whether the level of the noise of every measured channel is known."""
        return all(self.noise[c].is_known for c in self.fit_records[0].measured if c in self.noise)

    @property
    def form(self) -> str:
        """Form of the residual."""
        return self.rig.form


def load_problem(path: str | Path, design: DesignValues | None = None) -> Problem:
    """Read an experiment and build its identification problem."""
    return problem_of(load_experiment(path, design))


PARTS = 8
"""Parts of a record that are left out of its fit in turn."""

FEWEST_HELD_OUT = 2 * PARTS
"""Least number of independent held-out rows: two in each of as many blocks, of which Student's t can decide."""


def problem_of(experiment: Experiment) -> Problem:
    """The problem of an experiment whose records are read now. Raises as `load_problem`."""
    found = build_problem(experiment, load_records(experiment))
    if any(record.role != "fit" for record in experiment.records) or _independent_rows(found) >= FEWEST_HELD_OUT:
        return found
    whole = build_problem(experiment, load_whole_records(experiment))
    note = (
        f"no record validates, and its last 30 % hold fewer than {FEWEST_HELD_OUT} independent rows: all rows "
        f"are fitted, and effects are tested on each of {PARTS} parts left out in turn; errors listed as held out are "
        "those of the fit"
    )
    return replace(whole, notes=(*whole.notes, note))


def _independent_rows(problem: Problem) -> int:
    """Number of held-out rows at the distance of the width of the filter."""
    return sum(
        int(np.count_nonzero(valid) / max(1.0, record.filter_width / record.step))
        for record in problem.validate_records
        for valid in record.valid.values()
    )


def build_problem(
    experiment: Experiment,
    records: Sequence[Record],
    effects: Sequence[str] | None = None,
    custom: Sequence[Effect] | None = None,
) -> Problem:
    """The problem of an experiment already read; `effects` replace those of the model where given, and `custom` the
    user's own ones, which are loaded otherwise."""
    rig = RIG_MODELS[experiment.rig.kind]
    for name, like in rig.required.items():
        if name not in experiment.rig.known:
            raise InputError(
                f"{experiment.path}: rig.known.{name} is missing; a rig of kind '{rig.name}' needs it, like "
                f'{name} = "{like}", or "design"'
            )
    names = tuple(experiment.effects if effects is None else effects)
    custom = tuple(load_all_custom(experiment.custom, require_consent) if custom is None else custom)
    noise, notes = estimate.noise_by_channel(experiment, records)
    noise = estimate.with_quantisation(noise, rounding_effects(names, custom))
    logged, k = records, estimate.decimation_factor(records)
    hold, records = averaged(experiment, records)
    setup = replace(experiment.rig, input_hold=hold)
    noise = estimate.noise_of_means(noise, k) if k > 1 else noise
    own = rig.parameters(setup, records, noise)
    prepared = _prepared(rig, setup, records, noise, own.values)
    sensed = rig.with_input_noise(prepared, noise)
    if sensed is not noise:
        noise, prepared = sensed, _prepared(rig, setup, records, sensed, own.values)
        notes += [ACTS] * ("drive_force" in noise)
    prepared = [p.without_start() for p in prepared]
    for record, ready in zip(records, prepared, strict=True):
        if not any(valid.any() for valid in ready.valid.values()):
            missing = {name: np.isnan(values).mean() for name, values in record.channels.items()}
            name = max(missing, key=lambda one: missing[one])
            raise InputError(
                f"{record.file}: no row is left to score between gaps and ends; give longer stretches without gaps "
                f"(most are in '{name}', {missing[name]:.0%} of its rows)"
            )
    fits = tuple(p for p in prepared if p.role == "fit")
    held_out = tuple(p for p in prepared if p.role != "fit") or fits
    scales = replace(scales_of(fits), travel=scales_of(prepared).position)
    moving = [record for record in records if record.role == "fit"]
    if fault := rig.without_motion(scales) or _within_noise(moving, noise) or _without_change(moving, setup):
        raise InputError(f"{', '.join(record.file for record in moving)}: {fault}")
    put_scales(experiment, prepared[0].measured, own.values, own.unknowns, notes)
    model = Model((), own.values, tuple(own.unknowns))
    for name in names:
        model = with_effect(model, find(name, custom), scales, as_listed=True)
    model = _with_settings(rig.with_nuisances(model, fits), experiment)
    notes.extend(_notes_of_files(records))
    stated = {"mass", "inertia"} & experiment.rig.known.keys()
    if stated and "rig.mass" not in own.values:
        notes.append(
            f"rig.known.{stated.pop()} is not used: a measured friction force has no inertia force; where a mass moves "
            "between sensor and contact, the rig is a 'force-drive' with that force as drive_force"
        )
    stiffness = experiment.rig.known.get("pull_stiffness")
    by_spring = any(p.stick_phases is not None and p.stick_phases.compliance > 0.0 for p in prepared)
    if stiffness is not None and stiffness.std is None and by_spring:
        unit = "N*m/rad" if experiment.rig.rotary else "N/m"
        notes.append(
            "no position is recorded: the presliding displacement is computed from the spring force, with "
            "rig.known.pull_stiffness taken as exact; write its standard deviation if it has one, as in "
            f"'{stiffness.value:.4g} +- {0.01 * stiffness.value:.2g} {unit}'"
        )
    crossed = held_out is fits
    return Problem(experiment, tuple(logged), noise, fits, held_out, scales, custom, model, tuple(notes), crossed)


def _prepared(
    rig: RigModel, setup: Rig, records: Sequence[Record], noise: Mapping[str, estimate.Noise], values: Values
) -> list[PreparedRecord]:
    """The records as they are predicted, with their copies with noise added where predictions follow noisy channels."""
    prepared = rig.prepare(setup, records, noise, values)
    if not rig.along_motion and not noise.keys() & set(setup.declaration.input_channels):
        return prepared
    again = rig.prepare_again(prepared, setup, [_with_noise(record, noise) for record in records], noise, values)
    return [replace(p, redrawn=(other,)) for p, other in zip(prepared, again, strict=True)]


def _within_noise(records: Sequence[Record], noise: Mapping[str, estimate.Noise]) -> str:
    """Error of records whose motion is nowhere larger than the largest of their normal deviates, at the probability
    1e-3; empty if something moves."""
    channels = [c for c in ("position", "velocity") if c in noise and all(c in record.channels for record in records)]
    steady = False
    for channel in channels:
        series = [record.channels[channel] for record in records]
        # Of records at one speed each, the speeds may differ.
        for values in [*series, np.concatenate(series)] if channel == "velocity" else series:
            range_of_noise = 2.0 * noise[channel].value * np.sqrt(2.0 * np.log(1e3 * values.size))
            if np.nanmax(values) - np.nanmin(values) > range_of_noise:
                return ""
            steady |= channel == "velocity" and bool(abs(np.nanmean(values)) > range_of_noise)
    if steady:
        return "one speed only: no change of velocity exceeds its noise; give records at several speeds"
    where = " or ".join(channels)
    return f"nothing moves: no change of {where} exceeds its noise; give a record of motion" if channels else ""


def _without_change(records: Sequence[Record], rig: Rig) -> str:
    """Error of records in which no measured channel ever changes; empty if one does."""
    measured = [channel for channel in rig.declaration.measured_channels if channel in records[0].channels]
    values = [record.channels[channel] for record in records for channel in measured if channel in record.channels]
    if any(np.nanmax(one) > np.nanmin(one) for one in values):
        return ""
    return f"{' and '.join(measured)} never changes; the sensor or the column is wrong"


ACTS = "the drive force has jitter that moves the mass: that is no noise of a sensor"
"""Note on a drive force whose estimated noise is a jitter of the command."""

FAR = 0.25
"""Part of its range by which a channel must have left its first value for the side to be that of its motion."""


def _with_noise(record: Record, noise: Mapping[str, estimate.Noise]) -> Record:
    """The log with noise of each sensor added: mirrored for a mirrored channel, and the same at another origin."""
    channels, random = dict(record.channels), np.random.default_rng(zlib.crc32(record.name.encode()))
    for name in sorted(noise.keys() & channels.keys()):
        values = channels[name]
        span = np.nanmax(values, initial=-np.inf) - np.nanmin(values, initial=np.inf)
        if not span > 0.0:
            continue
        away = values - values[np.argmax(np.isfinite(values))]
        side = np.sign(away[np.argmax(np.abs(away) > FAR * span)])
        channels[name] = values + side * noise[name].value * noise[name].spectrum.drawn(values.size, random)
    return replace(record, channels=channels)


def averaged(experiment: Experiment, records: Sequence[Record]) -> tuple[Literal["zero", "linear"], list[Record]]:
    """The records as they are prepared, long ones as means over blocks of rows, and how their input runs from row to
    row."""
    k, hold = estimate.decimation_factor(records), experiment.rig.input_hold
    if k == 1:
        return hold, list(records)
    held = ("drive_force",) if hold == "zero" else ()
    return "linear", [estimate.decimated(record, k, held) for record in records]


def _notes_of_files(records: Sequence[Record]) -> Iterator[str]:
    """Each note of the records once, after the files that it is on."""
    for said in dict.fromkeys(note for record in records for note in record.notes):
        # Two records may be parts of one file.
        files = list(dict.fromkeys(record.file for record in records if said in record.notes))
        yield f"{', '.join(files[:3])}{f' and {len(files) - 3} more' if len(files) > 3 else ''}: {said}"


def _with_settings(model: Model, experiment: Experiment) -> Model:
    """The model with the starts, bounds and fixed values of `[model.parameters]`."""
    values, unknowns = dict(model.values), list(model.unknowns)
    for key, setting in experiment.parameters.items():
        if key not in values:
            continue
        if setting.start is not None:
            values[key] = setting.start
        if setting.fixed:
            unknowns = [u for u in unknowns if u.key != key]
            continue
        for k, unknown in enumerate(unknowns):
            if unknown.key == key:
                low = unknown.low if setting.low is None else setting.low
                high = unknown.high if setting.high is None else setting.high
                prior = None if setting.std is None else Prior(values[key], setting.std)
                unknowns[k] = replace(unknown, low=low, high=high, start=values[key], prior=prior)
    return Model(model.effects, values, tuple(unknowns))
