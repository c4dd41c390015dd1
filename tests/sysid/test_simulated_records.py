"""Records simulated from a model and compared with the same model, parameters fixed: the error is the noise.

For every kind of rig, every effect that it can show, and every variant. The motion of driven masses is integrated in
time (`sim.integration`), that of the others simulated at instants between the rows; the comparison evaluates a force
balance, or predicts, along the rows. The two share the laws of the effects only.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find, library
from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError
from sysid.estimation.misfit import misfit
from sysid.experiment.experiment import Experiment, load_experiment
from sysid.experiment.record import Record, load_records
from sysid.experiment.rigs import CHANNELS
from sysid.noise.estimate import Noise
from sysid.prediction.model import Model, size_of, with_effect
from sysid.prediction.observable import is_observable, on_channels
from sysid.prediction.problem import Problem, build_problem
from sysid.prediction.simulation import simulated_channels
from sysid.simulate_experiment import noise_signal
from tests.experiments import write_rig

Channels = dict[str, np.ndarray]


@dataclass(frozen=True)
class Bench:
    """A rig: known values, model without the effect, inputs at times (n,), noise by channel, rows and their step (s),
    instants per row of the simulation, draws of the noise, values of parameters by name that suit the motion, and the
    effects whose error is not the noise yet."""

    kind: str
    known: Mapping[str, str]
    model: Mapping[str, str]
    inputs: Callable[[np.ndarray], Channels]
    noise: Mapping[str, float]
    rows: int
    step: float
    finer: int
    draws: int
    values: Mapping[str, float] = field(default_factory=dict)
    beyond: frozenset[str] = frozenset()
    rotary: bool = False


def _wave(t: np.ndarray, *waves: tuple[float, float, float]) -> np.ndarray:
    """Sum of sines (amplitude, Hz, phase) that starts at zero."""
    return np.sum([a * (np.sin(2.0 * np.pi * f * t + p) - np.sin(p)) for a, f, p in waves], axis=0)


def _surroundings(t: np.ndarray) -> Channels:
    return {"normal_load": 20.0 + 4.0 * np.sin(0.9 * t), "temperature": 20.0 + 6.0 * np.sin(0.17 * t)}


def _imposed(t: np.ndarray) -> Channels:
    """Strokes of many speeds with rests between them."""
    wave = 0.014 * np.sin(2.0 * np.pi * 0.61 * t + 0.3) + 0.01 * np.sin(2.0 * np.pi * 1.13 * t)
    velocity = np.sign(wave) * np.maximum(np.abs(wave) - 0.003, 0.0)
    return {"position": np.cumsum(velocity) * (t[1] - t[0]), "velocity": velocity, **_surroundings(t)}


def _pulled(t: np.ndarray) -> Channels:
    return {"pull_position": _wave(t, (5e-3, 0.41, 0.3), (2e-3, 1.13, 1.0)), **_surroundings(t)}


def _forced(t: np.ndarray) -> Channels:
    return {"drive_force": _wave(t, (12.0, 0.9, 0.0), (6.0, 2.1, 0.0)), **_surroundings(t)}


def _volts(t: np.ndarray) -> Channels:
    lean, up = _wave(t, (25.0, 1.3, 0.3), (15.0, 7.7, 1.0), (8.0, 31.0, 2.0)), _wave(t, (12.0, 4.3, 0.7))
    return {"voltage_1": 75.0 + up - lean, "voltage_2": 75.0 + up + lean}


TIP = {"piezo_spacing": "46 mm", "tip_height": "20 mm", "bias_voltage": "75 V"}
STAGE = TIP | {"mass": "3 kg", "contact_stiffness": "8e6 N/m", "piezo_gain": "1.1e-7 m/V", "press": "4 um"}
FRICTION = {
    "coulomb.force": "1.5 N",
    "viscous.coefficient": "12 N*s/m",
    "stribeck.force": "0.4 N",
    "stribeck.velocity": "5 mm/s",
}
RIGID = FRICTION | {"coulomb.stretch": "1 nm"}
"""The balance takes Coulomb friction as rigid. In time its bristle has the constant stiffness force/stretch, and a mass
m turns round at up to 2 level/sqrt(force m/stretch): 0.2 mm/s for 8 kg under the level of a long rest at 5 nm."""
PADS = {"coulomb.force": "1.5 N", "stribeck.force": "0.3 N", "stribeck.velocity": "0.05 mm/s"}
SPRING = {"mass": "1.79 kg", "pull_stiffness": "5752 N/m"}
PULL_NOISE = {"position": 5e-8, "spring_force": 0.02}
TIP_NOISE = {"tip_x": 2e-9, "tip_y": 2e-9}
PRESLIDING = frozenset(
    ("presliding", "presliding:maxwell_slip", "presliding:dahl", "presliding:lugre", "presliding:lugre_causal")
    + ("dahl", "lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run", "maxwell_slip")
    + ("elasto_plastic", "rate_and_state", "second_order_dahl")
)
"""Bristles of a driven mass that stretch by a hundred times the noise of the position: while it sticks, the balance
takes the mass as at rest, and the spread of the displacement by that of the sensor alone."""

DRIVEN_PRESLIDING = frozenset(("presliding", "presliding:maxwell_slip", "maxwell_slip", "second_order_dahl"))
"""Those under a known force: the noise along the motion covers the smooth laws of first order; three have corners."""

BENCHES = {
    "velocity-drive": Bench("velocity-drive", {}, FRICTION, _imposed, {"friction_force": 0.01}, 6000, 2.5e-4, 4, 1),
    "spring-pull": Bench(
        *("spring-pull", SPRING, FRICTION, _pulled, PULL_NOISE, 12000, 1e-3, 1, 2),
        beyond=PRESLIDING | {"sensor_lag", "sensor_nonlinearity", "sensor_drift:power"},
    ),
    "force-drive": Bench(
        *("force-drive", {"mass": "8 kg"}, RIGID, _forced, {"position": 1e-7}, 12000, 1e-3, 1, 2),
        values={"pitch": 5e-2},
        beyond=DRIVEN_PRESLIDING | {"sensor_lag"},
    ),
    "actuator-tip": Bench("actuator-tip", TIP, {}, _volts, TIP_NOISE, 8000, 5e-4, 4, 1),
    "friction-drive": Bench(
        *("friction-drive", STAGE, PADS, _volts, {"position": 2e-9}, 4000, 5e-4, 1, 2),
        # Friction is evaluated along the measured position, whose noise must be far below a pitch.
        values={"pitch": 2e-6, "memory_length": 5e-7},
        # Whether the stage rests, or a bristle sticks, follows from the measured motion too.
        beyond=frozenset(("bristle_damping:spread", "dwell_strengthening:fading")),
    ),
}
RIGS = [b if "drive" in name else pytest.param(b, marks=pytest.mark.slow) for name, b in BENCHES.items()]
"""The others take a quarter of a minute each."""

ALONG_RECORDS = {"frictional_lag:relaxation", "frictional_lag:film", "dwell_strengthening:fading"}
"""Laws defined along a whole record only."""

RIG_VALUES = {"rig.gain": 1.1e-7, "rig.offset_tip_x": 1e-7, "rig.offset_tip_y": 0.0, "rig.contact_damping": 400.0}


def _experiment(bench: Bench, folder: Path) -> Experiment:
    """The experiment of a bench with its plain model; the measured channels in its file are placeholders."""
    time = bench.step * np.arange(400)
    channels = {**bench.inputs(time), **dict.fromkeys(bench.noise, time)}
    units = {name: CHANNELS[name].si_unit(bench.rotary) for name in channels}
    columns = {"time [s]": time, **{f"{name} [{units[name]}]": values for name, values in channels.items()}}
    effects = list(dict.fromkeys(key.partition(".")[0] for key in bench.model))
    noise = {name: f"{std} {units[name]}" for name, std in bench.noise.items()}
    write_rig(folder, bench.kind, {"x": columns}, effects, known=bench.known, noise=noise, parameters=bench.model)
    return load_experiment(folder)


def _simulated(bench: Bench, experiment: Experiment, model: Model) -> Channels:
    """Inputs and exact measured channels at the rows."""
    # A command of steps is held from row to row: nothing lies between them.
    finer = 1 if any(e.name.endswith(":of_steps") for e in model.effects) else bench.finer
    instants = bench.step / finer * np.arange(finer * bench.rows)
    rows = instants[::finer]
    inputs = bench.inputs(instants)
    if "voltage_1" in inputs:
        # Voltages go straight from row to row.
        inputs = {name: np.interp(instants, rows, values) for name, values in bench.inputs(rows).items()}
    record = replace(load_records(experiment)[0], time=instants, channels=inputs)
    _, channels = simulated_channels(experiment.rig, record, model.effects, model.values)
    return {name: values[::finer] for name, values in channels.items()}


def _logged(bench: Bench, channels: Channels, quantised: str = "") -> list[Record]:
    """Records with several draws of the noise; the channels that an effect named `quantised` acts on are rounded."""
    time, found = bench.step * np.arange(bench.rows), []
    for seed in range(bench.draws):
        random = np.random.default_rng(seed)
        noisy = {n: channels[n] + noise_signal(Noise(std, "", "given"), time, random) for n, std in bench.noise.items()}
        for name, std in bench.noise.items():
            if quantised.endswith(("sensor_quantisation", f"sensor_quantisation@{name}")):
                noisy[name] = 2.0 * std * np.round(noisy[name] / (2.0 * std))
        units = {name: CHANNELS[name].si_unit(bench.rotary) for name in channels}
        found.append(
            Record(
                *(f"{seed}", "fit", "x.csv", time, {**channels, **noisy}, units, bench.rotary, (), "", bench.step),
                uniform=True,
                noise={"position": 1e-12, **bench.noise},  # The imposed motion is exact.
            )
        )
    return found


def _plain(bench: Bench, experiment: Experiment) -> tuple[Problem, Model]:
    """The problem of records without a further effect, and its model at the true values."""
    values = RIG_VALUES | {f"rig.{name}": known.value for name, known in experiment.rig.known.items()}
    effects = [find(name) for name in experiment.effects]
    for effect in effects:
        values |= {f"{effect.name}.{p.name}": p.default for p in effect.parameters}
    values |= {key: setting.start for key, setting in experiment.parameters.items() if setting.start is not None}
    channels = _simulated(bench, experiment, Model(tuple(effects), values, ()))
    problem = build_problem(experiment, _logged(bench, channels))
    true = {key: value for key, value in values.items() if key != "coulomb.stretch" or bench.kind == "velocity-drive"}
    return problem, problem.start.at({key: v for key, v in true.items() if key in problem.start.values})


def _visible(model: Model, effect: Effect, problem: Problem, given: Mapping[str, float]) -> Model:
    """The model with `given` values by the name of the parameter, sizes that start at zero at a tenth of their scale,
    and those of a sensor at a twentieth of its channel's range."""
    values, channel = {}, effect.name.partition("@")[2]
    spans = {name: float(np.ptp(y)) for name, y in problem.records[0].channels.items()}
    span = spans[channel] if channel else max(spans[name] for name in problem.fit_records[0].measured)
    for p in effect.parameters:
        key, free = f"{effect.name}.{p.name}", p.role in ("amplitude", "shape") and not p.fixed
        if p.unit == "channel":
            values[key] = 0.05 * span if free else span
        elif model.values[key] == 0.0 and free:
            values[key] = 0.2 * p.high if p.role == "shape" else min(size_of(p, problem.scales), p.high)
        values |= {key: given[p.name]} if p.name in given else {}
    return model.at(values)


def compared(bench: Bench, folder: Path, variants: bool) -> tuple[dict[str, dict[str, float]], set[str]]:
    """Error over noise by effect and channel, and the effects that cannot be simulated in time.

    Args:
        bench: rig, motion and noise.
        folder: for the experiment.
        variants: the variants of the effects, or else the effects themselves.
    """
    experiment = _experiment(bench, folder)
    plain, model = _plain(bench, experiment)
    without = _simulated(bench, experiment, model)
    table, refused = {}, set()
    laws = [law for declared in library().values() for law in (declared.variants if variants else (declared,))]
    for effect in laws:
        if effect.name in experiment.effects or not is_observable(plain, effect):
            continue
        for option in on_channels(plain, effect, []):
            extended = _visible(with_effect(model, option, plain.scales), option, plain, bench.values)
            try:
                channels = _simulated(bench, experiment, extended)
            except InputError:
                refused.add(option.name)
                continue
            shows = [np.max(np.abs(channels[name] - without[name])) / std for name, std in bench.noise.items()]
            assert "quantisation" in option.name or max(shows) > 1.0, option.name
            logged = _logged(bench, channels, option.name)
            problem = build_problem(experiment, logged, [e.name for e in extended.effects])
            true = {key: value for key, value in extended.values.items() if key in problem.start.values}
            found = misfit(problem.start.at(true), problem.fit_records)
            table[option.name] = {channel: m.over_noise for channel, m in found.items()}
    return table, refused


@pytest.mark.parametrize("variants", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["effects", "variants"])
@pytest.mark.parametrize("bench", RIGS, ids=BENCHES)
def test_error_is_the_noise(bench: Bench, variants: bool, tmp_path: Path) -> None:
    """Protects every effect and variant on every rig that shows it against another evaluation than that of the fit."""
    table, refused = compared(bench, tmp_path, variants)
    wrong = {name: row for name, row in table.items() if any(abs(v - 1.0) > 0.03 for v in row.values())}
    tried = {name.partition("@")[0] for name in table}
    assert {name.partition("@")[0] for name in wrong} == bench.beyond & tried, wrong
    in_time = "mass" in bench.known and bench.kind != "friction-drive"
    assert refused == ({name for name in ALONG_RECORDS if (":" in name) == variants} if in_time else set())
