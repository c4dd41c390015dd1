"""An experiment made ready: records prepared, noise known, model at its best fit. Every command begins here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sim.custom import load_all_custom
from sim.effect import Effect
from sim.library import find
from stagecad.parameters.errors import InputError
from sysid.balance import Balance, filled
from sysid.base_fit import Fitted, fit_model
from sysid.experiment import DesignValues, Experiment, load_experiment
from sysid.first_fit import first_fit
from sysid.fit import Prior, Unknown
from sysid.friction_drive import CONTACT_STIFFNESS, contact_damping, friction_drive_record, gain_and_press
from sysid.misfit import Weighting, weighted_residual, weighting
from sysid.model import Model, Prepared, Scales, scales_of, with_effect
from sysid.noise_floor import Noise, estimate_noise
from sysid.prepare import driven_mass, velocity_drive
from sysid.records import Record, load_records
from sysid.smoothing import GaussianFilter
from sysid.starts import searched
from sysid.tip import tip_record
from sysid.uniform import uniform

FORMS = {
    "velocity-drive": "output",
    "actuator-tip": "output",
    "friction-drive": "output",
    "spring-pull": "force_balance",
    "force-drive": "force_balance",
}
"""The form in which the residual is taken on each kind of rig."""


@dataclass(frozen=True)
class Case:
    """An experiment with everything the loop needs.

    Args:
        experiment: as read.
        records: as read.
        noise: by measured channel.
        fit_records, validate_records: prepared.
        scales: sizes set by the records of the fit.
        custom: the user's own effects.
        start: the model as the experiment states it, before any fit.
        notes: what the user should be told.
    """

    experiment: Experiment
    records: tuple[Record, ...]
    noise: Mapping[str, Noise]
    fit_records: tuple[Prepared, ...]
    validate_records: tuple[Prepared, ...]
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


def load_case(path: str | Path, design: DesignValues | None = None) -> Case:
    """Read an experiment and prepare it.

    Raises:
        InputError: one line that says what is wrong with a file.
    """
    experiment = load_experiment(path, design)
    if experiment.rig.kind not in FORMS:
        raise InputError(
            f"{experiment.path}: rig.kind = '{experiment.rig.kind}' cannot be compared yet; allowed: {', '.join(FORMS)}"
        )
    return make_case(experiment, load_records(experiment))


def make_case(experiment: Experiment, records: Sequence[Record], effects: Sequence[str] | None = None) -> Case:
    """Prepare an experiment already read; `effects` stand in place of the model's where given."""
    _need_tip(experiment)
    names = tuple(experiment.effects if effects is None else effects)
    custom = tuple(load_all_custom(experiment.custom))
    noise, notes = _noise(experiment, records)
    quantised = [n for n in names if n.partition("@")[0] == "sensor_quantisation"]
    if quantised:
        noise = with_quantisation(noise, quantised)
    rig, rig_unknowns = _rig_numbers(experiment, records, noise)
    prepared = _prepare(experiment, records, noise, rig)
    for record, ready in zip(records, prepared, strict=True):
        if not any(valid.any() for valid in ready.valid.values()):
            raise InputError(
                f"{record.file}: no row is left to score between gaps and ends; give longer stretches without gaps"
            )
    fits = tuple(p for p in prepared if p.role == "fit")
    held_out = tuple(p for p in prepared if p.role != "fit")
    scales = scales_of(fits)
    model = Model((), rig, tuple(rig_unknowns))
    for name in names:
        model = with_effect(model, find(name, custom), scales)
    model = _with_stretch(model, fits)
    model = _with_settings(model, experiment)
    if experiment.rig.kind == "friction-drive" and any("position_y" in record.channels for record in records):
        notes.append("position_y is not predicted: a friction-drive's model moves along one axis")
    for record in records:
        notes.extend(f"{record.file}: {note}" for note in record.notes)
    return Case(experiment, tuple(records), noise, fits, held_out, scales, custom, model, tuple(notes))


def _need_tip(experiment: Experiment) -> None:
    """A rig with a tip needs its two lengths: without them voltages say nothing about motion."""
    if experiment.rig.kind not in ("actuator-tip", "friction-drive"):
        return
    for name, like in (("piezo_spacing", "46 mm"), ("tip_height", "20 mm")):
        if name not in experiment.rig.known:
            raise InputError(
                f"{experiment.path}: rig.known.{name} is missing; a rig of kind '{experiment.rig.kind}' needs it, like "
                f'{name} = "{like}", or "design"'
            )


def _measured(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    rig = experiment.rig
    names = list(rig.declaration.measured_channels)
    if rig.kind == "force-drive":
        names.append("drive_force")
    if rig.kind == "velocity-drive":
        names.append("position")
    present = set().union(*(r.channels for r in records))
    return [n for n in dict.fromkeys(names) if n in present]


def _noise(experiment: Experiment, records: Sequence[Record]) -> tuple[dict[str, Noise], list[str]]:
    noise, notes = {}, []
    for channel in _measured(experiment, records):
        given = experiment.noise.get(channel)
        per_record = [r.noise[channel] for r in records if channel in r.noise]
        if given is None and per_record:
            given = float(np.sqrt(np.mean(np.square(per_record))))
        # A known input: only its smoothness matters, and only where the velocity has to be taken from it.
        imposed = channel == "position" and experiment.rig.kind == "velocity-drive" and given is None
        if imposed and any("velocity" in r.channels for r in records):
            continue
        found = estimate_noise(records, channel, given)
        noise[channel] = found
        if found.note:
            notes.append(f"noise of {channel}: {found.note}")
    return noise, notes


def with_quantisation(noise: Mapping[str, Noise], names: Sequence[str]) -> dict[str, Noise]:
    """Noise with step/sqrt(12) added in the channels that the named `sensor_quantisation` effects act on."""
    out = dict(noise)
    for name in names:
        wanted = name.partition("@")[2]
        for channel, found in noise.items():
            if found.quantum is None or (wanted and wanted != channel):
                continue
            step = found.quantum / np.sqrt(12.0)
            # Steps well above the noise come and go with the motion, not from sample to sample: as good as white.
            out[channel] = replace(found, value=float(np.hypot(found.value, step)), correlation=0.0)
    return out


def _rig_numbers(
    experiment: Experiment, records: Sequence[Record], noise: Mapping[str, Noise]
) -> tuple[dict[str, float], list[Unknown]]:
    """Numbers of the rig, those the user knows held, those unknown or uncertain moved by the fit."""
    known, kind = experiment.rig.known, experiment.rig.kind
    values: dict[str, float] = {}
    unknowns: list[Unknown] = []

    def put(name: str, guess: Callable[[], float], known_as: str | None = None) -> None:
        given = known.get(known_as or name)
        value = given.value if given is not None else guess()
        values[f"rig.{name}"] = value
        if given is None:
            unknowns.append(Unknown(f"rig.{name}", value, 1e-3 * abs(value), 1e3 * abs(value), abs(value)))
        elif given.std:
            reach = 3.0 * given.std
            prior = Prior(value, given.std)
            unknowns.append(Unknown(f"rig.{name}", value, value - reach, value + reach, given.std, prior))

    if kind == "spring-pull":
        put("pull_stiffness", lambda: _guess_stiffness(records))
    if kind in ("spring-pull", "force-drive"):
        put("mass", lambda: _guess_mass(records, kind, values.get("rig.pull_stiffness"), noise))
    if kind == "friction-drive":
        fits = [r for r in records if r.role == "fit"]
        gain, press = gain_and_press(fits, {name: k.value for name, k in known.items()})
        values["rig.contact_stiffness"] = (
            known["contact_stiffness"].value if "contact_stiffness" in known else (CONTACT_STIFFNESS)
        )
        put("mass", lambda: 1.0)
        damping = contact_damping(values["rig.contact_stiffness"], values["rig.mass"])
        put("contact_damping", lambda: damping)
        if "contact_damping" not in known:
            # Ten times that is a third of critical: a fit that wants more wants something else.
            unknowns[-1] = replace(unknowns[-1], low=0.0, high=10.0 * damping)
        put("gain", lambda: gain, "piezo_gain")
        if press is not None:
            put("press", lambda: press)
    if kind == "actuator-tip":
        fits = [r for r in records if r.role == "fit"]
        rows = {c: np.concatenate([r.channels[c] for r in fits]) for c in fits[0].channels}
        spread = max(float(np.nanstd(v)) for c, v in rows.items() if c.startswith("voltage"))
        size = max(float(np.nanstd(v)) for c, v in rows.items() if c.startswith("tip"))
        gain = size / max(spread, 1e-300)
        values["rig.gain"] = gain
        unknowns.append(Unknown("rig.gain", gain, 0.0, np.inf, gain))
        for channel in ("tip_x", "tip_y", "tip_z"):
            if channel in rows:
                offset = float(np.nanmean(rows[channel]))
                values[f"rig.offset_{channel}"] = offset
                unknowns.append(Unknown(f"rig.offset_{channel}", offset, -np.inf, np.inf, size))
    return values, unknowns


def _guess_stiffness(records: Sequence[Record]) -> float:
    """Slope of spring force over stretch, where both are measured."""
    for record in records:
        c = record.channels
        if {"pull_position", "position", "spring_force"} <= set(c):
            stretch, force = c["pull_position"] - c["position"], c["spring_force"]
            ok = np.isfinite(stretch) & np.isfinite(force)
            if np.ptp(stretch[ok]) > 0:
                return abs(float(np.polyfit(stretch[ok], force[ok], 1)[0])) or 1.0
    raise InputError(
        f"{records[0].file}: without rig.known.pull_stiffness both 'position' and 'spring_force' must be recorded, "
        "since the stiffness is then read off them"
    )


def _guess_mass(records: Sequence[Record], kind: str, stiffness: float | None, noise: Mapping[str, Noise]) -> float:
    """Mass from the force balance: the force regressed on acceleration, direction, velocity and one."""
    best = 1.0
    for record in [r for r in records if r.role == "fit"][:1]:
        best = mass = _largest_mass(record, kind, stiffness, noise)
        for _ in range(4):
            balance = driven_mass(record, kind, noise, mass, stiffness)
            channel = balance.force_channel
            y = balance.measured[channel]
            if channel == "position":
                y = balance.inputs["spring_force"]
            ok = balance.valid[channel]
            if ok.sum() < LEAST_ROWS:
                # A filter as wide as this guess asks for leaves nothing between the gaps.
                mass *= 0.1
                continue
            assert balance.acceleration is not None and balance.whole is not None and balance.direction is not None
            columns = [balance.acceleration, balance.whole(balance.direction), balance.axis.velocity, np.ones(y.size)]
            solution, *_ = np.linalg.lstsq(np.column_stack([c[ok] for c in columns]), y[ok], rcond=None)
            best = float(solution[0]) if solution[0] > 0 else mass
            if abs(best - mass) < 0.01 * best:
                break
            mass = best
    return best


LEAST_ROWS = 200
"""Scored rows below which a mass is not read off a record."""


def _largest_mass(record: Record, kind: str, stiffness: float | None, noise: Mapping[str, Noise]) -> float:
    """Mass that would need all of the force: its size over that of the acceleration, where that stands off its noise.

    An upper guess: it sets how wide a filter the first estimate of the mass begins with.
    """
    _, step, channels, _ = uniform(record)
    position = channels.get("position")
    force = channels.get("drive_force" if kind == "force-drive" else "spring_force")
    if position is None or force is None:
        return 1.0
    position, force = filled(position)[0], filled(force)[0]
    width = step
    while width < position.size * step / 40.0:
        smooth = GaussianFilter(width, step, position.size)
        acceleration = float(np.std(smooth(position, 2)))
        sigma = noise["position"]
        if sigma.value * smooth.noise_gain(2, sigma.correlation) < 0.2 * acceleration:
            return float(np.std(force)) / acceleration
        width *= 2.0
    return 1.0


def _prepare(
    experiment: Experiment, records: Sequence[Record], noise: Mapping[str, Noise], rig: Mapping[str, float]
) -> list[Prepared]:
    kind = experiment.rig.kind
    prepared: list[Prepared] = []
    width = None
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
                record, kind, noise, rig["rig.mass"], rig.get("rig.pull_stiffness"), experiment.rig.input_hold, width
            )
            width = balance.whole.width if balance.whole is not None else None
            prepared.append(balance)
    return prepared


def _with_stretch(model: Model, records: Sequence[Prepared]) -> Model:
    """On a driven mass the Coulomb bristle's stretch is fitted too, below the position's noise: it sets how sharply
    friction turns round, which the balance feels though the position cannot show it."""
    key = "coulomb.stretch"
    noises = [r.position_noise for r in records if isinstance(r, Balance) and r.turns is not None]
    if key not in model.values or not noises:
        return model
    highest = max(noises)
    start = 0.05 * highest
    values = {**model.values, key: start}
    return Model(model.effects, values, (*model.unknowns, Unknown(key, start, 1e-4 * highest, highest, start)))


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


@dataclass(frozen=True)
class BaseFit:
    """The model of a case at its best, and what the comparison with others needs.

    Args:
        fitted: model, fit and weights on the records of the fit.
        weights: deviations and samples of the held-out records.
        residual: of the held-out records, in deviations, (n,).
        laws: effects of the model whose law was chosen among variants, as `stribeck:rational`.
    """

    fitted: Fitted
    weights: Weighting
    residual: np.ndarray
    laws: tuple[str, ...] = ()


def fit_case(case: Case, model: Model | None = None) -> BaseFit:
    """Fit the case's model; an effect named without a variant takes the law of its family that fits best."""
    chosen: tuple[str, ...] = ()
    if model is not None:
        fitted = fit_model(model, case.fit_records)
    else:
        given = [key for key, setting in case.experiment.parameters.items() if setting.start is not None]
        fitted = first_fit(case.start, case.fit_records, case.scales, given)
        fitted, chosen = best_laws(case, fitted)
    weights = weighting(fitted.model, case.validate_records)
    residual = weighted_residual(fitted.model, case.validate_records, weights)
    return BaseFit(fitted, weights, residual, chosen)


def best_laws(case: Case, fitted: Fitted, families: Collection[str] | None = None) -> tuple[Fitted, tuple[str, ...]]:
    """A fit in which effects have the best law of their family.

    The law of the family's own name is taken unless another is clearly better.

    Args:
        case: whose records are fitted.
        fitted: the model as it stands, with any law of each family.
        families: names of the effects whose law is open; those of `open_laws` where left out.

    Returns:
        The fit, and the names of the laws that took their family's place.
    """
    chosen: list[str] = []
    for name in open_laws(case) if families is None else families:
        effect = find(name, case.custom)
        present = {e.name for e in fitted.model.effects}
        if effect.name not in present:
            if not any(e.name.partition(":")[0] == name for e in fitted.model.effects):
                continue
            # Another law was chosen while the model still lacked something.
            fitted = searched(fitted, effect, case.fit_records, case.scales)
        trials = [searched(fitted, variant, case.fit_records, case.scales) for variant in effect.variants]
        best = min(trials, key=lambda t: t.fit.cost + 4.0 * len(t.model.unknowns), default=fitted)
        if clearly_better(best, fitted):
            fitted = best
            chosen += [e.name for e in best.model.effects if e.name.partition(":")[0] == name]
    return fitted, tuple(chosen)


def open_laws(case: Case) -> tuple[str, ...]:
    """Effects whose law is for the fit to choose: named without a variant, and with no value given by the user."""
    given = {key.rpartition(".")[0] for key in case.experiment.parameters}
    return tuple(
        e.name for e in case.start.effects
        if e.core is None and ":" not in e.name and e.variants and e.name not in given
    )  # fmt: skip


def clearly_better(other: Fitted, fitted: Fitted) -> bool:
    """Whether another law of an effect fits so much better that chance and its extra values do not explain it."""
    extra = len(other.model.unknowns) - len(fitted.model.unknowns)
    # Law by law the cost of a wrong curve is far above the noise; chance is not.
    return other.fit.cost < 0.97 * fitted.fit.cost - 4.0 * max(extra, 0)
