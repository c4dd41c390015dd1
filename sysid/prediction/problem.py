"""The identification problem of an experiment: prepared records, noise and stated model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from sim.effects.catalogue import find
from sim.effects.custom import load_all_custom
from sim.library.effect import Effect
from stagecad.parameters.errors import InputError
from sysid.experiment.consent import require_consent
from sysid.experiment.experiment import DesignValues, Experiment, load_experiment
from sysid.experiment.record import Record, load_records
from sysid.experiment.unknowns import Prior, Unknown
from sysid.noise.decimation import decimated, decimation_factor, noise_of_means
from sysid.noise.estimate import Noise, noise_by_channel, with_quantisation
from sysid.prediction.actuator_tip import TipRecord, tip_record
from sysid.prediction.force_balance.imposed_motion import velocity_drive
from sysid.prediction.force_balance.prepare import driven_mass
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.friction_drive.record import friction_drive_record
from sysid.prediction.model import Model, PreparedRecord, Scales, scales_of, with_effect
from sysid.prediction.rig_parameters import rig_parameters
from sysid.prediction.settling import without_start

FORMS = {
    "velocity-drive": "output",
    "actuator-tip": "output",
    "friction-drive": "output",
    "spring-pull": "force_balance",
    "force-drive": "force_balance",
}
"""The form in which the residual is taken on each kind of rig."""


@dataclass(frozen=True)
class Problem:
    """An identification problem.

    Args:
        experiment: as read.
        records: as read.
        noise: by measured channel.
        fit_records, validate_records: prepared.
        scales: sizes set by the records of the fit.
        custom: the user's own effects.
        start: the model as the experiment states it, before any fit.
        notes: for the user.
    """

    experiment: Experiment
    records: tuple[Record, ...]
    noise: Mapping[str, Noise]
    fit_records: tuple[PreparedRecord, ...]
    validate_records: tuple[PreparedRecord, ...]
    scales: Scales
    custom: tuple[Effect, ...]
    start: Model
    notes: tuple[str, ...]

    @property
    def kind(self) -> str:
        """Kind of rig."""
        return self.experiment.rig.kind

    @property
    def form(self) -> str:
        """Form of the residual."""
        return FORMS[self.kind]


def load_problem(path: str | Path, design: DesignValues | None = None) -> Problem:
    """Read an experiment and build its identification problem.

    Raises:
        InputError: one line on the fault in a file.
    """
    return problem_of(load_experiment(path, design))


def problem_of(experiment: Experiment) -> Problem:
    """The problem of an experiment whose records are read now. Raises as `load_problem`."""
    if experiment.rig.kind not in FORMS:
        raise InputError(
            f"{experiment.path}: rig.kind = '{experiment.rig.kind}' cannot be compared yet; allowed: {', '.join(FORMS)}"
        )
    return build_problem(experiment, load_records(experiment))


def build_problem(
    experiment: Experiment,
    records: Sequence[Record],
    effects: Sequence[str] | None = None,
    custom: Sequence[Effect] | None = None,
) -> Problem:
    """The problem of an experiment already read; `effects` replace those of the model where given, and `custom` the
    user's own ones, which are loaded otherwise."""
    _need_tip(experiment)
    names = tuple(experiment.effects if effects is None else effects)
    custom = tuple(load_all_custom(experiment.custom, require_consent) if custom is None else custom)
    noise, notes = noise_by_channel(experiment, records)
    quantised = [n for n in names if n.partition("@")[0] == "sensor_quantisation"]
    if quantised:
        noise = with_quantisation(noise, quantised)
    logged, k = records, decimation_factor(records)
    hold, records = averaged(experiment, records)
    noise = noise_of_means(noise, k) if k > 1 else noise
    rig, rig_unknowns = rig_parameters(experiment, records, noise)
    prepared = _prepare(experiment, records, noise, rig, hold)
    for record, ready in zip(records, prepared, strict=True):
        if not any(valid.any() for valid in ready.valid.values()):
            raise InputError(
                f"{record.file}: no row is left to score between gaps and ends; give longer stretches without gaps"
            )
    fits = tuple(p for p in prepared if p.role == "fit")
    held_out = tuple(p for p in prepared if p.role != "fit")
    scales = scales_of(fits)
    _need_motion(records, fits, scales)
    model = Model((), rig, tuple(rig_unknowns))
    for name in names:
        model = with_effect(model, find(name, custom), scales, as_listed=True)
    model = _with_stretch(model, fits)
    model = _with_settings(model, experiment)
    for record in records:
        notes.extend(f"{record.file}: {note}" for note in record.notes)
    stiffness = experiment.rig.known.get("pull_stiffness")
    if stiffness is not None and stiffness.std is None and any(_displacement_by_spring(p) for p in prepared):
        unit = "N*m/rad" if experiment.rig.rotary else "N/m"
        notes.append(
            "no position is recorded: the presliding displacement is computed from the spring force, with "
            "rig.known.pull_stiffness taken as exact; write its standard deviation if it has one, as in "
            f"'{stiffness.value:.4g} +- {0.01 * stiffness.value:.2g} {unit}'"
        )
    return Problem(experiment, tuple(logged), noise, fits, held_out, scales, custom, model, tuple(notes))


def averaged(experiment: Experiment, records: Sequence[Record]) -> tuple[Literal["zero", "linear"], list[Record]]:
    """The records as they are prepared, long ones as means over blocks of rows, and how their input runs from row to
    row."""
    k, hold = decimation_factor(records), experiment.rig.input_hold
    if k == 1:
        return hold, list(records)
    held = ("drive_force",) if hold == "zero" else ()
    return "linear", [decimated(record, k, held) for record in records]


def _displacement_by_spring(record: PreparedRecord) -> bool:
    return (
        isinstance(record, ForceBalanceRecord)
        and record.stick_phases is not None
        and record.stick_phases.compliance > 0.0
    )


def _need_tip(experiment: Experiment) -> None:
    """A rig with a tip needs its two lengths, which relate the voltages to the motion."""
    if experiment.rig.kind not in ("actuator-tip", "friction-drive"):
        return
    for name, like in (("piezo_spacing", "46 mm"), ("tip_height", "20 mm")):
        if name not in experiment.rig.known:
            raise InputError(
                f"{experiment.path}: rig.known.{name} is missing; a rig of kind '{experiment.rig.kind}' needs it, like "
                f'{name} = "{like}", or "design"'
            )


def _need_motion(records: Sequence[Record], fits: Sequence[PreparedRecord], scales: Scales) -> None:
    """Something must have moved, or been driven, in the records of the fit."""
    files = ", ".join(record.file for record in records if record.role == "fit")
    if all(isinstance(fit, TipRecord) for fit in fits):
        if scales.input == 0.0:
            raise InputError(f"{files}: the voltages never change; their effect on the tip is not identifiable")
    elif scales.position == 0.0 or scales.velocity == 0.0:
        raise InputError(f"{files}: nothing moves; give a record of motion")


def _prepare(
    experiment: Experiment, records: Sequence[Record], noise: Mapping[str, Noise], rig: Mapping[str, float], hold: str
) -> list[PreparedRecord]:
    kind = experiment.rig.kind
    prepared: list[PreparedRecord] = []
    width = None
    longest_step = max(record.step for record in records)
    for record in records:
        if kind == "velocity-drive":
            prepared.append(velocity_drive(record, noise))
        elif kind == "friction-drive":
            prepared.append(friction_drive_record(record, {k: v.value for k, v in experiment.rig.known.items()}, noise))
        elif kind == "actuator-tip":
            known = {name: k.value for name, k in experiment.rig.known.items()}
            prepared.append(tip_record(record, known, noise))
        else:
            balance = driven_mass(
                record,
                kind,
                noise,
                rig["rig.mass"],
                rig.get("rig.pull_stiffness"),
                hold,
                width,
                longest_step,
            )
            width = balance.full_filter.width if balance.full_filter is not None else None
            prepared.append(balance)
    return [without_start(record) for record in prepared]


def _with_stretch(model: Model, records: Sequence[PreparedRecord]) -> Model:
    """The model with the stretch of the Coulomb bristle free on a driven mass, below the position's noise: it sets how
    fast the friction reverses, which affects the force balance though it does not show in the position."""
    key = "coulomb.stretch"
    noises = [r.position_noise for r in records if isinstance(r, ForceBalanceRecord) and r.reversals is not None]
    if key not in model.values or not noises:
        return model
    least = find("coulomb").parameter("stretch").low
    highest = max(*noises, 10.0 * least)
    start = max(0.05 * highest, least)
    values = {**model.values, key: start}
    unknown = Unknown(key, start, max(1e-4 * highest, least), highest, start)
    return Model(model.effects, values, (*model.unknowns, unknown))


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
