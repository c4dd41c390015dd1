"""The error of a model with fixed parameters does not depend on how a record is described.

A mirrored axis, another origin of position or time, another unit and a record of another size (lengths and forces
multiplied, parameters with them) leave the physics unchanged. Every effect that a rig can show is tested on it.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from benchmarks.generators.every_rig import BIAS, RIGS, SIGNED, write
from sim.effects.catalogue import find, library
from sim.effects.effect import Effect
from sysid.compare import compare
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.experiment import Experiment, load_experiment
from sysid.experiment.record import Record, load_records
from sysid.prediction.effect_terms import split_channel
from sysid.prediction.model import Model, predict, public_name, with_effect
from sysid.prediction.observable import is_observable
from sysid.prediction.problem import Problem, build_problem, load_problem
from tests.beside import beside

LENGTHS = ("position", "velocity", "pull_position", "tip_x", "tip_y", "tip_z")
LENGTH, FORCE = 2.0**-10, 2.0**4
"""Factors of the record of another size; powers of two, so that rounding is the same."""

POWERS = {
    "m": (1, 0), "m/s": (1, 0), "N": (0, 1), "N/m": (-1, 1), "N*s/m": (-1, 1), "N*s^2/m^2": (-2, 1),
    "kg": (-1, 1), "1/m": (-1, 0),
}  # fmt: skip
"""Powers of length and force in a unit, at fixed time."""

RIG_UNITS = {
    "mass": "kg", "pull_stiffness": "N/m", "pull_damping": "N*s/m", "contact_stiffness": "N/m",
    "contact_damping": "N*s/m", "gain": "m", "press": "m",
    "offset_tip_x": "m", "offset_tip_y": "m", "offset_tip_z": "m",
}  # fmt: skip

SIGN_CHANGES = {
    *(("direction_asymmetry", "coulomb"), ("direction_asymmetry", "viscous"), ("constant_bias", "force")),
    *(("cable_spring", "rest_position"), ("sensor_nonlinearity", "second_order"), ("sensor_drift", "amplitude")),
    *(("position_dependent_friction", "gradient"), ("position_dependent_friction", "second_sine")),
    *(("magnetic_cogging", "phase"), ("magnetic_cogging", "second_cosine"), ("gravity_torque", "phase")),
}
"""Parameters of effects with a preferred direction that change sign when the axis is mirrored: a force A sin(k x + p)
becomes A sin(k x - p); a friction level 1 + A sin(k x + p) becomes 1 + A sin(k x + pi - p)."""
SEED = 11
"""Of the record that most tests describe anew."""
FITTED = ["velocity drive, position", "spring pull, both", "force drive, position", "two piezos"]


@cache
def _problem(rig: str, seed: int) -> tuple[Experiment, list[Record], Problem]:
    with TemporaryDirectory() as folder:
        experiment = load_experiment(write(Path(folder), RIGS[rig], [], seed))
        records = load_records(experiment)
    return experiment, records, build_problem(experiment, records)


def _effects(problem: Problem) -> list[Effect]:
    """Every effect and variant that the rig can show, those of a sensor on each channel."""
    found = [law for effect in library().values() for law in (effect, *effect.variants)]
    found = [effect for effect in found if is_observable(problem, effect)]
    channels = list(problem.fit_records[0].measured)
    if problem.form == "output" or len(channels) == 1:
        return found
    on_channels = [find(f"{e.name}@{channel}") for e in found if e.acts_on == "sensor" for channel in channels]
    return [effect for effect in found if effect.acts_on != "sensor"] + on_channels


def _model(problem: Problem, effect: Effect) -> Model:
    """Coulomb and viscous friction with one more effect, whose parameters are not zero."""
    model = Model((), {k: v for k, v in problem.start.values.items() if k.startswith("rig.")}, ())
    names = [] if problem.kind == "actuator-tip" else ["coulomb", "viscous"]
    for name in [*(n for n in names if n != effect.name), effect.name]:
        model = with_effect(model, find(name), problem.scales, as_listed=True)
    values, sizes = dict(model.values), {"1": 0.1, "1/m": 5.0, "N": 0.3, "N*s/m": 1.0, "rad": 0.7}
    for parameter in effect.parameters:
        key = f"{effect.name}.{parameter.name}"
        if parameter.role != "reference" and values[key] == 0.0:
            channel = 0.05 * problem.scales.channel if problem.form == "force_balance" else 1e-7
            values[key] = 0.2 * problem.scales.position if parameter.unit == "m" else sizes.get(parameter.unit, channel)
    return model.at(values)


@cache
def _known(rig: str, seed: int = SEED) -> list[tuple[Effect, Model, dict[str, ChannelMisfit]]]:
    """What the rig can show: each effect, the model with it, and its errors on the record."""
    problem = _problem(rig, seed)[2]
    models = [(effect, _model(problem, effect)) for effect in _effects(problem)]
    return [(effect, model, misfit(model, problem.fit_records)) for effect, model in models]


def _assert_same(errors: dict[str, ChannelMisfit], second: Problem, other: Model, within: float = 1e-6) -> None:
    found = misfit(other, second.fit_records)
    for channel, known in errors.items():
        assert found[channel].over_noise == pytest.approx(known.over_noise, rel=within), other.effects[-1].name
        assert found[channel].fit_percent == pytest.approx(known.fit_percent, rel=within, abs=within)
        assert found[channel].size == known.size


def _with(record: Record, change: Callable[[str, np.ndarray], np.ndarray]) -> Record:
    return replace(record, channels={name: change(name, values) for name, values in record.channels.items()})


def _mirrored(record: Record) -> Record:
    return _with(record, lambda c, u: -u if c in SIGNED else 2.0 * BIAS - u if c.startswith("voltage") else u)


def _mirrored_model(model: Model) -> Model:
    values = dict(model.values)
    for key, value in values.items():
        effect, parameter = key.rsplit(".", 1)
        name = (public_name(effect), parameter)
        if name in SIGN_CHANGES or parameter.startswith("offset"):
            values[key] = -value
        elif name == ("position_dependent_friction", "phase"):
            values[key] = np.pi - value
    return model.at(values)


@pytest.mark.parametrize("seed", [SEED, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 614))])
@pytest.mark.parametrize("rig", RIGS)
def test_a_mirrored_axis_has_the_same_errors(rig: str, seed: int) -> None:
    experiment, records, _ = _problem(rig, seed)
    mirrored = build_problem(experiment, [_mirrored(record) for record in records])
    for _, model, errors in _known(rig, seed):
        _assert_same(errors, mirrored, _mirrored_model(model))


def test_exchanged_piezos_mirror_a_tip_across_its_axis() -> None:
    experiment, records, _ = _problem("two piezos", SEED)
    other = {"voltage_1": "voltage_2", "voltage_2": "voltage_1"}
    exchanged = [
        replace(r, channels={c: -r.channels[c] if c == "tip_x" else r.channels[other.get(c, c)] for c in r.channels})
        for r in records
    ]
    mirrored = build_problem(experiment, exchanged)
    for effect, model, errors in _known("two piezos"):
        if public_name(effect.name) in ("gain_mismatch", "sensor_nonlinearity", "sensor_drift"):
            continue
        _assert_same(errors, mirrored, model.at({"rig.offset_tip_x": -model.values["rig.offset_tip_x"]}))


def _shifted_model(model: Model, distance: float) -> Model | None:
    """The model with its origin of position shifted; none where the last effect has no parameter for that."""
    effect = model.effects[-1]
    if "position" not in effect.coordinates or public_name(effect.name) in ("backlash", "presliding"):
        return model
    values = dict(model.values)
    if f"{effect.name}.phase" in values:
        period = values.get(f"{effect.name}.pitch", 2.0 * np.pi)
        values[f"{effect.name}.phase"] -= 2.0 * np.pi * distance / period
    elif f"{effect.name}.rest_position" in values:
        values[f"{effect.name}.rest_position"] += distance
    else:
        return None
    return model.at(values)


@pytest.mark.parametrize("rig", [name for name, rig in RIGS.items() if "position" in (*rig.channels, "pull_position")])
def test_another_origin_of_position_has_the_same_errors(rig: str) -> None:
    experiment, records, problem = _problem(rig, SEED)
    distance = 0.37
    moved = ("position", "pull_position")
    shifted = build_problem(experiment, [_with(r, lambda c, u: u + distance if c in moved else u) for r in records])
    of_position = any(channel in moved for channel in problem.fit_records[0].measured)
    for effect, model, errors in _known(rig):
        other = _shifted_model(model, distance)
        absolute = of_position and public_name(effect.name) == "sensor_nonlinearity"
        if other is not None and not absolute:
            _assert_same(errors, shifted, other, 1e-5)


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("start", [-3.0, 1.55e9])
def test_another_origin_of_time_has_the_same_errors(rig: str, start: float) -> None:
    experiment, records, _ = _problem(rig, SEED)
    late = build_problem(experiment, [replace(record, time=record.time + start) for record in records])
    for _, model, errors in _known(rig):
        _assert_same(errors, late, model, 1e-5)


def _size(unit: str, channel: float) -> float:
    powers = POWERS.get(unit, (0, 0))
    return channel if unit == "channel" else LENGTH ** powers[0] * FORCE ** powers[1]


def _scaled_model(model: Model, channels: list[str]) -> Model:
    values = {}
    for key, value in model.values.items():
        effect, name = key.rsplit(".", 1)
        if effect == "rig":
            values[key] = value * _size(RIG_UNITS[name], 1.0)
            continue
        # Load and temperature keep their sizes.
        own = split_channel(effect)[1] or channels[0]
        unit = "1" if name == "reference" else find(effect).parameter(name).unit
        values[key] = value * _size(unit, LENGTH if own in LENGTHS else FORCE)
    return model.at(values)


@pytest.mark.parametrize("rig", RIGS)
def test_another_size_has_the_same_errors(rig: str) -> None:
    """The evaluation has no absolute length or force: lengths times 2^-10 and forces times 2^4 at fixed time."""
    experiment, records, problem = _problem(rig, SEED)

    def factor(channel: str) -> float:
        return LENGTH if channel in LENGTHS else FORCE if channel.endswith("force") else 1.0

    known = {k: replace(v, value=v.value * _size(RIG_UNITS.get(k, "1"), 1.0)) for k, v in experiment.rig.known.items()}
    known |= {"inertia": known["mass"]} if "inertia" in known else {}
    resized = replace(
        experiment,
        noise={channel: value * factor(channel) for channel, value in experiment.noise.items()},
        rig=replace(experiment.rig, known=known),
    )
    scaled = [
        replace(_with(r, lambda c, u: factor(c) * u), noise={c: factor(c) * u for c, u in r.noise.items()})
        for r in records
    ]
    other = build_problem(resized, scaled)
    channels = list(problem.fit_records[0].measured)
    for effect, model, errors in _known(rig):
        if "rotary" not in effect.needs:
            _assert_same(errors, other, _scaled_model(model, channels))


@pytest.mark.parametrize("rig", [name for name, rig in RIGS.items() if not rig.rotary])
def test_other_units_in_the_file_have_the_same_errors(rig: str, tmp_path: Path) -> None:
    units = {"time": ("ms", 1e3), "normal_load": ("mN", 1e3)}
    units |= {c: ("mm", 1e3) for c in RIGS[rig].channels if c in LENGTHS and c != "velocity"}
    units |= {c: ("mN", 1e3) for c in RIGS[rig].channels if c.endswith("force")}
    other = load_problem(write(tmp_path, RIGS[rig], [], SEED, units))
    for _, model, errors in _known(rig):
        _assert_same(errors, other, model)


@pytest.mark.parametrize("rig", FITTED)
def test_a_mirrored_axis_has_the_same_fit(rig: str) -> None:
    experiment, records, _ = _problem(rig, 53)
    names = ["piezo_hysteresis"] if "piezos" in rig else ["coulomb", "viscous", "constant_bias"]
    problem = build_problem(experiment, records, names)
    mirrored = build_problem(experiment, [_mirrored(record) for record in records], names)
    first, second = fit_stated_model(problem).fitted.model, fit_stated_model(mirrored).fitted.model
    _assert_same(misfit(first, problem.fit_records), mirrored, second, 1e-3)


@pytest.mark.slow
def test_measured_records_and_their_mirror_images_have_the_same_errors() -> None:
    first, second = (compare(beside("data", "sign_symmetry", name)) for name in ("neg", "flipped"))
    for part in ("fit", "validate"):
        known, other = (getattr(found, part)["drive_force"] for found in (first, second))
        assert other.rms == pytest.approx(known.rms, rel=1e-9)
        # An independent evaluation of the balance of the mirrored record.
        assert known.rms == pytest.approx(0.0161, rel=0.05)


@pytest.mark.parametrize("rig", ["velocity drive, position", "velocity drive, both", "force drive, position"])
def test_a_record_in_two_parts_has_the_same_predictions(rig: str) -> None:
    """A friction law or force gives the same where both parts and the whole are scored: what the first rows of a part
    do not determine is not scored. Distances travelled start afresh, and the state of a signal is not known."""
    experiment, records, problem = _problem(rig, 61)
    cut = 700
    parts = [
        replace(r, name=f"{r.name} {k}", time=r.time[rows], channels={c: u[rows] for c, u in r.channels.items()})
        for r in records
        for k, rows in enumerate((slice(0, cut), slice(cut, None)))
    ]
    first, second = build_problem(experiment, parts).fit_records
    whole = problem.fit_records[0]
    laws = [e for e in _effects(problem) if e.acts_on in ("friction", "axis", "memory")]
    for effect in (e for e in laws if public_name(e.name) != "run_in"):
        model = _model(problem, effect)
        known = predict(whole, model.effects, model.values)
        for part, start in ((first, 0), (second, cut)):
            predicted = predict(part, model.effects, model.values)
            for channel, noise in whole.noise.items():
                rows = slice(start, start + part.size)
                both = part.valid[channel] & whole.valid[channel][rows]
                assert np.count_nonzero(both) > 0.7 * part.size
                difference = (predicted[channel] - known[channel][rows])[both]
                assert np.max(np.abs(difference)) < 0.1 * noise, effect.name
